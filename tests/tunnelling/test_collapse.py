"""Collapse of tunnels in clay against limit analysis; longer runs: reference/problems/tunnels.py."""

from __future__ import annotations

import pytest

from geodem.tunnelling.collapse import make_search
from reference.problems.tunnels_shallow import collapse_pressure, half, middle, shallow_strength


def test_strength_reduction_finds_the_collapse_of_the_bounds():
    """Clay 1.3 times as strong as at the collapse between both bounds has the factor 1.3, within 1.5 %."""
    row = shallow_strength(2.0, 0.0, 1500)
    assert row.good, (row.value, row.expected)


def test_the_reaction_curve_ends_where_the_tunnel_collapses():
    """Only the difference of surcharge and pressure on the wall counts in weightless clay."""
    (row,) = collapse_pressure(1.0, 0.0, 1500)
    assert row.good, (row.value, row.expected)


def test_a_tunnel_that_fell_in_has_a_factor_below_one():
    """Trials start from the elastic answer to the excavation, so the collapse on the way does not matter."""
    digging = half(1.0, 0.0, middle(1.0, 0.0), 600, strength=0.7)
    assert digging.run().collapse is not None
    found = make_search(digging, "strength-reduction", tolerance=0.02).run().value
    assert found == pytest.approx(0.7, rel=0.03)
