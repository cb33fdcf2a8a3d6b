"""Regular arrays at failure within 1 % (P23): reference/problems/arrays.py, with one friction each."""

from __future__ import annotations

from reference.problems.arrays import axisymmetric, discs, plane_strain
from tests.verification.rows import check


def test_hexagonal_discs():
    check(*discs(0.2))


def test_face_centred_spheres():
    check(*axisymmetric(0.3), *plane_strain(0.3))
