"""What a case is once it has been read: frozen data in SI units, nothing left out and nothing to parse."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

METHODS = ("strength-reduction", "gravity-increase")
PACKINGS = ("random", "hexagonal")
SUPPORTS = ("free", "roller", "fixed")
LAWS = ("mohr_coulomb",)

Point = tuple[float, float]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Refinement:
    """A place where the particles lie closer: a whole material, or a box (exactly one of them).

    Attributes
    ----------
    spacing : float
        [m]
    material : str or None
    box : tuple of float or None
        Left, bottom, right, top [m].
    """

    spacing: float
    material: str | None = None
    box: tuple[float, float, float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class SectionOptions(ABC):
    """What every kind of section has.

    Attributes
    ----------
    layers : int
        Rows of triangles across the thinnest seam, at least 2.
    thin : str
        ``refine`` puts closer particles into a seam that is too thin for them, ``refuse`` stops with an
        error.
    refine : tuple of Refinement
    """

    layers: int = 2
    thin: str = "refine"
    refine: tuple[Refinement, ...] = ()

    key: ClassVar[str] = "regions"
    """The key of [section] that names its file, or "regions"."""

    @property
    @abstractmethod
    def materials(self) -> tuple[str, ...]:
        """Materials in order of first appearance."""

    @property
    @abstractmethod
    def bounds(self) -> tuple[float, float, float, float]:
        """Left, bottom, right, top [m]."""

    @property
    def file(self) -> Path | None:
        """What it is read from."""
        return None

    def beside(self) -> SectionOptions:
        """The same with its file named without a folder: as it stands in the folder of the results."""
        return self


@dataclass(frozen=True, eq=False)
class RegionSection(SectionOptions):
    """A section given by polygons; a later one lies over an earlier one.

    Attributes
    ----------
    regions : tuple of (str, ndarray)
        Material and corners (n, 2) [m], not closed, in the order given.
    """

    regions: tuple[tuple[str, Floats], ...]

    @property
    def materials(self) -> tuple[str, ...]:
        """Materials in order of first appearance."""
        return tuple(dict.fromkeys(material for material, _ in self.regions))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Left, bottom, right, top [m]."""
        corners = np.concatenate([polygon for _, polygon in self.regions])
        (left, bottom), (right, top) = corners.min(axis=0), corners.max(axis=0)
        return float(left), float(bottom), float(right), float(top)


@dataclass(frozen=True)
class ImageSection(SectionOptions):
    """A section given by a picture, one colour a material.

    Attributes
    ----------
    image : pathlib.Path
        Absolute.
    scale : float
        [m/px]
    legend : mapping of str to str
        Colour ``#rrggbb`` (lower case) to material.
    background : tuple of str
        Colours that are no ground; ``transparent`` may be one.
    y_axis : str
        ``up``: the picture shows the ground as it stands. ``down``: its first row is the lowest.
    origin : (float, float)
        Lower left corner of the ground's picture [m].
    pixels : (int, int)
        Width and height [px].
    """

    image: Path
    scale: float
    legend: Mapping[str, str]
    background: tuple[str, ...]
    y_axis: str
    origin: Point
    pixels: tuple[int, int]

    key: ClassVar[str] = "image"

    @property
    def file(self) -> Path:
        """The picture."""
        return self.image

    def beside(self) -> ImageSection:
        """The same with its picture named without a folder."""
        return replace(self, image=Path(self.image.name))

    @property
    def materials(self) -> tuple[str, ...]:
        """Materials in order of first appearance in the legend."""
        return tuple(dict.fromkeys(self.legend.values()))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Left, bottom, right, top of the picture [m]."""
        left, bottom = self.origin
        return left, bottom, left + self.pixels[0] * self.scale, bottom + self.pixels[1] * self.scale


@dataclass(frozen=True)
class Boundary:
    """How each side of the section is held: ``free``, ``roller`` (moves along the side) or ``fixed``."""

    left: str = "free"
    right: str = "free"
    bottom: str = "free"
    top: str = "free"


@dataclass(frozen=True)
class Surcharge:
    """A pressure [Pa] on the surface from `start` to `end` [m], positive onto the ground."""

    start: Point
    end: Point
    pressure: float


@dataclass(frozen=True)
class Loads:
    """Loads beside the weight.

    Attributes
    ----------
    horizontal_acceleration : float
        Pseudo-static, positive out of the slope [m/s2].
    surcharge : tuple of Surcharge
    """

    horizontal_acceleration: float = 0.0
    surcharge: tuple[Surcharge, ...] = ()


@dataclass(frozen=True)
class GroundMaterial:
    """Macroscopic properties of one material.

    Attributes
    ----------
    name : str
    law : str
        ``mohr_coulomb``.
    density : float
        [kg/m3]; unit weight / `geodem.units.GRAVITY` where the case gives a unit weight.
    cohesion : float
        [Pa]
    friction_angle, dilation_angle : float
        [rad]
    young_modulus : float
        [Pa]
    poisson_ratio : float
        [-]
    tensile_strength : float
        [Pa]; infinite for none, that is the full Mohr-Coulomb cone.
    dilation_given : bool
        False where the dilation angle was left out and taken equal to the friction angle.
    """

    name: str
    law: str
    density: float
    cohesion: float
    friction_angle: float
    dilation_angle: float
    young_modulus: float
    poisson_ratio: float
    tensile_strength: float = math.inf
    dilation_given: bool = True


@dataclass(frozen=True)
class Reference:
    """A published factor of safety that is shown beside the computed one, and where it stands."""

    factor: float
    source: str


@dataclass(frozen=True, eq=False)
class Case:
    """A validated case, SI units.

    Attributes
    ----------
    workflow : str
    title : str
    particles : int or None
        Number of particles asked for; None where `spacing` is given, or where the nodes of a mesh are the particles.
    spacing : float or None
        [m]
    packing : str
        ``random`` or ``hexagonal``.
    methods : tuple of str
        Of `METHODS`, in the order they are run.
    tolerance : float
        Width of [stable, failed] over the factor.
    seed : int
    section : a kind of SectionOptions
        Regions, a picture, a mesh or a terrain.
    boundary : Boundary
    loads : Loads
    materials : mapping of str to GroundMaterial
        In the order of the file, those that the section does not use included.
    reference : Reference or None
    allow_implausible : tuple of str
        Keys whose value is meant although it looks mistaken.
    notices : tuple of str
        Every default that was taken and every implausible value that was allowed, in words.
    questions : tuple of str
        Doubts that do not stop a run.
    text : str
        The file as it was read.
    """

    workflow: str
    title: str
    particles: int | None
    spacing: float | None
    packing: str
    methods: tuple[str, ...]
    tolerance: float
    seed: int
    section: SectionOptions
    boundary: Boundary
    loads: Loads
    materials: Mapping[str, GroundMaterial]
    reference: Reference | None = None
    allow_implausible: tuple[str, ...] = ()
    notices: tuple[str, ...] = ()
    questions: tuple[str, ...] = ()
    text: str = ""

    def as_run_text(self) -> str:
        """The case as it is run, as TOML: every default written out, lengths in metres.

        Reading it back gives the same numbers to the last bit.
        """
        from geodem.case.writing import as_run_text  # the writer needs the classes of this file

        return as_run_text(self)
