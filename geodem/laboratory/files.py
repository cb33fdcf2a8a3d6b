"""Finished tests as files for others to read: curves and a line each as text, particles and cracks for ParaView."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..io.files import remove
from ..io.history import write_history
from ..io.vtkhdf import write_vtkhdf
from .orders import FinishedTest
from .record import UNITS
from .summary import group_tests

HISTORY_COLUMNS = (
    "test [-]",
    "stress [Pa]",
    "seed [-]",
    "strength [Pa]",
    "peak strain [-]",
    "Young's modulus [Pa]",
    "Poisson's ratio [-]",
    "tension cracks [-]",
    "shear cracks [-]",
    "failed [-]",
    "steps [-]",
    "time [s]",
)


FRAMES = ("particles", "cracks")
"""Names of the files of a test that is drawn begin so."""


def write_tests(folder: Path, tests: Sequence[FinishedTest]) -> None:
    """curves/NAME.csv of all; particles-NAME.vtkhdf and cracks-NAME.vtkhdf of the typical one of every kind and stress.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    for test in tests:
        curves = test.record.curves
        columns = [f"{name} [{UNITS.get(name, '-')}]" for name in curves]
        write_history(
            folder / "curves" / f"{test.order.name}.csv", columns, zip(*curves.values(), strict=True)
        )
    typical = [group.typical for group in group_tests(tests)]
    wanted = {f"{what}-{test.order.name}.vtkhdf" for test in typical for what in FRAMES}
    for what in FRAMES:
        for path in folder.glob(f"{what}-*.vtkhdf"):
            if path.name not in wanted:
                # of a run that was stopped, where another test was the typical one
                remove(path)
    for test in typical:
        _write_frames(folder, test)


def history_line(test: FinishedTest) -> tuple[object, ...]:
    """A line of history.csv."""
    r = test.record
    numbers = (r.numbers.get(name, math.nan) for name in ("peak_strain", "young_modulus", "poisson_ratio"))
    return (
        r.kind, test.order.stress, test.order.seed, r.strength, *numbers, r.cracks.tension, r.cracks.shear,
        int(r.failed), r.steps, round(test.seconds, 3),
    )  # fmt: skip


def _write_frames(folder: Path, test: FinishedTest) -> None:
    """Particles and cracks of a test at its end, for ParaView."""
    record, name = test.record, test.order.name
    write_vtkhdf(
        folder / f"particles-{name}.vtkhdf", record.positions,
        point_data={"radius [m]": test.radii, "displacement [m]": record.displacements},
    )  # fmt: skip
    cracks = record.cracks
    write_vtkhdf(
        folder / f"cracks-{name}.vtkhdf", cracks.place,
        point_data={
            "mode [-]": cracks.mode.astype(np.uint8), "normal [-]": cracks.direction, "size [m]": cracks.size,
            "axial stress [Pa]": cracks.stress,
        },
    )  # fmt: skip
