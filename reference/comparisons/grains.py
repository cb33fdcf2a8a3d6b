"""Grains that settle and flow in three codes: their laws, and what is measured of them at rest.

The springs and the friction are the same in all codes, and so are those of the walls. How energy is lost is not: YADE's
contact of this law has no dashpots, LIGGGHTS has no local damping. So geodem runs with local damping beside YADE, and
with dashpots in the contacts beside LIGGGHTS, in its own convention both times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.measure.fabric import coordination_number, fabric_tensor
from geodem.preparation.sample import mechanical_coordination

from ..backends import BACKENDS
from ..ours_posed import run_posed
from ..posed import Floats, Posed, Trajectory

DIAMETER = 0.01  # mean [m]
SPREAD = 0.2  # of the radii: from 0.8 to 1.2 times the mean, all equally frequent
DENSITY = 2500.0  # [kg/m3]
GRAVITY = 9.81  # [m/s2]
MASS = DENSITY * math.pi / 6.0 * DIAMETER**3  # of a grain of the mean diameter [kg]
UNIT_TIME = math.sqrt(DIAMETER / GRAVITY)  # [s]
STIFFNESS = 3000.0
"""kn d/(m g): forty grains deep, contacts overlap by less than a per cent in the mean."""
NORMAL = STIFFNESS * MASS * GRAVITY / DIAMETER  # [N/m]
FRICTION = 0.5
RESTITUTION = 0.3  # of two mean grains with dashpots
LOCAL_DAMPING = 0.2
TIME_STEP = 0.2 * math.sqrt(MASS / NORMAL)  # [s]
SMOOTH = {"friction_coefficient": 0.0}
AT_REST = 2e-3
"""Kinetic energy of a grain at the end over m g d, at most."""
FAST = 0.05
"""Share of the grains, the fastest, that may still bounce and roll where the heap is at rest."""
LEAST_CONTACTS = 3
"""Grains with fewer carry nothing."""
LAYERS = 5
WARM_UP = 400  # steps

LAWS = {"yade": "linear_frictional", "liggghts": "hooke_stiffness"}


def said(code: str, local_damping: float = LOCAL_DAMPING) -> str:
    """How energy is lost beside a code."""
    return f"local damping {local_damping:g}" if code == "yade" else f"dashpots, restitution {RESTITUTION:g}"


def contact_of(code: str, friction: float = FRICTION) -> dict[str, float]:
    """Parameters of the law that stands beside a code."""
    contact = {
        "normal_stiffness": NORMAL,
        "shear_stiffness": 2.0 / 7.0 * NORMAL,
        "friction_coefficient": friction,
    }
    if LAWS[code] == "hooke_stiffness":
        loss = -math.log(RESTITUTION)
        damping = 2.0 * loss / math.hypot(math.pi, loss) * math.sqrt(NORMAL / (0.5 * MASS))
        contact |= {"normal_damping": damping, "shear_damping": 0.5 * damping}
    return contact


def builder_of(code: str, friction: float = FRICTION) -> AssemblyBuilder:
    """A builder with the material "grain" of the law that stands beside a code."""
    made = AssemblyBuilder(3, LAWS[code], gravity=(0.0, 0.0, -GRAVITY))
    made.add_material("grain", density=DENSITY, contact=contact_of(code, friction))
    return made


def posed_for(
    name: str, code: str, assembly: Any, duration: float, frames: int, local_damping: float = LOCAL_DAMPING
) -> Posed:
    """A scene in the other code's terms; `duration` in `UNIT_TIME`."""
    every = max(1, math.ceil(duration * UNIT_TIME / TIME_STEP / frames))
    return Posed(
        name=f"{name}, {said(code, local_damping)}", assembly=assembly, time_step=TIME_STEP, steps=every * frames,
        first=every, every=every, pairs_at=(every * frames,), convention=code,
        local_damping=local_damping if code == "yade" else 0.0,
    )  # fmt: skip


def run(code: str, posed: Posed) -> Trajectory:
    """One code's run of a scene, geodem's in its own convention."""
    if code == "geodem":
        own = replace(posed, convention="geodem")
        # all kernels are compiled before anything is timed, those that look for neighbours anew as well
        few = min(own.steps, WARM_UP)
        run_posed([replace(own, steps=few, first=few, every=few, pairs_at=())])
        return run_posed([own])[0]
    found: Trajectory = BACKENDS[code].run_posed([posed])[0]
    return found


@dataclass(frozen=True)
class AtRest:
    """The last frame of a run.

    Attributes
    ----------
    positions : (n, 3) [m]
        Of the grains that may move.
    radii, mass : (n,) [m], [kg]
    numbers : dict of float
        Coordination, forces, directions of the contacts.
    forces : (k,) [-]
        Normal forces between grains, over their mean in one of five layers with as many contacts each.
    kinetic : float
        Mean kinetic energy of a grain over m g d, the fastest twentieth left out [-].
    overlap : float
        Mean over the mean diameter [-].
    """

    positions: Floats
    radii: Floats
    mass: Floats
    numbers: dict[str, float]
    forces: Floats
    kinetic: float
    overlap: float


def at_rest(posed: Posed, run: Trajectory, fixed: int = 0) -> AtRest:
    """What the last frame tells; the first `fixed` particles are held."""
    a = posed.assembly
    if run.pair_forces is None:
        raise ValueError(f"{posed.name}: {run.code} tells no forces between pairs")
    found = run.pair_forces.of_frame(len(posed.frames) - 1)
    pressing = -(found.normal * found.along).sum(axis=1)
    moving = (found.pairs >= fixed).all(axis=1) & (pressing > 0.0)
    pairs, force, along = found.pairs[moving] - fixed, pressing[moving], found.along[moving]
    on_floor = found.pairs[(found.pairs < fixed).any(axis=1) & (pressing > 0.0)].max(axis=1) - fixed
    positions, radii, mass = run.positions[-1][fixed:], a.radii[fixed:], a.mass[fixed:]
    on_walls = [on_floor]
    for wall in a.walls:
        for point, normal in wall.planes:
            on_walls.append(np.flatnonzero((positions - point) @ normal < radii))
    forces = over_mean_of_layers(force, positions[pairs, 2].mean(axis=1))
    carried = np.concatenate(on_walls).astype(np.int64)
    energy = 0.5 * mass * (run.velocities[-1][fixed:] ** 2).sum(axis=1)
    energy += 0.5 * a.inertia[fixed:] * (run.spins[-1][fixed:] ** 2).sum(axis=1)
    slow = np.sort(energy)[: math.ceil((1.0 - FAST) * len(energy))]
    return AtRest(
        positions=positions, radii=radii, mass=mass,
        numbers={
            "coordination number": coordination_number(pairs, len(radii)),
            "coordination number without rattlers": mechanical_coordination(
                pairs, carried, len(radii), LEAST_CONTACTS
            ),
            "share of the contacts with more than twice the mean force": float((forces > 2.0).mean()),
            "decay of the tail of the forces": tail(forces),
            "fabric along gravity": float(fabric_tensor(along)[2, 2]),
        },
        forces=forces,
        kinetic=float(slow.mean()) / (MASS * GRAVITY * DIAMETER),
        overlap=float(force.mean()) / NORMAL / DIAMETER,
    )  # fmt: skip


def over_mean_of_layers(force: Floats, height: Floats) -> Floats:
    """Forces over the mean in their layer, of `LAYERS` with as many contacts each: what lies above presses on all."""
    order = np.argsort(height, kind="stable")
    scaled = np.empty(len(force))
    for layer in np.array_split(order, LAYERS):
        if len(layer):
            scaled[layer] = force[layer] / force[layer].mean()
    return scaled


def tail(forces: Floats) -> float:
    """b of a distribution that falls as exp(-b f) where f is above the mean, most likely [-]; nan without any."""
    above = forces[forces > 1.0]
    return 1.0 / float((above - 1.0).mean()) if len(above) else math.nan


def seconds_of(ours: list[Trajectory], theirs: list[Trajectory]) -> tuple[str, float]:
    """Of the steps of all runs, in words, and their ratio."""
    own, other = (sum(one.loop_seconds for one in runs) for runs in (ours, theirs))
    return f"seconds of all steps, {own:.1f} in geodem and {other:.1f}, one over the other", own / other
