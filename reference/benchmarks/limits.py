"""Speed against what the machine allows: the same loop in plain C, and the bandwidth of the memory.

Both run the same scene in the same layout of rows, chunks and pairs. Bytes of a pair are those of a count by hand:
100 of a pair of spheres, 148 of a bond of two discs.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from statistics import median
from typing import Any

from .. import limits, ours, scenes
from ..results_file import Row, load_rows, store_rows
from .alternating import alternate, compared, enough_steps

NAME = "limits"
SIZES = (10_000, 100_000)
DAMPING = 0.1
BYTES = {2: 148.0, 3: 100.0}
"""A pair and step."""
SCENES: dict[str, Callable[[int], scenes.Scene]] = {
    "touching": scenes.touching_spheres,
    "bonded-discs": scenes.bonded_discs,
}
RATIOS = {
    ("touching", 10_000): 1.6,
    ("touching", 100_000): 1.4,
    ("bonded-discs", 10_000): 0.95,
    ("bonded-discs", 100_000): 0.95,
}
"""How many times faster than the C loop geodem is held to be."""
SHARES = {2: 0.45, 3: 0.30}
"""Share of the two-thread triad that geodem is held to, from 100,000 particles on."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``bench limits``."""
    parser.add_argument("--scenes", nargs="*", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--sizes", nargs="*", type=int, default=list(SIZES), help="numbers of particles")
    parser.add_argument("--threads", nargs="*", type=int, default=[1, 2])
    parser.add_argument("--rounds", type=int, default=7, help="measurements of each")
    parser.add_argument("--seconds", type=float, default=1.0, help="length of a measurement")
    parser.add_argument(
        "--chunk",
        type=int,
        default=None,
        help="particles a chunk of the C loop, in pairs of its own; geodem's chunks and pairs if left out",
    )
    parser.add_argument("--alone", action="store_true", help="measure C and memory only; nothing is stored")


def main(arguments: argparse.Namespace) -> int:
    """Measure what is asked, print a line a row, store the rows."""
    missing = limits.available()
    if missing:
        print(missing, file=sys.stderr)
        return 2
    bandwidth = {threads: limits.triad(threads) for threads in arguments.threads}
    for threads, values in bandwidth.items():
        print(
            f"triad, {threads} threads: {median(values) / 1e9:.1f} GB/s "
            f"({min(values) / 1e9:.1f}-{max(values) / 1e9:.1f})",
            flush=True,
        )
    rows = load_rows(NAME)
    command = "python -m reference " + " ".join(sys.argv[1:])
    for size in arguments.sizes:
        for kind in arguments.scenes:
            # damping pulls at rest towards zero without gravity; the discs need no fall either
            scene = replace(SCENES[kind](size), gravity=(0.0, 0.0, 0.0))
            for threads in arguments.threads:
                triad = median(bandwidth[threads])
                if arguments.alone:
                    print(_alone(kind, scene, threads, triad, arguments), flush=True)
                    continue
                row = measure(kind, scene, threads, triad, arguments)
                rows = [r for r in rows if _key(r) != _key(row)] + [row]
                store_rows(NAME, sorted(rows, key=_key), command)
                print(_line(row), flush=True)
    return 0


def measure(kind: str, scene: scenes.Scene, threads: int, triad: float, arguments: argparse.Namespace) -> Row:
    """geodem and the C loop in turn; a row of the results file, times in seconds a step."""
    loop = _loop(scene, arguments)

    def our_seconds(steps: int) -> float:
        return ours.run_speed(scene, steps, threads, damping=DAMPING).seconds_per_step

    times = alternate(
        our_seconds,
        lambda steps: loop.step(steps, threads),
        seconds=arguments.seconds,
        rounds=arguments.rounds,
    )
    found: dict[str, Any] = compared(*times)
    return {
        "scene": kind,
        "particles": scene.particles,
        "threads": threads,
        "pairs": loop.pairs(),
        "chunk": loop.chunk,
        "triad": triad,
        "share_of_triad": BYTES[scene.dimension] * loop.pairs() / found["ours"] / triad,
        "held_to_ratio": RATIOS.get((kind, scene.particles)),
        "held_to_share": SHARES[scene.dimension] if threads == 2 and scene.particles >= 100_000 else None,
        **found,
    }


def _loop(scene: scenes.Scene, arguments: argparse.Namespace) -> limits.Loop:
    if arguments.chunk or arguments.alone:
        return limits.loop_of(scene, damping=DAMPING, chunk=arguments.chunk)
    return limits.loop_of_engine(scene, ours.simulation_of(scene, damping=DAMPING), damping=DAMPING)


def _alone(kind: str, scene: scenes.Scene, threads: int, triad: float, arguments: argparse.Namespace) -> str:
    loop = _loop(scene, arguments)

    def run(steps: int) -> float:
        return loop.step(steps, threads)

    steps = enough_steps(run, arguments.seconds)
    rate = loop.pairs() / median(run(steps) for _ in range(arguments.rounds))
    return (
        f"{kind:13s} {scene.particles:8d} C, chunks of {loop.chunk}, {threads} threads: "
        f"{rate / 1e6:.1f} million pairs/s, {BYTES[scene.dimension] * rate / triad:.2f} of triad"
    )


def _key(row: Row) -> tuple[str, int, int]:
    return row["scene"], row["particles"], row["threads"]


def _line(row: Row) -> str:
    return (
        f"{row['scene']:13s} {row['particles']:8d} {row['threads']} threads: {row['pairs'] / row['ours'] / 1e6:.1f} "
        f"against {row['pairs'] / row['theirs'] / 1e6:.1f} million pairs/s in C, {row['ratio']:.2f} times "
        f"({row['ratio_low']:.2f}-{row['ratio_high']:.2f}), {row['share_of_triad']:.2f} of triad"
    )
