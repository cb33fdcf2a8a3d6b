"""Period, energy and order of the leap-frog: reference/problems/oscillator.py."""

from __future__ import annotations

import pytest

from reference.problems.oscillator import KINDS, SHARES, drift, order, swing
from tests.verification.rows import check

PERIOD_ERRORS = (-0.042, -0.167, -0.674, -4.5)
"""[%] at `SHARES` of the critical step."""


@pytest.mark.parametrize("kind", KINDS)
def test_period_and_energy(kind):
    for share, error in zip(SHARES, PERIOD_ERRORS, strict=True):
        rows = swing(kind, share, periods=15)
        check(*rows)
        assert 100.0 * rows[0].value == pytest.approx(error, abs=0.008 if share == 0.5 else 0.0006)


@pytest.mark.parametrize("kind", KINDS)
def test_energy_does_not_drift(kind):
    check(*drift(kind, steps=100_000))


@pytest.mark.parametrize("kind", KINDS)
def test_second_order(kind):
    check(order(kind, periods=8))
