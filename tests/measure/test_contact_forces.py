"""Forces of contacts and bonds against statics: what holds a particle up is its weight and what lies on it."""

import numpy as np
import pytest

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

GRAVITY = 9.81
CONTACT = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
BONDS = {
    "two_springs": {"normal_stiffness": 1e7, "shear_stiffness": 5e6, "tensile_strength": 1e9, "cohesion": 1e9,
                    "friction_coefficient": 0.5, "width_ratio": 0.8},
    "parallel_bond": {"radius_factor": 1.0, "normal_stiffness": 1e8, "shear_stiffness": 5e7,
                      "tensile_strength": 1e12, "shear_strength": 1e12},
}  # fmt: skip


def resultants(simulation):
    """Contact forces and weight, summed for every particle (n, d)."""
    a = simulation.assembly
    total = a.mass[:, None] * a.gravity
    normal, shear = simulation.contact_forces()
    first, second = simulation.contacts().pairs.T
    apart = simulation.positions[second] - simulation.positions[first]
    along = apart / np.sqrt((apart**2).sum(axis=1))[:, None]
    force = -normal[:, None] * along + shear
    np.add.at(total, first, force)
    np.add.at(total, second, -force)
    return total


@pytest.mark.parametrize(
    ("dimension", "law"), [(2, "two_springs"), (2, "parallel_bond"), (3, "parallel_bond")]
)
def test_a_beam_carries_its_weight_to_where_it_is_held(dimension, law):
    """Normal, shear and tension: every free particle in balance, the held ones bear everything."""
    builder = AssemblyBuilder(dimension, bond_law=law, gravity=(0.0,) * (dimension - 1) + (-GRAVITY,))
    builder.add_material("rock", density=2000.0, contact=CONTACT, bond=BONDS[law])
    kind, cells = ("hexagonal", (8, 2)) if dimension == 2 else ("fcc", (4, 2, 2))
    places = lattice(kind, 0.1, cells=cells).positions
    builder.add_particles(places, 0.1, "rock")
    builder.bond_within(1.01)
    held = places[:, 0] < places[:, 0].min() + 0.15
    rest = {"x": 0.0, "y": 0.0, "rotation": 0.0} | ({"z": 0.0} if dimension == 3 else {})
    builder.hold(held, **rest)
    simulation = ParticleSimulation(builder.build())
    assert find_equilibrium(simulation, tolerance=1e-9).reached
    weight = float(simulation.assembly.mass.sum()) * GRAVITY
    left = resultants(simulation)
    assert np.abs(left[~held]).max() < 1e-6 * weight
    assert left[held].sum(axis=0)[-1] == pytest.approx(-weight, rel=1e-6)
    normal, shear = simulation.contact_forces()
    assert normal.min() < 0.0 < normal.max()
    assert np.abs(shear).max() > 0.01 * weight


def test_a_column_on_a_floor():
    """The k-th contact from above bears k discs."""
    builder = AssemblyBuilder(2, gravity=(0.0, -GRAVITY))
    builder.add_material("grain", density=2000.0, contact=CONTACT)
    ids = builder.add_particles([(0.0, 0.1 + 0.2 * k) for k in range(4)], 0.1, "grain")
    builder.hold(ids, x=0.0, rotation=0.0)
    builder.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0)))
    simulation = ParticleSimulation(builder.build(), local_damping=0.8)
    simulation.run(3000)
    one = 2000.0 * np.pi * 0.01 * GRAVITY
    normal, shear = simulation.contact_forces()
    assert simulation.contacts().pairs.tolist() == [[0, 1], [1, 2], [2, 3]]
    assert normal == pytest.approx([3 * one, 2 * one, one], rel=1e-6)
    assert np.abs(shear).max() < 1e-6 * one
