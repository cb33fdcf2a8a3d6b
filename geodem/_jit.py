"""Kernels compiled for one scene: a law and a loop are written into one module with the scene's features as constants.

numba finds a compiled function in its disk cache only when that function lies in a file, and it looks at that
one file alone to decide whether the cached machine code is still right. So geodem writes, for every
combination of law and features, a file that holds all the text the kernel is made of. Its name is the hash of
that text: an edited law is another file, and old physics can never be run from the cache. Constants are module
globals, which numba folds, so that what a scene lacks is not in its machine code.
"""

from __future__ import annotations

import contextlib
import gc
import hashlib
import importlib
import importlib.util
import inspect
import os
import pickle
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

# How long an OpenMP thread spins before it sleeps. libgomp's default is milliseconds, which on a machine with
# other work starves the very thread that is waited for; without any spinning each of the two parallel regions
# of a step pays a wake-up. Read by libgomp when it is loaded, so it is set before numba starts a region.
os.environ.setdefault("GOMP_SPINCOUNT", "20000")

# "nnan" and "ninf" are left out: they would let the compiler drop comparisons that meet infinite strengths. "reassoc"
# too: a parallel loop is optimised once by itself and once more in its caller, and the second time sums came out in
# another order; the process that compiled a kernel ran the first, those that found it in the cache the second. Without
# it the loops over stress particles take three quarters of the time.
_OPTIONS = "error_model='numpy', fastmath={'afn', 'arcp', 'contract', 'nsz'}"

# Everything: for kernels whose tables hold finite numbers only and whose results are tested for finiteness outside.
# Terms that a scene lacks are zeros here and there, and only "nnan" and "nsz" together let them vanish.
_FINITE_OPTIONS = "error_model='numpy', fastmath=True"

# Nothing calls a kernel through a C pointer. What only other kernels call needs no way in from Python either, and no
# place in the cache: its code is in that of its callers. Each way in is a function to be compiled, which is a quarter
# of the time.
_CALLED = "cache=True, no_cfunc_wrapper=True"
_INNER = "no_cpython_wrapper=True, no_cfunc_wrapper=True"

COMPILE_SECONDS, COMPILE_SECONDS_PER_LINE = 2.0, 0.007
"""Time of compiling a kernel, and what each line of its text adds, about [s]."""

_compile_seconds = 0.0


def cache_folder() -> Path:
    """Folder of the generated kernels: ``$GEODEM_CACHE``, else the user's cache folder, else a temporary one."""
    named = os.environ.get("GEODEM_CACHE")
    home = os.environ.get("XDG_CACHE_HOME")
    candidates = [Path(named)] if named else [Path(home) if home else Path.home() / ".cache"]
    candidates.append(
        Path(tempfile.gettempdir()) / f"geodem-cache-{os.getuid() if hasattr(os, 'getuid') else 0}"
    )
    for candidate in candidates:
        folder = candidate if named and candidate == candidates[0] else candidate / "geodem" / "kernels"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=folder):
                return folder
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="geodem-kernels-"))


_threads: int | None = None


def set_threads(threads: int | None) -> int:
    """Choose how many threads kernels may use, at most the cores; None: all. Returns the number."""
    global _threads
    import numba

    most = int(_numba_settings().NUMBA_NUM_THREADS)
    # numba starts its threads, and with them the layer, when it is told their number
    _choose_layer()
    _threads = most if threads is None else min(threads, most)
    numba.set_num_threads(_threads)
    return _threads


def threads_allowed() -> int:
    """How many threads kernels may use; a `ThreadPilot` may have chosen fewer for now."""
    return int(_numba_settings().NUMBA_NUM_THREADS) if _threads is None else _threads


@contextmanager
def alone() -> Iterator[None]:
    """Kernels use one thread within: for so little that several would only wait for each other."""
    import numba

    _choose_layer()
    before = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        yield
    finally:
        numba.set_num_threads(before)


class ThreadPilot:
    """Chooses, batch by batch, between all threads and one.

    On a machine with other work a thread that lost its core keeps all others waiting at the end of every loop, and
    several threads can be many times slower than one. The bits do not depend on the number of threads, so
    it may be chosen by the clock. The other choice is looked at now and then, for a short time only: soon where steps
    take longer than they did, ever later where it was no better. A look begins with batches that do not count:
    threads that have slept share a core at first, until the system moves them apart.
    """

    LOOK_AGAIN_SECONDS = 1.0
    LONGEST_SECONDS = 16.0
    """Between two looks."""
    SLOWER = 1.5
    """Steps that take so many times what they took call for a look."""
    LOOK_SECONDS = 0.02
    """Length of each batch of a look."""
    GATHERING = 4
    """Batches that do not count when threads have slept."""
    REMEMBERED = 3
    """Batches whose best counts."""
    FIRST_STEPS = 20
    """Length of the first batch, when it is not known what a step costs."""

    def __init__(self) -> None:
        self._all = threads_allowed()
        self._costs: dict[int, list[float]] = {}  # threads -> seconds per step of the last batches that count
        self._last: dict[int, float] = {}  # threads -> seconds per step of the last batch, counted or not
        self._tried: dict[int, float] = {}  # threads -> when
        self._coming: list[tuple[int, bool]] = []  # threads of the batches to come, and whether they count
        self._wait = self.LOOK_AGAIN_SECONDS  # from one look to the next

    def choose(self) -> tuple[int, int]:
        """Set and return the number of threads of the next batch, and the most steps that it should have."""
        import numba

        if not self._coming:
            self._coming = self._plan()
        threads, _ = self._coming[0]
        if self._all > 1:
            numba.set_num_threads(threads)
        if threads not in self._last:
            return threads, self.FIRST_STEPS
        best = min(self._costs, key=self._cost, default=0)
        seconds = self.LOOK_AGAIN_SECONDS if threads == best and len(self._coming) == 1 else self.LOOK_SECONDS
        return threads, max(2, int(seconds / self._last[threads]))

    def _cost(self, threads: int) -> float:
        # what else the machine does can only make a step longer
        return min(self._costs[threads])

    def _plan(self) -> list[tuple[int, bool]]:
        if self._all not in self._costs:
            # the first of all starts the threads and fills the caches
            return [(self._all, False), *self._look(self._all)]
        if 1 not in self._costs:
            return self._look(1)
        best, other = sorted((1, self._all), key=self._cost)
        if self._last[best] > self.SLOWER * self._cost(best):
            self._wait = self.LOOK_AGAIN_SECONDS
        if time.perf_counter() - self._tried[other] > self._wait:
            self._wait = min(2.0 * self._wait, self.LONGEST_SECONDS)
            return self._look(other)
        return [(best, True)]

    def _look(self, threads: int) -> list[tuple[int, bool]]:
        if threads == 1:
            return [(1, False), (1, True)]
        return [(threads, False)] * self.GATHERING + [(threads, True)] * self.REMEMBERED

    def learn(self, seconds_per_step: float) -> None:
        """Say what the last batch cost."""
        threads, counts = self._coming.pop(0)
        self._last[threads] = seconds_per_step
        if counts:
            self._costs[threads] = [*self._costs.get(threads, []), seconds_per_step][-self.REMEMBERED :]
            self._tried[threads] = time.perf_counter()


def compile_seconds() -> float:
    """Seconds that this process has spent compiling kernels or loading them from the cache."""
    return _compile_seconds


def add_compile_seconds(seconds: float) -> None:
    """Count time spent in a kernel's first call."""
    global _compile_seconds
    _compile_seconds += seconds


@cache
def function_source(function: Callable[..., Any]) -> str:
    """Text of a function, read once: finding its end takes Python a millisecond, and a kernel has some hundred."""
    return textwrap.dedent(inspect.getsource(function)).rstrip()


def kernel_text(
    functions: Sequence[Callable[..., Any]],
    constants: Mapping[str, object],
    parallel: bool,
    texts: Sequence[str] = (),
    finite: bool = False,
    entries: Sequence[Callable[..., Any]] | None = None,
) -> str:
    """Source of a kernel module: constants, texts to be inlined, then each function's text, in the order given."""
    options = _FINITE_OPTIONS if finite else _OPTIONS
    lines = ['"""Written by geodem._jit; edits are lost."""', "import math", "import numpy as np"]
    lines += ["from numba import njit, prange", ""]
    lines += [f"{name} = {value!r}" for name, value in constants.items()]
    for text in texts:
        inlined = [f"@njit(forceinline=True, {_INNER}, {options})"] if text.startswith("def ") else []
        lines += ["", "", *inlined, text]
    for function in functions:
        source = function_source(function)
        # only loops that ask for it are made parallel: numba warns about any other function
        threads = parallel and "prange(" in source
        called = _CALLED if entries is None or function in entries else _INNER
        lines += ["", "", f"@njit(parallel={threads}, {called}, {options})", source]
    return "\n".join(lines) + "\n"


def compile_kernel(
    functions: Sequence[Callable[..., Any]],
    constants: Mapping[str, object],
    *,
    parallel: bool,
    texts: Sequence[str] = (),
    finite: bool = False,
    entries: Sequence[Callable[..., Any]] | None = None,
) -> ModuleType:
    """Write and import the module that holds `functions` compiled with `constants`.

    Parameters
    ----------
    functions : sequence of functions
        Plain Python functions, callees before callers. They may use ``math``, ``np``, ``prange``, each other and
        the constants by name, and nothing else.
    constants : mapping
        Module globals: features of the scene, folded by the compiler.
    parallel : bool
        Compile with numba's parallel backend (``prange`` is a plain range otherwise).
    texts : sequence of str
        Sources of functions that are written before the others and inlined where they are called (or of plain
        statements).
    finite : bool
        The kernel meets finite numbers only, so the compiler need not care for infinities and what is no number.
    entries : sequence of functions, optional
        Those of `functions` that Python may call; all, where it is left out. The others compile faster.

    Returns
    -------
    module
        With the compiled functions as attributes.
    """
    import numba

    start = time.perf_counter()
    _choose_layer()
    _rest_collector_while_compiling()
    text = kernel_text(functions, constants, parallel, texts, finite, entries)
    digest = hashlib.sha256(f"{numba.__version__}{text}".encode()).hexdigest()[:24]
    name = f"geodem_kernel_{digest}"
    module = sys.modules.get(name)
    if module is None:
        path = cache_folder() / f"{name}.py"
        if not path.exists() or path.read_text() != text:
            _write_atomically(path, text)
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    add_compile_seconds(time.perf_counter() - start)
    return module


_ELSEWHERE = """
import gc, importlib.util, pickle, signal, sys
gc.disable()
signal.signal(signal.SIGINT, signal.SIG_IGN)
name, path, function = sys.argv[1:]
spec = importlib.util.spec_from_file_location(name, path)
sys.modules[name] = module = importlib.util.module_from_spec(spec)
spec.loader.exec_module(module)
getattr(module, function).compile(pickle.load(sys.stdin.buffer))
"""


def run_from_cache(module: ModuleType, name: str, arguments: Sequence[Any]) -> None:
    """Make ready a parallel function of a kernel as the cache holds it: what is not there is compiled elsewhere.

    Machine code that a process has just made is not that of the cache: numba optimises a parallel loop by itself, and
    once more within its caller. The process that compiles runs the former, all others the latter, where sums may come
    out in another order. So that the same input gives the same bits in every process, one that is there for nothing
    else compiles.

    Parameters
    ----------
    module : module
        Of `compile_kernel`.
    name : str
        Of its function.
    arguments : sequence
        What it is about to be called with.
    """
    function = getattr(module, name)
    if function.overloads:
        return
    signature = tuple(map(function.typeof_pyval, arguments))
    if sys.executable and not _is_cached(function, signature):
        _tell_of(function)
        command = [sys.executable, "-P", "-c", _ELSEWHERE, module.__name__, str(module.__file__), name]
        # where that is not possible it is compiled here, and the bits are those of the process that compiles
        with contextlib.suppress(OSError):
            subprocess.run(command, input=pickle.dumps(signature), capture_output=True, check=False)
    function.compile(signature)


def _is_cached(function: Any, signature: tuple[Any, ...]) -> bool:
    """Whether the cache holds the machine code; also where numba does not say."""
    try:
        store = function._cache
        return store._index_key(signature, function.targetctx.codegen()) in store._cache_file._load_index()
    except AttributeError:
        return True


_told: Callable[[float], None] | None = None
_told_of: set[str] = set()


@contextmanager
def told_of_compiling(tell: Callable[[float], None]) -> Iterator[None]:
    """While it lasts `tell` is given the seconds that a kernel about to be compiled takes, about.

    Kernels that are found in the cache are not told of, and each of the others once.
    """
    global _told
    before, _told = _told, tell
    try:
        yield
    finally:
        _told = before


def _tell_of(dispatcher: Any) -> None:
    """Tell whoever wants to know that the kernel is compiled that a function belongs to."""
    path = Path(dispatcher.py_func.__code__.co_filename)
    if _told is None or path.name in _told_of or not path.name.startswith("geodem_kernel_"):
        return
    _told_of.add(path.name)
    _told(COMPILE_SECONDS + COMPILE_SECONDS_PER_LINE * path.read_text().count("\n"))


@cache
def _rest_collector_while_compiling() -> None:
    """Let Python's collector of garbage rest while numba compiles, and tell who wants to know that it does.

    numba makes millions of small objects that live as long as the compilation, and looking through them again and
    again is a fifth of its time.
    """
    from numba.core import event

    class Rest(event.Listener):
        """Compilations are nested: a callee's within its caller's."""

        def __init__(self) -> None:
            self.depth = 0
            self.collects = False

        def on_start(self, event: Any) -> None:
            if self.depth == 0:
                self.collects = gc.isenabled()
                gc.disable()
                _tell_of(event.data["dispatcher"])
            self.depth += 1

        def on_end(self, event: object) -> None:
            self.depth -= 1
            if self.depth == 0 and self.collects:
                gc.enable()

    event.register("numba:compile", Rest())


def _numba_settings() -> Any:
    """numba's settings: a module whose names are made at run time."""
    import numba

    return numba.config


def _choose_layer() -> None:
    """OpenMP, whose parallel regions start a hundred times faster than those of numba's own choice, TBB."""
    settings = _numba_settings()
    if settings.THREADING_LAYER == "default":
        settings.THREADING_LAYER = "omp" if _has_openmp() else "workqueue"


def _has_openmp() -> bool:
    try:
        importlib.import_module("numba.np.ufunc.omppool")
    except ImportError:
        return False
    return True


def _write_atomically(path: Path, text: str) -> None:
    handle, name = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    try:
        with os.fdopen(handle, "w") as stream:
            stream.write(text)
        os.replace(name, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise
