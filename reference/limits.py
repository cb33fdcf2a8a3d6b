"""What this machine allows: the engine's inner loop in plain C on the same arrays, and the speed of its memory.

The C text is `limits_loop.c`, compiled when first needed with gcc and its fastest options for this machine.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import shutil
import subprocess
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem._jit import cache_folder
from geodem.errors import InputError
from geodem.particle_simulation import ParticleSimulation

from .scene_packings import touching_pairs
from .scenes import Scene

SOURCE = Path(__file__).parent / "limits_loop.c"
OPTIONS = ("-O3", "-march=native", "-ffast-math", "-fopenmp", "-fPIC")
WIDTH = {2: 8, 3: 12}
"""Doubles in the row of a particle."""
_LOADS = {2: 3, 3: 6}
_HUGE = 1e300  # for an infinite strength: -ffast-math does not know infinity

Floats = NDArray[np.float64]


def available() -> str | None:
    """None where the C compiler is found, else how to install it."""
    return None if shutil.which("gcc") else "gcc is missing: apt-get install gcc"


class Parameters(ctypes.Structure):
    """Numbers of a loop; as the structure of the same name in C."""

    _fields_ = [
        (name, ctypes.c_double)
        for name in ("kn", "ks", "friction", "damping", "dt", "gx", "gy", "gz", "tension", "cohesion")
    ]


@dataclass
class Loop:
    """Arrays of a scene as the engine lays them out; a C loop steps them in place.

    Attributes
    ----------
    dimension : int
    rows : (2, n, 12) or (2, n, 8) float
        Double-buffered. 3D: x y z radius, vx vy vz mass, wx wy wz material; 2D: x y radius material, vx vy spin mass.
    chunk : int
        Particles a chunk.
    start : (chunks + 1,) int64
        Pairs of every chunk.
    a, b : (p,) uint32
        Rows of the particles of a pair; a pair across chunks stands in both.
    bond : (p,) int32
        0: none; read in 2D only.
    touching : (p,) uint8
    history : (p, h) float
        3D: h >= 3, shear force x y z; 2D: h >= 2, shear force and overlap at bonding.
    parameters : Parameters
    current : int
        The newest of the two sets of rows.
    """

    dimension: int
    rows: Floats
    chunk: int
    start: NDArray[np.int64]
    a: NDArray[np.uint32]
    b: NDArray[np.uint32]
    bond: NDArray[np.int32]
    touching: NDArray[np.uint8]
    history: Floats
    parameters: Parameters
    current: int = 0

    @property
    def particles(self) -> int:
        """Number of particles."""
        return self.rows.shape[1]

    def pairs(self) -> int:
        """Pairs, each counted once."""
        return int(self.once().sum())

    def once(self) -> NDArray[np.bool_]:
        """Which entries (p,) count a pair: a pair across chunks stands in both, and counts where its lower row is."""
        owner = np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))
        return np.asarray(np.minimum(self.a, self.b) // self.chunk == owner)

    def step(self, steps: int, threads: int) -> float:
        """Do `steps` steps; return the seconds of one.

        Raises InputError where an array is not what the loop reads.
        """
        self._check()
        loads = np.empty(_LOADS[self.dimension] * self.chunk * threads)
        bonds = (_at(self.bond),) if self.dimension == 2 else ()
        function = library().discs if self.dimension == 2 else library().spheres
        begin = time.perf_counter()
        self.current = function(
            *(ctypes.c_int64(k) for k in (self.particles, self.chunk, steps)),
            ctypes.c_int(self.current),
            *(_at(array) for array in (self.rows, self.start, self.a, self.b)),
            *bonds,
            *(_at(array) for array in (self.touching, self.history)),
            ctypes.c_int64(self.history.shape[1]),
            _at(loads),
            ctypes.byref(self.parameters),
            ctypes.c_int(threads),
        )
        return (time.perf_counter() - begin) / steps

    def _check(self) -> None:
        """The loop reads raw memory: refuse arrays it would misread."""
        chunks = -(-self.particles // self.chunk)
        wanted: dict[str, tuple[Any, tuple[int, ...]]] = {
            "rows": (np.float64, (2, self.particles, WIDTH[self.dimension])),
            "start": (np.int64, (chunks + 1,)),
            "a": (np.uint32, (len(self.a),)),
            "b": (np.uint32, (len(self.a),)),
            "bond": (np.int32, (len(self.a),)),
            "touching": (np.uint8, (len(self.a),)),
            "history": (np.float64, (len(self.a), self.history.shape[1])),
        }
        for name, (kind, shape) in wanted.items():
            array = getattr(self, name)
            if array.dtype != kind or array.shape != shape or not array.flags.c_contiguous:
                raise InputError(
                    name, f"is not a contiguous {np.dtype(kind)} array of shape {shape}",
                    "give the engine's own array", value=(array.dtype, array.shape),
                )  # fmt: skip
        if self.history.shape[1] < (2 if self.dimension == 2 else 3):
            raise InputError(
                "history", "has too few columns", "give 3 in 3D, 2 in 2D", value=self.history.shape
            )
        if self.start[-1] != len(self.a) or (
            len(self.a) and max(self.a.max(), self.b.max()) >= self.particles
        ):
            raise InputError("start", "does not describe the pairs", "give the starts of these pairs")


def _at(array: NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


@lru_cache(maxsize=1)
def library() -> ctypes.CDLL:
    """The compiled C text; compiled again where the text or the machine is another."""
    missing = available()
    if missing:
        raise InputError("gcc", "the loop in C cannot be compiled", missing)
    text = SOURCE.read_bytes()
    native = subprocess.run(
        ["gcc", "-march=native", "-Q", "--help=target"], capture_output=True, check=True
    ).stdout
    digest = hashlib.sha256(text + native + " ".join(OPTIONS).encode()).hexdigest()[:16]
    path = cache_folder() / f"limits_{digest}.so"
    if not path.exists():
        part = path.with_suffix(f".{os.getpid()}.part")
        # linked without -ffast-math: with it gcc adds start-up code that has the whole process flush denormal numbers
        # to zero, Python and numpy included; scipy's k-d tree crashes then
        unlinked = path.with_suffix(f".{os.getpid()}.o")
        subprocess.run(["gcc", *OPTIONS, "-c", "-o", str(unlinked), str(SOURCE)], check=True)
        subprocess.run(["gcc", "-shared", "-fopenmp", "-o", str(part), str(unlinked), "-lm"], check=True)
        unlinked.unlink()
        os.replace(part, path)
    loaded = ctypes.CDLL(str(path))
    loaded.triad.restype = ctypes.c_double
    return loaded


def loop_of(scene: Scene, *, damping: float = 0.0, chunk: int | None = None, margin: float = 0.0) -> Loop:
    """A scene in the engine's layout; bonds in 2D only, no walls.

    Parameters
    ----------
    damping : float
        Local damping.
    chunk : int, optional
        Particles a chunk; 32 chunks, of at least 256, where it is left out.
    margin : float
        Pairs are listed to this distance of their surfaces, over the largest radius.
    """
    n = scene.particles
    chunk = chunk or max(256, -(-n // 32))
    pairs = touching_pairs(scene.positions, scene.radii, margin * float(scene.radii.max()))
    start, a, b, own = chunked(pairs, n, chunk)
    rows = np.zeros((2, n, WIDTH[scene.dimension]))
    bond = np.zeros(len(a), dtype=np.int32)
    if scene.dimension == 3:
        rows[:, :, 0:3], rows[:, :, 3] = scene.positions, scene.radii
        rows[:, :, 4:7], rows[:, :, 7], rows[:, :, 8:11] = scene.velocities, scene.mass, scene.spins
        history = np.zeros((len(a), 3))
    else:
        rows[:, :, 0:2], rows[:, :, 2] = scene.positions[:, :2], scene.radii
        rows[:, :, 4:6], rows[:, :, 6], rows[:, :, 7] = scene.velocities[:, :2], scene.spins[:, 2], scene.mass
        history = np.zeros((len(a), 2))
        if scene.bonds is not None:
            numbers = {(int(i), int(j)): k + 1 for k, (i, j) in enumerate(scene.bonds.pairs)}
            bond[:] = np.array([numbers.get((int(i), int(j)), 0) for i, j in pairs], dtype=np.int32)[own]
            apart = scene.positions[pairs[:, 1]] - scene.positions[pairs[:, 0]]
            overlap = scene.radii[pairs].sum(1) - np.sqrt((apart**2).sum(1))
            history[:, 1] = np.where(bond > 0, overlap[own], 0.0)
    untouched = np.zeros(len(a), dtype=np.uint8)
    return Loop(
        scene.dimension, rows, chunk, start, a, b, bond, untouched, history, _parameters(scene, damping)
    )


def loop_of_engine(
    scene: Scene, simulation: ParticleSimulation, *, damping: float = 0.0, chunk: int | None = None
) -> Loop:
    """The rows and pairs of geodem's own simulation of a scene, copied; with histories as C keeps them.

    C's chunks, geodem's if left out, do without a halo: both chunks of a pair across compute it.
    """
    listed, now = simulation.pairs, simulation.now
    dimension = scene.dimension
    chunk = chunk or simulation.chunk
    pairs = np.sort(np.stack([listed.a, listed.b], axis=1).astype(np.int64), axis=1)
    start, a, b, own = chunked(pairs, len(now), chunk)
    history = np.zeros((len(a), 3 if dimension == 3 else 2))
    bond = np.ascontiguousarray(listed.bond[own])
    if dimension == 2 and simulation.layout.offset is not None:
        # the overlap at bonding
        history[:, 1] = np.where(bond > 0, -listed.history[own, simulation.layout.offset], 0.0)
    untouched = np.zeros(len(a), dtype=np.uint8)
    return Loop(
        dimension,
        np.stack([now, now]),
        chunk,
        start,
        a,
        b,
        bond,
        untouched,
        history,
        _parameters(scene, damping),
    )


def _parameters(scene: Scene, damping: float) -> Parameters:
    bonds = scene.bonds
    return Parameters(
        scene.normal,
        scene.shear,
        scene.friction,
        damping,
        scene.time_step,
        *scene.gravity,
        min(bonds.tension, _HUGE) if bonds else 0.0,
        min(bonds.cohesion, _HUGE) if bonds else 0.0,
    )


def chunked(
    pairs: NDArray[np.int64], particles: int, chunk: int
) -> tuple[NDArray[np.int64], NDArray[np.uint32], NDArray[np.uint32], NDArray[np.int64]]:
    """Pairs by the chunk that computes them: starts, both sides, and the pair each entry came from."""
    number = np.arange(len(pairs))
    first, second = pairs[:, 0] // chunk, pairs[:, 1] // chunk
    across = np.flatnonzero(first != second)
    owner = np.concatenate([first, second[across]])
    row = np.concatenate([pairs[:, 0], pairs[across, 1]])
    own = np.concatenate([number, across])
    order = np.lexsort((own, row, owner))
    own = own[order]
    start = np.searchsorted(owner[order], np.arange(-(-particles // chunk) + 1)).astype(np.int64)
    return start, pairs[own, 0].astype(np.uint32), pairs[own, 1].astype(np.uint32), own


def triad(threads: int, *, megabytes: int = 128, repeats: int = 9) -> list[float]:
    """Bandwidth of a = b + s c [B/s], 24 bytes counted an element; one figure a repeat, after one warm-up.

    Every one of the three arrays has `megabytes`; they must be far larger than the last cache.
    """
    count = megabytes * 2**20 // 8
    arrays = [np.empty(count) for _ in range(3)]
    places = [_at(array) for array in arrays]
    size, used = ctypes.c_int64(count), ctypes.c_int(threads)
    library().triad_fill(size, *places, used)
    seconds = [library().triad(size, *places, ctypes.c_double(3.0), used) for _ in range(repeats + 1)][1:]
    if arrays[0][-1] != 7.0:
        raise RuntimeError(f"the triad gave {arrays[0][-1]}, not 7")
    return [24.0 * count / second for second in seconds]


def triad_median(threads: int) -> float:
    """Median of several bandwidths [B/s]."""
    return median(triad(threads))
