"""The workflow as it is shipped, run as a user runs it: everything that a run leaves, and the factor."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from PIL import Image

from geodem.case import load_case
from geodem.io.history import read_history
from tests.small_cases import ROOT, environment, geodem, result_of

WORKFLOW = ROOT / "workflows" / "slope_from_picture"
EXPECTED = tomllib.loads((WORKFLOW / "expected.toml").read_text())


@pytest.fixture(scope="module")
def out(tmp_path_factory) -> Path:
    """The results of a quick run from Python, which checks itself."""
    folder = tmp_path_factory.mktemp("workflow") / "out"
    command = [sys.executable, str(WORKFLOW / "run.py"), str(folder), "--quick"]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{folder}/report.html" in done.stdout
    return folder


@pytest.fixture(scope="module")
def result(out) -> dict[str, Any]:
    return result_of(out)


# what result.json promises, with the type of each entry
CONTRACT = {
    "workflow": str, "title": str, "status": str, "particles": int, "dimension": int, "factors": list,
    "steps": int, "wall_time_s": float, "compile_time_s": float, "seconds_to_first_step": float, "threads": int,
    "seed": int, "tolerance": float, "energy": dict, "cracks": dict, "versions": dict, "warnings": list,
    "notices": list, "neighbours": list, "digest": str,
}  # fmt: skip


def test_result_holds_what_is_promised(result):
    for key, kind in CONTRACT.items():
        assert isinstance(result[key], kind), key
    assert result["workflow"] == "slope"
    assert result["status"] == "done"
    assert result["dimension"] == 2
    assert result["seed"] == 1
    assert result["cracks"] == {"tension": 0, "shear": 0}
    assert {"geodem", "python", "numpy", "scipy", "numba"} <= set(result["versions"])
    assert 0.0 <= result["compile_time_s"] < result["wall_time_s"]
    assert 0.0 < result["seconds_to_first_step"] < result["wall_time_s"]
    assert re.fullmatch(r"[0-9a-f]{64}", result["digest"])
    strength, gravity = result["factors"]
    assert (strength["kind"], gravity["kind"]) == ("strength-reduction", "gravity-increase")
    for entry in result["factors"]:
        assert entry["stable"] < entry["value"] < entry["failed"]
        assert entry["value"] == pytest.approx(0.5 * (entry["stable"] + entry["failed"]))
        assert entry["failed"] - entry["stable"] <= result["tolerance"] * entry["value"] * (1 + 1e-9)
        for word in ("stable at", "failed at"):
            assert word in entry["criterion"]
        for trial in entry["trials"]:
            assert trial["verdict"] in ("stable", "failed", "undecided")
            assert trial["steps"] > 0
            assert trial["criterion"]
        assert entry["failure"]["moving_area_m2"] > 10.0
    assert "factor of safety" in strength["meaning"]
    assert "not a factor of safety" in gravity["meaning"]
    assert sum(t["steps"] for e in result["factors"] for t in e["trials"]) == result["steps"]


def test_the_factor_is_the_expected_one(result):
    """Upper bound of limit analysis 1.284; a coarse model is a little stronger."""
    expected = EXPECTED["strength-reduction"]
    found = result["factors"][0]
    assert found["value"] == pytest.approx(expected["factor"], rel=0.06)
    assert found["reference"]["value"] == pytest.approx(1.26)
    difference = 100 * (found["value"] / 1.26 - 1)
    assert found["reference"]["difference_percent"] == pytest.approx(difference, abs=1e-3)


def test_it_fails_along_the_seam(result):
    """The seam lies between 26.5 and 27.0 m; the slope between x = 43 m and its crest at 67.5 m."""
    surface = np.array(result["factors"][0]["failure"]["slip_surface_m"])
    assert 26.3 < surface[:, 1].min() < 27.1
    low = surface[surface[:, 1] < 27.3]
    assert np.ptp(low[:, 0]) > 10.0
    assert surface[:, 0].min() < 45.0
    assert surface[:, 0].max() > 67.0


def test_the_energy_account_closes(result):
    account = result["energy"]
    spent = sum(account[f"{kind}_J_per_m"] for kind in ("elastic", "plastic", "damping", "kinetic"))
    assert account["external_work_J_per_m"] > 0.0
    assert account["plastic_J_per_m"] > 0.5 * account["external_work_J_per_m"], "the ground fails by yielding"
    assert (
        abs(account["external_work_J_per_m"] - spent)
        < EXPECTED["energy"]["closure"] * account["external_work_J_per_m"]
    )
    assert abs(account["closure"]) < EXPECTED["energy"]["closure"]


def test_limit_equilibrium_beside_it(result):
    """Circles cannot follow the seam, so they lie far above; a non-circular surface does not (Spencer 1.258)."""
    beside = {neighbour["method"]: neighbour["factor"] for neighbour in result["neighbours"]}
    assert beside["Bishop simplified"] > 1.15 * result["factors"][0]["value"]
    assert beside["Spencer, non-circular"] == pytest.approx(1.258, rel=0.02)


def test_the_report_needs_nothing_else(out, result):
    page = (out / "report.html").read_text()
    assert page.rstrip().endswith("</html>")
    outside = re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#)([^"']*)""", page)
    assert outside == [], "a report that can be sent by mail"
    assert "@import" not in page
    assert "url(http" not in page
    assert page.count("data:image/png;base64,") + page.count("data:image/svg+xml;base64,") >= 10
    text = re.sub(r"<[^>]*>", " ", re.sub(r"<(style|script).*?</\1>", " ", page, flags=re.DOTALL))
    for words in (
        "Factor of safety",
        "NOT a factor of safety",
        "Bishop simplified",
        "displacement of what moves",
    ):
        assert words.lower() in text.lower(), words
    assert f"{result['factors'][0]['stable']:.3f}" in text
    assert str(ROOT) not in text, "no folder of the machine it was made on"


def test_every_picture_is_one(out):
    names = {path.stem for path in (out / "figures").glob("*.png")}
    assert {
        "particles",
        "strength-failure",
        "gravity-failure",
        "strength-bracket",
        "gravity-history",
    } <= names
    for path in (out / "figures").glob("*.png"):
        with Image.open(path) as picture:
            picture.load()
            assert min(picture.size) > 200
            assert len(picture.convert("RGB").getcolors(1 << 24)) > 20, "not an empty frame"


def test_frames_can_be_read(out, result):
    found = sorted(path.name for path in out.glob("*.vtkhdf"))
    assert found == [f"{kind}-{end}.vtkhdf" for kind in ("gravity-increase", "strength-reduction")
                     for end in ("failed", "stable")]  # fmt: skip
    for name in found:
        with h5py.File(out / name) as file:
            root = file["VTKHDF"]
            assert root["Points"].shape == (result["particles"], 3)
            fields = root["PointData"]
            displacement = next(fields[key] for key in fields if key.startswith("displacement"))[()]
            assert np.isfinite(displacement).all()
            far = np.abs(displacement).max()
            assert far > (0.05 if "failed" in name else 0.0)


def test_frames_in_paraviews_own_reader(out, result):
    pyvista = pytest.importorskip("pyvista")
    grid = pyvista.read(out / "strength-reduction-failed.vtkhdf")
    assert grid.n_points == result["particles"]
    assert grid.n_cells > result["particles"]


def test_history_has_every_trial(out, result):
    history = read_history(out / "history.csv")
    assert all(name.endswith("]") for name in history), "every column names its unit"
    for entry in result["factors"]:
        for trial in entry["trials"]:
            rows = (history["method [-]"] == entry["kind"]) & (history["factor [-]"] == trial["factor"])
            rows &= history["model [-]"] == trial["model"]
            assert history["step [-]"][rows].max() == trial["steps"]
            assert history["displacement of what moves [m]"][rows][-1] == trial["displacement"]


def test_the_case_in_the_folder_runs_again_to_the_same_bits(out, result, tmp_path):
    """A copy of case and picture is all that a colleague needs."""
    case = load_case(out)
    assert case.particles == pytest.approx(result["particles"], rel=0.02)
    for name in ("case.toml", "section.png"):
        (tmp_path / name).write_bytes((out / name).read_bytes())
    done = geodem("run", tmp_path, "--out", tmp_path / "again", "--threads", 1)
    assert done.returncode == 0, done.stderr
    assert result_of(tmp_path / "again")["digest"] == result["digest"]


def test_the_picture_is_the_one_that_is_drawn(tmp_path):
    """draw.py makes section.png anew, pixel by pixel."""
    import runpy

    drawn = runpy.run_path(str(WORKFLOW / "draw.py"), run_name="imported")
    drawn["draw"](tmp_path / "section.png")
    with Image.open(tmp_path / "section.png") as new, Image.open(WORKFLOW / "section.png") as old:
        assert new.size == old.size
        assert new.convert("RGB").tobytes() == old.convert("RGB").tobytes()
