"""The same few spheres in geodem, YADE, LIGGGHTS and a plain stepper, a thousand steps: only rounding may differ.

A formula changed by one part in a million is far out of the bounds, see
`test_a_formula_that_is_a_millionth_off_is_seen`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from reference.backends import BACKENDS
from reference.backends.program import BackendError
from reference.comparisons import convergence, fewbody, handover, mutation
from reference.comparisons.comparison import rows_of
from reference.ours_posed import run_posed
from reference.posed import Posed
from reference.posed_difference import differences, good
from tests.reference import plain_codes

CODES = ("yade", "liggghts")
SCENES = {(code, one.name): one for code in CODES for one in fewbody.posed(code)}
SMALL = [key for key, one in SCENES.items() if one.assembly.particles < 20]
# what needs a kernel of its own is left to `python -m reference compare fewbody`
QUICK = [key for key in SCENES if "driven" not in key[1] and "true branch" not in key[1]]


def installed(code):
    missing = BACKENDS[code].available()
    if missing:
        pytest.skip(missing)


@cache
def theirs(code):
    """All scenes in one go: starting YADE takes longer than running it."""
    names = [name for own, name in SCENES if own == code]
    return dict(zip(names, BACKENDS[code].run_posed([SCENES[code, name] for name in names]), strict=True))


@cache
def plain(code, name):
    return plain_codes.run(SCENES[code, name])


def told_by_all(one):
    """The quantities that the plain stepper tells, too."""
    return replace(one, quantities=tuple(q for q in one.quantities if q != "pair_shear"))


@pytest.mark.parametrize("key", QUICK, ids=lambda key: f"{key[0]}: {key[1]}")
def test_geodem_moves_a_few_spheres_as_another_code_does(key):
    code, name = key
    installed(code)
    one = SCENES[key]
    (ours,) = run_posed([one])
    found = differences(ours, theirs(code)[name], one)
    assert good(found, one.bound), found


@pytest.mark.parametrize("key", SMALL, ids=lambda key: f"{key[0]}: {key[1]}")
def test_the_formulae_written_down_plainly_are_those_of_the_code(key):
    code, name = key
    installed(code)
    one = told_by_all(SCENES[key])
    found = differences(plain(code, name), theirs(code)[name], one)
    assert good(found, one.bound), found


@pytest.mark.parametrize("key", [key for key in SMALL if key in QUICK], ids=lambda key: f"{key[0]}: {key[1]}")
def test_geodem_does_what_is_written_down_plainly(key):
    """Needs no other code."""
    code, name = key
    one = told_by_all(SCENES[key])
    (ours,) = run_posed([one])
    found = differences(ours, plain(code, name), one)
    assert good(found, one.bound), found


def test_scenes_are_what_their_names_say():
    for code in CODES:
        installed(code)
        found = theirs(code)
        for name, run in found.items():
            moved = np.abs(run.positions[-1] - SCENES[code, name].assembly.positions).max()
            assert moved > 1e-5, name
            if "to break" in name:
                assert len(run.broken) == 1, name
                # well inside the run, so that both sides of the break are compared
                assert 2 <= run.broken[0][2] <= 200, name
            elif run.broken:
                pytest.fail(f"{name} broke {run.broken}")


def test_slipping_after_a_shear_break_goes_on_in_touch():
    installed("yade")
    for law in ("cohesive_moments", "jointed_cohesive"):
        run = theirs("yade")[f"shear to break, then slide, {law}"]
        after = [k for k in range(len(run.steps)) if len(run.pair_forces.of_frame(k).pairs)]
        assert len(after) > 500


def test_a_formula_that_is_a_millionth_off_is_seen():
    """Against the plain stepper, so that it is always run; all laws: `python -m reference compare mutation`."""
    change = next(one for one in mutation.MUTATIONS if one.what == "normal force")
    scenes = [told_by_all(SCENES["yade", f"{name}, {change.law}"]) for name in ("head-on", "oblique")]
    references = [plain("yade", one.name) for one in scenes]
    seen = mutation.seen(change, scenes, references)
    for one in scenes:
        assert seen[one.name] > 1e4 * one.bound, seen
    # and the true law is back in its place
    (ours,) = run_posed(scenes[-1:])
    assert good(differences(ours, references[-1], scenes[-1]), scenes[-1].bound)


def test_every_formula_that_is_to_be_changed_is_found():
    for change in mutation.MUTATIONS:
        with mutation.mutated(change) as module:
            assert change.law == module.NAME


@pytest.mark.parametrize(("code", "law"), [("yade", "elastic_frictional"), ("liggghts", "hooke_stiffness")])
def test_a_state_handed_over_goes_on_alike(code, law):
    installed(code)
    rows = handover.compare_one(code, law, particles=500, before=60)
    assert {row.quantity for row in rows} == {"positions", "velocities", "spins", "forces", "torques"}
    assert all(row.good for row in rows), rows


def test_geodems_own_convention_differs_from_the_others_by_the_time_step():
    installed("yade")
    one = fewbody.oblique("elastic_frictional", "yade-plain")
    found = []
    for times in (1, 4):
        shorter = convergence.finer(one, times)
        (theirs_,) = BACKENDS["yade"].run_posed([shorter])
        (ours,) = run_posed([replace(shorter, convention="geodem")])
        found.append(max(differences(ours, theirs_, shorter).values()))
    # first order: a quarter of the step, a quarter of the difference
    assert found[0] > 1e-9
    assert found[1] == pytest.approx(found[0] / 4.0, rel=0.5)


def test_rows_tell_scene_code_version_and_bound():
    installed("liggghts")
    one = SCENES["liggghts", "head-on, hooke_stiffness"]
    run = theirs("liggghts")[one.name]
    rows = rows_of(one, run, run)
    assert {row.quantity for row in rows} == set(one.quantities)
    assert all(row.good and row.difference == 0.0 and row.bound == one.bound for row in rows)
    assert rows[0].version.startswith("LIGGGHTS-PUBLIC")


@pytest.mark.parametrize(("code", "law"), [("yade", "elastic_frictional"), ("liggghts", "hooke_stiffness")])
def test_discs_weigh_by_the_metre_in_other_codes(code, law):
    """Two discs on their way to each other are pressed by v/w at most, w^2 = 2 kn/m, m = pi r^2 rho."""
    installed(code)
    _, _, convention = fewbody.OF_CODE[code]
    contact = {**fewbody.MATERIALS[law][0]} | ({"normal_damping": 0.0} if law == "hooke_stiffness" else {})
    b = AssemblyBuilder(2, law)
    b.add_material("a", density=260.0, contact=contact)
    b.add_particles(
        [[0.0, 0.0], [0.02002, 0.0]], 0.01, "a", velocity=[[0.1, 0.0], [-0.1, 0.0]], spin=[[3.0], [3.0]]
    )
    mass = np.pi * 1e-4 * 260.0
    wave = np.sqrt(2.0 * 1e5 / mass)
    time_step = np.pi / wave / 400
    one = Posed("discs", b.build(), time_step, 700, convention)
    (run,) = BACKENDS[code].run_posed([one])
    pressed = 0.02 - (run.positions[:, 1, 0] - run.positions[:, 0, 0])
    assert pressed.max() == pytest.approx(0.2 / wave, rel=1e-4)
    # friction takes 2 r m w/2 of spin from both alike: the torque on a disc turns it by m r^2/2
    assert np.ptp(run.spins[:, 0, 2]) > 0.0
    np.testing.assert_allclose(run.spins[:, :, :2], 0.0)
    change = np.diff(run.spins[:, 0, 2])
    np.testing.assert_allclose(
        change, run.torques[1:, 0, 2] * time_step / (0.5 * mass * 1e-4), rtol=1e-9, atol=1e-12
    )
    np.testing.assert_allclose(run.positions[:, :, 2], 0.0, atol=1e-18)


# --- LAMMPS, whose bonds are those of the law rotational_bond ----------------------------------------------


def drawn(strength, **given):
    """Two bonded spheres that fly apart at 0.2 m/s, the first held; kn = 1e5 N/m."""
    stiffness = {"normal_stiffness": 1e5, "shear_stiffness": 4e4}
    rotations = {
        "twisting_stiffness": 2.0,
        "bending_stiffness": 3.0,
        "twisting_strength": 1.0,
        "bending_strength": 1.0,
    }
    b = AssemblyBuilder(3, "linear_frictional", "rotational_bond", **given)
    bond = {**stiffness, **rotations, "tensile_strength": strength, "shear_strength": 5.0}
    b.add_material("a", density=2600.0, contact={**stiffness, "friction_coefficient": 0.5}, bond=bond)
    b.add_particles(
        [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0]], 0.01, "a", velocity=[[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]]
    )
    b.hold([0], x=0.0, y=0.0, z=0.0, rotation=0.0)
    b.bond([[0, 1]])
    return Posed("drawn", b.build(), 2e-6, 500, "geodem")


def test_a_bond_in_lammps_swings_and_breaks_as_it_must():
    installed("lammps")
    one = drawn(100.0)
    whole, cut = BACKENDS["lammps"].run_posed([one, drawn(3.0)])
    wave = np.sqrt(1e5 / one.assembly.mass[1])
    time = whole.steps * one.time_step
    # u = v/w sin wt; velocity Verlet's error in the amplitude is (w dt)^2/8 over the swing
    np.testing.assert_allclose(
        whole.positions[:, 1, 0] - 0.02,
        0.2 / wave * np.sin(wave * time),
        atol=0.2 / wave * (wave * 2e-6) ** 2 * 10,
    )
    assert not whole.broken
    # half a step back
    np.testing.assert_allclose(whole.velocities[:, 1, 0], 0.2 * np.cos(wave * (time - 1e-6)), atol=1e-5)
    # it breaks where kn u = 3 N, with the forces that lead to the frame
    at = np.flatnonzero(whole.forces[:, 1, 0] < -3.0)[0]
    assert cut.broken == ((0, 1, int(whole.steps[at])),)
    assert cut.forces[at, 1, 0] == 0.0
    np.testing.assert_allclose(cut.positions[:at, 1], whole.positions[:at, 1], rtol=1e-14)


def test_a_floor_of_lammps_bears_the_weight():
    installed("lammps")
    b = AssemblyBuilder(3, "linear_frictional", gravity=fewbody.GRAVITY)
    b.add_material("a", density=2600.0, contact=fewbody.LINEAR[0])
    weight = 2600.0 * 4.0 / 3.0 * np.pi * 1e-6 * 9.81
    # a wall is twice as stiff as a contact of two spheres
    b.add_particles([[0.0, 0.0, 0.01 - weight / 2e5]], 0.01, "a")
    b.add_wall(fewbody.FLOOR)
    (run,) = BACKENDS["lammps"].run_posed([Posed("at rest", b.build(), 4e-6, 50, "geodem")])
    np.testing.assert_allclose(run.wall_forces[:, 0], [[0.0, 0.0, -weight]] * 50, rtol=1e-9, atol=1e-12)


# --- what a code cannot express ----------------------------------------------------------------------------


def refused(code, assembly=None, match="", **changes):
    law, convention = ("elastic_frictional", "yade") if code == "yade" else ("hooke_stiffness", "liggghts")
    one = fewbody.head_on(law, convention)
    with pytest.raises(BackendError, match=match):
        BACKENDS[code].run_posed([replace(one, assembly=assembly or one.assembly, **changes)])


@pytest.mark.parametrize("code", CODES)
def test_what_a_code_cannot_express_is_refused(code):
    installed(code)
    law = "elastic_frictional" if code == "yade" else "hooke_stiffness"
    other = fewbody.head_on("hooke_stiffness" if code == "yade" else "elastic_frictional", "geodem").assembly
    refused(code, other, match="no contact law")
    refused(code, match="convention", convention="geodem")
    one = fewbody.head_on(law, "yade").assembly
    tilted = replace(one.walls[0], planes=np.array([[[0.0, 0.0, -0.1], [0.6, 0.0, 0.8]]]))
    refused(code, replace(one, walls=(tilted,)), match="not along the axes")
    turning = replace(one.walls[0], spin=np.array([0.0, 0.0, 1.0]))
    refused(code, replace(one, walls=(turning,)), match="turns or is driven")
    table = one.contact_table.copy()
    table[1, 0] *= 1.1
    if code == "yade":
        refused(code, replace(one, contact_table=table), match="follow from the materials")
    else:
        refused(code, match="no local damping", local_damping=0.1)
        held = one.held.copy()
        held[0, 3] = True
        refused(code, replace(one, held=held), match="about all axes or about none")
        moving = replace(one.walls[0], velocity=np.array([0.0, 0.0, 1.0]))
        refused(code, replace(one, walls=(moving,)), match="its planes are fixed")


def test_bonds_that_yade_has_not_are_refused():
    installed("yade")
    bonded = fewbody.bending("cohesive_moments", "yade")
    with pytest.raises(BackendError, match="no bond law"):
        BACKENDS["yade"].run_posed(
            [replace(bonded, assembly=replace(bonded.assembly, bond_law="parallel_bond"))]
        )
    with pytest.raises(BackendError, match="it has no bonds"):
        BACKENDS["liggghts"].run_posed(
            [
                replace(
                    bonded,
                    convention="liggghts",
                    assembly=replace(bonded.assembly, contact_law="hooke_stiffness"),
                )
            ]
        )
