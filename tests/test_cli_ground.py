"""Cases of ground, and slopes from files, by the commands as a newcomer meets them."""

from __future__ import annotations

import re
import signal
import subprocess
import sys

import pytest
from PIL import Image

from tests.ground_files import GROUND, ground_case, slope_case, write_msh
from tests.small_cases import environment, result_of


def test_new_check_run_plot_the_template(tmp_path, call):
    folder, out = tmp_path / "mine", tmp_path / "out"
    made = call("new", "ground", folder)
    assert made.status == 0, made.err
    assert f"geodem check {folder}" in made.out
    looked = call("check", folder, "--out", tmp_path / "look.png")
    assert looked.status == 0, looked.err
    assert re.search(
        r"^8,0\d\d discs of 4 materials, x from 0 to 30 m, y from 0 to 16 m", looked.out, re.MULTILINE
    )
    assert re.search(r"mass difference \[%\] +0\.000 +0\.000 +0\.000 +0\.000", looked.out)
    assert "Time step: not known" in looked.out
    with Image.open(tmp_path / "look.png") as picture:
        assert min(picture.size) > 200
    assert not out.exists()
    done = call("run", folder, "--out", out, "--quick")
    assert done.status == 0, done.err
    assert re.search(
        r"gravel: \d{3}, differ from the source by [+-]?0\.\d+ % in size and 0\.000 % in mass", done.out
    )
    assert f"{out}/report.html" in done.out
    assert result_of(out)["workflow"] == "ground"
    (out / "report.html").unlink()
    drawn = call("plot", out)
    assert drawn.status == 0, drawn.err
    assert (out / "report.html").is_file()
    again = call("resume", out)
    assert again.status == 0, again.err


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"ground"', '"grond"', r"workflow = 'grond'.*Did you mean .ground"),
        ('"0.1 m/px"', "0.1", r"source\.scale = 0\.1: a bare number"),
        ("bank.png", "nothing.png", r"source\.image = 'nothing\.png': there is no such file"),
        ("[material.seam]", "[material.seem]", r"material\.seam: missing"),
        ("particles = 1200", 'radius = "20 m"', r"particles\.radius = '20 m': the ground is 12 m by 6 m"),
        ("particles = 1200", "particles = 1000000000", r"particles\.particles = 1000000000: so many"),
    ],
)
def test_a_mistake_ends_with_a_message_and_writes_nothing(tmp_path, call, old, new, said):
    case = ground_case(tmp_path / "case", GROUND.replace(old, new))
    for command in (
        ("run", case, "--out", tmp_path / "out"),
        ("check", case, "--out", tmp_path / "look.png"),
    ):
        answer = call(*command)
        assert answer.status == 2
        assert re.search(said, answer.err.replace("\n", " ")), answer.err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case"]


def test_the_other_commands_name_the_right_one(tmp_path, call):
    answer = call("lab", ground_case(tmp_path / "case"), "--out", tmp_path / "out")
    assert answer.status == 2
    assert "geodem run" in answer.err


def test_interrupted(tmp_path):
    """As a program: whenever it is stopped, it wrote nothing or everything."""
    case = ground_case(tmp_path / "case", GROUND.replace("1200", "400000"))
    command = [sys.executable, "-m", "geodem", "run", str(case), "--out", str(tmp_path / "out")]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment()
    ) as program:
        assert program.stdout is not None
        assert "reading the image" in program.stdout.readline()
        program.send_signal(signal.SIGINT)
        _, errors = program.communicate(timeout=120)
    assert program.returncode == 3, errors
    assert "Nothing was kept" in errors
    assert not (tmp_path / "out").exists()


def test_a_slope_from_a_mesh(tmp_path, call):
    """Strength reduction on the nodes lies within 6 % of Bishop's factor, which comes from the polygons alone."""
    pytest.importorskip("meshio")
    write_msh(tmp_path / "case" / "section.msh")
    text = slope_case('mesh = "section.msh"\nparticles_on = "nodes"', "clay", "fill", head="")
    (tmp_path / "case" / "case.toml").write_text(text)
    looked = call("check", tmp_path / "case", "--out", tmp_path / "look.png")
    assert looked.status == 0, looked.err
    assert "(the nodes of the mesh)" in looked.out
    done = call("run", tmp_path / "case", "--out", tmp_path / "out")
    assert done.status == 0, done.err
    found = result_of(tmp_path / "out")
    bishop = next(n["factor"] for n in found["neighbours"] if n["method"] == "Bishop simplified")
    assert found["factors"][0]["value"] == pytest.approx(bishop, rel=0.06)
    assert (tmp_path / "out" / "section.msh").read_bytes() == (tmp_path / "case" / "section.msh").read_bytes()
