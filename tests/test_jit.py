"""Kernels compiled for one scene: right text, right cache, right physics."""

from __future__ import annotations

import contextlib
import gc
import importlib.util
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numba
import pytest
from numba.core import event

from geodem import _jit

LAW = """
import math

def pull(x):
    return {slope} * x

def drive(x):
    total = 0.0
    for _ in range(10):
        total += pull(x)
    if WAVES:
        total += math.sin(x)
    return total
"""

SCRIPT = """
import importlib.util, sys
from geodem import _jit
spec = importlib.util.spec_from_file_location("law", sys.argv[1])
law = importlib.util.module_from_spec(spec)
spec.loader.exec_module(law)
kernel = _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False)
stats = kernel.drive.stats
print(kernel.drive(1.0), sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache of its own."""
    monkeypatch.setenv("GEODEM_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def write(path: Path, slope: float):
    path.write_text(LAW.format(slope=slope))


def load(path: Path):
    spec = importlib.util.spec_from_file_location("law", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_an_edited_law_is_new_physics(cache, tmp_path):
    path = tmp_path / "law.py"
    write(path, 2.0)
    law = load(path)
    old = _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False)
    assert old.drive(1.0) == 20.0

    write(path, 3.25)
    law = load(path)
    new = _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False)
    assert new.drive(1.0) == 32.5
    assert new.__file__ != old.__file__
    assert Path(new.__file__).parent == cache
    assert old.drive(1.0) == 20.0


def test_an_edited_callee_is_new_physics_in_another_process(cache, tmp_path):
    """numba looks only at the file of the caller: the callee's old code would stay in its cache."""
    path = tmp_path / "law.py"
    write(path, 2.0)
    assert run(path).split()[0] == "20.0"
    write(path, 5.0)
    assert run(path).split()[0] == "50.0"


def test_a_second_process_compiles_nothing(cache, tmp_path):
    path = tmp_path / "law.py"
    write(path, 2.0)
    assert run(path).split() == ["20.0", "0", "1"]
    assert run(path).split() == ["20.0", "1", "0"]


def test_only_what_python_calls_is_kept_in_the_cache(cache, tmp_path):
    path = tmp_path / "law.py"
    write(path, 3.0)
    law = load(path)
    functions, constants = [law.pull, law.drive], {"WAVES": False}
    kernel = _jit.compile_kernel(functions, constants, parallel=False, entries=[law.drive])
    assert kernel.drive(1.0) == 30.0
    assert [file.name.split("-")[0] for file in cache.rglob("*.nbc")] == [f"{kernel.__name__}.drive"]
    whole = _jit.compile_kernel(functions, constants, parallel=False)
    assert whole.pull(1.0) == 3.0


def test_what_is_compiled_is_told_of_once_and_what_is_in_the_cache_not_at_all(cache, tmp_path):
    path = tmp_path / "law.py"
    write(path, 7.0)
    law = load(path)
    told = []
    with _jit.told_of_compiling(told.append):
        kernel = _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False)
        assert kernel.drive(1.0) == 70.0
        kernel.pull(1.0)
    lines = Path(kernel.__file__).read_text().count("\n")
    assert told == [_jit.COMPILE_SECONDS + _jit.COMPILE_SECONDS_PER_LINE * lines]
    write(path, 9.0)
    assert run(path).split() == ["90.0", "0", "1"]  # by another process, into the cache
    law = load(path)
    with _jit.told_of_compiling(told.append):
        assert _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False).drive(1.0) == 90.0
    assert len(told) == 1


def test_the_collector_works_again_after_a_compilation(cache, tmp_path):
    path = tmp_path / "law.py"
    write(path, 8.0)
    law = load(path)
    kernel = _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False)
    assert gc.isenabled()
    with watched_collector() as runs:
        kernel.drive(1.0)
    assert gc.isenabled()
    assert runs == []
    with pytest.raises(numba.TypingError):
        kernel.drive("no number")
    assert gc.isenabled()
    gc.disable()
    try:
        kernel.drive(2)
        assert not gc.isenabled()
    finally:
        gc.enable()


@contextlib.contextmanager
def watched_collector():
    """What the collector does while a kernel is being compiled: called from numba's own passes."""
    runs: list[str] = []
    compiling: list[int] = []

    class Passes(event.Listener):
        def on_start(self, event):
            compiling.append(1)

        def on_end(self, event):
            compiling.pop()

    def note(phase, info):
        if compiling and phase == "start":
            runs.append(phase)

    gc.callbacks.append(note)
    try:
        with event.install_listener("numba:run_pass", Passes()):
            yield runs
    finally:
        gc.callbacks.remove(note)


def run(path: Path) -> str:
    root = Path(_jit.__file__).parents[1]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    command = [sys.executable, "-c", SCRIPT, str(path)]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


def test_the_same_kernel_is_made_once(cache, tmp_path):
    path = tmp_path / "law.py"
    write(path, 2.0)
    law = load(path)
    make = [law.pull, law.drive], {"WAVES": False}
    assert _jit.compile_kernel(*make, parallel=False) is _jit.compile_kernel(*make, parallel=False)


def test_what_a_scene_lacks_is_not_in_its_code(cache, tmp_path):
    path = tmp_path / "law.py"
    write(path, 7.0)
    law = load(path)
    with_, without = (
        _jit.compile_kernel([law.pull, law.drive], {"WAVES": waves}, parallel=False)
        for waves in (True, False)
    )
    assert with_.drive(0.5) == pytest.approx(35.0 + 0.479425538604203, rel=1e-14)  # sin 0.5
    assert without.drive(0.5) == 35.0

    def code(kernel):
        return next(iter(kernel.drive.inspect_asm().values()))

    assert re.search(r"\bsin\b", code(with_))
    assert not re.search(r"\bsin\b", code(without))


def test_a_cache_that_cannot_be_written_is_left_alone(tmp_path, monkeypatch):
    """A folder below a file can be made by nobody, not even by root."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("GEODEM_CACHE", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "elsewhere"))
    (tmp_path / "elsewhere").mkdir()
    folder = _jit.cache_folder()
    assert folder.is_relative_to(tmp_path / "elsewhere")
    path = tmp_path / "law.py"
    write(path, 4.0)
    law = load(path)
    kernel = _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False)
    assert kernel.drive(1.0) == 40.0
    assert Path(kernel.__file__).parent == folder


def test_a_damaged_kernel_file_is_written_again(cache, tmp_path):
    path = tmp_path / "law.py"
    write(path, 6.0)
    law = load(path)
    kernel = _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False)
    Path(kernel.__file__).write_text("broken")
    del sys.modules[kernel.__name__]
    again = _jit.compile_kernel([law.pull, law.drive], {"WAVES": False}, parallel=False)
    assert again.drive(1.0) == 60.0


def test_the_user_cache_is_used_where_none_is_named(tmp_path, monkeypatch):
    monkeypatch.delenv("GEODEM_CACHE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert _jit.cache_folder() == tmp_path / "geodem" / "kernels"


def test_threads_are_those_of_openmp_even_where_their_number_is_chosen_first(tmp_path):
    """numba starts its threads when it is told their number, with its own choice of a layer if none was made."""
    if not _jit._has_openmp():
        pytest.skip("this numba has no OpenMP")
    text = "import numba; from geodem._jit import set_threads; set_threads(1); print(numba.threading_layer())"
    done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["omp"]


def test_alone_is_one_thread_and_gives_the_others_back():
    before = numba.get_num_threads()
    with _jit.alone():
        assert numba.get_num_threads() == 1
    assert numba.get_num_threads() == before
