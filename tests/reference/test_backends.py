"""Other codes as geodem runs them: two spheres against the closed form, and three codes against each other."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from reference import ours, scenes
from reference.backends import BACKENDS, Outcome
from reference.backends.outcome import WARM_UP
from reference.backends.program import BackendError

RADII = (4e-3, 6e-3)  # [m]
SPEED = 0.3  # [m/s]


def installed(name: str) -> None:
    """Skip where a code is not there; the message holds the command that installs it."""
    missing = BACKENDS[name].available()
    if missing:
        pytest.skip(missing)


@lru_cache
def collision(name: str, steps_in_contact: float) -> tuple[scenes.Scene, Outcome]:
    scene = scenes.head_on(RADII, SPEED, steps_in_contact=steps_in_contact)
    return scene, BACKENDS[name].run(scene, int(steps_in_contact) + 30, every=1)


@pytest.mark.parametrize("name", BACKENDS)
def test_two_spheres_touch_for_half_a_period_and_part_as_fast_as_they_met(name):
    # half a sine: duration pi sqrt(m/kn), largest overlap v sqrt(m/kn), m = m1 m2/(m1 + m2); no energy is lost.
    installed(name)
    steps = 500.25
    scene, outcome = collision(name, steps)
    reduced = scene.mass.prod() / scene.mass.sum()
    distance = np.linalg.norm(outcome.positions[:, 1] - outcome.positions[:, 0], axis=1)
    overlap = scene.radii.sum() - distance
    duration = np.count_nonzero(overlap > 0.0) * scene.time_step
    assert duration == pytest.approx(np.pi * np.sqrt(reduced / scene.normal), abs=scene.time_step)
    # leap-frog's error in amplitude is (omega dt)^2/8 and a little for the step in which they meet
    error = (np.pi / steps) ** 2
    assert overlap.max() == pytest.approx(SPEED * np.sqrt(reduced / scene.normal), rel=error)
    np.testing.assert_allclose(outcome.velocities[-1, :, 0], -scene.velocities[:, 0], rtol=error)
    # and nothing but the line between their centres knows of it
    assert not outcome.velocities[-1, :, 1:].any()
    assert not outcome.spins.any()


@pytest.mark.parametrize("name", BACKENDS)
def test_the_overlap_converges_with_the_square_of_the_step(name):
    installed(name)

    def error(steps_in_contact: float) -> float:
        # the collision lies alike between the steps for both, so the errors have the same shape
        scene, outcome = collision(name, steps_in_contact)
        reduced = scene.mass.prod() / scene.mass.sum()
        time = (np.arange(1, len(outcome.positions) + 1) - 10.25) * scene.time_step
        wave = np.sqrt(scene.normal / reduced)
        exact = np.where(time < 0.0, -time * SPEED, -np.sin(wave * time) * SPEED / wave)
        distance = outcome.positions[:, 1, 0] - outcome.positions[:, 0, 0] - scene.radii.sum()
        touching = (time > 0.0) & (wave * time < np.pi)
        return float(np.abs(distance - exact)[touching].max())

    assert np.log2(error(50.25) / error(100.25)) == pytest.approx(2.0, abs=0.3)


@pytest.mark.parametrize("name", ["yade", "lammps"])
def test_a_packing_without_friction_moves_alike_in_all_codes(name):
    """Contacts, walls, gravity, masses and time step are the same: only rounding may differ in 20 steps."""
    installed("liggghts")
    installed(name)
    scene = replace(scenes.spheres_in_a_box(200), friction=0.0)
    first = BACKENDS["liggghts"].run(scene, 20).positions[-1]
    second = BACKENDS[name].run(scene, 20).positions[-1]
    moved = np.abs(first - scene.positions).max()
    assert moved > 1e-8  # [m]
    np.testing.assert_allclose(second, first, atol=1e-7 * moved, rtol=0.0)


@pytest.mark.parametrize(("name", "bound"), [("yade", 0.01), ("lammps", 0.02)])
def test_friction_is_the_same_law_up_to_its_details(name, bound):
    """How the spring turns with the contact, and how long a lever is, differ by a share of overlap over radius."""
    installed("liggghts")
    installed(name)
    scene = scenes.spheres_in_a_box(200)
    first = BACKENDS["liggghts"].run(scene, 20)
    second = BACKENDS[name].run(scene, 20)
    moved = np.abs(first.positions[-1] - scene.positions).max()
    assert np.abs(second.positions[-1] - first.positions[-1]).max() < bound * moved
    assert np.abs(first.spins[-1]).max() > 0.0


def test_bonded_blocks_move_alike_in_yade_and_lammps():
    """The same stiffness in all four directions. YADE's shear counts the motion of the step before the start, too.

    That is a time lag of one step, so the steps are small and many.
    """
    for name in ("yade", "lammps"):
        installed(name)
    scene = scenes.bonded_block(60)
    scene = replace(scene, time_step=scene.time_step / 20.0)
    first, second = (BACKENDS[name].run(scene, 1000) for name in ("yade", "lammps"))
    moved = np.abs(first.positions[-1] - scene.positions).max()
    turned = np.abs(first.spins[-1]).max()
    assert np.abs(second.positions[-1] - first.positions[-1]).max() < 0.005 * moved
    assert np.abs(second.spins[-1] - first.spins[-1]).max() < 0.02 * turned


@pytest.mark.parametrize(("name", "bound"), [("yade", 1e-3), ("liggghts", 1e-3), ("lammps", 0.02)])
def test_geodem_moves_a_packing_as_the_others_do(name, bound):
    installed(name)
    scene = replace(scenes.spheres_in_a_box(600), box=None)
    theirs = BACKENDS[name].run(scene, 20).positions[-1]
    moved = np.abs(theirs - scene.positions).max()
    assert np.abs(ours.run(scene, 20).positions[-1] - theirs).max() < bound * moved
    # without friction nothing is left to differ but rounding
    smooth = replace(scene, friction=0.0)
    theirs = BACKENDS[name].run(smooth, 20).positions[-1]
    assert np.abs(ours.run(smooth, 20).positions[-1] - theirs).max() < 1e-7 * moved


@pytest.mark.parametrize(("name", "spins_bound"), [("yade", 2e-4), ("lammps", 0.01)])
def test_geodem_moves_a_bonded_block_as_the_others_do(name, spins_bound):
    """YADE counts the motion of the step before the start; LAMMPS' spins are half a step later than geodem's."""
    installed(name)
    scene = scenes.bonded_block(60)
    scene = replace(scene, time_step=scene.time_step / 20.0)
    mine = ours.run(scene, 1000, convention="yade-plain" if name == "yade" else "geodem")
    theirs = BACKENDS[name].run(scene, 1000)
    moved = np.abs(theirs.positions[-1] - scene.positions).max()
    turned = np.abs(theirs.spins[-1]).max()
    assert np.abs(mine.positions[-1] - theirs.positions[-1]).max() < 1e-4 * moved
    assert np.abs(mine.spins[-1] - theirs.spins[-1]).max() < spins_bound * turned


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("name", BACKENDS)
def test_speed_is_told_with_the_law_and_the_contacts(name, threads):
    installed(name)
    scene = scenes.spheres_in_a_box(200)
    speed = BACKENDS[name].run_speed(scene, 50, threads)
    assert 0.0 < speed.seconds_per_step < 1.0
    assert 2.0 * scene.particles < speed.contacts < 4.0 * scene.particles
    assert "history" in speed.law or "CundallStrack" in speed.law
    assert WARM_UP > 0


@pytest.mark.parametrize(
    ("name", "scene", "reason"),
    [
        ("liggghts", "bonded_block", "it has no bonds"),
        ("lammps", "bonded_discs", "the mass of discs"),
    ],
)
def test_a_scene_that_a_code_cannot_stand_for_is_refused(name, scene, reason):
    installed(name)
    with pytest.raises(BackendError, match=reason):
        BACKENDS[name].run(getattr(scenes, scene)(60), 1)


def test_yade_refuses_bonds_between_different_radii():
    installed("yade")
    scene = scenes.bonded_block(60)
    radii = scene.radii.copy()
    radii[0] *= 0.99
    with pytest.raises(BackendError, match="follow the radius"):
        BACKENDS["yade"].run(replace(scene, radii=radii), 1)


@pytest.mark.parametrize("name", BACKENDS)
def test_a_missing_code_tells_how_to_get_it(monkeypatch, name):
    module = BACKENDS[name]
    monkeypatch.setattr(module, "PROGRAM", type(module.PROGRAM)("/nowhere/program"))
    assert "install" in module.available()
    with pytest.raises(BackendError, match="install"):
        module.run(scenes.head_on(RADII, SPEED), 1)
