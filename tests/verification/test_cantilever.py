"""A beam of bonded spheres by the engine: reference/problems/cantilever.py."""

from __future__ import annotations

import pytest

from reference.problems.cantilever import INCH, beam, elastic
from tests.verification.rows import check


def test_bent_and_pulled():
    """Deflection, rotation and extension to 0.1 %, stress to 1 %."""
    rows = beam(10)
    check(*rows)
    # the published figures, in inches and radians
    assert rows[0].expected / INCH == pytest.approx(0.82893, rel=1e-5)
    assert rows[1].expected == pytest.approx(6.217e-3, rel=1e-4)
    assert rows[5].expected / INCH == pytest.approx(9.947e-3, rel=1e-4)


def test_twisted_and_sheared():
    check(*elastic(20))
