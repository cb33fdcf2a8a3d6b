"""Run by YADE's own Python: ``yade -n -x inside_yade.py FOLDER`` does the tasks there and leaves their results.

`tasks.json` holds their numbers; arrays of task k are in `task-k.npz`, what comes of it goes to `result-k.npz`. See
`reference.backends.yade_task` for what is in them.
"""

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
    Vector3,
    utils,
)

FORMAT = 2
# share of the smallest radius by which bounding boxes are larger; the default of 0.5 lists many pairs for nothing
# in a packing that hardly moves
VERLET = -0.1
STATE = ("positions", "velocities", "spins", "orientations", "forces", "torques")


class Run:
    """One task: bodies and engines, the frames of its steps, and what is left at the end."""

    def __init__(self, task: dict[str, Any], arrays: Any) -> None:
        self.task, self.arrays = task, arrays
        self.law = task["law"]
        self.spheres = len(arrays["radii"])
        self.frames: list[list[Any]] = []
        self.pairs: list[Any] = []
        self.walls: list[Any] = []
        self.broken: dict[int, int] = {}
        self.clock: dict[str, float] = {}
        self.record = set(task["frames"])
        self.pairs_at = set(task["pairs_at"])
        # a rising gravity is set anew every so many steps
        self.ramp: dict[str, Any] = task.get("ramp") or {}
        self.watched: list[tuple[float, ...]] = []
        events = self.record | {task["warm_up"], task["steps"]}
        if self.ramp:
            events |= set(range(self.ramp["every"], task["steps"] + 1, self.ramp["every"]))
        self.events = sorted(events - {0}, reverse=True)

    def material(self, row: int, *, frictional: bool = False) -> Any:
        """Material of a row of the table."""
        numbers = {name: float(values[row]) for name, values in self.table.items()}
        common = {name: numbers[name] for name in ("young", "poisson", "frictionAngle", "density")}
        if self.law == "moments" and not frictional:
            return CohFrictMat(
                normalCohesion=numbers["tension"], shearCohesion=numbers["cohesion"], isCohesive=True, fragile=True,
                momentRotationLaw=True, alphaKr=numbers["bend"], alphaKtw=numbers["twist"], etaRoll=-1, etaTwist=-1,
                **common,
            )  # fmt: skip
        if self.law == "jointed":
            return JCFpmMat(tensileStrength=numbers["tension"], cohesion=numbers["cohesion"], **common)
        return FrictMat(**common)

    def build(self) -> None:
        """Bodies, engines, bonds."""
        a = self.arrays
        self.table = {name.removeprefix("material_"): a[name] for name in a if name.startswith("material_")}
        materials: dict[int, Any] = {}
        bodies = []
        for k in range(self.spheres):
            row = int(a["material"][k])
            if row not in materials:
                materials[row] = self.material(row)
            body = utils.sphere(a["positions"][k].tolist(), float(a["radii"][k]), material=materials[row])
            body.state.vel = a["velocities"][k].tolist()
            body.state.angVel = a["spins"][k].tolist()
            body.state.mass = float(a["mass"][k])
            body.state.inertia = Vector3(*[float(a["inertia"][k])] * 3)
            body.state.blockedDOFs = "".join(
                freedom for freedom, held in zip("xyzXYZ", a["held"][k], strict=True) if held
            )
            # the first bit is shared by all spheres, the second is that of the material, for walls of its own
            body.mask = 1 + 2 ** (1 + int(a["group"][k]))
            bodies.append(body)
        O.bodies.append(bodies)
        for pushed in np.flatnonzero(a["applied"].any(axis=1)).tolist():
            O.forces.setPermF(pushed, a["applied"][pushed, :3].tolist())
            O.forces.setPermT(pushed, a["applied"][pushed, 3:].tolist())
        for axis, sense, place, velocity, row, group in zip(
            a["wall_axis"], a["wall_sense"], a["wall_place"], a["wall_velocity"], a["wall_material"], a["wall_group"],
            strict=True,
        ):  # fmt: skip
            body = utils.wall(
                float(place), int(axis), int(sense), material=self.material(int(row), frictional=True)
            )
            body.state.vel = velocity.tolist()
            body.mask = 2**20 - 2 if group < 0 else 2 ** (1 + int(group))
            O.bodies.append(body)
        loop = self.loop()
        O.engines = [
            ForceResetter(),
            InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=VERLET),
            loop,
            NewtonIntegrator(damping=self.task["damping"], gravity=self.task["gravity"]),
            PyRunner(command="current.after_step()", iterPeriod=1, initRun=True),
        ]
        if self.ramp:
            O.engines[3].gravity = [0.0, 0.0, 0.0]
        O.dt = self.task["time_step"]
        self.bond(loop)

    def loop(self) -> Any:
        """Geometry, physics and law of the contacts."""
        ratchet = self.task["avoid_ratcheting"]
        geometry = [
            Ig2_Sphere_Sphere_ScGeom(avoidGranularRatcheting=ratchet),
            Ig2_Wall_Sphere_ScGeom(noRatch=ratchet),
        ]
        frictional = [Ip2_FrictMat_FrictMat_FrictPhys()]
        if self.law == "moments":
            geometry[0] = Ig2_Sphere_Sphere_ScGeom6D(avoidGranularRatcheting=ratchet)
            # moments end with the bond
            moment = Law2_ScGeom6D_CohFrictPhys_CohesionMoment(
                always_use_moment_law=False, useIncrementalForm=False
            )
            self.physics = Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionOnNewContacts=True)
            return InteractionLoop(
                geometry,
                [self.physics, *frictional],
                [moment, Law2_ScGeom_FrictPhys_CundallStrack()],
            )
        if self.law == "jointed":
            self.physics = Ip2_JCFpmMat_JCFpmMat_JCFpmPhys(cohesiveTresholdIteration=1)
            return InteractionLoop(
                geometry, [self.physics], [Law2_ScGeom_JCFpmPhys_JointedCohesiveFrictionalPM()]
            )
        return InteractionLoop(geometry, frictional, [Law2_ScGeom_FrictPhys_CundallStrack()])

    def bond(self, loop: Any) -> None:
        """Bond the listed pairs, and no others."""
        for (first, second), factor in zip(
            self.arrays["bonds"].tolist(), self.arrays["bond_factor"], strict=True
        ):
            made = utils.createInteraction(first, second)
            if self.law == "moments":
                made.phys.normalAdhesion *= factor
                made.phys.shearAdhesion *= factor
            else:
                made.phys.FnMax *= factor
                made.phys.FsMax *= factor
        if self.law == "moments":
            self.physics.setCohesionOnNewContacts = False
        elif self.law == "jointed":
            self.physics.cohesiveTresholdIteration = 0

    def after_step(self) -> None:
        """Called at the end of every step: O.iter counts from 0."""
        done = O.iter + 1
        if done == self.task["steps"]:
            self.clock["end"] = time.perf_counter()
        if done in self.record:
            begun = time.perf_counter()
            self.note(done)
            if done != self.task["steps"]:
                self.clock["noting"] += time.perf_counter() - begun
        if self.ramp and done % self.ramp["every"] == 0:
            self.raise_gravity(done)
        if done == self.task["warm_up"]:
            self.clock["begin"] = time.perf_counter()
            self.clock["noting"] = 0.0
        # not called again before something is to be done
        while self.events and self.events[-1] <= done:
            self.events.pop()
        if self.events:
            O.engines[-1].iterPeriod = self.events[-1] - done

    def raise_gravity(self, done: int) -> None:
        """Gravity in proportion to the steps done; bonds broken so far."""
        share = min(done / self.ramp["steps"], 1.0)
        O.engines[3].gravity = [share * c for c in self.task["gravity"]]
        law = O.engines[2].lawDispatcher.functors[0]
        cracks = law.nbTensCracks + law.nbShearCracks
        self.clock["end"] = time.perf_counter()
        seconds = self.clock["end"] - self.clock["begin"]
        self.watched.append((done, cracks, seconds))
        if cracks >= self.ramp["until"]:
            O.pause()

    def note(self, step: int) -> None:
        """Keep a frame."""
        parts: list[Any] = [[] for _ in STATE]
        forces = O.forces
        for i in range(self.spheres):
            s = O.bodies[i].state
            q = s.ori
            found = (s.pos, s.vel, s.angVel, (q[3], q[0], q[1], q[2]), forces.f(i), forces.t(i))
            for part, value in zip(parts, found, strict=True):
                part.append(tuple(value))
        self.frames.append([np.array(part) for part in parts])
        walls = range(self.spheres, self.spheres + len(self.arrays["wall_axis"]))
        self.walls.append([tuple(forces.f(i)) for i in walls])
        if step in self.pairs_at:
            for i in O.interactions:
                if i.isReal and max(i.id1, i.id2) < self.spheres:
                    # YADE's forces are those on the second
                    vectors = (-i.phys.normalForce, -i.phys.shearForce, i.geom.normal)
                    self.pairs.append((len(self.frames) - 1, i.id1, i.id2, *(x for v in vectors for x in v)))
        for number, (first, second) in enumerate(self.arrays["bonds"].tolist()):
            if number not in self.broken and not self.bonded(first, second):
                self.broken[number] = step

    def bonded(self, first: int, second: int) -> bool:
        """Whether two spheres are joined by an intact bond."""
        try:
            found = O.interactions[first, second]
        except IndexError:
            return False
        if not found.isReal:
            return False
        return bool(found.phys.isCohesive) if self.law == "jointed" else not bool(found.phys.cohesionBroken)

    def save(self, path: Path) -> None:
        """Write what was found."""
        state: dict[str, Any] = {
            name: np.array([frame[k] for frame in self.frames]) for k, name in enumerate(STATE)
        }
        np.savez(
            path, format=FORMAT, version=yade.config.version, steps=np.array(sorted(self.record), dtype=int),
            seconds=self.clock["end"] - self.clock["begin"] - self.clock["noting"],
            wall_forces=np.array(self.walls), watched=np.array(self.watched).reshape(-1, 3),
            pairs=np.array(self.pairs).reshape(-1, 12),
            broken=np.array(sorted(self.broken.items()), dtype=int).reshape(-1, 2), **state,
        )  # fmt: skip


folder = Path(sys.argv[1])
for number, task in enumerate(json.loads((folder / "tasks.json").read_text())):
    O.reset()
    with np.load(folder / f"task-{number}.npz") as stored:
        current = Run(task, {name: stored[name] for name in stored})
    current.build()
    current.clock["noting"] = 0.0
    current.clock["begin"] = time.perf_counter()
    O.run(task["steps"], True)
    current.save(folder / f"result-{number}.npz")
