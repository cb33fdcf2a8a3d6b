"""YADE (Debian's package): frictional spheres, bonded spheres (CohFrict), bonded discs (JCFpm)."""

from __future__ import annotations

import json
import math
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from ..scenes import Scene
from .outcome import BackendError, Outcome, Speed, clean_environment, refuse, speed, start

NAME = "yade"
PROGRAM = "/usr/bin/yade"
INSIDE = Path(__file__).parent / "inside_yade.py"
_UNBREAKABLE = 1e30  # [Pa]

LAWS = {
    "frictional": "Law2_ScGeom_FrictPhys_CundallStrack, without damping",
    "moments": "Law2_ScGeom6D_CohFrictPhys_CohesionMoment with moments in total form; normal force from the overlap "
    "of the surfaces, not from the distance at bonding",
    "central": "Law2_ScGeom_JCFpmPhys_JointedCohesiveFrictionalPM",
}


def available() -> str | None:
    """None where YADE is found, else how to install it."""
    return None if shutil.which(PROGRAM) else "YADE is missing: apt-get install yade"


def run(scene: Scene, steps: int, *, threads: int = 1, warm_up: int = 0, every: int = 0) -> Outcome:
    """`warm_up` steps, then `steps` timed ones; frames every `every` steps (0: the last only).

    Raises BackendError where YADE is missing or fails, or where its laws cannot stand for the scene.
    """
    missing = available()
    if missing:
        raise BackendError(missing)
    task = _law(scene) | {
        "steps": steps,
        "warm_up": warm_up,
        "every": every,
        "time_step": scene.time_step,
        "gravity": list(scene.gravity),
        "density": scene.density,
        "friction_angle": math.atan(scene.friction),
        "planar": scene.dimension == 2,
    }
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "task.json").write_text(json.dumps(task))
        np.savez(
            folder / "scene.npz",
            positions=scene.positions,
            velocities=scene.velocities,
            spins=scene.spins,
            radii=scene.radii,
            # a contact's stiffness is the harmonic mean of E r (and E r nu) of its two sides
            young=scene.normal / scene.radii,
            box=np.zeros((0, 3)) if scene.box is None else scene.box,
        )
        # -x: leave when the script is done, and tell an error by the exit status
        command = [PROGRAM, "-n", "-x", f"-j{threads}", str(INSIDE), str(folder)]
        printed = start("YADE", command, folder, clean_environment(), 3600.0)
        result = folder / "result.npz"
        if not result.exists():
            raise BackendError(f"YADE gave no result:\n{printed[-2000:]}")
        with np.load(result) as found:
            made = int(found["bonds"])
            if scene.bonds is not None and made != len(scene.bonds.pairs):
                raise BackendError(f"YADE made {made} bonds where the scene has {len(scene.bonds.pairs)}")
            return Outcome(
                float(found["seconds"]) / steps,
                LAWS[str(task["law"])],
                str(found["version"]),
                found["positions"],
                found["velocities"],
                found["spins"],
            )


def run_speed(scene: Scene, steps: int, threads: int) -> Speed:
    """Seconds of one step, by YADE's own loop."""
    return speed(run, scene, steps, threads)


def _law(scene: Scene) -> dict[str, Any]:
    """Numbers of the law; bonds only between spheres of one radius, for YADE's strengths follow the radius."""
    numbers: dict[str, Any] = {"law": "frictional", "ratio": scene.shear / scene.normal}
    bonds = scene.bonds
    if bonds is None:
        return numbers
    radius = float(scene.radii[0])
    if np.any(scene.radii != radius):
        raise refuse("YADE", "strengths and moments of its bonds follow the radius, and the radii differ")
    if (bonds.normal, bonds.shear) != (scene.normal, scene.shear):
        raise refuse("YADE", "its bonds are as stiff as its contacts")
    moments = bonds.twist > 0.0 or bonds.bend > 0.0
    area = radius**2 if moments else math.pi * radius**2
    return numbers | {
        "law": "moments" if moments else "central",
        "tension": min(bonds.tension / area, _UNBREAKABLE),
        "cohesion": min(bonds.cohesion / area, _UNBREAKABLE),
        "bend": bonds.bend / (radius**2 * scene.shear),
        "twist": bonds.twist / (radius**2 * scene.shear),
    }
