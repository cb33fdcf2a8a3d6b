"""When a trial stands, has failed, or is undecided; which ways count; what a factor does to strength."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.breaking.criteria import Criteria, most_moved
from geodem.breaking.weakening import Strength, set_strength
from tests.breaking.chains import STRENGTH, chain

RULES = Criteria()
DIAMETER = 1.0
MOST = 2000


def looks(ratio: float, way, count: int = 20):
    """A trial of equal looks; `way` (share of the trial) is what moved [m]."""
    return [(100 * (k + 1), ratio, way((k + 1) / count)) for k in range(count)]


@pytest.mark.parametrize(
    ("history", "verdict"),
    [
        (looks(5e-5, lambda t: 0.1), "stable"),
        # two diameters at a steady speed
        (looks(1e-2, lambda t: 2.5 * t), "failed"),
        # the same way, nearly at rest again
        (looks(1e-2, lambda t: 2.5 * (1.0 - np.exp(-8.0 * t)), 19), None),
        (looks(1e-2, lambda t: 0.5 * t, 10), None),
        # at the step limit: still going as fast as before
        (looks(1e-2, lambda t: 1.0 * t), "failed"),
        # at the step limit: no farther for a long time, in balance but for a grain that rolls
        (looks(1e-3, lambda t: 0.3), "stable"),
        # at the step limit: slowing down
        (looks(1e-2, lambda t: 1.0 - np.exp(-6.0 * t)), "undecided"),
    ],
)
def test_verdicts(history, verdict):
    found = RULES.judge(history, DIAMETER, MOST)
    assert (None if found is None else found[0]) == verdict


def test_what_moves_most_is_ten_particles_at_least():
    ways = np.concatenate([np.zeros(990), np.full(10, 3.0)])
    assert most_moved(ways, 0.005) == 3.0
    assert most_moved(ways, 0.02) == 1.5
    assert most_moved(np.array([1.0, 2.0]), 0.005) == 1.5


def test_step_limits_grow_with_the_length_of_a_side():
    assert RULES.most_steps(10_000, 2) == 4 * RULES.most_steps(625, 2) == 20_000
    assert RULES.most_steps(1_000_000, 3) == 20_000


def test_strength_over_a_factor_leaves_stiffness():
    s = chain()
    full = Strength.of(s)
    set_strength(s, full, np.array([4.0]), 4.0)
    # effective modulus, stiffness ratio, tensile and shear strength, friction, moment contribution
    assert s.bond_table[0] == pytest.approx([1e9, 2.0, STRENGTH / 4, 1e8 / 4, 0.5 / 4, 0.0])
    assert s.table[0, :3] == pytest.approx([1e9, 2.0, 0.5 / 4])
    assert full.bond[0, 2] == STRENGTH
    walls = s.wall_parameters
    assert (walls[:, 2] == full.wall[:, 2] / 4).all()
