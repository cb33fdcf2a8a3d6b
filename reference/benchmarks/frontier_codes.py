"""Run time against error for geodem, YADE and LIGGGHTS: collisions, a settling pack, a bonded beam, a slope.

Each code runs in one thread, in turn with the others, in its own laws and its own way of stepping. LIGGGHTS has no
bonds, so that it has no part in the beam and the slope.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable

from geodem._jit import set_threads, threads_allowed

from ..backends import BACKENDS
from ..results_file import Row
from . import frontier_codes_bonded as bonded
from . import frontier_codes_motion as motion
from . import frontier_codes_slope as slope
from .checks import Results
from .frontier_codes_runs import GEODEM, LIGGGHTS, YADE, starts

NAME = "frontier-codes"

PROBLEMS = ("start", "collision", "pack", "cantilever", "swing", "slope")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``bench frontier-codes``."""
    parser.add_argument("--problems", nargs="*", default=list(PROBLEMS), choices=list(PROBLEMS))
    parser.add_argument("--with", nargs="*", dest="codes", default=[YADE, LIGGGHTS], choices=[YADE, LIGGGHTS])
    parser.add_argument("--rounds", type=int, default=3, help="measurements of each run time")
    parser.add_argument("--pairs", type=int, default=500, help="collisions at once")
    parser.add_argument("--spheres", type=int, default=1000, help="of the pack")
    parser.add_argument("--settle", type=int, default=3200, help="steps of the pack that are timed")
    parser.add_argument("--long", type=int, default=20, help="free spheres of the cantilever at rest")
    parser.add_argument("--steps", type=int, default=32768, help="most steps until it rests")
    parser.add_argument("--free", type=int, default=8, help="free spheres of the cantilever that swings")
    parser.add_argument("--periods", type=int, default=5)
    parser.add_argument("--height", type=int, default=26, help="rows of the slope")
    parser.add_argument(
        "--ramps", nargs="*", type=int, default=[500, 1000, 2000, 4000, 8000, 16000], metavar="STEPS"
    )


def main(arguments: argparse.Namespace) -> int:
    """Measure, print a line a row, store the rows."""
    codes = [GEODEM]
    for name in arguments.codes:
        missing = BACKENDS[name].available()
        if missing:
            print(f"left out: {missing}", file=sys.stderr)
        else:
            codes.append(name)
    results = Results(NAME)
    before = threads_allowed()
    set_threads(1)
    try:
        for problem in arguments.problems:
            rows = measure(problem, codes, arguments)
            replaced = {row["problem"] for row in rows}
            results.rows = [row for row in results.rows if row["problem"] not in replaced]
            for row in rows:
                results.add(row)
    finally:
        set_threads(before)
    return 0


def measure(problem: str, codes: list[str], given: argparse.Namespace) -> list[Row]:
    """Rows of one problem."""
    makers: dict[str, Callable[[], list[Row]]] = {
        "start": lambda: starts(
            {code: motion.collisions(code, given.pairs, [0.5], oblique=True)[0] for code in codes},
            given.rounds,
        ),
        "collision": lambda: motion.collision_rows(codes, given.pairs, given.rounds),
        "pack": lambda: motion.pack_rows(codes, given.spheres, given.settle, given.rounds),
        "cantilever": lambda: bonded.rest_rows(codes, given.long, given.steps, given.rounds),
        "swing": lambda: bonded.swing_rows(codes, given.free, given.periods, given.rounds),
        "slope": lambda: slope.slope_rows(codes, given.height, given.ramps, given.rounds),
    }
    return makers[problem]()
