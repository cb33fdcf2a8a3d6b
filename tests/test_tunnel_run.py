"""A tunnel run: its folder, stop and resume to the same bits, what is refused, what is told."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from geodem.case.tunnel_reading import parse_tunnel
from geodem.errors import InputError, StoppedError
from geodem.tunnel_files import COLUMNS, write_history
from geodem.tunnel_run import redraw_tunnel, resume_tunnel, run_tunnel
from tests.case.test_tunnel_case import HERE, changed
from tests.small_cases import forecast_error, history_begun, works_of

STABILITY = 'stability = {methods = ["strength-reduction"], tolerance = 0.05}\n'


@pytest.fixture(scope="module")
def case():
    return parse_tunnel(changed("\n[material.clay]", f"{STABILITY}\n[material.clay]"), HERE)


@pytest.fixture(scope="module")
def told():
    """What the whole run tells."""
    return []


@pytest.fixture(scope="module")
def finished(case, told, tmp_path_factory) -> tuple[Path, dict]:
    folder = tmp_path_factory.mktemp("tunnel") / "out"
    return folder, run_tunnel(case, folder, threads=1, watch=told.append)


def test_no_more_work_comes_than_is_told_at_most(finished, told):
    works = works_of(told)
    whole = works[-1].done
    # four increments twice, and all looks of the trials
    assert len(works) > 8 + 100
    assert all(work.done + work.most >= whole for work in works)
    # how many trials a search takes is not known before; near its end it is
    assert forecast_error(works, after=0.8) < 0.1


def test_the_folder_holds_what_every_run_leaves(finished):
    folder, result = finished
    for name in ("result.json", "report.html", "history.csv", "case.toml", "stage-3.vtkhdf"):
        assert (folder / name).is_file(), name
    assert json.loads((folder / "result.json").read_text()) == json.loads(json.dumps(result))
    header, *lines = (folder / "history.csv").read_text().splitlines()
    assert "mean convergence [m]" in header
    # at rest as it was, two increments to 50 % and two to the end
    assert len(lines) == 5
    page = (folder / "report.html").read_text()
    for words in ("Ground reaction", "Factor of safety", "Lining shell", "excavate </span>"):
        assert words in page
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)


def test_what_is_found_is_told_by_kind(finished):
    _, result = finished
    (factor,) = result["factors"]
    assert factor["kind"] == "strength-reduction"
    assert factor["meaning"].startswith("factor of safety")
    assert factor["stable"] < factor["value"]
    assert result["excavations"]["tunnel"]["relaxed"] == 1.0
    # the shell bears what the ground gave up after it was built; without it the wall moves farther
    assert result["linings"][0]["largest_thrust_N_per_m"] > 0.0
    unlined = result["ground_reaction"][-1]["mean_convergence_m"]
    assert unlined > result["excavations"]["tunnel"]["mean_convergence_m"] > 0.0
    assert result["kind_of_result"].startswith("static")


def test_a_finished_case_is_not_run_again(case, finished):
    folder, result = finished
    assert run_tunnel(case, folder)["digest"] == result["digest"]


def test_stopped_anywhere_and_resumed_gives_the_same_bits(case, finished, tmp_path):
    for after in (2, 5, 30):
        folder = tmp_path / f"stopped-{after}"
        asked = iter(range(1000))
        with pytest.raises(StoppedError):
            run_tunnel(
                case, folder, threads=1, stop_asked=lambda asked=asked, after=after: next(asked) >= after
            )
        assert json.loads((folder / "result.json").read_text())["status"] == "stopped"
        assert history_begun(folder, finished[0])
        again = resume_tunnel(folder, parse_tunnel((folder / "case.toml").read_text(), folder), threads=1)
        assert again["digest"] == finished[1]["digest"], after
        assert again["status"] == "done"


def test_another_case_is_not_written_over(case, finished):
    folder, _ = finished
    other = parse_tunnel(changed("increments = 4", "increments = 5"), HERE)
    with pytest.raises(InputError, match="another case"):
        run_tunnel(other, folder)


def test_the_history_is_written_whole(tmp_path):
    """A row that cannot be written leaves what stood there: no half of the new one."""
    (tmp_path / "history.csv").write_text("old")
    with pytest.raises(KeyError):
        write_history(
            tmp_path / "history.csv", [dict.fromkeys(("stage", "opening", *COLUMNS.values()), 0.0), {}]
        )
    assert (tmp_path / "history.csv").read_text() == "old"


def test_it_is_drawn_again_from_what_was_kept(case, finished):
    folder, _ = finished
    (folder / "report.html").unlink()
    (folder / "figures" / "reaction.png").unlink()
    redraw_tunnel(folder, case)
    assert (folder / "report.html").is_file()
    assert (folder / "figures" / "reaction.png").is_file()


def test_stress_beyond_the_strength_is_told_before_anything_is_written(tmp_path):
    text = changed("initial_stress.k0 = 0.7", "initial_stress.k0 = 0.15")
    weak = parse_tunnel(changed('cohesion = "60 kPa"', 'cohesion = "1 kPa"', text), HERE)
    with pytest.raises(InputError, match="beyond the strength"):
        run_tunnel(weak, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_tunnel_that_does_not_stand_says_so(tmp_path):
    """Without friction and with little cohesion it collapses on the way, and has a factor below one."""
    text = changed('cohesion = "60 kPa"', 'cohesion = "40 kPa"')
    text = changed('friction_angle = "20 deg"\ndilation_angle = "20 deg"', 'friction_angle = "0 deg"', text)
    text = changed("initial_stress.k0 = 0.7", "initial_stress.k0 = 1.0", text)
    text = changed('lining = [{name = "shell", thickness = "20 cm", young_modulus = "15 GPa"}]\n', "", text)
    text = changed(', {install = "shell"}, {relax = 1.0}', ", {relax = 1.0}", text)
    text = changed("\n[material.clay]", f"{STABILITY}\n[material.clay]", text)
    result = run_tunnel(parse_tunnel(text, HERE), tmp_path / "out", threads=1)
    assert result["collapse"] is not None
    assert result["collapse"]["relaxed_stable"] < result["collapse"]["relaxed_failed"] < 1.0
    assert result["factors"][0]["value"] < 1.0
    assert any("does not stand" in warning for warning in result["warnings"])
