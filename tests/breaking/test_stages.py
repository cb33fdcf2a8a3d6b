"""Stages on a hanging chain: weights, falls and ways that follow from mechanics alone."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.breaking.criteria import Criteria
from geodem.breaking.site import Site
from geodem.breaking.snapshot import bring_back, keep
from geodem.breaking.stages import ChangeStrength, Excavate, Gravity, MoveWall, RemoveWalls, Run, Settle
from geodem.breaking.walls import without_walls
from geodem.breaking.watching import Silent
from geodem.errors import InputError, StoppedError
from tests.breaking.chains import FACTOR, GRAVITY, LINKS, RADIUS, WEIGHT, chain, site

# small scenes need more steps a length than large ones to come to rest
PATIENT = Criteria(rest=1e-6, steps_per_length=3000.0)


def settled() -> Site:
    found = site()
    facts = Settle("settle", criteria=PATIENT).carry_out(found, Silent())
    assert facts["at_rest"]
    return found


def reaction(found: Site) -> float:
    """Pull of the first disc on what holds it, its own weight not counted [N]."""
    return -float(found.simulation.forces[0, 1]) - WEIGHT * found.gravity_factor


def test_settled_chain_hangs_with_its_whole_weight():
    found = settled()
    assert reaction(found) == pytest.approx((LINKS - 1) * WEIGHT, rel=1e-4)
    # a chain of equal springs k = E 2r/2r under its weight: k u = W n (n - 1)/2 at the end, n = LINKS
    end = found.at_points()["end"][1]
    assert end == pytest.approx(-WEIGHT * LINKS * (LINKS - 1) / 2 / 1e9, rel=1e-3)
    assert not found.displacement(found.settled).any()


def test_gravity_times_two():
    found = settled()
    facts = Gravity("twice", 2.0, PATIENT).carry_out(found, Silent())
    assert facts["gravity_factor"] == 2.0
    assert reaction(found) == pytest.approx(2 * (LINKS - 1) * WEIGHT, rel=1e-4)


def test_excavated_part_leaves_the_weight_of_the_rest():
    found = settled()
    stage = Excavate("cut", lambda s: s.simulation.positions[:, 1] < -7.4 * 2 * RADIUS, 5, True, PATIENT)
    facts = stage.carry_out(found, Silent())
    assert facts["particles_removed"] == 4
    assert facts["mass_removed"] == pytest.approx(4 * WEIGHT / GRAVITY)
    assert reaction(found) == pytest.approx((LINKS - 1 - 4) * WEIGHT, rel=1e-4)
    assert found.number.tolist() == list(range(LINKS - 4))
    assert np.isnan(found.at_points()["end"]).all()


def test_an_excavation_of_nothing_or_all_is_refused():
    for inside in (False, True):
        with pytest.raises(InputError, match="cut"):
            Excavate("cut", lambda s, inside=inside: np.full(LINKS, inside)).carry_out(site(), Silent())


def test_strength_of_a_material_falls_until_it_breaks():
    found = settled()
    ChangeStrength("weaker", (0,), 0.9 * FACTOR, PATIENT).carry_out(found, Silent())
    assert found.cracks().count == 0
    ChangeStrength("weaker still", (), 1.2, PATIENT).carry_out(found, Silent())
    cracks = found.cracks()
    assert cracks.by_mode() == {"tension": 1, "shear": 0}
    # the top bond, between the first two discs
    assert cracks.bond.tolist() == [0]
    assert cracks.place[0] == pytest.approx([0.0, -RADIUS], abs=0.05)


def test_freed_chain_falls_as_damping_lets_it():
    """Local damping alpha takes alpha of the resultant force: a = g (1 - alpha)."""
    found = site(0.4)
    found.set_strength(1e9)
    Run("fall", 1.0).carry_out(found, Silent())
    s = found.simulation
    assert found.at_points()["end"][1] == pytest.approx(-0.5 * 0.6 * GRAVITY * s.time**2, rel=0.02)
    with pytest.raises(StoppedError):
        found.advance(1, Stopping())


class Stopping(Silent):
    def stop_asked(self) -> bool:
        return True


def test_moved_wall_goes_its_way_and_stands_still():
    found = site()
    facts = MoveWall("lower", "shelf", (0.0, -2.0), 0.01).carry_out(found, Silent())
    s = found.simulation
    assert facts["wall_displacement_m"] == pytest.approx([0.0, -2.0 * s.time], rel=1e-9)
    found.advance(10, Silent())
    assert s.walls.displacements()[1][1] == pytest.approx(facts["wall_displacement_m"][1])


def test_a_wall_taken_away_changes_nothing_else():
    whole, less = site(), site()
    facts = RemoveWalls("open", ("shelf",)).carry_out(less, Silent())
    assert facts == {"walls_removed": ["shelf"]}
    assert less.simulation.walls.names == ("floor",)
    for found in (whole, less):
        found.advance(500, Silent())
    assert np.array_equal(whole.simulation.positions, less.simulation.positions)
    assert len(less.history[0]) == len(less.columns()) == len(whole.history[0])
    assert np.isnan(less.wall_forces()["shelf"]).all()
    with pytest.raises(InputError, match="wall"):
        without_walls(less.simulation, ("shelf",))


def test_a_kept_state_goes_on_to_the_same_bits():
    s = chain()
    s.run(200)
    tree = keep(s)
    s.run(300)
    for _ in range(2):
        other = bring_back(tree)
        other.run(300)
        assert np.array_equal(other.positions, s.positions)
        assert other.time == s.time
    whole = settled()
    again = Site.from_tree(whole.tree())
    for found in (whole, again):
        found.advance(250, Silent())
    assert np.array_equal(whole.simulation.positions, again.simulation.positions)
    assert whole.history[-1] == pytest.approx(again.history[-1], rel=0, abs=0, nan_ok=True)
