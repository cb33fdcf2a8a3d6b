"""A test as an order: data that says all of it, so that any process can carry it out, store it and find it again."""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..io.checkpoint import CheckpointFormat, checksum, read_checkpoint, write_checkpoint
from ..provenance import sources_digest
from . import pace as paces
from .axial import FALL, compress, pull
from .bending import bend
from .brazilian import split
from .direct_shear import shear
from .material import BondedMaterial
from .record import Cracks, Floats, TestRecord
from .rig import Watch
from .specimen import Specimen, make_specimen

TEST = CheckpointFormat(
    "geodem-test",
    1,
    "a test of the laboratory",
    "Give a file of the folder 'tests' that 'geodem lab' wrote",
    "Take it away: the test is then made again",
)


SURE = 0.05
"""Share of a test over which its pace is taken at least."""

BEFORE = 0.1
"""Making the specimen, its elastic state and the pilot take as long as this share of the steps to the peak."""


@dataclass(frozen=True)
class TestOrder:
    """One test on one specimen.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    specimen : dict
        Arguments of `make_specimen`, the seed among them.
    material : BondedMaterial
    stress : float
        Confinement of a triaxial test, normal stress of a direct shear test [Pa].
    pace, fall : float
        As of `geodem.laboratory.axial.compress`; tests of another sort have their own end.
    expected_strain : float or None
        As of `compress`.
    """

    __test__ = False  # not one of pytest's

    kind: str
    specimen: Mapping[str, Any]
    material: BondedMaterial
    stress: float = 0.0
    pace: float = paces.PACE
    fall: float = FALL
    expected_strain: float | None = field(default=None)

    @property
    def seed(self) -> int:
        """Of the specimen and of the scatter of its strengths."""
        return int(self.specimen.get("seed", 1))

    @property
    def name(self) -> str:
        """Of its files: kind, stress where there is one, and seed."""
        stress = f"-{self.stress / 1e6:.6g}MPa" if self.stress else ""
        return f"{self.kind}{stress}-{self.seed}"

    @property
    def file(self) -> str:
        """Where it is stored."""
        return f"{self.name}.h5"

    def identity(self) -> str:
        """Hash of all that decides the result: the order, geodem's sources and the libraries' versions."""
        text = json.dumps(asdict(self), sort_keys=True, default=float)
        return hashlib.sha256(f"{sources_digest()}{text}".encode()).hexdigest()

    def cost(self) -> float:
        """About how many steps of a particle it takes; only to be compared with that of other orders."""
        d = int(self.specimen["dimension"])
        kind = KINDS[self.kind]
        across = kind.across * float(self.specimen["across"])
        height, width = self.specimen.get("height"), float(self.specimen["width"])
        slender = kind.slender or (2.0 if height is None else float(height) / width)
        return slender * across**d * max(slender, 1.0) * across * self.pace * kind.length


@dataclass(frozen=True, eq=False)
class FinishedTest:
    """What an order ended with.

    Attributes
    ----------
    order : TestOrder
    record : TestRecord
    radii : (n,) [m]
        Of the specimen.
    size : (d,) [m]
        Of the box around it.
    compile_seconds : float
        Spent on compiling or loading kernels where it was carried out.
    """

    order: TestOrder
    record: TestRecord
    radii: Floats
    size: Floats
    compile_seconds: float

    @property
    def seconds(self) -> float:
        """Run time of the test without compiling [s]."""
        return max(self.record.seconds - self.compile_seconds, 0.0)

    def digest(self) -> str:
        """Hash of the bits of the answer, whatever the time it took."""
        tree = _tree(self)
        del tree["seconds"]
        return checksum({"identity": self.order.identity(), **tree})


@dataclass(frozen=True)
class TestKind:
    """How a kind of test is made.

    Attributes
    ----------
    make : callable
        (specimen, order, watch) -> TestRecord
    length : float
        Steps until it ends over its pace times the particles along its specimen, from where the first bonds break: in
        the middle of two rocks, two and three dimensions.
    wave : float
        Particles that a wave passes, by which it is paced, over those along its specimen.
    shape : str or None
        Of its specimen; None: that of the order.
    slender : float
        Height of its specimen over the width; 0: that of the order.
    across : float
        Particles across its specimen over those of the order.
    stress : str
        What its stress is called; empty where it has none.
    """

    __test__ = False  # not one of pytest's

    make: Callable[[Specimen, TestOrder, Watch | None], TestRecord]
    length: float = 1.0
    wave: float = 1.0
    shape: str | None = None
    slender: float = 0.0
    across: float = 1.0
    stress: str = ""


def carry_out(order: TestOrder, watch: Watch | None = None) -> FinishedTest:
    """Make the specimen and test it, in this process.

    Parameters
    ----------
    order : TestOrder
    watch : callable, optional
        Is told the strain and the stress now and then.

    Raises
    ------
    InputError
        No such test; as of `make_specimen` and of the test.
    """
    from .._jit import compile_seconds

    before = compile_seconds()
    specimen = specimen_of(order)
    record = KINDS[order.kind].make(specimen, order, watch)
    return FinishedTest(order, record, specimen.radii, specimen.size, compile_seconds() - before)


class Told(NamedTuple):
    """Where a test is that is under way.

    Attributes
    ----------
    strain, stress : float
        [-], [Pa]; nan until it has begun.
    share : float
        Of its steps that are done, if its peak is where it is expected; may grow beyond 1.
    whole : float
        Seconds that all its steps take, by the pace since it told first; nan while that is short.
    compiling : float
        Seconds that the kernel takes that is being compiled now, about; nan where none is.
    """

    strain: float = math.nan
    stress: float = math.nan
    share: float = math.nan
    whole: float = math.nan
    compiling: float = math.nan


def perform(order: TestOrder, say: Callable[[Told], None]) -> FinishedTest:
    """`carry_out` for a process of its own: what is told is told together, and errors name the test."""
    from .._jit import told_of_compiling

    kind = KINDS[order.kind]
    length = BEFORE + kind.length / kind.wave
    begun: list[tuple[float, float]] = []

    def watch(strain: float, stress: float, way: float) -> None:
        share, now = (BEFORE + way) / length, time.perf_counter()
        if not begun:
            # starting a process, making the specimen and the pilot are no part of the pace
            begun.append((share, now))
        first, at = begun[0]
        whole = (now - at) / (share - first) if share - first > SURE else math.nan
        say(Told(strain, stress, share, whole))

    try:
        with told_of_compiling(lambda seconds: say(Told(compiling=seconds))):
            return carry_out(order, watch)
    except InputError as error:
        raise InputError(
            f"{order.name}, {error.place}", error.problem, error.remedy, value=error.value
        ) from error


def specimen_of(order: TestOrder) -> Specimen:
    """The specimen of an order; raises InputError where there is no such test, or as `make_specimen`."""
    if order.kind not in KINDS:
        remedy = f"Choose one of: {', '.join(KINDS)}"
        raise InputError("test, kind", "there is no such test", remedy, value=order.kind)
    kind = KINDS[order.kind]
    arguments = dict(order.specimen)
    arguments["across"] = kind.across * float(arguments["across"])
    if kind.shape is not None:
        arguments["shape"] = kind.shape
    if kind.slender:
        arguments["height"] = kind.slender * float(arguments["width"])
    return make_specimen(**arguments)


def write_test(path: Path, test: FinishedTest) -> None:
    """Store a finished test, whole or not at all.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    tree = {**_tree(test), "identity": test.order.identity(), "compile_seconds": test.compile_seconds}
    write_checkpoint(path, tree, TEST)


def find_test(path: Path, order: TestOrder) -> FinishedTest | None:
    """The finished test of exactly this order; None where the file is not there, damaged, or of another."""
    if not path.is_file():
        return None
    try:
        tree = read_checkpoint(path, TEST)
    except InputError:
        return None
    if tree.pop("identity") != order.identity():
        return None
    cracks = Cracks(**tree["cracks"])
    radii, size, compiled = (tree.pop(name) for name in ("radii", "size", "compile_seconds"))
    record = TestRecord(**{**tree, "cracks": cracks, "warnings": tuple(tree["warnings"])})
    return FinishedTest(order, record, radii, size, compiled)


def _tree(test: FinishedTest) -> dict[str, Any]:
    r = test.record
    plain = ("kind", "strength", "failed", "reason", "numbers", "steps", "seconds", "seed")
    return {
        **{name: getattr(r, name) for name in plain},
        "warnings": list(r.warnings),
        "curves": {name: np.asarray(curve) for name, curve in r.curves.items()},
        "cracks": {name: getattr(r.cracks, name) for name in Cracks.__dataclass_fields__},
        "positions": r.positions,
        "displacements": r.displacements,
        "radii": test.radii,
        "size": test.size,
    }


def _compress(specimen: Specimen, order: TestOrder, watch: Watch | None) -> TestRecord:
    return compress(
        specimen, order.material, confinement=order.stress, expected_strain=order.expected_strain,
        pace=order.pace, fall=order.fall, seed=order.seed, watch=watch,
    )  # fmt: skip


def _pull(specimen: Specimen, order: TestOrder, watch: Watch | None) -> TestRecord:
    return pull(
        specimen, order.material, expected_strain=order.expected_strain, pace=order.pace, fall=order.fall,
        seed=order.seed, watch=watch,
    )  # fmt: skip


def _split(specimen: Specimen, order: TestOrder, watch: Watch | None) -> TestRecord:
    return split(specimen, order.material, pace=order.pace, seed=order.seed, watch=watch)


def _shear(specimen: Specimen, order: TestOrder, watch: Watch | None) -> TestRecord:
    return shear(
        specimen, order.material, normal_stress=order.stress, pace=order.pace, seed=order.seed, watch=watch
    )


def _bend(specimen: Specimen, order: TestOrder, watch: Watch | None) -> TestRecord:
    return bend(specimen, order.material, pace=order.pace, seed=order.seed, watch=watch)


KINDS = {
    "uniaxial-compression": TestKind(_compress, 1.35),
    "triaxial-compression": TestKind(_compress, 2.0, stress="confinement"),
    # what is pulled breaks soon after its first bond
    "direct-tension": TestKind(_pull, 0.35),
    "brazilian": TestKind(_split, 0.8, shape="disc", slender=0.5),
    "direct-shear": TestKind(_shear, 3.3, shape="prism", slender=1.0, stress="normal stress"),
    # a beam bends more slowly than a wave passes, and needs less across than along
    "three-point-bending": TestKind(_bend, 1.05, wave=4.05, shape="prism", slender=4.5, across=0.5),
}
"""Tests by name. A disc is half as thick as it is wide (in 2D a metre), a block to be sheared as high as it is wide."""
