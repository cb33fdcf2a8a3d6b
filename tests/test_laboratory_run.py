"""A laboratory case in its folder: what it leaves, that nothing is made twice, and the same bits by any processes."""

from __future__ import annotations

import json
import math
import re
import statistics
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image

from geodem.case import load_any
from geodem.errors import InputError, StoppedError
from geodem.io.history import read_history
from geodem.laboratory import orders as orders_module
from geodem.laboratory.files import write_tests
from geodem.laboratory.orders import TestOrder, Told, find_test
from geodem.laboratory.workers import Forecast, Overview, Workers
from geodem.laboratory_run import (
    _finished,
    orders_of,
    quick,
    redraw_laboratory,
    resume_laboratory,
    run_laboratory,
)
from tests.laboratory_cases import LABORATORY, TENSION, write_case
from tests.small_cases import result_of


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    return write_case(tmp_path_factory.mktemp("laboratory"))


@pytest.fixture(scope="module")
def seen() -> list[Overview]:
    return []


@pytest.fixture(scope="module")
def out(place, seen) -> Path:
    """The results of a quick run, two tests at a time."""
    run_laboratory(
        load_any(place), place / "out", threads=2, quickly=True, watch=seen.append, command="geodem lab"
    )
    return place / "out"


@pytest.fixture(scope="module")
def result(out) -> dict:
    return result_of(out)


def test_result_holds_what_is_promised(result):
    contract = {
        "workflow": str, "title": str, "status": str, "kind_of_result": str, "particles": int, "dimension": int,
        "specimen": dict, "material": dict, "properties": dict, "tests": list, "envelope": dict, "cracks": dict,
        "steps": int, "wall_time_s": float, "compile_time_s": float, "test_time_s": float, "threads": int,
        "seed": int, "versions": dict, "warnings": list, "notices": list, "digest": str, "identity": str,
        "quick": bool, "command": str, "sources_digest": str,
    }  # fmt: skip
    assert {key: type(value) for key, value in result.items()} == contract
    assert result["status"] == "done"
    assert [test["kind"] for test in result["tests"]] == [
        "uniaxial-compression",
        "direct-tension",
        "triaxial-compression",
    ]
    assert "confinement_Pa" not in result["tests"][0]
    assert result["tests"][2]["confinement_Pa"] == 10e6
    for test in result["tests"]:
        assert test["seeds"] == [3, 4]
        assert test["failed"] == [True, True]
        values = test["strength_Pa"]["values"]
        assert test["strength_Pa"]["mean"] == pytest.approx(statistics.mean(values))
        assert test["strength_Pa"]["standard_deviation"] == pytest.approx(statistics.stdev(values))
        for key in ("young_modulus_Pa", "poisson_ratio", "peak_strain", "crack_initiation_stress_Pa"):
            assert test[key]["specimens"] == 2
    assert result["steps"] == sum(test["steps"] for test in result["tests"])
    assert any(notice.startswith("--quick: ") for notice in result["notices"])
    assert any("12 particles across" in warning for warning in result["warnings"])


def test_properties_are_those_of_such_bonds(result):
    """Prototypes of 24 to 60 discs across: E = 0.85 Ec, nu = 0.21 at kappa 2.5, T = 0.62 Tb,
    ln R = 1.02 + 0.86 ln(C/Tb) + 0.52 t + 0.035 t ln(C/Tb). So coarse a specimen comes near it only.
    """
    found = {key: entry["mean"] for key, entry in result["properties"].items()}
    assert found["young_modulus_Pa"] == pytest.approx(0.85 * 80e9, rel=0.2)
    assert found["poisson_ratio"] == pytest.approx(0.21, abs=0.06)
    assert found["tensile_strength_Pa"] == pytest.approx(0.62 * 15e6, rel=0.25)
    ratio = math.exp(1.02 + 0.86 * math.log(4.0) + 0.52 * 0.7 + 0.035 * 0.7 * math.log(4.0))
    assert found["strength_ratio"] == pytest.approx(ratio, rel=0.35)


def test_the_envelope_goes_through_the_strengths(result):
    """s1 = UCS + N s3, N = (1 + sin phi)/(1 - sin phi), UCS = 2 c sqrt(N) (Jaeger, Cook & Zimmerman 2007, eq. 4.22)."""
    ucs, confined = (result["tests"][k]["strength_Pa"]["mean"] for k in (0, 2))
    slope = (confined - ucs) / 10e6
    envelope = result["envelope"]
    assert math.sin(envelope["friction_angle_rad"]) == pytest.approx((slope - 1.0) / (slope + 1.0))
    assert envelope["cohesion_Pa"] == pytest.approx(ucs / (2.0 * math.sqrt(slope)))
    singles = [
        (b - a) / 10e6
        for a, b in zip(*(result["tests"][k]["strength_Pa"]["values"] for k in (0, 2)), strict=True)
    ]
    angles = [math.asin((n - 1.0) / (n + 1.0)) for n in singles]
    spread = envelope["over_specimens"]["friction_angle_rad"]
    assert spread["mean"] == pytest.approx(statistics.mean(angles))
    assert spread["standard_deviation"] == pytest.approx(statistics.stdev(angles))


def test_files_tell_the_same(out, result):
    history = read_history(out / "history.csv")
    assert all(name.endswith("]") for name in history)
    strengths = [value for test in result["tests"] for value in test["strength_Pa"]["values"]]
    assert history["strength [Pa]"].tolist() == strengths
    curves = read_history(out / "curves" / "uniaxial-compression-3.csv")
    assert curves["axial_stress [Pa]"].max() == strengths[0]
    assert len(list((out / "curves").iterdir())) == 6
    again = load_any(out)
    assert orders_of(again, quickly=True) == orders_of(quick(again), quickly=True)


def test_frames_can_be_read(out, result):
    names = sorted(path.name for path in out.glob("*.vtkhdf"))
    assert [name.split("-")[0] for name in names] == ["cracks"] * 3 + ["particles"] * 3
    for name in names:
        with h5py.File(out / name) as file:
            root = file["VTKHDF"]
            if name.startswith("particles"):
                assert root["Points"].shape == (result["particles"], 3)
            else:
                modes = root["PointData"]["mode [-]"][()]
                assert len(modes) > 0
                assert set(modes.tolist()) <= {1, 2}


def test_the_report_needs_nothing_else(out, result):
    page = (out / "report.html").read_text()
    outside = re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#)([^"']*)""", page)
    assert outside == []
    assert page.count("data:image/") >= 7
    text = re.sub(r"<[^>]*>", " ", re.sub(r"<(style|script).*?</\1>", " ", page, flags=re.DOTALL))
    for words in (
        "Young&#x27;s modulus",
        "friction angle",
        "standard deviation",
        "positive in compression",
        "plane stress",
    ):
        assert words in text, words
    ucs = result["properties"]["uniaxial_compressive_strength_Pa"]["mean"]
    assert f"{ucs / 1e6:.3g} MPa" in text
    for name in ("curves-compression", "curves-direct-tension", "cracking", "envelope"):
        with Image.open(out / "figures" / f"{name}.png") as picture:
            assert len(picture.convert("RGB").getcolors(1 << 24)) > 20


def test_progress_tells_what_is_done_and_left(seen, out):
    finished = [overview.finished for overview in seen if overview.last is not None]
    assert finished == [1, 2, 3, 4, 5, 6]
    assert math.isnan(seen[0].seconds_left)
    assert all(overview.seconds_left > 0.0 for overview in seen if 0 < overview.finished < 6)
    assert seen[-1].seconds_left == 0.0
    assert max(len(overview.running) for overview in seen) == 2


def test_frames_of_a_stopped_run_do_not_stay(place, out, tmp_path):
    """With fewer tests another one is the typical one of its kind."""
    tests = _finished(orders_of(quick(load_any(place)), True), out)
    whole = {path.name for path in out.glob("*.vtkhdf")}
    begun = set()
    for test in tests:
        write_tests(tmp_path, [test])
        begun |= {path.name for path in tmp_path.glob("*.vtkhdf")}
    assert begun > whole
    write_tests(tmp_path, tests)
    assert {path.name for path in tmp_path.glob("*.vtkhdf")} == whole


def test_what_is_done_is_not_done_again(place, out, result):
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*") if path.is_file()}
    again = run_laboratory(load_any(place), out, quickly=True)
    assert again == result
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*") if path.is_file()} == before


def test_stopped_and_resumed_gives_the_same_bits(tmp_path):
    """Stopped on two processes after its second test; the rest, and one that was damaged, on one."""
    case = load_any(write_case(tmp_path, TENSION))
    whole = run_laboratory(case, tmp_path / "whole", threads=2)
    folder = tmp_path / "stopped"
    finished: list = []
    grown: list[int] = []

    def watch(overview: Overview) -> None:
        if overview.last is not None:
            finished.append(overview.last)
            grown.append(len(read_history(folder / "history.csv")["test [-]"]))

    with pytest.raises(StoppedError):
        run_laboratory(case, folder, threads=2, watch=watch, stop_asked=lambda: len(finished) > 1)
    stopped = result_of(folder)
    assert stopped["status"] == "stopped"
    # the history has grown with every test
    assert grown == sorted(grown)
    assert grown[-1] >= 2
    assert (folder / "report.html").is_file()
    kept = sorted((folder / "tests").glob("*.h5"))
    assert 2 <= len(kept) < 6
    kept[0].write_bytes(kept[0].read_bytes()[:-100])
    before = kept[1].stat().st_mtime_ns
    resumed = resume_laboratory(folder, load_any(folder), threads=1)
    assert resumed["status"] == "done"
    assert resumed["digest"] == whole["digest"]
    assert resumed["tests"][0]["strength_Pa"] == whole["tests"][0]["strength_Pa"]
    assert kept[1].stat().st_mtime_ns == before
    assert resumed["wall_time_s"] > stopped["wall_time_s"]


def test_redrawn_from_what_is_there(out, result):
    report = (out / "report.html").read_text()
    (out / "report.html").unlink()
    (out / "history.csv").unlink()
    assert redraw_laboratory(out, load_any(out)) == out / "report.html"
    assert (out / "report.html").read_text() == report
    assert (out / "history.csv").is_file()


def test_another_case_is_not_written_over(place, out):
    before = (out / "result.json").read_bytes()
    other = write_case(place / "other", LABORATORY.replace("15 MPa", "16 MPa"))
    with pytest.raises(InputError, match=r"another case.*overwrite"):
        run_laboratory(load_any(other), out, quickly=True)
    with pytest.raises(InputError, match="holds a case file"):
        run_laboratory(load_any(other), place, quickly=True)
    assert (out / "result.json").read_bytes() == before


def test_what_cannot_be_tested_is_told_before_anything_is_written(place, tmp_path):
    case = load_any(place)
    wrong = replace(case, specimen=replace(case.specimen, across=5.0))
    with pytest.raises(InputError, match="too coarse"):
        run_laboratory(wrong, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def orders(place: Path) -> list[TestOrder]:
    return orders_of(quick(load_any(place)), quickly=True)


def test_a_finished_test_is_found_by_all_that_decides_it(place, out, monkeypatch):
    first = orders(place)[0]
    path = out / "tests" / f"{first.name}.h5"
    found = find_test(path, first)
    assert found is not None
    assert found.record.strength == result_of(out)["tests"][0]["strength_Pa"]["values"][0]
    for other in (
        replace(first, pace=first.pace + 1.0),
        replace(first, material=first.material.with_bond(tensile_strength=16e6)),
        replace(first, specimen={**first.specimen, "size_ratio": 1.5}),
    ):
        assert find_test(path, other) is None
    assert find_test(out / "tests" / "none.h5", first) is None
    monkeypatch.setattr(orders_module, "sources_digest", lambda: "another version")
    assert find_test(path, first) is None


def test_what_goes_wrong_in_a_process_comes_out_of_it(place):
    first = orders(place)[0]
    with Workers(1) as workers:
        with pytest.raises(InputError, match=r"uniaxial-compression-3, specimen, across = 5\.0.*too coarse"):
            workers.run([replace(first, specimen={**first.specimen, "across": 5.0})])
        with pytest.raises(RuntimeError, match=r"(?s)Traceback.*unexpected keyword argument 'colour'"):
            workers.run([replace(first, specimen={**first.specimen, "colour": "red"})])


def test_a_process_that_was_ended_is_told(place):
    def end(overview: Overview) -> None:
        for hand in workers.processes._hands:
            hand.process.kill()

    workers = Workers(1, watch=end)
    with workers, pytest.raises(InputError, match=r"ended from outside.*signal 9.*memory"):
        workers.run(orders(place)[:1])


def test_time_left_is_that_of_the_longest_line(place):
    first = orders(place)[0]
    forecast = Forecast()
    assert math.isnan(forecast.left([(first, 4.0, Told())], [], 1)), (
        "nothing has ended, nothing is well under way"
    )
    # a quarter of one is done, at a pace of 12 s for the whole
    under_way = (first, 4.0, Told(share=0.25, whole=12.0))
    assert forecast.left([under_way], [first], 1) == pytest.approx(9.0 + 12.0)
    forecast.learn(first, 10.0)
    assert forecast.left([], [first] * 3, 2) == pytest.approx(20.0)
    assert forecast.left([(first, 4.0, Told())], [first] * 2, 2) == pytest.approx(16.0)
    assert forecast.left([under_way], [first] * 2, 2) == pytest.approx(17.5)
    assert forecast.left([(first, 50.0, Told(share=1.3))], [], 1) == pytest.approx(0.5), "overdue"
    assert forecast.left([], [], 2) == 0.0


def test_curves_of_a_run_are_numbers(out):
    for path in (out / "curves").glob("*.csv"):
        for name, values in read_history(path).items():
            assert np.isfinite(values).all(), (path, name)
    json.loads((out / "result.json").read_text(), parse_constant=lambda text: pytest.fail(text))
