"""The flat joint: elements that break one by one, the broken face, its end, and the search for equilibrium."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.laws.bond import flat_joint
from geodem.laws.protocol import history_arguments
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium
from tests.contract.two_particles import (
    LAWS,
    RADIUS_A,
    RADIUS_B,
    SIZE,
    Motion,
    Pair,
    no_motion,
    parameters_of,
    random_motion,
)

GIVEN = LAWS["flat_joint"]
H = RADIUS_B
TENSION, SHEAR = GIVEN["tensile_strength"], GIVEN["shear_strength"]
TAN, MU = GIVEN["friction_coefficient"], GIVEN["residual_friction_coefficient"]
BIT = 2 ** np.arange(6)

both = pytest.mark.parametrize("dimension", [2, 3])


def area(dimension):
    return 2 * H if dimension == 2 else np.pi * H**2


def places(dimension):
    """Levers d of the elements (m, 3), across the normal z, in 2D along the axis of bending x.

    Four or six points of equal weight with the second moment of the strip, h^2/3, or of the disc, h^2/4.
    """
    if dimension == 2:
        first = np.array([0.6, 1 / 15, 1 / 15, 0.6]) ** 0.5 * [1, 1, -1, -1] * H
        return first[:, None] * np.array([1.0, 0.0, 0.0])
    angle = np.radians([60.0, 120.0, -120.0, -60.0, 0.0, 180.0])
    # the direction 1 of a joint along z is y, the direction 2 is z x y
    return H / 2**0.5 * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)


def new_pair(dimension, **more):
    return Pair(flat_joint, parameters_of(flat_joint), dimension, **more)


def remembered(pair, name):
    return pair.history[history_arguments(flat_joint).index(name)]


def damage(pair):
    """Elements (m,): 0 whole, 1 torn, 2 cut."""
    torn, cut = int(remembered(pair, "damage")) & 63, int(remembered(pair, "damage")) >> 6
    assert torn & cut == 0
    count = 4 if pair._dimension == 2 else 6
    return np.where(BIT & torn, 1, np.where(BIT & cut, 2, 0))[:count]


class Face:
    """The same joint told by vectors in space: two rigid faces with springs at points r, forces and moments by r x F.

    Potyondy 2012: sigma = kn g, tau by steps; whole elements break at Tb or at C + tan(phi) p; broken ones bear no
    tension and rub.
    """

    def __init__(self, dimension):
        self.dimension = dimension
        lever = places(dimension)
        self.count = len(lever)
        # 2D: the normal is x, across it y, and bending turns about z
        self.normal = np.array([1.0, 0.0, 0.0]) if dimension == 2 else np.array([0.0, 0.0, 1.0])
        if dimension == 2:
            lever = lever[:, [1, 2, 0]]
        self.point = np.cross(lever, self.normal)
        self.gap = np.zeros(self.count)
        self.shear = np.zeros((self.count, 3))
        self.damage = np.zeros(self.count, int)
        self.ks = GIVEN["effective_modulus"] / (RADIUS_A + RADIUS_B) / GIVEN["stiffness_ratio"]

    def in_space(self, vector):
        return np.array([0.0, vector[0], 0.0]) if self.dimension == 2 else vector * [1.0, 1.0, 0.0]

    def step(self, motion):
        n = self.normal
        turn = motion.twist * n
        turn = turn + ([0.0, 0.0, motion.bend[0]] if self.dimension == 2 else self.in_space(motion.bend))
        way = self.in_space(motion.slip) - motion.approach * n + np.cross(turn, self.point)
        self.gap -= way @ n
        share = area(self.dimension) / self.count
        pressure = GIVEN["effective_modulus"] / (RADIUS_A + RADIUS_B) * self.gap
        stress = self.shear / share + self.ks * (way - np.outer(way @ n, n))
        size = np.linalg.norm(stress, axis=1)
        tension = np.where(self.damage == 0, -pressure / TENSION, 0.0)
        shearing = np.where(self.damage == 0, (size - TAN * pressure) / SHEAR, 0.0)
        self.damage[(tension >= 1.0) & (tension >= shearing)] = 1
        self.damage[(shearing >= 1.0) & (shearing > tension)] = 2
        broken = self.damage > 0
        pressure[broken] = np.maximum(pressure[broken], 0.0)
        keep = np.where(broken, np.minimum(1.0, MU * pressure / np.maximum(size, 1e-300)), 1.0)
        self.shear = stress * keep[:, None] * share
        force = self.shear - share * np.outer(pressure, n)
        moment = np.cross(self.point, force).sum(axis=0)
        total = force.sum(axis=0)
        self.utilisation = [max(0.0, np.where(broken, 0.0, u).max()) for u in (tension, shearing)]
        if self.dimension == 2:
            return np.array([-total @ n, total[1], 0, 0, 0, moment[2], 0, 0])
        return np.array([-total @ n, total[0], total[1], 0, moment @ n, moment[0], moment[1], 0])


@both
def test_it_is_two_faces_with_springs_that_break_one_by_one(dimension):
    rng = np.random.default_rng(11)
    partly = 0
    for _ in range(60):
        pair, face = new_pair(dimension), Face(dimension)
        for _ in range(12):
            motion = random_motion(rng, dimension, size=0.15 * SIZE)
            answer, expected = pair.step(motion), face.step(motion)
            if pair.broken:
                break
            size = np.array([abs(expected[:4]).max()] * 4 + [H * abs(expected[:4]).max()] * 4)
            assert np.abs(answer.vector() - expected).max() <= 1e-11 * size.max()
            assert (damage(pair) == face.damage).all()
            assert answer.utilisation == pytest.approx(face.utilisation, rel=1e-11)
            partly += 0 < (face.damage > 0).sum() < face.count
    assert partly > 50


@both
def test_whole_it_is_as_stiff_as_its_undivided_section(dimension):
    """I = 2 h^3/3 of the strip; I = pi h^4/4 and J = pi h^4/2 of the disc."""
    pair = new_pair(dimension)
    kn, ks, twist, bend = pair.stiffness()
    per_area = GIVEN["effective_modulus"] / (RADIUS_A + RADIUS_B)
    inertia = 2 * H**3 / 3 if dimension == 2 else np.pi * H**4 / 4
    assert (kn, bend) == pytest.approx((per_area * area(dimension), per_area * inertia), rel=1e-14)
    assert ks == pytest.approx(kn / GIVEN["stiffness_ratio"], rel=1e-14)
    assert twist == pytest.approx(2 * bend / GIVEN["stiffness_ratio"] if dimension == 3 else 0.0)
    answer = pair.step(no_motion(bend=np.array([1e-6, 0.0, 0.0])))
    assert answer.bend_moment[0] == pytest.approx(1e-6 * bend, rel=1e-12)


@both
@pytest.mark.parametrize("scale", [1.0, 0.25])
def test_the_first_element_breaks_at_its_strength(dimension, scale):
    """Tension Tb A, bending Tb I/x, shear (C + p tan(phi)) A, twist C J/r, of the elements farthest out."""
    section, lever = area(dimension), np.linalg.norm(places(dimension), axis=1).max()
    inertia = section * H**2 / (3 if dimension == 2 else 4)
    kn, ks, twist, bend = new_pair(dimension).stiffness()
    axis = np.array([1.0, 0.0, 0.0] if dimension == 2 else [0.0, 1.0, 0.0])
    press = scale * 5e5 / (GIVEN["effective_modulus"] / (RADIUS_A + RADIUS_B))
    everything = 4 if dimension == 2 else 6
    cases = [
        ("tension", no_motion(approach=-TENSION * section / kn), 1, everything),
        ("bending", no_motion(bend=TENSION * inertia / lever / bend * axis), 1, 1),
        ("shear", no_motion(slip=SHEAR * section / ks * axis), 2, everything),
        ("pressed", no_motion(slip=(SHEAR + TAN * 5e5) * section / ks * axis), 2, everything),
    ]
    if dimension == 3:
        cases.append(("twist", no_motion(twist=SHEAR * 2 * inertia / lever / twist), 2, everything))
    for name, motion, mode, count in cases:
        for factor, broken in ((0.999, 0), (1.0 - 1e-12, 0), (1.0 + 1e-12, count)):
            pair = new_pair(dimension, scale=scale)
            if name == "pressed":
                pair.step(no_motion(approach=press))
            size = factor * scale
            answer = pair.step(Motion(*(size * np.asarray(part) for part in motion)))
            if not pair.broken:
                assert (damage(pair) == mode).sum() == broken, name
                assert (damage(pair) > 0).sum() == broken, name
            else:
                # nothing presses the faces: the joint ends with its last element
                assert (broken, count) == (everything, everything), name
                assert name != "pressed"
            if factor == 0.999 and name != "pressed":
                assert answer.utilisation[mode - 1] == pytest.approx(factor, rel=1e-11)


def test_a_pressed_face_rubs_and_resists_rotation_when_it_is_broken():
    """Strip of two faces without tension: kn I/A of the elements that are closed, and in the end the edge alone."""
    pair = new_pair(2)
    press = 1.5 * SIZE
    slip = np.array([SIZE, 0.0, 0.0])
    pair.step(no_motion(approach=press))
    for _ in range(5):
        answer = pair.step(no_motion(slip=slip))
    kn, _, _, bend = pair.stiffness()
    assert damage(pair).tolist() == [2, 2, 2, 2]
    assert answer.normal == pytest.approx(kn * press, rel=1e-12)
    assert answer.shear[0] == pytest.approx(MU * kn * press, rel=1e-12)
    assert answer.utilisation == (0.0, 0.0)
    # all closed: as the whole section; the outer element opens at press/(h sqrt(3/5))
    turn = 0.99 * press / (0.6**0.5 * H)
    answer = pair.step(no_motion(bend=np.array([turn, 0.0, 0.0])))
    assert answer.bend_moment[0] == pytest.approx(turn * bend, rel=1e-12)
    # ever farther at the same pressing force: it stands on its edge
    for _ in range(100):
        answer = pair.step(no_motion(bend=np.array([0.1 * turn, 0.0, 0.0])))
        for _ in range(60):
            answer = pair.step(no_motion(approach=(kn * press - answer.normal) / kn))
    assert answer.normal == pytest.approx(kn * press, rel=1e-6)
    assert answer.bend_moment[0] == pytest.approx(0.6**0.5 * H * answer.normal, rel=1e-6)


@both
def test_the_joint_ends_where_its_broken_faces_open_or_leave_each_other(dimension):
    def broken_pair():
        pair = new_pair(dimension)
        pair.step(no_motion(approach=SIZE))
        pair.step(no_motion(slip=np.array([10 * SIZE, 0.0, 0.0])))
        assert set(damage(pair)) == {2}
        assert not pair.broken
        return pair

    pair = broken_pair()
    pair.step(no_motion(approach=-0.999 * SIZE))
    assert not pair.broken
    pair.step(no_motion(approach=-0.002 * SIZE))
    assert pair.broken
    pair = broken_pair()
    pair.step(no_motion(slip=np.array([H - 11 * SIZE, 0.0, 0.0])))
    assert not pair.broken
    pair.step(no_motion(slip=np.array([2 * SIZE, 0.0, 0.0])))
    assert pair.broken
    pair = broken_pair()
    pair.step(no_motion(bend=np.array([0.99, 0.0, 0.0])))
    assert not pair.broken
    pair.step(no_motion(bend=np.array([0.02, 0.0, 0.0])))
    assert pair.broken
    # and not before its last element broke
    pair = new_pair(dimension)
    lever = np.linalg.norm(places(dimension), axis=1).max()
    turn = 1.05 * TENSION / GIVEN["effective_modulus"] * (RADIUS_A + RADIUS_B) / lever
    pair.step(no_motion(bend=turn * np.array([1.0, 0.0, 0.0] if dimension == 2 else [0.0, 1.0, 0.0])))
    pair.step(no_motion(approach=-0.01 * SIZE))
    assert 0 < (damage(pair) > 0).sum() < len(damage(pair))
    assert not pair.broken


@both
def test_on_the_way_to_an_equilibrium_nothing_breaks(dimension):
    pair = new_pair(dimension)
    pair._values["breaking"] = np.inf
    kn = pair.stiffness()[0]
    answer = pair.step(no_motion(approach=-3.0 * TENSION * area(dimension) / kn))
    assert not damage(pair).any()
    assert answer.utilisation[0] == pytest.approx(3.0, rel=1e-12)
    pair._values["breaking"] = 2.9
    answer = pair.step(no_motion())
    assert max(answer.utilisation) == 0.0  # of the pair that is gone
    assert pair.broken


def test_in_space_only_the_directions_of_the_joint_matter():
    rng = np.random.default_rng(5)
    column = history_arguments(flat_joint).index("along_x")
    for _ in range(20):
        q, r = np.linalg.qr(rng.normal(size=(3, 3)))
        turn = q * np.sign(np.diag(r))
        turn *= np.sign(np.linalg.det(turn))
        straight, turned = new_pair(3), new_pair(3, normal=turn[:, 2])
        straight.history[column : column + 3] = [1.0, 0.0, 0.0]
        turned.history[column : column + 3] = turn[:, 0]
        for _ in range(6):
            motion = random_motion(rng, 3, size=0.2 * SIZE)
            motion = motion._replace(slip=motion.slip * [1, 1, 0], bend=motion.bend * [1, 1, 0])
            a = straight.step(motion)
            b = turned.step(motion._replace(slip=turn @ motion.slip, bend=turn @ motion.bend))
            if straight.broken or turned.broken:
                break
            size = abs(a.vector()).max()
            assert [b.normal, b.twist_moment] == pytest.approx([a.normal, a.twist_moment], abs=1e-11 * size)
            assert b.shear == pytest.approx(turn @ a.shear, rel=0, abs=1e-11 * size)
            assert b.bend_moment == pytest.approx(turn @ a.bend_moment, rel=0, abs=1e-11 * size)
            assert (damage(straight) == damage(turned)).all()


# ------------------------------------------------------------------ in the loops


WEAK = {**GIVEN, "tensile_strength": 0.01 * TENSION, "shear_strength": 0.01 * SHEAR}
"""It breaks before its turning counts for the statics."""


def loaded_pair(push, moment, **run):
    """Two bonded discs along x, the first held; force and moment on the second, pressed and bent."""
    builder = AssemblyBuilder(2, contact_law="effective_modulus", bond_law="flat_joint")
    contact = {"effective_modulus": 2e9, "stiffness_ratio": 2.5, "friction_coefficient": MU}
    builder.add_material("m", density=2600.0, contact=contact, bond=WEAK)
    builder.add_particles([[0.0, 0.0], [RADIUS_A + RADIUS_B, 0.0]], [RADIUS_A, RADIUS_B], "m")
    builder.hold([0], x=0.0, y=0.0, rotation=0.0)
    builder.bond([[0, 1]])
    builder.apply([1], force=[-push, 0.0], torque=moment)
    return ParticleSimulation(builder.build(), **run)


def history_of(simulation):
    names = simulation.layout.contact + simulation.layout.bond
    return dict(zip(names, simulation.pairs.history[0], strict=False))


def test_equilibrium_breaks_the_overstressed_element_and_no_other():
    """Pressed beside the middle of the face: statics of the three elements that are left."""
    section, place = area(2), places(2)[:, 0]
    strength = WEAK["tensile_strength"] * section
    push = 2 * strength
    # what brings the outer element to 1.04 times its strength
    moment = 3.04 * strength * H**2 / 3 / place.max()
    held = loaded_pair(push, moment)
    result = find_equilibrium(held, tolerance=1e-9, breaking=False)
    assert (result.reached, len(result.broken)) == (True, 0)
    assert history_of(held)["damage"] == 0.0
    assert held.utilisation[0, 0] == pytest.approx(1.04, rel=1e-3)
    simulation = loaded_pair(push, moment)
    result = find_equilibrium(simulation, tolerance=1e-9)
    assert result.reached
    assert result.rounds == 2
    assert len(result.broken) == 0
    torn = np.flatnonzero(BIT[:4] & int(history_of(simulation)["damage"]))
    assert len(torn) == 1
    left = np.delete(place, torn)
    # moment about the middle of what is left; of the normal force only the pressed side knows
    middle, sign = left.mean(), np.sign(left.mean())
    bend = moment - push * abs(middle)
    force = push / 3 + bend * (left - middle) * sign / ((left - middle) ** 2).sum()
    tension = -force.min() / (strength / 4)
    assert simulation.utilisation[0, 0] == pytest.approx(tension, rel=1e-3)


def test_the_account_of_energy_closes_where_elements_break_and_faces_rub():
    """Kinetic and elastic energy grow by the work of the load less what breaking and rubbing take."""
    push = WEAK["tensile_strength"] * area(2)
    simulation = loaded_pair(push, 1.6 * push * H**2 / 3 / places(2).max(), time_step=1e-6, energy=True)
    simulation.run(2000)
    assert history_of(simulation)["damage"] != 0.0
    account = simulation.energy()
    spent = account.friction + account.broken
    assert spent > 0.0
    stands = account.kinetic + account.elastic + spent
    assert stands == pytest.approx(account.applied, rel=1e-3)
