"""Bonded ground as a case says it: source, particles, materials, sides, joints, bolts, linings, initial stress; SI."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from geodem.breaking.materials import Interface, SceneMaterial
from geodem.case.ground import GroundSource, ParticleOptions

Place = tuple[float, ...]


@dataclass(frozen=True)
class FacePlace:
    """Where a joint or a fault runs.

    Attributes
    ----------
    points : tuple of points [m]
        Corners of a line, 2D; empty where the centre is given.
    centre : point or None [m]
    radius : float
        Half the length in 2D, of the disc in 3D [m]; infinite: through the whole ground.
    angle : float or None
        Above the x axis, counter-clockwise, 2D [rad].
    dip, dip_direction : float or None
        3D, see `geodem.builders.joints.dip_normal` [rad].
    """

    points: tuple[Place, ...] = ()
    centre: Place | None = None
    radius: float = math.inf
    angle: float | None = None
    dip: float | None = None
    dip_direction: float | None = None


@dataclass(frozen=True)
class JointOptions:
    """One joint: its place and its parameters, keys of `geodem.case.scene_joints.PROPERTIES`, angles [rad]."""

    name: str
    place: FacePlace
    parameters: Mapping[str, float]


@dataclass(frozen=True)
class JointSetOptions:
    """Parallel joints, as of `geodem.builders.joint_sets`; angles [rad], lengths [m], scatter [rad] and [-]."""

    name: str
    spacing: float
    parameters: Mapping[str, float]
    angle: float | None = None
    dip: float | None = None
    dip_direction: float | None = None
    trace: float = math.inf
    gap: float = 0.0
    origin: Place | None = None
    seed: int = 1
    angle_scatter: float = 0.0
    spacing_scatter: float = 0.0
    trace_scatter: float = 0.0


@dataclass(frozen=True)
class FaultOptions:
    """A band of another material along a joint's place; the particles in it belong to that material."""

    material: str
    thickness: float
    place: FacePlace


@dataclass(frozen=True)
class BoltOptions:
    """A row of bolts.

    Attributes
    ----------
    name : str
    head, end : points [m]
        Of the first one.
    step : point [m]
        From one to the next.
    count : int
    out_of_plane : float
        Distance between bolts out of the plane, 2D [m].
    axial_stiffness, yield_force, pretension : float
        Of one bolt [N].
    elongation : float
        At break [-].
    density_per_length : float
        [kg/m]
    grout_stiffness : float
        Of one bolt [N/m2].
    grout_strength : float
        [N/m]
    plate : bool
    """

    name: str
    head: Place
    end: Place
    axial_stiffness: float
    grout_stiffness: float
    step: Place | None = None
    count: int = 1
    out_of_plane: float = 1.0
    yield_force: float = math.inf
    pretension: float = 0.0
    elongation: float = math.inf
    density_per_length: float = 4.0
    grout_strength: float = math.inf
    plate: bool = False


@dataclass(frozen=True)
class LiningOptions:
    """A lining, 2D: its middle line or ring, its thickness [m], modulus [Pa] and density [kg/m3]."""

    name: str
    thickness: float
    young_modulus: float
    density: float = 2500.0
    points: tuple[Place, ...] = ()
    closed: bool = False
    centre: Place | None = None
    radius: float | None = None


@dataclass(frozen=True)
class StressOptions:
    """Stress before anything is done.

    Attributes
    ----------
    k0 : tuple of float
        Horizontal over vertical stress, one or two [-]; empty where components are given.
    unit_weight : float or None
        Of the ground above [N/m3]; that of the case's ground where it is left out.
    surface : float or None
        Height of the surface [m]; the top of the ground where it is left out.
    components : mapping of str to float
        "x", "y", "z", "xy", "xz", "yz" [Pa], pressure positive.
    """

    k0: tuple[float, ...] = ()
    unit_weight: float | None = None
    surface: float | None = None
    components: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class SceneCase:
    """Bonded ground.

    Attributes
    ----------
    source : GroundSource
    particles : ParticleOptions
    materials : mapping of str to SceneMaterial
    boundary : mapping of str to str
        Support by side, see `geodem.breaking.supports`; "front" and "back" belong to 3D alone.
    gravity : tuple of float or float
        A vector, or the value of one downwards [m/s2].
    grain_bonds : float
        Factor on the strength of bonds between grains or blocks of the source [-].
    seed : int
        Of the scatter of strength.
    interfaces, joints, joint_sets, faults, bolts, linings : tuples
    initial_stress : StressOptions or None
    """

    source: GroundSource
    particles: ParticleOptions
    materials: Mapping[str, SceneMaterial]
    boundary: Mapping[str, str]
    gravity: tuple[float, ...] | float
    grain_bonds: float = 1.0
    seed: int = 1
    interfaces: tuple[Interface, ...] = ()
    joints: tuple[JointOptions, ...] = ()
    joint_sets: tuple[JointSetOptions, ...] = ()
    faults: tuple[FaultOptions, ...] = ()
    bolts: tuple[BoltOptions, ...] = ()
    linings: tuple[LiningOptions, ...] = ()
    initial_stress: StressOptions | None = None

    def beside(self) -> tuple[SceneCase, dict[str, Path]]:
        """The same with the files of its source in a folder ``source`` beside it, and where each comes from."""
        source, copies = self.source.beside()
        return replace(self, source=source), copies
