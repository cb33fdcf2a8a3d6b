"""What is dug and built, in which order: plain data."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

METHODS = ("strength-reduction", "load-increase", "gravity-increase")
"""Searches for a factor, see `geodem.tunnelling.collapse`."""
INCREMENTS = 20
"""Increments in which all of the kept forces are relaxed."""

Floats = NDArray[np.float64]
Point = tuple[float, float]


@dataclass(frozen=True)
class Opening:
    """Ground that is to be dug out.

    Attributes
    ----------
    name : str
    polygon : shapely.Polygon
        Outline [m].
    centre : (x, y) [m]
        What radii are measured from.
    """

    name: str
    polygon: Any
    centre: Point


@dataclass(frozen=True)
class UniformStress:
    """The same stress everywhere, compression positive [Pa]; the ground's weight is left out."""

    horizontal: float
    vertical: float
    shear: float = 0.0


@dataclass(frozen=True)
class DepthStress:
    """Vertical stress of the weight above and of the surcharges, horizontal stress K0 times that.

    Attributes
    ----------
    k0 : float
        Horizontal over vertical stress, total stresses [-].
    """

    k0: float


@dataclass(frozen=True)
class Lining:
    """An elastic ring or arch on the wall of an opening, joined to the ground without slip.

    Attributes
    ----------
    name : str
    opening : str
    thickness : float [m]
    young_modulus : float [Pa]
    poisson_ratio : float
        Plane strain: E / (1 - nu^2) resists.
    compressive_strength, tensile_strength : float [Pa]
        What the outermost fibre is compared with; the lining stays elastic.
    """

    name: str
    opening: str
    thickness: float
    young_modulus: float
    poisson_ratio: float = 0.2
    compressive_strength: float = math.inf
    tensile_strength: float = math.inf

    @property
    def axial_stiffness(self) -> float:
        """E t / (1 - nu^2) [N/m]."""
        return self.young_modulus * self.thickness / (1.0 - self.poisson_ratio**2)

    @property
    def bending_stiffness(self) -> float:
        """E t^3 / (12 (1 - nu^2)) [N m]."""
        return self.axial_stiffness * self.thickness**2 / 12.0


@dataclass(frozen=True)
class Bolts:
    """Rock bolts of one kind, spread over the length of the tunnel.

    Attributes
    ----------
    name : str
    bars : tuple of (start, end) [m]
        The start is the head, on the wall.
    area : float [m2]
    young_modulus : float [Pa]
    yield_force : float [N]
        Of one bolt, in tension and in compression.
    spacing : float [m]
        Along the tunnel: one bolt stands for that length.
    grout_stiffness : float [N/m2]
        Shear force per length of bolt and slip; nothing is meant where `anchored`.
    grout_strength : float [N/m]
        Shear force per length of bolt at which it slips.
    anchored : bool
        Held at its two ends alone.
    """

    name: str
    bars: tuple[tuple[Point, Point], ...]
    area: float
    young_modulus: float
    yield_force: float
    spacing: float
    grout_stiffness: float = 1e9
    grout_strength: float = math.inf
    anchored: bool = False


@dataclass(frozen=True)
class Stage:
    """One step of the work; what is named happens in this order.

    Attributes
    ----------
    name : str
    excavate : tuple of str
        Openings that are dug out; the forces that their ground exerted stay until they are relaxed.
    install : tuple of str
        Linings and bolts; they bear nothing at first.
    opening : str or None
        Whose forces `relax` and `pressure` mean; None: of all that are open.
    relax : float or None
        Share of the excavated ground's forces that is gone at the end [-].
    pressure : float or None [Pa]
        Pressure on the wall at the end, beside what is not relaxed yet.
    """

    name: str
    excavate: tuple[str, ...] = ()
    install: tuple[str, ...] = ()
    opening: str | None = None
    relax: float | None = None
    pressure: float | None = None


@dataclass(frozen=True)
class Plan:
    """Everything that happens to the ground."""

    openings: tuple[Opening, ...]
    initial: UniformStress | DepthStress
    stages: tuple[Stage, ...]
    linings: tuple[Lining, ...] = ()
    bolts: tuple[Bolts, ...] = ()

    def opening(self, name: str) -> int:
        """Place of an opening in `openings`."""
        return [entry.name for entry in self.openings].index(name)

    def without_supports(self) -> Plan:
        """The same digging with nothing installed: for the ground's own reaction curve."""
        bare = tuple(
            Stage(s.name, s.excavate, (), s.opening, s.relax, s.pressure)
            for s in self.stages
            if s.excavate or s.relax is not None or s.pressure is not None
        )
        return Plan(self.openings, self.initial, bare)
