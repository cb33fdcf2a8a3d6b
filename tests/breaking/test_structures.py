"""Joints, bolts, linings and faults of a scene: what is built, and what misses the ground."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.breaking.faults import with_band
from geodem.breaking.scene import build_scene, start
from geodem.breaking.structures import BoltPlan, JointPlan, LiningPlan
from geodem.builders.bolts import Bar, Grout
from geodem.builders.joints import segment
from geodem.errors import InputError
from geodem.preparation.initial_stress import far_field
from tests.breaking.scenes import ROCK, lattice, random_ground

JOINT = {"normal_stiffness": 1e10, "shear_stiffness": 5e9, "friction_coefficient": 0.6}


def plan(start: tuple[float, float], end: tuple[float, float], **more: float) -> JointPlan:
    return JointPlan("fault", [segment(start, end, "joint")], {**JOINT, **more})


def bolt(head: tuple[float, float], end: tuple[float, float]) -> BoltPlan:
    return BoltPlan("roof", np.array(head), np.array(end), Bar(1e8), Grout(1e7))


def test_a_joint_cuts_the_bonds_of_a_row():
    """A level joint between two rows of a square lattice crosses one bond a column."""
    body, filling = lattice(8, 6)
    free = build_scene(body, filling, {"rock": ROCK}, joints=[plan((0.0, 3.0), (8.0, 3.0))])
    facts = free.structures.joints["fault"]
    assert facts[:2] == (1, pytest.approx(8.0))
    assert facts.pairs >= 8
    assert len(free.assembly.bonds) == 5 * 8 + 6 * 7 - 8
    glued = build_scene(body, filling, {"rock": ROCK}, joints=[plan((0.0, 3.0), (8.0, 3.0), cohesion=1e6)])
    assert glued.structures.joints["fault"].bonded > 0
    assert facts.traces[0].tolist() == [pytest.approx([0.0, 3.0]), pytest.approx([8.0, 3.0])]


def test_bolts_and_linings_are_set():
    scene = random_ground(bolts=[bolt((3.0, 8.0), (3.0, 4.0))])
    found = scene.structures.bolts["roof"]
    assert found.along[-1] == pytest.approx(4.0)
    assert len(scene.ids) == scene.filling.particles
    assert scene.assembly.particles == scene.filling.particles + len(found.particles)
    top = np.array([[1.0, 8.6], [9.0, 8.6]])
    lined = random_ground(linings=[LiningPlan("slab", top, 1e9, 1e9 * 0.3**2 / 12.0, 750.0)])
    ids = lined.structures.linings["slab"]
    # r = sqrt(3 EI / EA): half of a solid section's height
    assert lined.assembly.radii[ids[0]] == pytest.approx(0.15)


def test_joints_are_there_on_the_way_to_an_initial_stress_whether_energy_is_counted_or_not():
    """The account's columns lie before those of joints; a relaxation that counts no energy must not forget them."""
    scene = random_ground(
        300, joints=[plan((0.0, 4.0), (10.0, 4.5), cohesion=1e6, tensile_strength=1e5)],
        bolts=[bolt((3.0, 8.0), (3.0, 4.5))], initial_stress=far_field(np.diag([-2e6, -1e6])),
    )  # fmt: skip
    plain, _ = start(scene, applied=True)
    counted, found = start(scene, applied=True, energy=True)
    assert found is not None
    assert found.measured[0] == pytest.approx(np.diag([-2e6, -1e6]), abs=5e4)
    assert np.array_equal(plain.positions, counted.positions)


def test_what_floats_keeps_ground_from_its_initial_stress():
    top = np.array([[1.0, 8.9], [9.0, 8.9]])
    floating = LiningPlan("slab", top, 1e9, 1e9 * 0.3**2 / 12.0, 750.0)
    scene = random_ground(
        300, linings=[floating], gravity=(0.0, -9.81), initial_stress=far_field(np.diag([-2e6, -1e6]))
    )
    with pytest.raises(
        InputError, match=r"^initial_stress: particles .* can move without .* or leave \[initial_st"
    ):
        start(scene, applied=True)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"joints": [plan((0.0, 20.0), (8.0, 20.0))]}, "passes by"),
        ({"bolts": [bolt((3.0, 18.0), (3.0, 14.0))]}, "misses the ground"),
        ({"bolts": [bolt((3.0, 14.0), (3.0, 7.0))]}, "half outside"),
        (
            {"linings": [LiningPlan("l", np.array([[1.0, 30.0], [9.0, 30.0]]), 1e9, 1e7, 750.0)]},
            "no ground is near",
        ),
        (
            {"linings": [LiningPlan("l", np.array([[1.0, 5.0], [9.0, 5.0]]), 1e9, 1e7, 750.0)]},
            "lie in the ground",
        ),
    ],
)
def test_what_misses_the_ground_is_refused(options, match):
    with pytest.raises(InputError, match=match):
        random_ground(**options)


def test_a_fault_is_a_band_of_another_material():
    """Upright through a lattice: two columns of eight, and a quarter of the ground's area."""
    _, filling = lattice(8, 6)
    found = with_band(filling, segment((4.0, -1.0), (4.0, 7.0), "fault"), 1.5, "gouge")
    assert found.materials == ("rock", "gouge")
    band = found.material == 1
    assert sorted(set(found.positions[band, 0])) == pytest.approx([3.5, 4.5])
    assert found.sources == pytest.approx([36.0, 12.0])
    mass = found.density({"rock": 1000.0, "gouge": 1000.0}) * math.pi * found.radii**2
    assert mass.sum() == pytest.approx(48000.0)
    with pytest.raises(InputError, match="no particle"):
        with_band(filling, segment((4.0, 20.0), (5.0, 20.0), "fault"), 0.5, "gouge")
    with pytest.raises(InputError, match="all particles"):
        with_band(filling, segment((4.0, -1.0), (4.0, 7.0), "fault"), 50.0, "gouge")
