"""What every law of contacts and bonds promises, whatever its physics: one table of laws drives all tests."""

from __future__ import annotations

import numpy as np
import pytest

from geodem._jit import compile_kernel
from geodem.kernels import blocks, cell, pairs, sleep, steps, wall_geometry
from geodem.kernels import motion as moving
from geodem.kernels.adapters import module_constants
from geodem.kernels.wall_geometry import RIGID
from geodem.laws import BOND_LAWS, CONTACT_LAWS
from geodem.laws.contact import effective_modulus
from geodem.laws.protocol import argument_names, check_law, constants, history_names, in_dimension, sources
from tests.contract.bond_strengths import STRENGTHS
from tests.contract.two_particles import (
    CASES,
    JUMPS,
    LAWS,
    LOSSLESS,
    NOT_LINEAR,
    OF_ITS_LENGTH,
    OF_OTHER_CODES,
    PIECEWISE,
    RADIUS_A,
    RADIUS_B,
    REGISTERED,
    SHEAR_FOLLOWS_LOAD,
    SIZE,
    Motion,
    Pair,
    closed_path,
    elastic_parameters,
    no_motion,
    parameters_of,
    random_motion,
    scaled,
    work,
)

every_law = pytest.mark.parametrize("law", [REGISTERED[name] for name in LAWS], ids=lambda law: law.NAME)
every_case = pytest.mark.parametrize(
    ("law", "dimension"), CASES, ids=[f"{law.NAME} {dimension}D" for law, dimension in CASES]
)
pressed = no_motion(approach=20.0 * SIZE)
"""So far that no path of the tests parts the two."""

LITTLE = 1e-3 * SIZE
"""A step of central differences, which are exact for linear laws."""


def test_the_table_has_every_law():
    assert set(LAWS) | OF_OTHER_CODES == set(CONTACT_LAWS) | set(BOND_LAWS)
    assert not set(LAWS) & OF_OTHER_CODES
    assert not set(CONTACT_LAWS) & set(BOND_LAWS)


@pytest.mark.parametrize("kind", ["contact", "bond"])
def test_every_law_keeps_the_protocol(kind):
    for name, law in (CONTACT_LAWS if kind == "contact" else BOND_LAWS).items():
        check_law(law, kind)
        assert name == law.NAME
        assert law.__name__ == f"geodem.laws.{kind}.{name}"


@every_case
def test_force_is_the_gradient_of_the_energy(law, dimension):
    """dE/d(overlap, slip, twist, bend) = the forces and moments, by central differences."""
    parameters = elastic_parameters(law)
    rng = np.random.default_rng(1)
    for _ in range(5):
        past = [pressed, random_motion(rng, dimension), random_motion(rng, dimension)]
        here = Pair(law, parameters, dimension)
        for motion in past:
            force = here.step(motion).vector()
        directions = [(axis, name) for axis, name in enumerate(law_freedoms(law, dimension)) if name]
        for axis, name in reversed(directions):
            if name == "overlap" and law.NAME in SHEAR_FOLLOWS_LOAD:
                # of the energy in shear some is lost: here there is none
                past = [no_motion(approach=motion.approach) for motion in past]
            ends = []
            for sign in (1.0, -1.0):
                pair = Pair(law, parameters, dimension)
                for motion in past:
                    pair.step(motion)
                pair.step(scaled(unit_motion(axis), sign * LITTLE))
                ends.append(pair.energy())
            gradient = (ends[0] - ends[1]) / (2.0 * LITTLE)
            assert gradient == pytest.approx(force[axis], rel=1e-9, abs=1e-9 * abs(force).max())


def law_freedoms(law, dimension):
    """Overlap, slip x y z, twist, bend x y z: the names of those that the law resists, None for others."""
    names = ["overlap", "slip_x", "slip_y", "slip_z", "twist", "bend_x", "bend_y", "bend_z"]
    absent = set() if law.MOMENT else {"twist", "bend_x", "bend_y", "bend_z"}
    if dimension == 2:
        absent |= {"slip_y", "slip_z", "twist", "bend_y", "bend_z"}
    if law.NAME in PIECEWISE:
        # along the normal, which it is told
        absent |= {"slip_z", "bend_z"}
    return [None if name in absent else name for name in names]


def unit_motion(axis):
    row = np.eye(8)[axis]
    return Motion(row[0], row[1:4], row[4], row[5:])


@every_case
def test_stiffness_is_what_the_force_gains_in_a_step(law, dimension):
    parameters = elastic_parameters(law)
    pair = Pair(law, parameters, dimension)
    pair.step(pressed)
    kn, ks, twist, bend = pair.stiffness()
    for axis, name in enumerate(law_freedoms(law, dimension)):
        if name:
            expected = {"o": kn, "s": ks, "t": twist, "b": bend}[name[0]]
            before = pair.step(scaled(unit_motion(axis), -LITTLE)).vector()
            after = pair.step(scaled(unit_motion(axis), 2.0 * LITTLE)).vector()
            pair.step(scaled(unit_motion(axis), -LITTLE))
            assert (after - before)[axis] == pytest.approx(2.0 * expected * LITTLE, rel=1e-9, abs=1e-12)
    if not law.MOMENT:
        assert (twist, bend) == (0.0, 0.0)


@every_case
def test_an_elastic_loop_costs_nothing(law, dimension):
    pair = Pair(law, elastic_parameters(law), dimension)
    start = before = pair.step(pressed)
    stored = pair.energy()
    total = size = 0.0
    # the trapezoid sum is exact for linear laws; else wrong by the square of the steps
    linear = law.NAME not in NOT_LINEAR
    for motion in closed_path(np.random.default_rng(2), dimension, steps=20 if linear else 200):
        if law.NAME in SHEAR_FOLLOWS_LOAD:
            motion = motion._replace(approach=0.0)
        after = pair.step(motion)
        done = work(before, after, motion)
        assert done == pytest.approx(pair.energy() - stored, rel=1e-6, abs=1e-10 * abs(stored))
        total, size = total + done, size + abs(done)
        stored, before = pair.energy(), after
    assert abs(total) < (1e-11 if linear else 1e-8) * size
    assert before.vector() == pytest.approx(start.vector(), rel=0, abs=1e-11 * start.normal)


@every_case
def test_a_loop_gives_no_energy(law, dimension):
    """Closed loops from rest, through sliding, parting, touching again and breaking: work >= what is stored."""
    spent_share, jumps, sizes = [], [], []
    broken = parted = 0
    for seed in range(12):
        pair = Pair(law, parameters_of(law), dimension)
        before = pair.answer
        total = size = spent = unknown = 0.0
        lived = False
        for motion in closed_path(np.random.default_rng(seed), dimension):
            stored = pair.energy()
            after = pair.step(motion)
            done = work(before, after, motion)
            total, size = total + done, size + abs(done)
            spent += done - pair.energy() + stored
            if law.NAME in JUMPS and lived != pair.alive:
                # somewhere inside the step
                unknown += abs(after.normal - before.normal) * abs(motion.approach)
            # the work is a trapezoid sum, wrong by a part of the steps on which the two slide, touch or part
            assert spent >= -1e-5 * size - unknown
            parted += lived and not pair.alive
            lived, before = pair.alive, after
        assert total >= -1e-5 * size - unknown
        jumps.append(unknown)
        sizes.append(size)
        broken += pair.broken
        if size:
            spent_share.append(spent / size)
    assert sum(jumps) < 1e-3 * sum(sizes)
    if law.NAME in LOSSLESS:
        assert np.median(spent_share) < 1e-4
    else:
        assert max(spent_share) > 0.05, "the loops are meant to slide or break"
    assert parted >= 3, "the loops are meant to part the two"
    # a bond of elements is gone where the last one broke and none is pressed
    assert broken >= ((4 if law.NAME in PIECEWISE else 6) if law.NAME in BOND_LAWS else 0)


STRENGTH_CASES = [
    pytest.param(BOND_LAWS[name], dimension, load, id=f"{name} {dimension}D: {load.label}")
    for (name, dimension), loads in STRENGTHS.items()
    for load in loads
]


def test_every_bond_has_its_strengths_in_closed_form():
    assert set(STRENGTHS) == {(law.NAME, d) for law, d in CASES if law.NAME in BOND_LAWS} - {
        (name, dimension) for name in PIECEWISE for dimension in (2, 3)
    }
    for loads in STRENGTHS.values():
        assert {load.mode for load in loads} == {"tension", "shear"}


@pytest.mark.parametrize(("law", "dimension", "load"), STRENGTH_CASES)
@pytest.mark.parametrize("scale", [1.0, 0.25])
def test_bond_breaks_at_its_strength(law, dimension, load, scale):
    """Utilisation 1 at the load of the closed form (times `scale`), and in proportion below it."""
    along, across = (np.array([1.0, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]))
    if dimension == 3:
        along, across = np.array([0.6, 0.0, -0.8]), np.array([2.0, 1.0, 2.0]) / 3.0

    def under(factor):
        pair = Pair(law, parameters_of(law), dimension, scale=scale)
        kn, ks, k_twist, k_bend = pair.stiffness()
        size = factor * scale
        motion = Motion(
            size * load.normal / kn,
            size * load.shear / ks * along,
            size * load.twist / k_twist if load.twist else 0.0,
            size * load.bend / k_bend * across,
        )
        answer = pair.step(motion)
        return pair, answer

    mode = ("tension", "shear").index(load.mode)
    for factor in (0.3, 0.999):
        answer = under(factor)[1]
        assert answer.utilisation[mode] == pytest.approx(factor, rel=1e-12)
        assert answer.utilisation[1 - mode] < answer.utilisation[mode]
        assert answer.vector()[[0, 4]] == pytest.approx(
            np.array([load.normal, load.twist]) * factor * scale, rel=1e-12
        )
    assert not under(1.0 - 1e-12)[0].broken
    assert under(1.0 + 1e-12)[0].broken


@every_law
def test_no_loop_gives_another_meaning_to_a_constant_of_a_law(law):
    """Constants of the loops go over those of the laws in a kernel's module; SPHERES is meant to."""
    loops = module_constants(pairs, moving, sleep, steps, wall_geometry, blocks, cell)
    for dimension in law.DIMENSIONS:
        assert not set(constants(law, dimension)) & set(loops)


@every_case
def test_plain_and_compiled_agree(law, dimension):
    functions = [
        getattr(law, name)
        for name in ("force", "energy", "stiffness", "viscous", "reach", "bonded")
        if hasattr(law, name)
    ]
    called = [getattr(law, name) for name in sources(law, [function.__name__ for function in functions])]
    module = compile_kernel(called, constants(law, dimension), parallel=False)
    parameters = parameters_of(law)._asdict()
    rng = np.random.default_rng(3)
    for _ in range(200):
        motion = random_motion(rng, dimension)
        past = random_motion(rng, dimension, size=5.0 * SIZE)
        pair = Pair(law, parameters_of(law), dimension)
        known = set(history_names(law, dimension))
        values = {
            **parameters, **pair._values, "overlap": past.approach, "approach": motion.approach,
            "distance": 0.019, "twist": motion.twist, "scale": rng.uniform(0.5, 2.0),
            **dict(zip(("slip_x", "slip_y", "slip_z"), motion.slip, strict=True)),
            **dict(zip(("bend_x", "bend_y", "bend_z"), motion.bend, strict=True)),
        }  # fmt: skip
        for function in functions:
            for name in argument_names(function):
                if name not in values:
                    values[name] = rng.normal() * 50.0 if name in known else 0.0
            arguments = [values[name] for name in argument_names(function)]
            plain = np.atleast_1d(in_dimension(function, dimension)(*arguments))
            compiled = np.atleast_1d(getattr(module, function.__name__)(*arguments))
            scale = np.abs(plain).max()
            assert compiled == pytest.approx(plain, rel=1e-14, abs=1e-15 * scale)


@every_case
def test_action_is_reaction(law, dimension):
    """a and b change places: the normal, the slip and the bend turn round, the twist about the normal does not."""
    rng = np.random.default_rng(4)
    parameters = parameters_of(law)
    for _ in range(30):
        one = Pair(law, parameters, dimension, radii=(0.011, 0.008))
        other = Pair(law, parameters, dimension, radii=(0.008, 0.011), normal=(0.0, 0.0, -1.0))
        for _ in range(4):
            motion = random_motion(rng, dimension, size=0.3 * SIZE)
            turned = motion._replace(slip=-motion.slip, bend=-motion.bend)
            a, b = one.step(motion), other.step(turned)
            assert b.normal == a.normal
            assert b.twist_moment == a.twist_moment
            assert np.array_equal(b.shear, -a.shear)
            assert np.array_equal(b.bend_moment, -a.bend_moment)
            assert b.utilisation == a.utilisation
            assert other.energy() == one.energy()


@pytest.mark.parametrize(
    "law",
    [law for law, dimension in CASES if dimension == 3 and law.NAME not in PIECEWISE],
    ids=lambda law: law.NAME,
)
def test_the_tangential_frame_does_not_matter(law):
    rng = np.random.default_rng(5)
    parameters = parameters_of(law)
    for _ in range(30):
        q, r = np.linalg.qr(rng.normal(size=(3, 3)))
        turn = q * np.sign(np.diag(r))
        straight, turned = Pair(law, parameters, 3), Pair(law, parameters, 3)
        for _ in range(4):
            motion = random_motion(rng, 3, size=0.3 * SIZE)
            a = straight.step(motion)
            b = turned.step(motion._replace(slip=turn @ motion.slip, bend=turn @ motion.bend))
            size = abs(a.vector()).max()
            assert b.normal == pytest.approx(a.normal, rel=1e-12)
            assert b.shear == pytest.approx(turn @ a.shear, rel=0, abs=1e-12 * size)
            assert b.twist_moment == pytest.approx(a.twist_moment, rel=1e-12)
            assert b.bend_moment == pytest.approx(turn @ a.bend_moment, rel=0, abs=1e-12 * size)
            assert b.utilisation == pytest.approx(a.utilisation, rel=1e-11, abs=1e-12)


@every_case
def test_in_the_plane_forces_stay_in_the_plane(law, dimension):
    """With no motion out of the plane its components are exactly 0, so that a 2D loop need not keep them."""
    pair = Pair(law, parameters_of(law), dimension)
    rng = np.random.default_rng(6)
    for _ in range(20):
        answer = pair.step(random_motion(rng, 2, size=0.3 * SIZE))
        assert [*answer.shear[1:], answer.twist_moment, *answer.bend_moment[1:]] == [0.0] * 5


@every_law
def test_viscous_force_is_eta_k_v(law):
    """Zhao 2015, eqs 1.31-1.32: F = eta k v, against the velocity of b from a, so it always takes power.

    Dashpots that follow from a coefficient of restitution are tested with their laws.
    """
    assert hasattr(law, "viscous") == law.VISCOUS
    if "normal_viscosity" not in law.PARAMETERS._fields:
        return
    parameters = parameters_of(law)
    rng = np.random.default_rng(7)
    for _ in range(10):
        motion = random_motion(rng, 3)
        viscous = Pair(law, parameters, law.DIMENSIONS[0]).viscous(motion)
        step = 1e-6
        kn, ks = parameters.normal_stiffness, parameters.shear_stiffness
        assert viscous[0] == pytest.approx(1e-5 * kn * motion.approach / step, rel=1e-14)
        assert viscous[1:] == pytest.approx(2e-5 * ks * motion.slip / step, rel=1e-14)
    none = {name: 0.0 for name in parameters._fields if name.endswith("viscosity")}
    assert not Pair(law, parameters._replace(**none), law.DIMENSIONS[0]).viscous(motion).any()


@every_law
def test_two_materials(law):
    """Two halves in series, each twice as stiff as its material: 1/k = 1/(2 k1) + 1/(2 k2); a rigid half drops out."""
    first = parameters_of(law)
    second = first._replace(
        **{name: 3.0 * value for name, value in first._asdict().items() if name != "poisson_ratio"}
    )
    assert law.combine(first, first) == first
    both = law.combine(first, second)
    assert law.combine(second, first) == pytest.approx(both, rel=1e-15)
    stiff = {name for name in first._fields if name.endswith(("_stiffness", "_modulus"))}
    assert stiff
    rigid = first._replace(**dict.fromkeys(stiff, 1e30))
    wall = law.against_rigid(first)
    for name in stiff:
        one, other = getattr(first, name), getattr(second, name)
        assert getattr(both, name) == pytest.approx(1.0 / (0.5 / one + 0.5 / other), rel=1e-14)
        half = first if law.NAME in OF_ITS_LENGTH else law.combine(first, rigid)
        assert getattr(wall, name) == pytest.approx(getattr(half, name), rel=1e-14)
    for name in set(first._fields) - stiff:
        assert getattr(wall, name) == getattr(first, name)
        # neither stronger than the stronger material nor weaker than the weaker one
        assert getattr(first, name) <= getattr(both, name) <= getattr(second, name)
    assert law.check(both) == law.check(wall) == []


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_contact_with_a_modulus_meets_a_wall_with_its_own_half(dimension):
    """Potyondy & Cundall 2004: beams from the centres, Ec A/(ra + rb); to a wall from the centre to the surface."""
    law = effective_modulus
    parameters = parameters_of(law)
    area = 2 * RADIUS_B if dimension == 2 else np.pi * RADIUS_B**2
    inner = Pair(law, parameters, dimension).stiffness()
    assert inner[0] == pytest.approx(2e9 * area / (RADIUS_A + RADIUS_B), rel=1e-14)
    assert inner[1] == pytest.approx(inner[0] / 2.5, rel=1e-14)
    # a wall as the loops show it to a law
    wall = Pair(law, law.against_rigid(parameters), dimension, radii=(RADIUS_B, RIGID * RADIUS_B)).stiffness()
    assert wall[0] == pytest.approx(2e9 * area / RADIUS_B, rel=1e-14)
    assert wall[1] == pytest.approx(wall[0] / 2.5, rel=1e-14)


@pytest.mark.parametrize("dimension", [2, 3])
def test_cement_is_a_parallel_bond_of_a_beam(dimension):
    """Potyondy & Cundall 2004, section 3.1: kn = Ec/(ra + rb) and ks = kn/kappa per area; the rest is the same."""
    given = dict(LAWS["cement"])
    kn = given.pop("effective_modulus") / (RADIUS_A + RADIUS_B)
    ks = kn / given.pop("stiffness_ratio")
    beam = parameters_of(BOND_LAWS["parallel_bond"], **given, normal_stiffness=kn, shear_stiffness=ks)
    one = Pair(BOND_LAWS["cement"], parameters_of(BOND_LAWS["cement"]), dimension)
    other = Pair(BOND_LAWS["parallel_bond"], beam, dimension)
    assert one.stiffness() == pytest.approx(other.stiffness(), rel=1e-14)
    rng = np.random.default_rng(8)
    for _ in range(20):
        motion = random_motion(rng, dimension, size=0.1 * SIZE)
        a, b = one.step(motion), other.step(motion)
        assert a.vector() == pytest.approx(b.vector(), rel=1e-12, abs=1e-12 * abs(b.vector()).max())
        assert a.utilisation == pytest.approx(b.utilisation, rel=1e-12)
        assert one.energy() == pytest.approx(other.energy(), rel=1e-12)


@every_law
def test_the_theory_has_a_page(law):
    from tests.docs.pages import DOCS

    page = (DOCS / "theory" / f"{law.NAME}.md").read_text()
    for field in law.PARAMETERS._fields:
        assert f"`{field}`" in page
    assert f"theory/{law.NAME}.md" in (DOCS / "mkdocs" / "mkdocs.yml").read_text()
