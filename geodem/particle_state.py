"""Everything in a particle simulation that its next step depends on, as a checkpoint tree and back.

Rows are kept as they lie, in both buffers: their order decides the order of sums, and so the bits.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from .assembly import Assembly
from .boundaries.cell import PeriodicCell
from .boundaries.wall_pairs import WallPairs
from .boundaries.wall_table import wall_table
from .errors import InputError
from .io.checkpoint import PARTICLES, Tree
from .kernels.cell import CELL_WIDTH
from .kernels.particle_kernel import Features
from .neighbors import PairList
from .particle_layout import Columns, RowArrays, Sleep, anchor_table

if TYPE_CHECKING:
    from .particle_simulation import ParticleSimulation

ARRAYS = {
    "rows": (np.float64, "2 n w"),
    "angle": (np.float64, "? ?"),
    "force": (np.float64, "n f"),
    "reference": (np.float64, "n d"),
    "record": (np.float64, "b ?"),
    "utilisation": (np.float64, "b 2"),
    "bond_scale": (np.float64, "b"),
    "sums": (np.float64, "c ?"),
    "wall_sums": (np.float64, "c ? f"),
    "asleep": (np.uint8, "c"),
    "quiet": (np.int64, "c"),
    "table": (np.float64, "? ?"),
    "bond_table": (np.float64, "? ?"),
    "joint_table": (np.float64, "? ?"),
    "wall_parameters": (np.float64, "? ?"),
}
"""Arrays of the simulation: kind, and shape in n particles, w columns of a row, f freedoms, b bonds (at least 1),
c chunks, d dimensions."""

NUMBERS = (
    "phase", "chunk", "parallel", "buffer", "local_damping", "global_damping", "steps", "searches", "moved", "carried",
    "started", "lag", "span", "initial_energy", "critical_time_step", "time_step", "sorted_share",
)  # fmt: skip


def state_tree(s: ParticleSimulation) -> Tree:
    """The state as a checkpoint tree.

    Raises InputError in the middle of a search for equilibrium, which cannot be resumed.
    """
    if s.order_kept:
        raise InputError(
            "checkpoint", "a search for equilibrium is under way, of which only the end can be kept",
            "Save after find_equilibrium has returned",
        )  # fmt: skip
    return {
        "arrays": {name: getattr(s, name) for name in ARRAYS},
        "by_row": dict(vars(s.arrays)),
        "pairs": _parts(s.pairs),
        "wall_pairs": _parts(s.wall_pairs),
        "bodies": s.walls.bodies,
        **({} if s.cell is None else {"cell": s.cell.state}),
        "plain": {
            "numbers": {name: _plain(getattr(s, name)) for name in NUMBERS},
            "features": {**asdict(s.features), "joint_laws": list(s.features.joint_laws)},
            "sleep": None if s.sleep is None else [float(s.sleep.speed), int(s.sleep.steps)],
            "stages": [[int(step), float(time), float(length)] for step, time, length in s.stages],
            "far": int(s.pairs.far),
        },
    }


def restore(s: ParticleSimulation, assembly: Assembly, tree: Mapping[str, Any], place: str) -> None:
    """Fill a new simulation with the state in a tree, read from `place`.

    Raises
    ------
    InputError
        Parts are missing or do not fit the assembly.
    """
    try:
        _fill(s, assembly, tree)
        _check(s)
        s.listed()
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise InputError(place, f"its parts do not belong together ({error})", PARTICLES.again) from error


def _fill(s: ParticleSimulation, assembly: Assembly, tree: Mapping[str, Any]) -> None:
    plain = tree["plain"]
    s.assembly = assembly
    s.dimension = assembly.dimension
    s.columns = Columns(assembly.dimension)
    features = plain["features"]
    s.features = Features(**{**features, "joint_laws": tuple(features["joint_laws"])})
    s.layout = s.features.layout()
    s.sleep = None if plain["sleep"] is None else Sleep(*plain["sleep"])
    s.stages = [(step, time, length) for step, time, length in plain["stages"]]
    for name in NUMBERS:
        setattr(s, name, plain["numbers"][name])
    for name in ARRAYS:
        setattr(s, name, tree["arrays"][name])
    s.arrays = RowArrays(**tree["by_row"])
    s.pairs = PairList(chunk=s.chunk, far=plain["far"], **tree["pairs"])
    s.wall_pairs = WallPairs(chunk=s.chunk, **tree["wall_pairs"])
    s.anchors = anchor_table(assembly)
    s.walls = wall_table(assembly.walls, assembly.dimension)
    s.walls.bodies = tree["bodies"]
    s.cell = None if assembly.cell is None else PeriodicCell(assembly.cell.periodic, tree["cell"])


def _check(s: ParticleSimulation) -> None:
    """Compiled loops look at no bounds: sizes and numbers of rows must be right before."""
    n, p, w = s.assembly.particles, s.pairs, s.wall_pairs
    chunks = -(-n // s.chunk)
    letters = {
        "n": n, "w": s.columns.width, "f": s.assembly.held.shape[1], "b": max(len(s.assembly.bonds), 1), "c": chunks,
        "d": s.dimension,
    }  # fmt: skip
    for name, (kind, shape) in ARRAYS.items():
        array = getattr(s, name)
        wanted = [
            letters[part] if part in letters else int(part) if part != "?" else None for part in shape.split()
        ]
        right = len(wanted) == array.ndim and all(
            size is None or size == found for size, found in zip(wanted, array.shape, strict=True)
        )
        if array.dtype != kind or not right:
            raise ValueError(f"{name} is {array.dtype} {array.shape}")
    if s.sums.shape[1] != (17 if s.cell is None else 26):
        raise ValueError("sums do not fit")
    if s.cell is not None and (
        s.cell.state.shape != (CELL_WIDTH,) or p.image.shape != (len(p.a), s.dimension)
    ):
        raise ValueError("the cell is cut off")
    if not np.array_equal(np.sort(s.arrays.ids), np.arange(n)):
        raise ValueError("the rows are not those of the particles")
    within = (
        (p.a, n), (p.b, n), (w.particle, n), (w.primitive, len(s.walls.kind)), (p.bond, len(s.assembly.bonds) + 1),
    )  # fmt: skip
    for array, end in within:
        if len(array) and not 0 <= int(array.min()) <= int(array.max()) < end:
            raise ValueError("a pair names what does not exist")
    for pairs, count in ((p, len(p.a)), (w, len(w.particle))):
        if len(pairs.start) != chunks + 1 or len(pairs.row) != n + 1 or pairs.row[-1] != count:
            raise ValueError("a list of pairs is cut off")
        if (np.diff(pairs.row) < 0).any() or len(pairs.history) != count or len(pairs.touching) != count:
            raise ValueError("a list of pairs is not in order")
    if (np.minimum(p.a, p.b) != p.listed_under()).any():
        raise ValueError("a pair is not listed under its lower row")


def _parts(pairs: PairList | WallPairs) -> Tree:
    return {
        field.name: getattr(pairs, field.name)
        for field in fields(pairs)
        if isinstance(getattr(pairs, field.name), np.ndarray)
    }


def _plain(value: Any) -> bool | int | float:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    return int(value) if isinstance(value, int | np.integer) else float(value)
