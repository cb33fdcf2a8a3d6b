"""YADE (Debian's package): frictional spheres, bonded spheres (CohFrict), bonded discs and spheres (JCFpm)."""

from __future__ import annotations

import json
import math
import shutil
import tempfile
import time
import zipfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..posed import Posed, Trajectory
from ..scenes import Scene
from .answer import checked
from .outcome import Outcome, Speed, speed
from .program import TIMEOUT, BackendError, clean_environment, last_words, refuse, start
from .yade_task import FORMAT, LAWS, RIGID, UNBREAKABLE, task_of, trajectory_of

NAME = "yade"
PROGRAM = "/usr/bin/yade"
INSIDE = Path(__file__).parent / "inside_yade.py"

Arrays = dict[str, Any]

OF_SCENES = {
    "frictional": LAWS["frictional"] + ", without damping",
    "moments": LAWS["moments"],
    "jointed": LAWS["jointed"],
}


def available() -> str | None:
    """None where YADE is found, else how to install it."""
    return None if shutil.which(PROGRAM) else "YADE is missing: apt-get install yade"


def run_posed(posed: Sequence[Posed], *, threads: int = 1, timeout: float = TIMEOUT) -> list[Trajectory]:
    """Run posed scenes one after the other in one process of YADE, whose start takes a second.

    Raises BackendError where YADE is missing, fails, hangs or gives half an answer, or cannot express a scene.
    """
    tasks = [task_of(one) for one in posed]
    begun = time.perf_counter()
    answers, printed = _launch(tasks, threads, timeout)
    seconds = time.perf_counter() - begun
    found = [
        trajectory_of(one, arrays, answer, numbers["law"], printed)
        for one, (numbers, arrays), answer in zip(posed, tasks, answers, strict=True)
    ]
    return found if len(found) > 1 else [replace(one, seconds=seconds) for one in found]


def run_ramp(
    posed: Posed, *, every: int, until: int, threads: int = 1, timeout: float = TIMEOUT
) -> NDArray[np.float64]:
    """Spheres in jointed_cohesive bonds under a gravity that rises with the steps, from nothing to all of it.

    Parameters
    ----------
    posed : Posed
    every : int
        Steps between settings of gravity.
    until : int
        Broken bonds with which the run ends.

    Returns
    -------
    (k, 3)
        Steps done, bonds broken and seconds in the loop, every so many steps.
    """
    numbers, arrays = task_of(posed)
    if numbers["law"] != "jointed":
        raise refuse("YADE", "only the law of jointed_cohesive counts its broken bonds")
    numbers |= {"frames": [], "pairs_at": []}
    numbers["ramp"] = {"every": every, "steps": posed.steps, "until": until}
    (answer,), printed = _launch([(numbers, arrays)], threads, timeout)
    checked("YADE", answer, {"watched": (len(answer.get("watched", ())), 3)}, printed)
    return np.asarray(answer["watched"])


def run(
    scene: Scene, steps: int, *, threads: int = 1, warm_up: int = 0, every: int = 0, timeout: float = TIMEOUT
) -> Outcome:
    """`warm_up` steps, then `steps` timed ones; frames every `every` steps (0: the last only).

    Raises BackendError where YADE is missing or fails, or where its laws cannot stand for the scene.
    """
    last = warm_up + steps
    frames = list(range(warm_up + every, last + 1, every)) if every else []
    if not frames or frames[-1] != last:
        frames.append(last)
    numbers, arrays = _task(scene)
    numbers |= {"steps": last, "warm_up": warm_up, "frames": frames}
    (answer,), printed = _launch([(numbers, arrays)], threads, timeout)
    if len(answer["broken"]):
        raise BackendError(f"YADE broke {len(answer['broken'])} bonds. {last_words(printed)}")
    return Outcome(
        float(answer["seconds"]) / steps,
        OF_SCENES[numbers["law"]],
        str(answer["version"]),
        answer["positions"],
        answer["velocities"],
        answer["spins"],
    )


def run_speed(scene: Scene, steps: int, threads: int) -> Speed:
    """Seconds of one step, by YADE's own loop."""
    return speed(run, scene, steps, threads)


def _launch(
    tasks: Sequence[tuple[dict[str, Any], Arrays]], threads: int, timeout: float
) -> tuple[list[Arrays], str]:
    """Answers to tasks, and what YADE printed."""
    missing = available()
    if missing:
        raise BackendError(missing)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "tasks.json").write_text(json.dumps([numbers for numbers, _ in tasks]))
        for number, (_, arrays) in enumerate(tasks):
            np.savez(folder / f"task-{number}.npz", **arrays)
        # -x: leave when the script is done, and tell an error by the exit status
        command = [PROGRAM, "-n", "-x", f"-j{threads}", str(INSIDE), str(folder)]
        printed = start("YADE", command, folder, clean_environment(), timeout)
        return [_answer(folder / f"result-{number}.npz", printed) for number in range(len(tasks))], printed


def _answer(path: Path, printed: str) -> Arrays:
    """What stands in a file that YADE left."""
    if not path.exists():
        raise BackendError(f"YADE gave half an answer: there is no {path.name}. {last_words(printed)}")
    try:
        with np.load(path) as stored:
            found = {name: stored[name] for name in stored.files}
    except (zipfile.BadZipFile, OSError, ValueError, EOFError) as error:
        raise BackendError(
            f"YADE gave half an answer: {path.name} cannot be read ({error}). {last_words(printed)}"
        ) from error
    if int(found.get("format", -1)) != FORMAT:
        raise BackendError(
            f"YADE's answer has the format {found.get('format', 'unknown')} where {FORMAT} is read. "
            + last_words(printed)
        )
    return found


def _task(scene: Scene) -> tuple[dict[str, Any], Arrays]:
    """Numbers and arrays of a scene; bonds only between spheres of one radius, for strengths follow the radius."""
    n, planar = scene.particles, scene.dimension == 2
    held = np.zeros((n, 6), dtype=bool)
    if planar:
        held[:, 2:5] = True
    # a contact's stiffness is the harmonic mean of E r (and E r nu) of its two sides
    young, material = np.unique(scene.normal / scene.radii, return_inverse=True)
    numbers = {"law": "frictional", "tension": 0.0, "cohesion": 0.0, "bend": 0.0, "twist": 0.0} | _bonds(
        scene
    )
    columns = {
        "young": young,
        "poisson": np.full(len(young), scene.shear / scene.normal),
        "frictionAngle": np.full(len(young), math.atan(scene.friction)),
        "density": np.full(len(young), scene.density),
    }
    columns |= {
        name: np.full(len(young), numbers.pop(name)) for name in ("tension", "cohesion", "bend", "twist")
    }
    planes = [] if scene.box is None else [(k, 1 - 2 * s, scene.box[s, k]) for k in range(3) for s in (0, 1)]
    if planes:
        columns = {
            name: np.append(values, RIGID if name == "young" else values[0])
            for name, values in columns.items()
        }
    numbers |= {
        "pairs_at": [],
        "time_step": scene.time_step,
        "damping": 0.0,
        "gravity": list(scene.gravity),
        # true branch vectors: the relative velocity of the other codes
        "avoid_ratcheting": scene.bonds is not None and not planar,
    }
    arrays = {
        "positions": scene.positions, "velocities": scene.velocities, "spins": scene.spins, "radii": scene.radii,
        "mass": scene.mass, "inertia": 0.4 * scene.mass * scene.radii**2, "held": held,
        "material": material, "group": np.zeros(n, dtype=int), "applied": np.zeros((n, 6)),
        "bonds": np.zeros((0, 2), dtype=int) if scene.bonds is None else scene.bonds.pairs,
        "bond_factor": np.ones(0 if scene.bonds is None else len(scene.bonds.pairs)),
        "wall_axis": np.array([plane[0] for plane in planes], dtype=int),
        "wall_sense": np.array([plane[1] for plane in planes], dtype=int),
        "wall_place": np.array([plane[2] for plane in planes]),
        "wall_velocity": np.zeros((len(planes), 3)),
        "wall_material": np.full(len(planes), len(young)), "wall_group": np.full(len(planes), -1),
    }  # fmt: skip
    return numbers, arrays | {f"material_{name}": values for name, values in columns.items()}


def _bonds(scene: Scene) -> dict[str, Any]:
    bonds = scene.bonds
    if bonds is None:
        return {}
    radius = float(scene.radii[0])
    if np.any(scene.radii != radius):
        raise refuse("YADE", "strengths and moments of its bonds follow the radius, and the radii differ")
    if (bonds.normal, bonds.shear) != (scene.normal, scene.shear):
        raise refuse("YADE", "its bonds are as stiff as its contacts")
    moments = bonds.twist > 0.0 or bonds.bend > 0.0
    area = radius**2 if moments else math.pi * radius**2
    return {
        "law": "moments" if moments else "jointed",
        "tension": min(bonds.tension / area, UNBREAKABLE),
        "cohesion": min(bonds.cohesion / area, UNBREAKABLE),
        "bend": bonds.bend / (radius**2 * scene.shear),
        "twist": bonds.twist / (radius**2 * scene.shear),
    }
