"""Run by YADE's own Python: ``yade -n -x inside_yade.py FOLDER`` reads a scene there and leaves result.npz."""

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import yade.config
from yade import (
    Bo1_Sphere_Aabb,
    Bo1_Wall_Aabb,
    CohFrictMat,
    ForceResetter,
    FrictMat,
    Ig2_Sphere_Sphere_ScGeom,
    Ig2_Sphere_Sphere_ScGeom6D,
    Ig2_Wall_Sphere_ScGeom,
    InsertionSortCollider,
    InteractionLoop,
    Ip2_CohFrictMat_CohFrictMat_CohFrictPhys,
    Ip2_FrictMat_FrictMat_FrictPhys,
    Ip2_JCFpmMat_JCFpmMat_JCFpmPhys,
    JCFpmMat,
    Law2_ScGeom6D_CohFrictPhys_CohesionMoment,
    Law2_ScGeom_FrictPhys_CundallStrack,
    Law2_ScGeom_JCFpmPhys_JointedCohesiveFrictionalPM,
    NewtonIntegrator,
    O,
    PyRunner,
    utils,
)

folder = Path(sys.argv[1])
task = json.loads((folder / "task.json").read_text())
scene = np.load(folder / "scene.npz")
radii, young = scene["radii"], scene["young"]
law = task["law"]

# share of the smallest radius by which bounding boxes are larger; the default of 0.5 lists many pairs for nothing
# in a packing that hardly moves
VERLET = -0.1


def material(stiffness: float) -> Any:
    """Material of a sphere whose E is `stiffness`."""
    common = {
        "young": stiffness,
        "poisson": task["ratio"],
        "frictionAngle": task["friction_angle"],
        "density": task["density"],
    }
    if law == "moments":
        return CohFrictMat(
            normalCohesion=task["tension"], shearCohesion=task["cohesion"], isCohesive=True, fragile=True,
            momentRotationLaw=True, alphaKr=task["bend"], alphaKtw=task["twist"], etaRoll=-1, etaTwist=-1, **common,
        )  # fmt: skip
    if law == "central":
        return JCFpmMat(tensileStrength=task["tension"], cohesion=task["cohesion"], **common)
    return FrictMat(**common)


def laws() -> tuple[list[Any], list[Any], list[Any]]:
    """Geometry, physics and law of the contacts."""
    if law == "moments":
        physics = Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(
            setCohesionNow=True, setCohesionOnNewContacts=False
        )
        moment = Law2_ScGeom6D_CohFrictPhys_CohesionMoment(
            always_use_moment_law=True, useIncrementalForm=False
        )
        return [Ig2_Sphere_Sphere_ScGeom6D()], [physics], [moment]
    # true branch vectors: the relative velocity of the other codes
    geometry = [
        Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=False),
        Ig2_Wall_Sphere_ScGeom(noRatch=False),
    ]
    if law == "central":
        physics = Ip2_JCFpmMat_JCFpmMat_JCFpmPhys(cohesiveTresholdIteration=1)
        return geometry, [physics], [Law2_ScGeom_JCFpmPhys_JointedCohesiveFrictionalPM()]
    return geometry, [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]


frames: list[Any] = []
clock: dict[str, float] = {}


def after_step() -> None:
    """Called at the end of every step: O.iter counts from 0."""
    done = O.iter + 1
    if done == task["warm_up"] + task["steps"]:
        clock["end"] = time.perf_counter()
    if task["every"] and (done - task["warm_up"]) % task["every"] == 0 and done > task["warm_up"]:
        frames.append(state())
    if done == task["warm_up"]:
        clock["begin"] = time.perf_counter()


def state() -> Any:
    """Positions, velocities and spins."""
    return np.array(
        [[b.state.pos, b.state.vel, b.state.angVel] for b in (O.bodies[i] for i in range(len(radii)))]
    )


shared = material(float(young[0])) if np.all(young == young[0]) else None
bodies = []
for x, v, w, r, e in zip(scene["positions"], scene["velocities"], scene["spins"], radii, young, strict=True):
    body = utils.sphere(x.tolist(), float(r), material=shared or material(float(e)))
    body.state.vel = v.tolist()
    body.state.angVel = w.tolist()
    if task["planar"]:
        body.state.blockedDOFs = "zXY"
    bodies.append(body)
O.bodies.append(bodies)
if len(scene["box"]):
    rigid = material(1e30)
    for axis in range(3):
        for side, sense in ((0, 1), (1, -1)):
            O.bodies.append(utils.wall(float(scene["box"][side, axis]), axis, sense, material=rigid))

geometry, physics, law2 = laws()
O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=VERLET),
    InteractionLoop(geometry, physics, law2),
    NewtonIntegrator(damping=0.0, gravity=task["gravity"]),
    PyRunner(command="after_step()", iterPeriod=1, initRun=True),
]
O.dt = task["time_step"]
if not task["warm_up"]:
    clock["begin"] = time.perf_counter()
O.run(task["warm_up"] + task["steps"], True)
if not task["every"] or task["steps"] % task["every"]:
    frames.append(state())


def bonded(i: Any) -> bool:
    """Whether an interaction is an intact bond."""
    if law == "moments":
        return not bool(i.phys.cohesionBroken)
    return law == "central" and bool(i.phys.isCohesive)


bonds = sum(bonded(i) for i in O.interactions) if law != "frictional" else 0
recorded = np.array(frames)
np.savez(
    folder / "result.npz", seconds=clock["end"] - clock["begin"], version=yade.config.version, bonds=bonds,
    positions=recorded[:, :, 0], velocities=recorded[:, :, 1], spins=recorded[:, :, 2],
)  # fmt: skip
