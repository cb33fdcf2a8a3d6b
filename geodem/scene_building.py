"""From bonded ground of a case to its scene: body, particles, faults, joints, bolts, linings, initial stress."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from .assembly import Wall
from .breaking.faults import with_band
from .breaking.scene import BondedScene, build_scene
from .breaking.structures import BoltPlan, JointPlan, LiningPlan
from .breaking.supports import SIDES
from .builders.body import Body
from .builders.body_filling import BodyFilling
from .builders.bolts import Bar, Grout
from .builders.joint_sets import JointScatter, joint_set_2d, joint_set_3d
from .builders.joints import Joint, dip_normal, disc, plane, polyline, segment
from .case.ground import GroundCase, GroundGrains
from .case.scene import BoltOptions, FacePlace, JointSetOptions, LiningOptions, SceneCase, StressOptions
from .case.scene_joints import law_parameters
from .errors import InputError
from .ground_building import GroundBody, fill, make_body
from .preparation.initial_stress import WantedStress, far_field, ground_stress
from .units import show

Floats = NDArray[np.float64]
_RING = 96
"""Corners of a round lining."""


def make_scene(
    case: SceneCase, *, title: str = "", allow_implausible: tuple[str, ...] = ()
) -> tuple[GroundBody, BondedScene]:
    """Body and scene of a case.

    Raises
    ------
    InputError, InputErrors
        A source that cannot be used; materials or particles that do not fit it; a joint, bolt or lining that misses
        the ground; an initial stress that nothing holds.
    """
    made, filling = make_filling(case, title=title, allow_implausible=allow_implausible)
    return made, scene_of(case, made.body, filling)


def make_filling(
    case: SceneCase, *, title: str = "", allow_implausible: tuple[str, ...] = ()
) -> tuple[GroundBody, BodyFilling]:
    """Body and particles of a case, faults included; raises as `make_scene`."""
    ground = GroundCase(
        title=title,
        source=case.source,
        particles=case.particles,
        materials={name: GroundGrains(name, material.density) for name, material in case.materials.items()},
        allow_implausible=allow_implausible,
    )
    made = make_body(ground, spare=tuple(fault.material for fault in case.faults))
    filling = fill(ground, made.body)
    for number, fault in enumerate(case.faults):
        place = f"fault[{number}]"
        joint = _joint(fault.place, made.body, place)
        filling = with_band(filling, joint, fault.thickness, fault.material, place=place)
    return made, filling


def scene_of(case: SceneCase, body: Body, filling: BodyFilling, *, walls: Sequence[Wall] = ()) -> BondedScene:
    """The scene of a case whose particles are there, with more walls than its sides have; raises as `make_scene`."""
    d = body.dimension
    joints = [
        JointPlan(one.name, [_joint(one.place, body, f"joint[{k}]")], law_parameters(one.parameters))
        for k, one in enumerate(case.joints)
    ]
    joints += [
        JointPlan(one.name, _joint_set(one, body, f"joint_set[{k}]"), law_parameters(one.parameters))
        for k, one in enumerate(case.joint_sets)
    ]
    bolts = [plan for k, one in enumerate(case.bolts) for plan in _bolts(one, d, f"bolt[{k}]")]
    return build_scene(
        body,
        filling,
        case.materials,
        supports={side: kind for side, kind in case.boundary.items() if side in SIDES[d]},
        gravity=_gravity(case.gravity, d),
        interfaces=case.interfaces,
        across=case.grain_bonds,
        seed=case.seed,
        walls=walls,
        joints=joints,
        bolts=bolts,
        linings=[_lining(one, d, f"lining[{k}]") for k, one in enumerate(case.linings)],
        initial_stress=None
        if case.initial_stress is None
        else _stress(case, case.initial_stress, body, filling),
    )


def _gravity(given: tuple[float, ...] | float, dimension: int) -> Floats | None:
    if isinstance(given, tuple):
        if len(given) != dimension:
            raise InputError("loads.gravity", f"the ground is {dimension}D", f"Give {dimension} components")
        return np.array(given)
    return np.array([0.0] * (dimension - 1) + [-given])


def _joint(place: FacePlace, body: Body, where: str) -> Joint:
    """One joint; its material is named later."""
    d = body.dimension
    if place.points:
        _refuse_dimension(place.points[0], d, f"{where}.points")
        return polyline(np.array(place.points), "joint")
    assert place.centre is not None
    _refuse_dimension(place.centre, d, f"{where}.centre")
    middle = np.array(place.centre)
    if d == 2:
        if place.angle is None:
            raise InputError(f"{where}.angle", "missing: the ground is 2D", 'Write angle = "35 deg"')
        along = np.array([math.cos(place.angle), math.sin(place.angle)])
        if math.isinf(place.radius):
            return plane(middle, [-along[1], along[0]], body.bounds, "joint")
        return segment(middle - place.radius * along, middle + place.radius * along, "joint")
    if place.dip is None or place.dip_direction is None:
        raise InputError(f"{where}.dip", "missing: the ground is 3D", "Give dip and dip_direction")
    normal = dip_normal(place.dip, place.dip_direction)
    if math.isinf(place.radius):
        return plane(middle, normal, body.bounds, "joint")
    return disc(middle, normal, place.radius, "joint")


def _joint_set(one: JointSetOptions, body: Body, place: str) -> list[Joint]:
    scatter = JointScatter(one.seed, one.angle_scatter, one.spacing_scatter, one.trace_scatter)
    bounds = np.asarray(body.bounds)
    # the middle of the ground where nothing is said: joints lie evenly in it
    origin = 0.5 * (bounds[0] + bounds[1]) if one.origin is None else np.array(one.origin)
    _refuse_dimension(tuple(origin), body.dimension, f"{place}.origin")
    if body.dimension == 2:
        if one.angle is None:
            raise InputError(f"{place}.angle", "missing: the ground is 2D", 'Write angle = "35 deg"')
        make = partial(joint_set_2d, angle=one.angle)
    elif one.dip is None or one.dip_direction is None:
        raise InputError(f"{place}.dip", "missing: the ground is 3D", "Give dip and dip_direction")
    else:
        make = partial(joint_set_3d, dip=one.dip, dip_direction=one.dip_direction)
    try:
        return make(
            bounds, "joint", spacing=one.spacing, trace=one.trace, gap=one.gap, origin=origin, scatter=scatter
        )
    except InputError as error:
        shown = show(one.spacing, "length")
        raise InputError(f"{place}.spacing", error.problem, error.remedy, value=shown) from error


def _bolts(one: BoltOptions, dimension: int, where: str) -> list[BoltPlan]:
    """A row of bolts; in 2D each number over the distance out of the plane."""
    _refuse_dimension(one.head, dimension, f"{where}.from")
    share = 1.0 / one.out_of_plane if dimension == 2 else 1.0
    bar = Bar(
        axial_stiffness=share * one.axial_stiffness, yield_force=share * one.yield_force, elongation=one.elongation,
        density_per_length=share * one.density_per_length, pretension=share * one.pretension,
    )  # fmt: skip
    grout = Grout(share * one.grout_stiffness, share * one.grout_strength)
    step = np.zeros(dimension) if one.step is None else np.array(one.step)
    return [
        BoltPlan(
            one.name if one.count == 1 else f"{one.name} {k + 1}", np.array(one.head) + k * step,
            np.array(one.end) + k * step, bar, grout, plate=one.plate,
        )
        for k in range(one.count)
    ]  # fmt: skip


def _lining(one: LiningOptions, dimension: int, where: str) -> LiningPlan:
    if dimension != 2:
        raise InputError(where, "linings are there in 2D alone", "Remove it")
    if one.centre is not None and one.radius is not None:
        turn = 2.0 * math.pi * np.arange(_RING) / _RING
        points = np.array(one.centre) + one.radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    else:
        points = np.array(one.points)
    return LiningPlan(
        one.name, points, axial_stiffness=one.young_modulus * one.thickness,
        bending_stiffness=one.young_modulus * one.thickness**3 / 12.0,
        density_per_length=one.density * one.thickness, closed=one.closed,
    )  # fmt: skip


def _stress(case: SceneCase, given: StressOptions, body: Body, filling: BodyFilling) -> WantedStress:
    d = body.dimension
    if given.k0:
        weight = given.unit_weight
        if weight is None:
            weight = mean_unit_weight(case, filling, d)
        top = float(body.bounds[1][-1]) if given.surface is None else given.surface
        k0 = given.k0[0] if len(given.k0) == 1 else (given.k0[0], given.k0[1])
        return ground_stress(d, unit_weight=weight, k0=k0, top=top)
    tensor = np.zeros((d, d))
    for key, value in given.components.items():
        axes = ["xyz".index(letter) for letter in key]
        if max(axes) >= d:
            raise InputError(f"initial_stress.{key}", "the ground is 2D", "Remove it")
        tensor[axes[0], axes[-1]] = tensor[axes[-1], axes[0]] = -value
    if d == 3 and "z" not in given.components:
        raise InputError("initial_stress.z", "missing: the ground is 3D", 'Write z = "5 MPa"')
    return far_field(tensor)


def mean_unit_weight(case: SceneCase, filling: BodyFilling, dimension: int) -> float:
    """Weight of all the ground over its volume [N/m3]."""
    gravity = _gravity(case.gravity, dimension)
    assert gravity is not None
    densities: Mapping[str, float] = {name: m.density for name, m in case.materials.items()}
    mass = sum(densities[name] * size for name, size in zip(filling.materials, filling.sources, strict=True))
    return float(mass / filling.sources.sum() * abs(gravity[-1]))


def _refuse_dimension(point: tuple[float, ...], dimension: int, where: str) -> None:
    if len(point) != dimension:
        raise InputError(
            where, f"the ground is {dimension}D", f"Give {dimension} coordinates a point", value=list(point)
        )


def quick_particles(case: SceneCase, count: int) -> SceneCase:
    """The case with about `count` particles, for a first look; one whose sizes are given otherwise stays as it is."""
    options = case.particles
    if options.arrangement == "pixel" or options.grading is not None:
        return case
    return replace(case, particles=replace(options, particles=count, radius=None))
