"""Growth of radii and compaction in a periodic cell: porosity, pressure, and contacts near isostatic."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.builders.random_addition import scatter_particles
from geodem.builders.sizes import equal, graded, uniform
from geodem.errors import InputError
from geodem.particle_simulation import ParticleSimulation
from geodem.preparation import Grains, PreparedSample, compact, grow_radii

GRAINS = Grains(2600.0, {"normal_stiffness": 1e7, "shear_stiffness": 5e6, "friction_coefficient": 0.5})
# two sizes, 1 to 1.4, as many of each: they do not crystallise
TWO_SIZES = graded([(0.01, 0.0), (0.01, 1 / 2.96), (0.014, 1 / 2.96), (0.014, 1.0)], 2)


def scattered(dimension, count=300, seed=1):
    if dimension == 2:
        return scatter_particles(2, TWO_SIZES, count=count, solid_fraction=0.5, seed=seed)
    return scatter_particles(3, equal(0.01), count=count, solid_fraction=0.3, seed=seed)


def overlaps(sample):
    """Of all pairs, one by one, through the faces of the cell [m]; positive where they overlap."""
    step = sample.positions[:, None] - sample.positions[None]
    share = step @ np.linalg.inv(sample.cell)
    distance = np.linalg.norm((share - np.round(share)) @ sample.cell, axis=-1)
    return (sample.radii[:, None] + sample.radii[None] - distance)[np.triu_indices(sample.particles, 1)]


@pytest.fixture(scope="module")
def discs():
    return compact(scattered(2), GRAINS, coordination=4.2, local_damping=0.3)


@pytest.fixture(scope="module")
def spheres():
    return compact(scattered(3), GRAINS, pressure=2e4, local_damping=0.3)


def test_discs_reach_their_coordination_in_equilibrium(discs):
    assert discs.reached, discs.reason
    assert discs.coordination == pytest.approx(4.2, abs=0.05)
    assert discs.unbalanced_ratio < 1e-3
    # but for a pair that the last step itself may have closed or opened
    assert discs.coordination == pytest.approx(2.0 * (overlaps(discs) > 0.0).sum() / 300, abs=0.014)
    # jammed discs of these sizes: 0.842, O'Hern et al. (2003), Phys. Rev. E 68:011306
    assert discs.solid_fraction == pytest.approx(0.842, abs=0.015)
    assert discs.simulation.cell.velocity_gradient.tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_spheres_reach_their_pressure_with_contacts_near_isostatic(spheres):
    """Jammed: solid fraction 0.639 of equal spheres, 2 d contacts a particle without rattlers, O'Hern et al. (2003)."""
    assert spheres.reached, spheres.reason
    assert spheres.pressure == pytest.approx(2e4, rel=0.011)
    # the stress of Love and Weber from the overlaps alone, a step later
    depth = overlaps(spheres)
    depth = depth[depth > 0.0]
    pressed = (1e7 * depth * (0.02 - depth)).sum() / (3.0 * abs(np.linalg.det(spheres.cell)))
    assert spheres.pressure == pytest.approx(pressed, rel=1e-4)
    assert spheres.mechanical_coordination == pytest.approx(6.0, abs=0.35)
    assert spheres.solid_fraction == pytest.approx(0.639, abs=0.02)
    stress = -spheres.stress / spheres.pressure
    assert stress == pytest.approx(np.eye(3), abs=0.25)


def test_porosity_is_met_to_rounding():
    sample = compact(scattered(2), GRAINS, porosity=0.14, local_damping=0.3)
    assert sample.reached, sample.reason
    volume = math.pi * (sample.radii**2).sum()
    assert 1.0 - volume / abs(np.linalg.det(sample.cell)) == pytest.approx(0.14, abs=1e-9)
    assert sample.pressure > 0.0
    # it shrank alike in all directions
    sides = np.diag(sample.cell)
    assert sides == pytest.approx(sides[0], rel=1e-12)


def test_friction_makes_a_looser_sample(discs):
    rough = compact(scattered(2), GRAINS, friction=None, coordination=3.6, local_damping=0.3)
    assert rough.grains.friction == 0.5
    assert rough.reached, rough.reason
    assert rough.porosity > discs.porosity + 0.01
    # made anew from its numbers it is in balance only with the shear forces that its contacts remember
    ratios = []
    for remembered in ({}, rough.history):
        simulation = ParticleSimulation(rough.assembly(), local_damping=0.3, orientation=False)
        simulation.hand_over(rough.pairs, **remembered)
        simulation.run(1)
        ratios.append(simulation.unbalanced_ratio())
    assert ratios[1] < 5e-3
    assert ratios[0] > 5.0 * ratios[1]


def test_coordination_between_loose_and_rigid_is_told_not_to_be_reached():
    """Without friction contacts come all at once: none below, 2 d from where the discs jam."""
    sample = compact(scattered(2, 100), GRAINS, coordination=2.0, local_damping=0.3, most_steps=200_000)
    assert not sample.reached
    assert sample.reason
    assert sample.got == sample.coordination


def test_growth_meets_the_porosity_exactly():
    sample = grow_radii(3, GRAINS, uniform(0.008, 0.012), count=300, porosity=0.345, seed=2)
    assert sample.reached, sample.reason
    volume = 4.0 / 3.0 * math.pi * (sample.radii**3).sum()
    assert 1.0 - volume / np.prod(np.diag(sample.cell)) == pytest.approx(0.345, abs=1e-12)
    # denser than jammed: it bears a pressure
    assert sample.pressure > 0.0
    # 5.98 + 7.9 sqrt(excess of the solid fraction over jammed, 0.625 to 0.645 here), O'Hern et al. (2003)
    assert 5.98 + 7.9 * math.sqrt(0.655 - 0.645) - 0.1 < sample.mechanical_coordination
    assert sample.mechanical_coordination < 5.98 + 7.9 * math.sqrt(0.655 - 0.625) + 0.1
    assert sample.radii.max() / sample.radii.min() == pytest.approx(1.5, rel=0.01)
    # the grains kept their density
    mass = sample.simulation.assembly.mass
    assert mass.sum() == pytest.approx(2600.0 * volume, rel=1e-12)


def test_growth_to_a_loose_porosity_leaves_no_contact_that_presses():
    sample = grow_radii(2, GRAINS, TWO_SIZES, box=(0.5, 0.4), porosity=0.22, seed=2)
    assert sample.porosity == pytest.approx(0.22)
    assert np.diag(sample.cell).tolist() == pytest.approx([0.5, 0.4])
    assert overlaps(sample).max() <= 0.0
    assert sample.reached
    assert sample.pressure == 0.0


def test_too_dense_is_told_with_where_they_jam():
    sample = grow_radii(3, GRAINS, equal(0.01), count=120, porosity=0.27, seed=2)
    assert not sample.reached
    assert "without pressure these jam at a porosity of about 0.3" in sample.reason


def test_a_seed_gives_the_same_bits(discs):
    again = compact(scattered(2), GRAINS, coordination=4.2, local_damping=0.3)
    assert (again.positions == discs.positions).all()
    assert again.steps == discs.steps


def test_sample_comes_back_with_its_cell(tmp_path, discs):
    discs.save(tmp_path / "discs.npz")
    found = PreparedSample.load(tmp_path / "discs.npz")
    assert (found.cell == discs.cell).all()
    assert (found.stress == discs.stress).all()
    further = compact(found, GRAINS, coordination=4.4, local_damping=0.3)
    assert further.reached
    assert further.porosity < discs.porosity


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "one target"),
        ({"porosity": 0.2, "pressure": 1e5}, "one target"),
        ({"porosity": 0.01}, "no packing of equal particles is denser than 0.093"),
        ({"porosity": 0.9}, "denser already"),
        ({"coordination": 6.5}, "no packing in 2D has more than 6 contacts"),
        ({"pressure": -1e5}, "nothing presses"),
        ({"porosity": 0.2, "strain_rate": -1.0}, "has to shrink"),
        ({"porosity": 0.2, "within": 0.0}, "no distance"),
    ],
)  # fmt: skip
def test_wrong_input_is_refused(given, words):
    with pytest.raises(InputError, match=words):
        compact(scattered(2, 50), GRAINS, local_damping=0.3, **given)


def test_starts_and_sizes_that_cannot_be_are_refused():
    closed = scatter_particles(2, equal(0.01), count=50, solid_fraction=0.3, periodic=False, seed=1)
    with pytest.raises(InputError, match="no periodic cell"):
        compact(closed, GRAINS, porosity=0.2, local_damping=0.3)
    with pytest.raises(InputError, match="no packing of equal particles"):
        grow_radii(3, GRAINS, equal(0.01), count=50, porosity=0.2, seed=1)
    with pytest.raises(InputError, match="either a box or a count"):
        grow_radii(3, GRAINS, equal(0.01), porosity=0.4, seed=1)
