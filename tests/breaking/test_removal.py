"""Particles taken out of a simulation: what is left goes on as it was."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.breaking.removal import remove_particles
from geodem.breaking.scene import start
from geodem.breaking.shapes import inside_box, inside_circle, inside_cylinder, inside_polygon
from geodem.breaking.structures import BoltPlan, JointPlan
from geodem.builders.bolts import Bar, Grout
from geodem.builders.joints import segment
from geodem.errors import InputError
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium
from geodem.preparation.initial_stress import far_field
from tests.breaking.scenes import random_ground

JOINT = {"normal_stiffness": 1e10, "shear_stiffness": 5e9, "friction_coefficient": 0.6}

STRESS = far_field(np.diag([-2e6, -1e6]))


@pytest.fixture
def pressed() -> ParticleSimulation:
    """Ground of 390 or so discs at rest under stress, with room for applied forces."""
    simulation, found = start(random_ground(380, initial_stress=STRESS), applied=True, local_damping=0.2)
    assert found is not None
    simulation.run(50)
    return simulation


def hole(simulation: ParticleSimulation) -> np.ndarray:
    return inside_circle(simulation.positions, (5.0, 4.0), 1.2)


def test_nothing_moves_while_the_forces_are_kept(pressed):
    gone = hole(pressed)
    places, ratio = pressed.positions, pressed.unbalanced_ratio()
    removal = remove_particles(pressed, gone)
    history = pressed.contacts()
    new = removal.simulation
    assert np.array_equal(new.positions, places[~gone])
    assert np.array_equal(new.assembly.radii, pressed.assembly.radii[~gone])
    # what the contacts remember, to the bit
    kept = ~gone[history.pairs].any(axis=1)
    found = new.contacts()
    assert np.array_equal(removal.particles[found.pairs], history.pairs[kept])
    for name, values in history.history.items():
        assert np.array_equal(found.history[name], values[kept]), name
    new.run(100)
    assert new.unbalanced_ratio() < 2.0 * max(ratio, 1e-5)
    assert np.abs(new.positions - places[~gone]).max() < 1e-7
    # in balance under the far field, what the hole bears is nothing as a whole
    face = removal.face
    pushed = np.abs(face.forces[:, :2]).sum()
    assert np.abs(face.resultant).max() < 1e-3 * pushed


def test_forces_are_the_momentum_that_the_removed_gave(pressed):
    """Newton's third law: what acts on the removed from outside is opposite to what they exert."""
    gone = hole(pressed)
    pairs = pressed.contacts().pairs
    normal, shear = pressed.contact_forces()
    apart = pressed.positions[pairs[:, 1]] - pressed.positions[pairs[:, 0]]
    along = apart / np.linalg.norm(apart, axis=1)[:, None]
    on_first = shear - normal[:, None] * along
    wanted = np.zeros_like(pressed.positions)
    np.add.at(wanted, pairs[:, 0], np.where(gone[pairs[:, 1]][:, None], on_first, 0.0))
    np.add.at(wanted, pairs[:, 1], np.where(gone[pairs[:, 0]][:, None], -on_first, 0.0))
    face = remove_particles(pressed, gone).face
    old = np.flatnonzero(~gone)[face.particles]
    scale = np.abs(wanted).max()
    assert face.forces[:, :2] == pytest.approx(wanted[old], abs=1e-9 * scale)


def test_a_released_face_moves_in(pressed):
    gone = hole(pressed)
    removal = remove_particles(pressed, gone)
    new, face = removal.simulation, removal.face
    before = new.positions[face.particles]
    moved = []
    for factor in (0.5, 0.0):
        face.set(new, factor)
        find_equilibrium(new, breaking=False)
        away = before - np.array([5.0, 4.0])
        way = new.positions[face.particles] - before
        moved.append(-float((way * away).sum(axis=1).mean()))
    # elastic: half of the forces, half of the way
    assert moved[0] > 0.0
    assert moved[1] == pytest.approx(2.0 * moved[0], rel=0.02)
    assert np.abs(new.arrays.applied).max() < 1e-9 * np.abs(face.forces).max()


def test_what_is_apart_goes_on_to_the_bit():
    """Two blocks that do not touch: one goes, and the other does not notice."""
    ground = random_ground(300, supports={"bottom": "fixed"}, gravity=(0.0, -9.81))
    one, other = (ParticleSimulation(ground.assembly, applied=True, local_damping=0.2) for _ in range(2))
    cut = inside_box(one.positions, (4.5, -1.0), (5.5, 9.0))
    left = [remove_particles(s, cut, keep_forces=False).simulation for s in (one, other)]
    for s in left:
        s.run(40)
    far = left[1].positions[:, 0] > 5.0
    removal = remove_particles(left[1], far, keep_forces=False)
    left[0].feel(left[0].kernel(left[0].features))
    left[0].run(40)
    removal.simulation.run(40)
    assert np.array_equal(left[0].positions[~far], removal.simulation.positions)
    assert np.array_equal(left[0].velocities[~far], removal.simulation.velocities)


def test_energy_goes_with_the_removed_and_the_account_stays_closed():
    ground = random_ground(300, supports={"bottom": "fixed"}, gravity=(0.0, -9.81))
    s = ParticleSimulation(ground.assembly, applied=True, energy=True)
    s.run(200)
    error = s.energy().imbalance
    removal = remove_particles(s, inside_polygon(s.positions, [[4, 5], [8, 5], [8, 9], [4, 9]]))
    assert removal.energy > 0.0
    new = removal.simulation
    # of the removed: m v^2/2, and what bonds to them held
    speed = 0.5 * float((s.assembly.mass[:, None] * s.velocities**2)[removal.new_of_old < 0].sum())
    elastic = s.energy().elastic - new.energy().elastic
    assert removal.energy == pytest.approx(speed + elastic, rel=0.02)
    new.run(200)
    assert abs(new.energy().imbalance) < 1e-4
    assert abs(error) < 1e-4


def test_a_checkpoint_of_what_is_left_goes_on(pressed, tmp_path):
    new = remove_particles(pressed, hole(pressed)).simulation
    new.save(tmp_path / "left.h5")
    again = ParticleSimulation.resume(tmp_path / "left.h5")
    for s in (new, again):
        s.run(30)
    assert np.array_equal(new.positions, again.positions)


def test_breaks_and_bonds_keep_their_places():
    ground = random_ground(300, supports={"bottom": "fixed"}, gravity=(0.0, -9.81))
    s = ParticleSimulation(ground.assembly, applied=True)
    s.run(1)
    s.record[5, 0] = 1
    gone = inside_box(s.positions, (-1.0, 6.0), (11.0, 9.0))
    removal = remove_particles(s, gone)
    assert removal.broken.bond.tolist() == [5]
    assert np.array_equal(
        removal.particles[removal.simulation.assembly.bonds], s.assembly.bonds[removal.bonds]
    )
    again = remove_particles(removal.simulation, inside_circle(removal.simulation.positions, (5.0, 4.0), 1.0))
    carried = removal.face.after(again)
    assert np.array_equal(
        again.particles[carried.particles],
        removal.face.particles[np.isin(removal.face.particles, again.particles)],
    )


def test_shapes():
    points = np.array([[0.5, 0.5, 0.5], [2.0, 0.0, 0.0], [0.0, 0.0, 3.0]])
    assert inside_box(points, (0, 0, 0), (1, 1, 1)).tolist() == [True, False, False]
    assert inside_circle(points, (0, 0, 0), 1.0).tolist() == [True, False, False]
    assert inside_cylinder(points, (0, 0, -1), (0, 0, 4), 1.0).tolist() == [True, False, True]
    assert inside_polygon(points, [[0, 0], [1, 0], [1, 1], [0, 1]]).tolist() == [True, False, True]
    for call in (
        lambda: inside_box(points, (0, 0, 0), (0, 1, 1)),
        lambda: inside_circle(points, (0, 0, 0), -1.0),
        lambda: inside_cylinder(points, (0, 0, 0), (0, 0, 0), 1.0),
        lambda: inside_polygon(points, [[0, 0], [1, 1], [1, 0], [0, 1]]),
    ):
        with pytest.raises(InputError):
            call()


def test_what_cannot_be_removed_is_refused(pressed):
    count = pressed.assembly.particles
    for which, match in (
        (np.zeros(count, dtype=bool), "nothing"),
        (np.ones(count, dtype=bool), "everything"),
        ([count], "particles 0 to"),
        (np.ones(3, dtype=bool), "mask"),
    ):
        with pytest.raises(InputError, match=match):
            remove_particles(pressed, which)


def test_joints_bolts_and_walls_bear_what_they_bore():
    """All forces on what is left are those before, with those of the removed kept."""
    joint = JointPlan("fault", [segment((0.0, 2.0), (10.0, 5.0), "joint")], JOINT)
    bolts = [
        BoltPlan(f"b{k}", np.array([k, 8.0]), np.array([k, 1.0]), Bar(1e8), Grout(1e7)) for k in (2.0, 5.0)
    ]
    scene = random_ground(
        300, supports={"left": "wall", "right": "wall", "bottom": "rough"}, gravity=(0.0, -9.81), joints=[joint],
        bolts=bolts,
    )  # fmt: skip
    s = ParticleSimulation(scene.assembly, applied=True, local_damping=0.2)
    s.run(150)
    # the second bolt goes with what is around it, and a piece of the joint
    gone = inside_box(s.positions, (4.2, -1.0), (6.0, 9.0))
    removal = remove_particles(s, gone)
    new = removal.simulation
    scale = np.abs(s.forces).max()
    assert new.forces == pytest.approx(s.forces[removal.particles], abs=1e-9 * scale)
    joints, before = new.assembly.joints, s.assembly.joints
    assert joints is not None
    assert before is not None
    crossed = ~gone[before.pairs].any(axis=1)
    assert np.array_equal(removal.particles[joints.pairs], before.pairs[crossed])
    for name in ("left", "right", "bottom"):
        assert np.abs(new.wall_force(name)).max() <= np.abs(s.wall_force(name)).max() * (1.0 + 1e-9)
    new.run(50)
    assert np.isfinite(new.positions).all()
