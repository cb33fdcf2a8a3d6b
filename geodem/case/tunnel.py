"""What a tunnel case is once it has been read: frozen data in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import shapely

from geodem.case.data import GroundMaterial, Point, SectionOptions, Surcharge
from geodem.tunnelling.plan import Bolts, DepthStress, Lining, Opening, Plan, Stage, UniformStress

CORNERS = 360
"""Corners of a circle: its area is 0.005 % short."""


@dataclass(frozen=True)
class Excavation:
    """One opening as the case draws it.

    Attributes
    ----------
    name : str
    shape : str
        ``circle`` (centre; diameter), ``horseshoe`` (middle of its floor; width, height: straight walls under half a
        circle) or ``polygon``.
    at : (x, y) [m]
        Centre or middle of the floor.
    sizes : tuple of float [m]
        Diameter, or width and height.
    corners : tuple of (x, y) [m]
        Of a polygon.
    """

    name: str
    shape: str
    at: Point = (0.0, 0.0)
    sizes: tuple[float, ...] = ()
    corners: tuple[Point, ...] = ()

    def opening(self) -> Opening:
        """Its outline and centre."""
        if self.shape == "polygon":
            polygon = shapely.Polygon(self.corners)
            middle = polygon.centroid
            return Opening(self.name, polygon, (float(middle.x), float(middle.y)))
        x, y = self.at
        if self.shape == "circle":
            return Opening(self.name, _arc(x, y, 0.5 * self.sizes[0], 0.0, 2.0 * np.pi, CORNERS), self.at)
        width, height = self.sizes
        roof = _arc(x, y + height - 0.5 * width, 0.5 * width, 0.0, np.pi, CORNERS // 2 + 1)
        floor = [(x - 0.5 * width, y), (x + 0.5 * width, y)]
        arch = list(roof.exterior.coords)[:-1]
        outline = shapely.Polygon([*arch, *floor]) if height > 0.5 * width else roof
        return Opening(self.name, outline, (x, y + 0.5 * height))


def _arc(x: float, y: float, radius: float, start: float, end: float, corners: int) -> shapely.Polygon:
    angle = np.linspace(start, end, corners, endpoint=end - start < 6.0)
    # the cosine of a right angle is not quite zero, and a corner so near to a line of symmetry makes a sliver
    unit = np.round(np.stack([np.cos(angle), np.sin(angle)], axis=1), 15)
    return shapely.Polygon(np.array([x, y]) + radius * unit)


@dataclass(frozen=True)
class BoltPattern:
    """Bolts as the case gives them: lengths and numbers of one bolt, and where they are.

    Attributes
    ----------
    name : str
    excavation : str or None
        Whose wall the heads are on, where `angles` are given.
    angles : tuple of float [rad]
        Directions from the opening's centre, from the horizontal on the right, anticlockwise.
    length : float [m]
    bars : tuple of (start, end) [m]
        Instead of angles; the start is the head.
    diameter, young_modulus, yield_force, spacing : float
        [m], [Pa], [N], [m] along the tunnel
    anchored : bool
    grout_stiffness, grout_strength : float
        [N/m2], [N/m]
    """

    name: str
    excavation: str | None
    angles: tuple[float, ...]
    length: float
    bars: tuple[tuple[Point, Point], ...]
    diameter: float
    young_modulus: float
    yield_force: float
    spacing: float
    anchored: bool
    grout_stiffness: float
    grout_strength: float

    def bolts(self, openings: Mapping[str, Opening]) -> Bolts:
        """The bolts with their heads on the wall."""
        bars = list(self.bars)
        if self.excavation is not None:
            opening = openings[self.excavation]
            bars += [_radial(opening, angle, self.length) for angle in self.angles]
        return Bolts(
            name=self.name,
            bars=tuple(bars),
            area=0.25 * np.pi * self.diameter**2,
            young_modulus=self.young_modulus,
            yield_force=self.yield_force,
            spacing=self.spacing,
            grout_stiffness=self.grout_stiffness,
            grout_strength=self.grout_strength,
            anchored=self.anchored,
        )


def _radial(opening: Opening, angle: float, length: float) -> tuple[Point, Point]:
    """A bolt along a ray from the centre: from the last point of the outline on it outwards."""
    centre, direction = np.asarray(opening.centre), np.array([np.cos(angle), np.sin(angle)])
    reach = 2.0 * float(np.hypot(*np.ptp(np.asarray(opening.polygon.exterior.coords), axis=0)))
    ray = shapely.LineString([centre, centre + reach * direction])
    met = shapely.get_coordinates(shapely.intersection(ray, opening.polygon.exterior))
    head = centre + max(float((point - centre) @ direction) for point in met) * direction
    tip = head + length * direction
    return (float(head[0]), float(head[1])), (float(tip[0]), float(tip[1]))


@dataclass(frozen=True, eq=False)
class TunnelCase:
    """A validated tunnel case.

    Attributes
    ----------
    title : str
    particles : int or None
    spacing, wall_spacing : float or None [m]
    seed : int
    increments : int
        In which all of the kept forces are relaxed.
    ground_reaction : bool
        The same digging without supports is run beside it.
    section : a kind of SectionOptions
    boundary : mapping of side to "free", "roller", "fixed" or "far"
    surcharge : tuple of Surcharge
    initial : UniformStress or DepthStress
    excavations, linings, bolts, stages : tuples
    methods : tuple of str
        Of `geodem.tunnelling.collapse.METHODS`, may be empty.
    tolerance : float
    materials : mapping of str to GroundMaterial
    """

    title: str
    particles: int | None
    spacing: float | None
    wall_spacing: float | None
    seed: int
    increments: int
    ground_reaction: bool
    section: SectionOptions
    boundary: Mapping[str, str]
    surcharge: tuple[Surcharge, ...]
    initial: UniformStress | DepthStress
    excavations: tuple[Excavation, ...]
    linings: tuple[Lining, ...]
    bolts: tuple[BoltPattern, ...]
    stages: tuple[Stage, ...]
    methods: tuple[str, ...]
    tolerance: float
    materials: Mapping[str, GroundMaterial]
    allow_implausible: tuple[str, ...] = field(default=())
    notices: tuple[str, ...] = field(default=())
    questions: tuple[str, ...] = field(default=())
    text: str = ""
    workflow: str = "tunnel"

    def plan(self) -> Plan:
        """What is dug and built, in SI."""
        openings = tuple(entry.opening() for entry in self.excavations)
        by_name = {opening.name: opening for opening in openings}
        bolts = tuple(pattern.bolts(by_name) for pattern in self.bolts)
        return Plan(openings, self.initial, self.stages, self.linings, bolts)

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default written out."""
        # the writer needs the classes of this file
        from geodem.case.tunnel_writing import tunnel_text

        return tunnel_text(self)

    def beside(self) -> tuple[TunnelCase, dict[str, Path]]:
        """The case with the file of its section as it stands in the folder of the results, and where it comes from."""
        if self.section.file is None:
            return self, {}
        return replace(self, section=self.section.beside()), {self.section.file.name: self.section.file}
