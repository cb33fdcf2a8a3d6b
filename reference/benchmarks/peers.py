"""Speed against YADE, LIGGGHTS and LAMMPS on the same scenes, timed in turn.

A row is one scene, one code and one number of threads (processes for LIGGGHTS and LAMMPS). Times are those of the
step alone, as each code measures it after a warm-up; reading the scene and starting the program do not count.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import Any

from .. import ours, scenes
from ..backends import BACKENDS, Speed
from ..results_file import Row, load_rows, store_rows
from .alternating import alternate, compared, enough_steps

NAME = "peers"
SIZES = (10_000, 100_000)
SCENES: dict[str, tuple[Callable[[int], scenes.Scene], dict[str, float]]] = {
    # scene, and for every code that can run it how many times faster geodem is held to be
    "spheres": (scenes.spheres_in_a_box, {"yade": 10.0, "liggghts": 1.5, "lammps": 1.5}),
    "moving": (scenes.moving_spheres, {"yade": 10.0, "liggghts": 1.5, "lammps": 1.5}),
    "touching": (scenes.touching_spheres, {"yade": 10.0, "liggghts": 1.5, "lammps": 1.5}),
    "bonded-block": (scenes.bonded_block, {"yade": 5.0, "lammps": 5.0}),
    "bonded-discs": (scenes.bonded_discs, {"yade": 20.0}),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of ``bench peers``."""
    parser.add_argument("--scenes", nargs="*", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--with", nargs="*", dest="codes", default=list(BACKENDS), choices=list(BACKENDS))
    parser.add_argument("--sizes", nargs="*", type=int, default=list(SIZES), help="numbers of particles")
    parser.add_argument("--threads", nargs="*", type=int, default=[1, 2])
    parser.add_argument("--rounds", type=int, default=5, help="measurements of each code")
    parser.add_argument("--seconds", type=float, default=3.0, help="length of a measurement")
    parser.add_argument("--alone", action="store_true", help="time the other codes only; nothing is stored")


def main(arguments: argparse.Namespace) -> int:
    """Time what is asked, print a line a row, store the rows."""
    codes = []
    for name in arguments.codes:
        missing = BACKENDS[name].available()
        if missing:
            print(f"left out: {missing}", file=sys.stderr)
        else:
            codes.append(name)
    rows = load_rows(NAME)
    command = "python -m reference " + " ".join(sys.argv[1:])
    for size in arguments.sizes:
        for kind in arguments.scenes:
            make, wanted = SCENES[kind]
            scene = make(size)
            for name in (code for code in codes if code in wanted):
                for threads in arguments.threads:
                    if arguments.alone:
                        print(_alone(kind, scene, name, threads, arguments.seconds), flush=True)
                        continue
                    row = measure(
                        kind, scene, name, threads, rounds=arguments.rounds, seconds=arguments.seconds
                    )
                    rows = [r for r in rows if _key(r) != _key(row)] + [row]
                    store_rows(NAME, sorted(rows, key=_key), command)
                    print(_line(row), flush=True)
    return 0


def measure(kind: str, scene: scenes.Scene, name: str, threads: int, *, rounds: int, seconds: float) -> Row:
    """geodem and one other code in turn; a row of the results file, times in seconds a step."""
    last: dict[str, Speed] = {}

    def timed(module: Any) -> Callable[[int], float]:
        def run(steps: int) -> float:
            last[module.NAME] = module.run_speed(scene, steps, threads)
            return last[module.NAME].seconds_per_step

        return run

    times = alternate(timed(ours), timed(BACKENDS[name]), seconds=seconds, rounds=rounds)
    return {
        "scene": kind,
        "code": name,
        "particles": scene.particles,
        "threads": threads,
        "contacts": last[name].contacts,
        "contacts_ours": last[ours.NAME].contacts,
        "law": last[name].law,
        "law_ours": last[ours.NAME].law,
        "version": last[name].version,
        "held_to": SCENES[kind][1][name],
        **compared(*times),
    }


def _alone(kind: str, scene: scenes.Scene, name: str, threads: int, seconds: float) -> str:
    def run(steps: int) -> float:
        return float(BACKENDS[name].run_speed(scene, steps, threads).seconds_per_step)

    result = BACKENDS[name].run_speed(scene, enough_steps(run, seconds), threads)
    return (
        f"{kind:13s} {scene.particles:8d} {name:9s} {threads} threads: "
        f"{scene.particles / result.seconds_per_step / 1e6:8.3f} million particle-steps/s, "
        f"{result.contacts / result.seconds_per_step / 1e6:8.3f} million contact-steps/s"
    )


def _key(row: Row) -> tuple[str, str, int, int]:
    return row["scene"], row["code"], row["particles"], row["threads"]


def _line(row: Row) -> str:
    return (
        f"{row['scene']:13s} {row['particles']:8d} {row['code']:9s} {row['threads']} threads: "
        f"{row['particles'] / row['ours'] / 1e6:.3f} against {row['particles'] / row['theirs'] / 1e6:.3f} million "
        f"particle-steps/s, {row['ratio']:.2f} times ({row['ratio_low']:.2f}-{row['ratio_high']:.2f}, "
        f"held to {row['held_to']:g})"
    )


def missed(rows: Sequence[Row]) -> list[Row]:
    """Rows below what geodem is held to."""
    return [row for row in rows if row["ratio"] < row["held_to"]]
