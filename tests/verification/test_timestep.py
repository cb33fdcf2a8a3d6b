"""Critical time step of regular packings: reference/problems/timestep.py."""

from __future__ import annotations

import pytest

from reference.problems import timestep_engine
from reference.problems.regular_packings import CELLS, CONTACTS, packing
from reference.problems.timestep import RATIOS, damped, driven, expected_step, found_step
from tests.verification.rows import check

# dt/sqrt(m/kn) of the full spectrum of lattice waves, four places, for ks/kn = 0, 0.4, 0.5, 1
TABLE = {
    "square": (1.0000, 0.7906, 0.7071, 0.5000),
    "hexagonal": (0.8165, 0.6455, 0.5774, 0.4082),
    "SC": (1.0000, 0.7071, 0.6325, 0.4472),
    "BCC": (0.8660, 0.6124, 0.5477, 0.3873),
    "FCC": (0.7071, 0.5000, 0.4472, 0.3162),
    "HCP": (0.7071, 0.5000, 0.4472, 0.3162),
}


@pytest.mark.parametrize("kind", CELLS)
def test_closed_forms_are_those_of_the_table(kind):
    found = [expected_step(kind, ratio) for ratio in RATIOS]
    assert found == pytest.approx(TABLE[kind], abs=5.1e-5)


@pytest.mark.parametrize("kind", CELLS)
def test_contacts_of_a_particle(kind):
    for cells in (1, 2, 3):
        cell = packing(kind, cells)
        assert 2 * len(cell.pairs) == CONTACTS[kind] * len(cell.positions)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("kind", CELLS)
def test_step(kind, ratio):
    """Periodic to 1e-6; a finite packing allows no less, Gershgorin's bound no more."""
    check(*found_step(kind, ratio))


@pytest.mark.parametrize("ratio", [0.0, 0.5])
@pytest.mark.parametrize("kind", ["square", "hexagonal", "BCC", "FCC"])
def test_bounded_below_and_growing_above(kind, ratio):
    check(*driven(kind, ratio))


@pytest.mark.parametrize("damping", [{"local": 0.8}, {"viscous": 0.3}, {"viscous": 0.2, "local": 0.7}])
def test_with_damping(damping):
    check(*damped("FCC", 0.5, **damping))


@pytest.mark.parametrize(("kind", "ratio", "steps"), [("hexagonal", 0.5, 10_000), ("BCC", 0.0, 1000)])
def test_by_the_engine(kind, ratio, steps):
    check(*timestep_engine.by_engine(kind, ratio, expected_step(kind, ratio), steps=steps))
