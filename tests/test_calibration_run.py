"""A calibration in its folder, with a map in closed form and specimens so coarse that it takes seconds."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from geodem.calibration import fit
from geodem.calibration.outcomes import StoredOutcomes
from geodem.calibration.surrogate import fit_surrogate
from geodem.calibration.table import table_of
from geodem.calibration_run import expected_orders, redraw_calibration, resume_calibration, run_calibration
from geodem.case import load_any, load_material
from geodem.errors import InputError, StoppedError
from geodem.io.history import read_history
from tests.calibration import synthetic
from tests.laboratory_cases import CALIBRATION, write_case
from tests.small_cases import result_of


@pytest.fixture(scope="module", autouse=True)
def closed_form_map():
    """In the place of the maps that are stored with the package: they are measured, and change."""
    found = {"close": fit_surrogate(table_of(synthetic.content(1), place="closed form"))}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fit, "surrogates", lambda *_: found)
        yield


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    return write_case(tmp_path_factory.mktemp("calibration"), CALIBRATION)


@pytest.fixture(scope="module")
def out(place) -> Path:
    """Stopped after the first specimen, resumed on another number of processes."""
    case, folder = load_any(place), place / "out"
    tested = []
    with pytest.raises(StoppedError):
        run_calibration(
            case, folder, threads=1, quickly=True, watch=tested.append,
            stop_asked=lambda: len(list(folder.glob("tests/trial-*"))) > 0,
        )  # fmt: skip
    assert result_of(folder)["status"] == "stopped"
    kept = {path: path.stat().st_mtime_ns for path in folder.glob("tests/trial-*")}
    assert len(kept) == 1
    resume_calibration(folder, load_any(folder), threads=2)
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    return folder


@pytest.fixture(scope="module")
def result(out) -> dict:
    return result_of(out)


def test_result_holds_what_is_promised(result):
    assert result["workflow"] == "calibration"
    assert result["status"] == "done"
    assert result["specimens_tested"] == 2
    assert len(result["rounds"]) == 1
    assert len(result["rounds"][0]["specimens"]) == 2
    wanted = {
        "young_modulus": 15e9, "poisson_ratio": 0.22, "uniaxial_compressive_strength": 70e6,
        "tensile_strength": 6.5e6,
    }  # fmt: skip
    for name, value in wanted.items():
        entry = result["properties"][name]
        assert entry["target"] == pytest.approx(value)
        assert entry["low"] < entry["achieved"] < entry["high"]
        assert entry["difference"] == pytest.approx(entry["achieved"] - value)
    assert result["properties"]["friction_angle"]["unit"] == "rad"
    assert result["quick"] is True
    assert any("as narrow as is wanted" in line for line in result["warnings"])
    fresh = result["fresh"]
    assert {test["kind"] for test in fresh["tests"]} == {
        "uniaxial-compression",
        "direct-tension",
        "triaxial-compression",
    }
    assert [test["confinement_Pa"] for test in fresh["tests"][2:]] == [8.75e6, 17.5e6, 35e6]
    seeds = {specimen["seed"] for specimen in result["rounds"][0]["specimens"]}
    assert not seeds & {seed for test in fresh["tests"] for seed in test["seeds"]}, "fresh ones"


def test_the_material_file_is_the_result(out, result):
    material, calibrated = load_material(out / "material.toml")
    assert dict(material.bond) == result["material"]["bond"]
    assert material.density == 2300.0
    assert calibrated is not None
    assert calibrated.targets.young_modulus == pytest.approx(15e9)
    for name, entry in result["properties"].items():
        assert calibrated.achieved[name].value == entry["achieved"]
        assert calibrated.achieved[name].low == entry["low"]


def test_the_report_needs_nothing_else(out, result):
    page = (out / "report.html").read_text()
    assert re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#)([^"']*)""", page) == []
    text = re.sub(r"<[^>]*>", " ", re.sub(r"<(style|script).*?</\1>", " ", page, flags=re.DOTALL))
    for words in ("95 % interval of the mean", "fresh specimens", "properties reached", "target"):
        assert words in text, words
    assert {"rounds", "envelope", "cracking"} <= {path.stem for path in (out / "figures").glob("*.png")}
    history = read_history(out / "history.csv")
    assert history["round [-]"].tolist() == [1.0]
    mean = sum(s["young_modulus"] for s in result["rounds"][0]["specimens"]) / 2
    assert history["young_modulus [Pa]"][0] == pytest.approx(mean)


def test_redrawn_without_a_test(out, result):
    report = (out / "report.html").read_text()
    (out / "report.html").unlink()
    assert redraw_calibration(out, load_any(out)) == out / "report.html"
    assert (out / "report.html").read_text() == report
    assert run_calibration(load_any(out), out, quickly=True) == result


def test_another_rock_is_not_written_over(place, out):
    other = write_case(place / "other", CALIBRATION.replace("70 MPa", "72 MPa"))
    with pytest.raises(InputError, match="another case"):
        run_calibration(load_any(other), out, quickly=True)


def test_what_it_will_cost_is_known_before(place):
    """Three tests a specimen of the rounds, and five of each of the three fresh ones."""
    orders = expected_orders(load_any(place))
    assert len(orders) == fit.ROUNDS * fit.SPECIMENS * 3 + 3 * 5
    assert {order.material.density for order in orders} == {2300.0}


def test_outcomes_of_another_version_do_not_count(tmp_path, monkeypatch):
    from geodem.calibration import outcomes

    StoredOutcomes(tmp_path)["a trial"] = {"seed": 1}
    assert StoredOutcomes(tmp_path) == {"a trial": {"seed": 1}}
    monkeypatch.setattr(outcomes, "sources_digest", lambda: "another version")
    assert StoredOutcomes(tmp_path) == {}
