"""Bonded ground under an initial stress; larger ones: reference/problems/ground_initial_stress.py."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.errors import InputError
from geodem.particle_simulation import ParticleSimulation
from geodem.preparation.initial_stress import (
    bulk_unit_weight,
    far_field,
    ground_stress,
    link_forces,
    set_initial_stress,
)
from reference.problems.ground_initial_stress import BOXES, TENSORS, ground, initial_stress
from tests.verification.rows import check


def test_far_field_and_k0_in_2d():
    """Every component within 1 % of the largest wanted one, no bond broken."""
    check(*initial_stress(2))


def test_far_field_in_3d():
    s = ground(3, (8.0, 8.0, 7.0), weight=False)
    found = set_initial_stress(s, far_field(1e6 * TENSORS[3]))
    assert found.reached
    assert found.error < 0.01
    assert s.intact().all()
    assert found.measured[0] == pytest.approx(1e6 * TENSORS[3], abs=2e4)


def test_k0_in_3d():
    """Shear stresses on level planes among them, which no strain that grows upwards takes away."""
    s = ground(3, (8.0, 8.0, 7.0), weight=True)
    top = float((s.positions[:, 2] + s.assembly.radii).max())
    wanted = ground_stress(3, unit_weight=bulk_unit_weight(s), k0=(1.5, 0.8), top=top)
    found = set_initial_stress(s, wanted)
    assert found.reached
    scale = np.abs(found.wanted).max(axis=(1, 2))[:, None, None]
    assert np.abs((found.measured - found.wanted) / scale).max() < 0.005


def test_weight_of_the_ground_above_is_borne_at_every_depth():
    """The vertical force through a level of the whole width is the weight above, but for what the sides bear."""
    s = ground(2, BOXES[2], weight=True)
    top = float((s.positions[:, 1] + s.assembly.radii).max())
    # its own weight, from all of it
    width = 40.0
    unit_weight = float(s.assembly.mass.sum()) * 9.81 / (width * 30.0)
    found = set_initial_stress(s, ground_stress(2, unit_weight=unit_weight, k0=0.8, top=top))
    assert s.intact().all()
    branches, starts, forces = link_forces(s)
    level = 12.0
    below, above = starts[:, 1] < level, starts[:, 1] + branches[:, 1] > level
    middle = np.abs(starts[:, 0] - 20.0) < 15.0
    up = (below & above & middle).nonzero()[0]
    down = (~below & ~above & middle & (starts[:, 1] + branches[:, 1] < level)).nonzero()[0]
    thrust = -float(forces[up, 1].sum()) + float(forces[down, 1].sum())
    assert thrust == pytest.approx(unit_weight * (top - level) * 30.0, rel=0.03)
    assert found.measured[:, 0, 0] == pytest.approx(0.8 * found.wanted[:, 1, 1], rel=0.02)


def test_what_cannot_be_is_refused():
    with pytest.raises(InputError, match="symmetric"):
        far_field([[1.0, 2.0], [0.0, 1.0]])
    with pytest.raises(InputError, match="tensor"):
        far_field([1.0, 2.0])
    with pytest.raises(InputError, match="K0"):
        ground_stress(2, unit_weight=2e4, k0=-1.0, top=0.0)
    build = AssemblyBuilder(2)
    contact = {"normal_stiffness": 1e7, "shear_stiffness": 1e7, "friction_coefficient": 0.5}
    build.add_material("m", density=2500.0, contact=contact)
    build.add_particles([[0.0, 0.0], [0.2, 0.0]], 0.1, "m")
    with pytest.raises(InputError, match="nothing is held"):
        set_initial_stress(ParticleSimulation(build.build()), far_field(np.eye(2)))
    with pytest.raises(InputError, match="2 x 2"):
        set_initial_stress(ParticleSimulation(build.build()), far_field(np.eye(3)))
