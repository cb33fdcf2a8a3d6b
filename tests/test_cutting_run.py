"""The folder of a cut: result, report, history, frames; stopped, resumed, drawn again; refused."""

import csv
import json
import sys

import numpy as np
import pytest
from rich.console import Console

import geodem.cutting_run as cutting_run
from geodem.cli import main
from geodem.cutting_check import check_cutting
from geodem.cutting_run import redraw_cutting, run_cutting
from geodem.errors import InputError, StoppedError
from geodem.kinds import KINDS
from tests.cutting_cases import small_case, small_text
from tests.small_cases import forecast_error, history_begun, works_of


@pytest.fixture(scope="module")
def told():
    """What the whole run tells."""
    return []


@pytest.fixture(scope="module")
def finished(told, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    case = small_case(folder)
    return case, folder / "out", run_cutting(case, folder / "out", watch=told.append)


def test_the_work_left_is_told_within_a_twentieth_of_all(finished, told):
    assert forecast_error(works_of(told)) < 0.05


def test_the_folder_holds_what_a_run_leaves(finished):
    _, out, result = finished
    stored = json.loads((out / "result.json").read_text())
    assert stored["status"] == "done"
    assert stored["workflow"] == "cutting"
    assert stored["forces"]["cutting_N_per_m"]["mean"] > 0.0
    assert abs(stored["energy"]["imbalance"]) < 0.01
    assert stored["chips"]["chips"] >= 0
    html = (out / "report.html").read_text()
    assert "Specific energy" in html
    for name in ("stages", "fragments", "forces", "energy"):
        assert (out / "figures" / f"{name}.png").is_file()
    # frames: the start and three more
    assert len(list(out.glob("particles-*.vtkhdf"))) == 4
    assert result["particles"] == stored["particles"]


def test_the_history_has_units_and_the_work_of_the_result(finished):
    _, out, result = finished
    with (out / "history.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert all(name.endswith("]") for name in rows[0])
    assert float(rows[-1]["work of the tool [J/m]"]) == pytest.approx(result["energy"]["tool_J_per_m"])
    way = np.array([float(row["way of the tool [m]"]) for row in rows])
    assert (np.diff(way) > 0.0).all()


def test_a_finished_run_is_not_run_again(finished):
    case, out, result = finished
    before = (out / "result.json").stat().st_mtime_ns
    again = run_cutting(case, out)
    assert (out / "result.json").stat().st_mtime_ns == before
    assert again["forces"] == json.loads(json.dumps(result["forces"]))


def test_a_stopped_run_goes_on_to_the_same_bits(finished, tmp_path):
    case, out, result = finished
    asked = iter([False, True])
    with pytest.raises(StoppedError):
        run_cutting(case, tmp_path / "out", stop_asked=lambda: next(asked))
    stored = json.loads((tmp_path / "out" / "result.json").read_text())
    assert stored["status"] == "stopped"
    assert history_begun(tmp_path / "out", out)
    kind = KINDS["cutting"]
    text = (tmp_path / "out" / "case.toml").read_text()
    resumed = kind.resume(tmp_path / "out", kind.parse(text, tmp_path / "out"))
    for name in ("forces", "energy", "chips", "cracks", "steps"):
        assert resumed[name] == result[name]
    assert (tmp_path / "out" / "history.csv").read_bytes() == (out / "history.csv").read_bytes()


def test_the_report_is_drawn_again_to_the_same_bytes(finished):
    case, out, _ = finished
    before = (out / "report.html").read_bytes()
    (out / "report.html").unlink()
    assert redraw_cutting(out, case) == out / "report.html"
    assert (out / "report.html").read_bytes() == before


def test_there_is_nothing_to_draw_without_a_cut(tmp_path):
    with pytest.raises(InputError, match="no finished cut"):
        redraw_cutting(tmp_path / "none", small_case(tmp_path))


@pytest.mark.parametrize(
    ("keys", "place"),
    [
        ({"start": '"50 mm"'}, "tool.start"),
        ({"start": '"5 mm"'}, "tool.start"),
        ({"distance": '"90 mm"'}, "tool.distance"),
        ({"depth": '"0.5 mm"'}, "tool.depth"),
        ({"depth": '"17.9 mm"', "height": '"60 mm"'}, "tool.depth"),
    ],
)
def test_a_cut_that_cannot_be_leaves_nothing(keys, place, tmp_path):
    with pytest.raises(InputError) as raised:
        run_cutting(small_case(tmp_path, **keys), tmp_path / "out")
    assert raised.value.place == place
    assert raised.value.remedy
    assert not (tmp_path / "out").exists()


def test_the_command_ends_with_2_on_bad_input(tmp_path, monkeypatch):
    path = tmp_path / "case.toml"
    path.write_text(small_text(start='"50 mm"'))
    monkeypatch.setattr(sys, "argv", ["geodem", "run", str(path), "--out", str(tmp_path / "out")])
    with pytest.raises(SystemExit) as raised:
        main()
    assert raised.value.code == 2


def test_check_tells_steps_and_draws_the_start(tmp_path):
    console = Console(record=True, width=200)
    case = small_case(tmp_path)
    found = check_cutting(case, tmp_path / "start.png", console)
    assert (tmp_path / "start.png").read_bytes()[:4] == b"\x89PNG"
    assert "mean diameters" in console.export_text()
    # the way and the ramp, over the way of one step
    assert found["steps"] == pytest.approx((1.2e-3 + 0.2e-3) / (8.0 * found["time_step_s"]), rel=0.01)


def test_quick_is_short_and_says_so(tmp_path):
    case = cutting_run.quick(small_case(tmp_path))
    assert case.plan.distance == pytest.approx(0.6e-3)
    assert any("--quick" in notice for notice in case.notices)
