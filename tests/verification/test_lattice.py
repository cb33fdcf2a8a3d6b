"""Moduli of lattices and a bonded beam against closed forms: reference/problems/lattice.py."""

from __future__ import annotations

import pytest

from reference.problems import lattice_engine
from reference.problems.lattice import HCP, cantilever, close_packed, face_centred, hexagonal, sample
from tests.verification.rows import check


@pytest.mark.parametrize("ratio", [0.0, 0.25, 1.0])
def test_periodic_cells(ratio):
    """E, nu, G of hexagonal discs and FCC spheres to 1e-6."""
    check(*hexagonal(ratio), *face_centred(ratio))


@pytest.mark.parametrize("ratio", HCP)
def test_hexagonal_close_packing(ratio):
    check(*close_packed(ratio))


def test_discs_between_plates():
    """30 x 60 discs: E and nu to 1 %."""
    check(*sample(0.4))


def test_discs_strained_by_the_engine():
    """30 x 60 discs: E and nu to 1 %."""
    check(*lattice_engine.strained(0.5))


def test_cantilever_of_bonded_spheres():
    """Deflection, rotation, extension and twist to 0.1 %, stress to 1 %."""
    check(*cantilever(10), *cantilever(20, shear="parallel bond, ks large"))
