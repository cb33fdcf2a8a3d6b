"""Joints, bolts and linings of a scene, as plans: what is built when the ground is there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..builders.assembly_builder import AssemblyBuilder
from ..builders.body import OUTSIDE, Body
from ..builders.bolts import Bar, Bolt, Grout, add_bolt, add_lining
from ..builders.joints import Joint, clipped
from ..errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

JOINT_LAW = "smooth_joint"
"""Law of joints: the one whose numbers are those of the joint, whatever the particles."""


@dataclass(frozen=True, eq=False)
class JointPlan:
    """One joint, or the joints of one set.

    Attributes
    ----------
    name : str
    joints : sequence of Joint
        Their material is replaced by `name`.
    parameters : dict of str to float
        Of the law `smooth_joint`, SI.
    """

    name: str
    joints: Sequence[Joint]
    parameters: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class BoltPlan:
    """One bolt.

    Attributes
    ----------
    name : str
    head, end : (d,) [m]
    bar : Bar
    grout : Grout
    spacing : float, optional
        Of its particles [m]; the mean diameter of those of the ground where it is left out.
    grouted : (float, float)
        From where to where, from the head [m].
    plate : bool
    """

    name: str
    head: Floats
    end: Floats
    bar: Bar
    grout: Grout
    spacing: float | None = None
    grouted: tuple[float, float] = (0.0, math.inf)
    plate: bool = False


@dataclass(frozen=True, eq=False)
class LiningPlan:
    """A lining along a line.

    Attributes
    ----------
    name : str
    points : (k, d) [m]
        Its middle line.
    axial_stiffness : float
        EA [N] (2D: N per m).
    bending_stiffness : float
        EI [N m2] (2D: per m).
    density_per_length : float
        [kg/m]
    closed : bool
    """

    name: str
    points: Floats
    axial_stiffness: float
    bending_stiffness: float
    density_per_length: float
    closed: bool = False


class JointFacts(NamedTuple):
    """What became of a joint or a set.

    Attributes
    ----------
    joints : int
        That meet the ground.
    size : float
        Of all faces in the ground's box [m2] (2D: length [m]).
    pairs : int
        Of particles that they cross.
    bonded : int
        Of these, those bonded across at the start.
    traces : (k, 2, 2) [m]
        Ends of segments, 2D only.
    faces : tuple of (centre, normal, radius)
        Of discs, 3D only.
    """

    joints: int
    size: float
    pairs: int
    bonded: int
    traces: Floats
    faces: tuple[tuple[Floats, Floats, float], ...] = ()


@dataclass(frozen=True, eq=False)
class Structures:
    """What was built.

    Attributes
    ----------
    joints : dict of str to JointFacts
    bolts : dict of str to Bolt
    linings : dict of str to (n,) int64
        Particles.
    """

    joints: dict[str, JointFacts] = field(default_factory=dict)
    bolts: dict[str, Bolt] = field(default_factory=dict)
    linings: dict[str, Integers] = field(default_factory=dict)


def cut_joints(build: AssemblyBuilder, plans: Sequence[JointPlan], bounds: Floats) -> dict[str, JointFacts]:
    """Cut all joints through bonded ground at once.

    Raises
    ------
    InputError
        A joint that passes by the ground, or crosses no pair of particles.
    """
    own: list[Joint] = []
    kept: list[list[Joint]] = []
    for plan in plans:
        build.add_joint_material(plan.name, law=JOINT_LAW, **plan.parameters)
        inside = [part for joint in plan.joints if (part := clipped(joint, bounds)) is not None]
        if not inside:
            raise InputError(
                f"joint {plan.name!r}",
                "it passes by the ground",
                f"The ground is {_box_text(bounds)}: move it",
            )
        named = [Joint(plan.name, joint.centres, joint.normals, joint.radii) for joint in inside]
        kept.append(named)
        own += named
    if not own:
        return {}
    cut = build.cut(own, within=1.05)
    found: dict[str, JointFacts] = {}
    first = 0
    for plan, joints in zip(plans, kept, strict=True):
        mine = (cut.joint >= first) & (cut.joint < first + len(joints))
        first += len(joints)
        if not mine.any():
            raise InputError(
                f"joint {plan.name!r}", "it lies between particles and crosses none of their contacts",
                "Make it longer, or take smaller particles",
            )  # fmt: skip
        strong = plan.parameters.get("tensile_strength", 0.0) > 0.0 or (
            plan.parameters.get("cohesion", 0.0) > plan.parameters.get("residual_cohesion", 0.0)
        )
        bonded = int((cut.areas[mine] > 0.0).sum()) if strong else 0
        size = float(sum(joint.area for joint in joints))
        found[plan.name] = JointFacts(
            len(joints), size, int(mine.sum()), bonded, traces(joints), _discs(joints)
        )
    return found


def _discs(joints: Sequence[Joint]) -> tuple[tuple[Floats, Floats, float], ...]:
    return tuple(
        (centre, normal, float(radius))
        for joint in joints
        if joint.dimension == 3
        for centre, normal, radius in zip(joint.centres, joint.normals, joint.radii, strict=True)
    )


def traces(joints: Sequence[Joint]) -> Floats:
    """Ends (k, 2, 2) [m] of the segments of joints in 2D; none in 3D."""
    flat = [joint for joint in joints if joint.dimension == 2]
    if not flat:
        return np.empty((0, 2, 2))
    ends = []
    for joint in flat:
        along = np.stack([joint.normals[:, 1], -joint.normals[:, 0]], axis=1) * joint.radii[:, None]
        ends.append(np.stack([joint.centres - along, joint.centres + along], axis=1))
    return np.concatenate(ends)


def add_bolts(
    build: AssemblyBuilder, plans: Sequence[BoltPlan], body: Body, spacing: float
) -> dict[str, Bolt]:
    """Set all bolts; the ground is bonded and cut.

    Parameters
    ----------
    spacing : float
        Of a bolt's particles where its plan gives none [m].

    Raises
    ------
    InputError
        A bolt that misses the ground.
    """
    found: dict[str, Bolt] = {}
    for plan in plans:
        head, end = np.asarray(plan.head, dtype=float), np.asarray(plan.end, dtype=float)
        along = np.linspace(0.0, 1.0, 101)[:, None]
        inside = np.asarray(body.material_at(head + along * (end - head))) != OUTSIDE
        if inside.mean() < 0.5:
            where = "misses the ground" if not inside.any() else "is more than half outside the ground"
            raise InputError(
                f"bolt {plan.name!r}", f"it {where}",
                f"The ground is {_box_text(body.bounds)}: give head and end in it",
                value=[head.tolist(), end.tolist()],
            )  # fmt: skip
        length = float(np.linalg.norm(end - head))
        found[plan.name] = add_bolt(
            build, plan.name, head, end, plan.bar, plan.grout, plate=plan.plate, grouted=plan.grouted,
            spacing=min(plan.spacing or spacing, length),
        )  # fmt: skip
    return found


def add_linings(
    build: AssemblyBuilder, plans: Sequence[LiningPlan], contact: Mapping[str, float], diameter: float
) -> dict[str, Integers]:
    """Set all linings.

    Parameters
    ----------
    contact : dict
        Of the law of contacts, with themselves.
    diameter : float
        Mean one of the ground [m].

    Raises
    ------
    InputError
        A lining that is not along anything: no particle of the ground near it; or one that goes through the ground.
    """
    found: dict[str, Integers] = {}
    for plan in plans:
        _, places, radii = build.solid()
        found[plan.name] = add_lining(
            build, plan.name, plan.points, axial_stiffness=plan.axial_stiffness,
            bending_stiffness=plan.bending_stiffness, density_per_length=plan.density_per_length,
            contact=dict(contact), closed=plan.closed,
        )  # fmt: skip
        _, all_places, all_radii = build.solid()
        _check_lining(plan.name, all_places[len(places) :], all_radii[len(radii) :], places, radii, diameter)
    return found


def _check_lining(
    name: str, own: Floats, thick: Floats, places: Floats, radii: Floats, diameter: float
) -> None:
    from scipy.spatial import cKDTree

    gap, nearest = cKDTree(places).query(own)
    gap = gap - thick - radii[nearest]
    if gap.min() > 2.0 * diameter:
        raise InputError(
            f"lining {name!r}", f"no ground is near it: the nearest is {gap.min():.3g} m away",
            "A lining lies along a free face of the ground: move its points there",
        )  # fmt: skip
    deep = int((gap < -0.5 * np.minimum(thick, radii[nearest])).sum())
    if deep:
        raise InputError(
            f"lining {name!r}", f"{deep} of its {len(own)} particles lie in the ground",
            "Excavate first, or move its points half a thickness and a particle off the face",
        )  # fmt: skip


def _box_text(bounds: Floats) -> str:
    names = "xyz" if len(bounds[0]) == 3 else "xy"
    return ", ".join(
        f"{axis} from {low:g} to {high:g} m"
        for axis, low, high in zip(names, *np.asarray(bounds), strict=True)
    )
