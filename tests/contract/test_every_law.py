"""What every law of the ground promises, whatever its physics: one table of laws drives all tests."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from geodem._jit import compile_kernel
from geodem.kernels import stress_particles
from geodem.laws import GROUND_LAWS

CONSTANTS = {
    "mohr_coulomb": {
        "associated": {"c": 10e3, "phi": 30.0, "psi": 30.0, "tension": np.inf},
        "no dilation": {"c": 10e3, "phi": 30.0, "psi": 0.0, "tension": np.inf},
        "some dilation": {"c": 2e3, "phi": 40.0, "psi": 10.0, "tension": np.inf},
        "undrained": {"c": 25e3, "phi": 0.0, "psi": 0.0, "tension": np.inf, "nu": 0.49},
        "tension cut-off": {"c": 10e3, "phi": 30.0, "psi": 30.0, "tension": 3e3},
        "undrained, no tension": {"c": 10e3, "phi": 0.0, "psi": 0.0, "tension": 0.0},
        "sand": {"c": 0.0, "phi": 35.0, "psi": 5.0, "tension": np.inf},
        "sand, no tension": {"c": 0.0, "phi": 35.0, "psi": 35.0, "tension": 0.0},
        "no strength at all": {"c": 0.0, "phi": 0.0, "psi": 0.0, "tension": np.inf},
    }
}
"""Materials that together reach every branch of a law."""


def make(constants):
    """Engineering constants of the table in SI."""
    return {
        "young_modulus": constants.get("young", 50e6),
        "poisson_ratio": constants.get("nu", 0.3),
        "cohesion": constants["c"],
        "friction_angle": np.radians(constants["phi"]),
        "dilation_angle": np.radians(constants["psi"]),
        "tensile_strength": constants["tension"],
    }


def strength_excess(constants, stress):
    """How far a stress lies outside its strength [Pa], from principal stresses (tension positive).

    Mohr-Coulomb as in the textbooks, with sigma_1 >= sigma_3:
    (sigma_1 - sigma_3)/2 + (sigma_1 + sigma_3)/2 sin(phi) - c cos(phi) <= 0, and sigma_1 <= tensile strength.
    """
    given = make(constants)
    low, high = np.linalg.eigvalsh([[stress[0], stress[2]], [stress[2], stress[1]]])
    phi = given["friction_angle"]
    shear = 0.5 * (high - low) + 0.5 * (high + low) * np.sin(phi) - given["cohesion"] * np.cos(phi)
    return max(shear, high - given["tensile_strength"])


def test_the_table_has_every_law():
    assert set(CONSTANTS) == set(GROUND_LAWS)


CASES = [
    pytest.param(GROUND_LAWS[name], constants, id=f"{name}: {label}")
    for name, materials in CONSTANTS.items()
    for label, constants in materials.items()
]
every_material = pytest.mark.parametrize(("law", "constants"), CASES)


@pytest.fixture
def elastic(monkeypatch):
    """Switch yielding off in the plain law."""
    for law in GROUND_LAWS.values():
        monkeypatch.setattr(law, "PLASTIC", False)


def update(law, material, stress, strain):
    return np.array(law.update_stress(*material, *stress, *strain))


def admissible_stress(law, material, rng, size=100e3):
    """A stress that the material bears: any stress, returned."""
    return update(law, material, rng.normal(size=3) * size, np.zeros(3))[:3]


def work(before, after, strain):
    """Work of the mean stress on a strain increment [J/m3]; strain xy is the tensor component."""
    mean = 0.5 * (np.asarray(before) + np.asarray(after))
    return mean[0] * strain[0] + mean[1] * strain[1] + 2.0 * mean[2] * strain[2]


def rotated(tensor, angle):
    """Components (xx, yy, xy) in axes turned by `angle`."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    full = turn @ np.array([[tensor[0], tensor[2]], [tensor[2], tensor[1]]]) @ turn.T
    return np.array([full[0, 0], full[1, 1], full[0, 1]])


@every_material
def test_stress_is_the_gradient_of_the_elastic_energy(law, constants, elastic):
    material = law.parameters(**make(constants))
    moduli = law.elastic_moduli(material)
    rng = np.random.default_rng(3)
    for _ in range(20):
        strain = rng.normal(size=3) * 1e-3
        stress = update(law, material, np.zeros(3), strain)[:3]
        step = 1e-6
        gradient = [
            (
                law.elastic_energy(*moduli, *update(law, material, np.zeros(3), strain + step * axis)[:3])
                - law.elastic_energy(*moduli, *update(law, material, np.zeros(3), strain - step * axis)[:3])
            )
            / (2.0 * step)
            for axis in np.eye(3)
        ]
        # the shear strain appears twice in the work; central differences of a quadratic are exact
        assert gradient == pytest.approx(
            [stress[0], stress[1], 2.0 * stress[2]], rel=1e-7, abs=1e-7 * abs(stress).max()
        )


def test_plane_strain_moduli():
    """E 10 GPa, nu 0.25, confined: E (1 - nu)/((1 + nu)(1 - 2 nu)) = 12 GPa; K0 = nu/(1 - nu) = 1/3."""
    given = {"c": 1e12, "phi": 0.0, "psi": 0.0, "tension": np.inf, "young": 10e9, "nu": 0.25}
    for law in GROUND_LAWS.values():
        material = law.parameters(**make(given))
        stress = update(law, material, np.zeros(3), [0.0, 1e-4, 0.0])
        assert stress[1] == pytest.approx(12e9 * 1e-4, rel=1e-12)
        assert stress[0] / stress[1] == pytest.approx(1.0 / 3.0, rel=1e-12)
        # G = E/(2 (1 + nu)) = 4 GPa
        assert update(law, material, np.zeros(3), [0.0, 0.0, 1e-4])[2] == pytest.approx(
            2 * 4e9 * 1e-4, rel=1e-12
        )


@every_material
def test_the_frame_does_not_matter(law, constants):
    material = law.parameters(**make(constants))
    rng = np.random.default_rng(4)
    for _ in range(100):
        stress, strain = admissible_stress(law, material, rng), rng.normal(size=3) * 2e-3
        angle = rng.uniform(0, np.pi)
        straight = update(law, material, stress, strain)
        turned = update(law, material, rotated(stress, angle), rotated(strain, angle))
        scale = 50e6 * 2e-3
        assert turned[:3] == pytest.approx(rotated(straight[:3], angle), rel=0, abs=1e-9 * scale)
        # exactly at the apex the plastic shear strain keeps its size
        assert turned[3:] == pytest.approx(straight[3:], rel=1e-7, abs=1e-12)


def strain_loops(rng, steps, corners=4):
    """A closed polygon through the origin of strain space, in equal steps along each side."""
    ends = np.vstack([np.zeros(3), rng.normal(size=(corners, 3)) * 2e-3, np.zeros(3)])
    return [(b - a) / steps for a, b in itertools.pairwise(ends) for _ in range(steps)]


@every_material
def test_an_elastic_loop_costs_nothing(law, constants, elastic):
    material = law.parameters(**make(constants))
    stress, total, size = np.zeros(3), 0.0, 0.0
    for strain in strain_loops(np.random.default_rng(5), 10):
        after = update(law, material, stress, strain)[:3]
        total += work(stress, after, strain)
        size += abs(work(stress, after, strain))
        stress = after
    assert abs(total) < 1e-12 * size
    assert abs(stress).max() < 1e-12 * 50e6 * 2e-3


@every_material
def test_a_loop_gives_no_energy(law, constants):
    """From the stress-free state round closed loops of strain: work is done on the material, never by it."""
    material = law.parameters(**make(constants))
    moduli = law.elastic_moduli(material)
    all_dissipated = all_size = 0.0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        stress, total, dissipated, size = np.zeros(3), 0.0, 0.0, 0.0
        for strain in strain_loops(rng, 200):
            answer = update(law, material, stress, strain)
            done = work(stress, answer[:3], strain)
            spent = done - law.elastic_energy(*moduli, *answer[:3]) + law.elastic_energy(*moduli, *stress)
            total += done
            dissipated += spent
            size += abs(done)
            stress = answer[:3]
        # nothing is stored at the start, so what is stored at the end was put in as well. The work is a
        # trapezoid sum, wrong by a part of the steps on which yielding begins.
        assert total >= -1e-5 * size
        assert dissipated >= -1e-5 * size
        all_dissipated, all_size = all_dissipated + dissipated, all_size + size
    if constants["c"] > 0.0:
        assert all_dissipated > 0.01 * all_size, "the loops are meant to yield"


@every_material
def test_the_returned_stress_is_borne(law, constants):
    material = law.parameters(**make(constants))
    rng = np.random.default_rng(6)
    yielded = 0
    for size in (1e-5, 1e-3, 1e-1, 1e3):
        for _ in range(200):
            stress = admissible_stress(law, material, rng, size=10.0 ** rng.uniform(2, 7))
            answer = update(law, material, stress, rng.normal(size=3) * size)
            # round-off of the trial stress, of which the answer is a small difference
            scale = abs(stress).max() + 2.0 * sum(law.elastic_moduli(material)) * size * 5
            assert strength_excess(constants, answer[:3]) <= 1e-12 * scale
            assert answer[4] >= 0.0, "plastic shear strain accumulates"
            yielded += answer[4] > 0.0
    assert yielded > 400


@every_material
def test_a_stress_within_its_strength_is_kept(law, constants):
    material = law.parameters(**make(constants))
    rng = np.random.default_rng(7)
    inside = 0
    for _ in range(100):
        stress = admissible_stress(law, material, rng)
        size = abs(stress).max()
        # on the yield surface, where round-off decides whether the stress is returned once more
        assert update(law, material, stress, np.zeros(3))[:3] == pytest.approx(
            stress, rel=0, abs=1e-13 * (size + 1e5)
        )
        half = 0.5 * stress
        if strength_excess(constants, half) < -1e-9 * size:
            inside += 1
            answer = update(law, material, half, np.zeros(3))
            assert answer[:3] == pytest.approx(half, rel=0, abs=1e-15 * size)
            assert answer[3] == answer[4] == 0.0
    if constants["c"] > 0.0:
        assert inside > 20


@every_material
def test_extreme_input_stays_finite(law, constants):
    material = law.parameters(**make(constants))
    axes = np.vstack([np.eye(3), -np.eye(3), [[1, 1, 0], [-1, -1, 0], [1, -1, 0]]])
    for stress in (np.zeros(3), np.array([1e5, 1e5, 0.0]), np.array([-1e5, -1e5, 0.0])):
        for axis in axes:
            for size in (0.0, 1e-300, 1e-12, 1.0, 1e12):
                answer = update(law, material, stress, axis * size)
                assert np.isfinite(answer).all(), (stress, axis, size)
                scale = 1e5 + 50e8 * size
                assert strength_excess(constants, answer[:3]) <= 1e-12 * scale


@every_material
@pytest.mark.parametrize("plastic", [True, False])
def test_compiled_is_plain(law, constants, plastic, monkeypatch):
    material = law.parameters(**make(constants))
    flags = law.features([material], plastic=plastic)
    for flag, value in flags.items():
        monkeypatch.setattr(law, flag, value)
    compiled = compile_kernel([law.update_stress], flags, parallel=False).update_stress
    rng = np.random.default_rng(8)
    for _ in range(300):
        stress, strain = rng.normal(size=3) * 1e5, rng.normal(size=3) * 10.0 ** rng.uniform(-6, -2)
        plain = update(law, material, stress, strain)
        fast = np.array(compiled(*material, *stress, *strain))
        scale = abs(stress).max() + sum(law.elastic_moduli(material)) * 2.0 * abs(strain).max()
        # sums may be contracted to fused multiply-adds
        assert fast[:3] == pytest.approx(plain[:3], rel=0, abs=8e-16 * scale)
        assert fast[3:] == pytest.approx(
            plain[3:], rel=0, abs=8e-16 * scale / law.elastic_moduli(material)[1]
        )


@every_material
def test_work_is_stored_or_dissipated(law, constants):
    """The kernel's account of one step: work of the stress = change of elastic energy + plastic work."""
    material = law.parameters(**make(constants))
    moduli = law.elastic_moduli(material)
    flags = {**law.features([material], plastic=True), "ONE_MATERIAL": True, "ENERGY": True, "CHUNK": 128}
    deform = compile_kernel(
        [law.update_stress, law.elastic_energy, stress_particles.deform], flags, parallel=False
    ).deform
    # three particles whose velocities give any strain: x along (1, 0), y along (0, 1)
    rows = (
        np.array([0, 3], np.int32),
        np.arange(3, dtype=np.int32),
        np.array([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]]),
    )
    rng = np.random.default_rng(9)
    for size in (1e-6, 1e-4, 1e-2):
        for _ in range(60):
            before = admissible_stress(law, material, rng)
            strain = rng.normal(size=3) * size
            velocity = np.array([[0.0, 0.0], [strain[0], strain[2]], [strain[2], strain[1]]])
            stress = np.array([[*before, 0.0]])
            dissipation = np.zeros(1)
            deform(
                velocity, *rows, np.ones(1), np.zeros(1, np.int32), np.array([material]), stress, dissipation
            )
            after = stress[0, :3]
            done = work(before, after, strain)
            stored = law.elastic_energy(*moduli, *after) - law.elastic_energy(*moduli, *before)
            scale = sum(law.elastic_moduli(material)) * size**2 + abs(before).max() * size
            assert dissipation[0] == pytest.approx(done - stored, rel=1e-9, abs=1e-10 * scale)


@every_material
@pytest.mark.parametrize("factor", [0.5, 1.0, 1.7, 40.0])
def test_strength_over_a_factor(law, constants, factor):
    """c/F, tan(phi)/F, tensile strength/F, dilation at most the reduced friction; stiffness is kept."""
    given = make(constants)
    phi = np.arctan(np.tan(given["friction_angle"]) / factor)
    expected = law.parameters(
        **{
            **given,
            "cohesion": given["cohesion"] / factor,
            "friction_angle": phi,
            "dilation_angle": min(given["dilation_angle"], phi),
            "tensile_strength": given["tensile_strength"] / factor,
        }
    )
    reduced = law.reduced(law.parameters(**given), factor)
    assert tuple(reduced) == pytest.approx(tuple(expected), rel=1e-12, abs=1e-12)


@every_material
def test_features_follow_from_the_materials(law, constants):
    """Leaving a branch out must not change an answer: the features that the law names are those it needs."""
    material = law.parameters(**make(constants))
    assert law.features([material], plastic=True) == {
        "PLASTIC": True,
        "TENSION": np.isfinite(constants["tension"]),
    }
    assert not any(law.features([material], plastic=False).values())


def test_one_material_with_a_cut_off_switches_it_on():
    for law in GROUND_LAWS.values():
        with_, without = (
            law.parameters(**make({"c": 10e3, "phi": 30.0, "psi": 0.0, "tension": tension}))
            for tension in (0.0, np.inf)
        )
        assert law.features([without, with_], plastic=True)["TENSION"]
        assert not law.features([without, without], plastic=True)["TENSION"]
