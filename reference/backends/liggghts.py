"""LIGGGHTS (Debian's package): frictional spheres; it has no bonds."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..posed import Posed, Trajectory
from ..scenes import Scene
from .granular_text import (
    COLUMNS,
    SKIN,
    domain,
    last_loop_seconds,
    loop_seconds,
    read_frames,
    spheres_of,
    write_particles,
)
from .liggghts_script import refuse_what_it_lacks, script_of, trajectory_of
from .outcome import Outcome, Speed, speed
from .program import TIMEOUT, BackendError, clean_environment, refuse, start
from .verlet import spheres_of_assembly

NAME = "liggghts"
PROGRAM = "/usr/bin/liggghts"
# its own MPI, whatever another one is first on the path
LAUNCHERS = ("/usr/bin/mpirun.openmpi", "/usr/bin/mpirun")
LAW = "gran model hooke/stiffness tangential history, without viscous damping; velocity Verlet"


def available() -> str | None:
    """None where LIGGGHTS is found, else how to install it."""
    return None if shutil.which(PROGRAM) else "LIGGGHTS is missing: apt-get install liggghts"


def run_posed(posed: Sequence[Posed], *, threads: int = 1, timeout: float = TIMEOUT) -> list[Trajectory]:
    """Run posed scenes, each in a process of its own, whose start takes a third of a second.

    Raises BackendError where LIGGGHTS is missing, fails, hangs or gives half an answer, or cannot express a scene.
    """
    missing = available()
    if missing:
        raise BackendError(missing)
    found = []
    for one in posed:
        refuse_what_it_lacks(one)
        script = script_of(one)
        types = len(one.assembly.material_names) + len(one.assembly.walls)
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_particles(folder / "particles.data", spheres_of_assembly(one, types))
            (folder / "scene.in").write_text(script)
            begun = time.perf_counter()
            printed = start("LIGGGHTS", _command(threads), folder, clean_environment(), timeout)
            seconds = time.perf_counter() - begun
            run = trajectory_of(one, folder, printed, _version(printed))
            found.append(replace(run, seconds=seconds, loop_seconds=loop_seconds(printed)))
    return found


def run(
    scene: Scene, steps: int, *, threads: int = 1, warm_up: int = 0, every: int = 0, timeout: float = TIMEOUT
) -> Outcome:
    """`warm_up` steps, then `steps` timed ones on `threads` processes; frames every `every` steps (0: the last).

    Raises BackendError where LIGGGHTS is missing or fails, or where its laws cannot stand for the scene.
    """
    missing = available()
    if missing:
        raise BackendError(missing)
    if scene.bonds is not None:
        raise refuse("LIGGGHTS", "it has no bonds")
    if scene.dimension != 3:
        raise refuse("LIGGGHTS", "its discs have the mass of discs, not of spheres")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_particles(folder / "particles.data", spheres_of(scene, types=2))
        (folder / "scene.in").write_text(_script(scene, steps, warm_up, every, threads))
        printed = start("LIGGGHTS", _command(threads), folder, clean_environment(), timeout)
        first = warm_up + max(every, 1)
        frames = read_frames(folder / "frames.txt", scene.particles, first, printed=printed)
    return Outcome(
        last_loop_seconds(printed) / steps,
        LAW,
        _version(printed),
        frames[:, :, 0:3],
        frames[:, :, 3:6],
        frames[:, :, 6:9],
    )


def _command(threads: int) -> list[str]:
    command = [PROGRAM, "-in", "scene.in"]
    if threads == 1:
        return command
    launcher = next((path for path in LAUNCHERS if shutil.which(path)), "mpirun")
    root = ["--allow-run-as-root"] if os.getuid() == 0 else []
    return [launcher, *root, "--oversubscribe", "--bind-to", "none", "-n", str(threads), *command]


def _version(printed: str) -> str:
    found = re.search(r"Version (LIGGGHTS-\S+ \S+)", printed)
    return found[1].rstrip(",") if found else "unknown"


def run_speed(scene: Scene, steps: int, threads: int) -> Speed:
    """Seconds of one step, as LIGGGHTS prints its loop time."""
    return speed(run, scene, steps, threads)


def _script(scene: Scene, steps: int, warm_up: int, every: int, threads: int) -> str:
    kn, kt, size = scene.normal, scene.shear, sum(c * c for c in scene.gravity) ** 0.5
    skin = SKIN * float(scene.radii.max())

    def by_pair(own: float, wall: float) -> str:
        return f"peratomtypepair 2 {own!r} {wall!r} {wall!r} {wall!r}"

    lines = [
        "atom_style granular",
        "atom_modify map array",
        "boundary f f f",
        "newton off",
        "communicate single vel yes",
        "units si",
        _processors(scene, threads),
        "read_data particles.data",
        f"neighbor {skin!r} bin",
        # the factor makes it drop the spring of a pair that has parted
        "neigh_modify delay 0 contact_distance_factor 1.1",
        f"fix kn all property/global kn {by_pair(kn, 2.0 * kn)}",
        f"fix kt all property/global kt {by_pair(kt, 2.0 * kt)}",
        f"fix gn all property/global gamman {by_pair(0.0, 0.0)}",
        f"fix gt all property/global gammat {by_pair(0.0, 0.0)}",
        f"fix mu all property/global coefficientFriction {by_pair(scene.friction, scene.friction)}",
        "pair_style gran model hooke/stiffness tangential history absolute_damping off",
        "pair_coeff * *",
        f"timestep {scene.time_step!r}",
    ]
    if size > 0.0:
        lines.append(
            f"fix fall all gravity {size!r} vector " + " ".join(repr(c / size) for c in scene.gravity)
        )
    if scene.box is not None:
        for side, word in enumerate(("low", "high")):
            for axis, letter in enumerate("xyz"):
                lines.append(
                    f"fix {word}{letter} all wall/gran model hooke/stiffness tangential history "
                    f"primitive type 2 {letter}plane {float(scene.box[side, axis])!r}"
                )
    lines += ["fix move all nve/sphere", "thermo 1000000", "thermo_modify lost error"]
    dump = "dump frames all custom {} frames.txt " + COLUMNS
    order = 'dump_modify frames sort id format "%d' + " %.17g" * 9 + '"'
    if every:
        lines += [dump.format(every), order]
    if warm_up:
        lines.append(f"run {warm_up}")
    lines.append(f"run {steps}")
    if not every:
        lines += [dump.format(1), order, "run 0"]
    return "\n".join(line for line in lines if line) + "\n"


def _processors(scene: Scene, threads: int) -> str:
    """Domains side by side along the longest direction, where there are few."""
    low, high = domain(scene)
    longest = int((high - low).argmax())
    return "processors " + " ".join(str(threads if axis == longest else 1) for axis in range(3))
