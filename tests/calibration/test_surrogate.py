"""Surfaces find a known map from noisy samples, say honestly how well, and are turned round."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geodem.calibration.inverse import invert
from geodem.calibration.surface import fit_surface, nearest_in_hull, noise_of
from geodem.calibration.surrogate import Estimate, Measured, estimate_of, fit_surrogate
from geodem.calibration.table import content_of, load_table, table_of
from geodem.calibration.targets import RockTargets
from geodem.errors import InputError
from tests.calibration.synthetic import ANSWERS, NOISE, SCATTER, Specimens, content, table, truth

SANDSTONE = RockTargets(2300.0, 15e9, 0.22, 70e6, 5e6, math.radians(43.0))
SURROGATE = fit_surrogate(table(0))


def random_micro(rng: np.random.Generator) -> dict[str, float]:
    """Bonds inside of what the synthetic map holds."""
    return {
        "stiffness_ratio": 1.0 / rng.uniform(1.0 / 8.0, 1.0 / 1.2),
        "shear_over_tension": math.exp(rng.uniform(math.log(1.5), math.log(10.0))),
        "bond_friction": rng.uniform(0.0, 1.05),
    }


def test_the_map_is_found_within_its_noise() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        micro = random_micro(rng)
        found = SURROGATE.predict(micro)
        for name, value in truth(micro).items():
            # four specimens: noise/2 of a row's mean and of what its seeds share, here in three standard deviations
            if name in SCATTER:
                assert abs(found[name].value - value) < 1.5 * SCATTER[name]
            else:
                assert abs(math.log(found[name].value / value)) < 1.5 * NOISE


def test_without_noise_the_map_is_exact() -> None:
    rng = np.random.default_rng(2)
    document = content(0)
    for row in document["rows"]:
        row["macro"] = {name: [value] * 4 for name, value in truth(row["micro"]).items()}
    surrogate = fit_surrogate(table_of(document))
    kinds = {line["answer"]: line["surface"] for line in surrogate.report()}
    # t ln(C/Tb) is in the closed forms
    assert kinds["strength_ratio"] == kinds["friction_angle"] == "interactions"
    assert kinds["tension_ratio"] == kinds["modulus_ratio"] == "constant"
    for _ in range(5):
        micro = random_micro(rng)
        for name, value in truth(micro).items():
            # (1 - s)/(3 + s) is no polynomial of ln(1/s); a cubic errs by less than 1e-3 over 1/8 < s < 1/1.2
            close = 1e-3 if name == "poisson_ratio" else 1e-9
            assert surrogate.predict(micro)[name].value == pytest.approx(value, rel=1e-9, abs=close)


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """95 % intervals: of the mean over all specimens, and of the mean over three that were never seen."""
    rng = np.random.default_rng(3)
    inside, fresh_inside, total = 0, 0, 0
    for trial in range(60):
        surrogate = fit_surrogate(table(1000 + trial))
        micro = random_micro(rng)
        wide, fresh = surrogate.predict(micro), surrogate.predict(micro, tests=3)
        tests = Specimens(3, rng).tested(micro)
        for name, value in truth(micro).items():
            logs = np.array(tests[name]) if name in SCATTER else np.log(tests[name])
            mean = float(logs.mean() if name in SCATTER else np.exp(logs.mean()))
            inside += wide[name].low <= value <= wide[name].high
            fresh_inside += fresh[name].low <= mean <= fresh[name].high
            total += 1
    assert 0.90 <= inside / total <= 0.99
    assert 0.90 <= fresh_inside / total <= 0.99


def test_a_map_of_one_specimen_a_point_knows_its_scatter_from_the_surface() -> None:
    rng = np.random.default_rng(8)
    inside, total = 0, 0
    for trial in range(25):
        surrogate = fit_surrogate(table_of(content(3000 + trial, seeds=1, apart=True)))
        assert surrogate.answers["strength_ratio"].surface.scatter == 0.0
        micro = random_micro(rng)
        found, tests = surrogate.predict(micro, tests=4), Specimens(4, rng).tested(micro)
        for name in ("tension_ratio", "strength_ratio", "friction_angle"):
            logs = np.array(tests[name]) if name in SCATTER else np.log(tests[name])
            mean = float(logs.mean() if name in SCATTER else np.exp(logs.mean()))
            inside += found[name].low <= mean <= found[name].high
            total += 1
    assert inside / total >= 0.90


def test_the_error_at_points_left_out_is_that_of_new_points() -> None:
    """Root mean squares over many maps: at left-out points of the maps, and at new points with as many specimens.

    The new points are tested on the seeds of the map, so that what these share is in neither of the two.
    """
    left_out, new = [], []
    for trial in range(25):
        document = content(2000 + trial)
        kept = [row for i, row in enumerate(document["rows"]) if i not in (5, 6)]
        surrogate = fit_surrogate(table_of({**document, "rows": kept}))
        left_out.append(surrogate.answers["strength_ratio"].surface.leave_one_out)
        for i in (5, 6):
            row = document["rows"][i]
            value = surrogate.predict(row["micro"])["strength_ratio"].value
            new.append(math.log(value) - float(np.mean(np.log(row["macro"]["strength_ratio"]))))
    assert np.sqrt(np.mean(np.square(left_out))) == pytest.approx(np.sqrt(np.mean(np.square(new))), rel=0.3)


def test_noise_is_parted_into_own_and_common() -> None:
    """Values with variance 1 of each kind: scatter sqrt 2, common 1/sqrt(20) for twenty seeds."""
    rng = np.random.default_rng(4)
    common = rng.normal(0.0, 1.0, 20)
    points = [{k: float(common[k] + rng.normal()) for k in range(20)} for _ in range(200)]
    noise = noise_of(points)
    assert noise.own == pytest.approx(1.0, rel=0.05)
    assert noise.common * math.sqrt(20.0) == pytest.approx(float(common.std(ddof=1)), rel=0.05)
    assert noise.scatter**2 == pytest.approx(1.0 + common.var(ddof=1), rel=0.05)
    other = [{100 * row + k: float(rng.normal()) for k in range(20)} for row in range(50)]
    assert noise_of(other).common == 0.0


def test_targets_to_bonds_and_back() -> None:
    """Bonds of the answer, put into the closed forms, have what was wanted."""
    rng = np.random.default_rng(5)
    for _ in range(6):
        wanted = truth(random_micro(rng))
        targets = RockTargets(
            2500.0,
            30e9,
            wanted["poisson_ratio"],
            wanted["strength_ratio"] * 6e6,
            6e6,
            wanted["friction_angle"],
        )
        fit = invert(SURROGATE, targets, tests=4)
        assert fit.missed == ()
        found = truth(dict(fit.micro))
        assert found["poisson_ratio"] == pytest.approx(wanted["poisson_ratio"], abs=0.015)
        assert found["strength_ratio"] == pytest.approx(wanted["strength_ratio"], rel=0.05)
        assert found["friction_angle"] == pytest.approx(wanted["friction_angle"], abs=math.radians(2.0))
        # E = 0.85 Ec, T = 0.62 Tb
        assert fit.effective_modulus == pytest.approx(30e9 / 0.85, rel=0.04)
        assert fit.tensile_strength == pytest.approx(6e6 / 0.62, rel=0.04)
        for name in ("young_modulus", "tensile_strength", "uniaxial_compressive_strength"):
            estimate = fit.answers[name]
            assert estimate.low < estimate.value < estimate.high
            assert estimate.value == pytest.approx(getattr(targets, name), rel=0.02)


def test_the_bonds_as_a_material() -> None:
    fit = invert(SURROGATE, SANDSTONE)
    material = fit.material(2300.0, name="sandstone")
    material.check()
    assert (
        material.bond["effective_modulus"] == material.contact["effective_modulus"] == fit.effective_modulus
    )
    ratio = material.bond["shear_strength"] / material.bond["tensile_strength"]
    assert ratio == pytest.approx(fit.micro["shear_over_tension"], rel=1e-12)
    assert material.bond["friction_coefficient"] == pytest.approx(fit.micro["bond_friction"], rel=1e-12)
    assert (material.bonding_range, material.contact["friction_coefficient"]) == (1.05, 0.5)


def test_what_cannot_be_had_is_named() -> None:
    """By the closed forms R = 20 with t = 1.05, the most there is, needs ln(C/Tb) = 1.594, so that phi = 52.9 deg."""
    fit = invert(SURROGATE, replace(SANDSTONE, friction_angle=math.radians(59.0), tensile_strength=3.5e6))
    (miss,) = fit.missed
    assert (miss.name, miss.others_kept) == ("friction_angle", True)
    assert math.degrees(miss.nearest) == pytest.approx(52.9, abs=1.0)
    assert str(miss).startswith("a friction angle of 59 deg cannot be had: at most 5")
    assert SURROGATE.distance(SURROGATE.place(fit.micro)) < 0.01
    far = invert(SURROGATE, replace(SANDSTONE, tensile_strength=1e6))
    assert {miss.name for miss in far.missed} >= {"strength_ratio"}
    assert "compressive over tensile strength 70 cannot be had: at most" in str(far.missed[0])


def test_outside_of_what_was_measured_is_told() -> None:
    inside = {"stiffness_ratio": 2.5, "shear_over_tension": 3.0, "bond_friction": 0.5}
    assert SURROGATE.distance(SURROGATE.place(inside)) == 0.0
    # twice the range of the friction: half of it beyond 1.05, that is two half ranges
    outside = {**inside, "bond_friction": 2.1}
    assert SURROGATE.distance(SURROGATE.place(outside)) == pytest.approx(2.0, abs=1e-3)
    with pytest.raises(InputError, match=r"bonding_range = 1.3: .*The map holds 1.05"):
        invert(SURROGATE, SANDSTONE, keep={"bonding_range": 1.3})
    with pytest.raises(InputError, match=r"stiffness_ratio = 20.0: .*The map holds 1.2 to 8"):
        invert(SURROGATE, SANDSTONE, keep={"stiffness_ratio": 20.0})
    kept = invert(SURROGATE, SANDSTONE, keep={"bond_friction": 0.5, "bonding_range": 1.05})
    assert kept.micro["bond_friction"] == pytest.approx(0.5, rel=1e-12)


def test_the_nearest_point_of_a_hull() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    np.testing.assert_allclose(nearest_in_hull(square, np.array([0.3, 0.6])), [0.3, 0.6], atol=1e-5)
    np.testing.assert_allclose(nearest_in_hull(square, np.array([2.0, 0.5])), [1.0, 0.5], atol=1e-5)
    np.testing.assert_allclose(nearest_in_hull(square, np.array([2.0, 3.0])), [1.0, 1.0], atol=1e-5)


def shifted(micro: dict[str, float]) -> dict[str, float]:
    """Specimens of another sort than the map's: R a sixth higher, 4 deg less of friction, and less so with more t."""
    found = truth(micro)
    found["strength_ratio"] *= 1.0 + 0.17 * math.exp(-0.2 * micro["bond_friction"])
    found["friction_angle"] -= math.radians(4.0 - micro["bond_friction"])
    return found


@pytest.mark.parametrize("seed", [6, 7])
def test_two_trials_bring_other_specimens_to_their_targets(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trials: list[Measured] = []
    away = []
    for _ in range(3):
        fit = invert(SURROGATE.corrected(trials), SANDSTONE)
        micro = dict(fit.micro)
        given = shifted(micro)
        away.append((given["strength_ratio"] / 14.0 - 1.0, math.degrees(given["friction_angle"]) - 43.0))
        noise = rng.normal(0.0, 1.0, (len(ANSWERS), 4))
        macro = {
            name: list(
                given[name] + SCATTER[name] * z if name in SCATTER else given[name] * np.exp(NOISE * z)
            )
            for name, z in zip(ANSWERS, noise, strict=True)
        }
        trials.append(Measured(micro, macro))
    assert away[0][0] > 0.1
    assert away[0][1] < -3.0
    # four specimens: a standard error of 1.5 % and 0.6 deg in each trial
    assert abs(away[2][0]) < 0.045
    assert abs(away[2][1]) < 1.8


def test_a_trial_of_much_noise_moves_the_surface_little() -> None:
    micro = {"stiffness_ratio": 2.5, "shear_over_tension": 4.0, "bond_friction": 0.6}
    before = SURROGATE.predict(micro)["strength_ratio"]
    few = SURROGATE.corrected([Measured(micro, {"strength_ratio": [before.value * 1.02]})])
    after = few.predict(micro)["strength_ratio"]
    assert before.value < after.value < before.value * 1.02
    many = SURROGATE.corrected([Measured(micro, {"strength_ratio": [before.value * 1.2] * 400})])
    assert many.predict(micro)["strength_ratio"].value == pytest.approx(before.value * 1.2, rel=1e-3)


def test_an_interval_from_specimens() -> None:
    """Student's t of 3 degrees of freedom: 3.182; mean 0.25, deviation 0.1291, standard error 0.0645."""
    found = estimate_of("poisson_ratio", [0.1, 0.2, 0.3, 0.4])
    assert found == Estimate(
        0.25, pytest.approx(0.25 - 3.1824 * 0.06455, abs=1e-4), pytest.approx(0.4554, abs=1e-4)
    )
    known = estimate_of("strength_ratio", [10.0], scatter=0.1)
    assert known.high / known.value == pytest.approx(math.exp(0.19600), rel=1e-4)
    with pytest.raises(InputError, match="Run two specimens"):
        estimate_of("strength_ratio", [10.0])


def test_a_map_file_goes_round(tmp_path: Path) -> None:
    document = content(3)
    document["rows"][0]["macro"]["strength_ratio"][1] = None
    path = tmp_path / "map.json"
    path.write_text(json.dumps(document))
    read = load_table(path)
    assert set(read.macro("strength_ratio")[0]) == {1, 3, 4}
    row = document["rows"][2]["macro"]
    # UCS/Tb = R T/Tb, seed by seed
    assert read.rows[2].macro["compression_ratio"][3] == row["strength_ratio"][3] * row["tension_ratio"][3]
    again = table_of(json.loads(json.dumps(content_of(read))))
    first, second = fit_surrogate(read), fit_surrogate(again)
    assert first.report() == second.report()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"format": 7}, "another format"),
        ({"rows": []}, "there are none"),
    ],
)
def test_bad_map_files(change: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        table_of({**content(0), **change})


def test_rows_of_a_map_file_are_checked(tmp_path: Path) -> None:
    document = content(0)
    document["rows"][1]["macro"]["strength_ratio"].append(1.0)
    with pytest.raises(InputError, match=r"rows\[1\].macro.strength_ratio: 5 values for 4 seeds"):
        table_of(document)
    document = content(0)
    document["rows"][0]["micro"]["kappa"] = 2.0
    with pytest.raises(InputError, match=r"unknown name.*stiffness_ratio"):
        table_of(document)
    with pytest.raises(InputError, match="cannot be read"):
        load_table(tmp_path / "none.json")


def test_too_few_points_are_no_surface() -> None:
    noise = noise_of([{1: 0.0}])
    points = np.linspace(-1.0, 1.0, 3)[:, None]
    with pytest.raises(InputError, match="3 points do not tell a surface"):
        fit_surface(points, np.zeros(3), np.ones(3), noise, what="friction_angle")
