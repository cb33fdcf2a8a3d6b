"""What the report is shown: plain data, gathered by whoever ran the case."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.measure.failure import Failure

Floats = NDArray[np.float64]
Point = tuple[float, float]


@dataclass(frozen=True)
class MethodView:
    """One search for a factor.

    Attributes
    ----------
    kind : "strength-reduction" or "gravity-increase"
    value, stable, failed : float or None [-]
        None where the search left that side open.
    criterion : str
        The rule that decided the failing trial, in words.
    undecided : list of float [-]
        Factors that were neither stable nor failed.
    trials : list of dict
        In the order tried: factor, verdict ("stable", "failed", "undecided"), criterion, steps, unbalanced,
        displacement [m], particles, seconds, model ("coarse", "fine").
    histories : list of (factor, verdict, step (k,), displacement of what moves (k,) [m])
    failure : Failure or None
        The lowest failed trial's fields, over the positions of the view.
    """

    kind: str
    value: float | None
    stable: float | None
    failed: float | None
    criterion: str = ""
    undecided: Sequence[float] = ()
    trials: Sequence[Mapping[str, Any]] = ()
    histories: Sequence[tuple[float, str, Floats, Floats]] = ()
    failure: Failure | None = None


@dataclass(frozen=True)
class ReportView:
    """A section, its particles and what was found.

    Attributes
    ----------
    title, case_text : str
    positions : (n, 2) [m]
    triangles : (m, 3) integers
    triangle_material : (m,) integers, into `materials`
    materials : sequence of str
    material_rows : sequence of dict
        ``{"name": ..., "cohesion": "28.5 kPa", ...}``, text with units.
    outlines : sequence of (material, rings)
        Of each region the outer ring and its holes, each (k, 2) [m].
    supports : dict
        "left", "right", "bottom", "top" to "fixed", "roller" or "free".
    loads : sequence of str, or one str
        In words, with units.
    image_path : path or None
        The picture that the section was read from.
    methods : sequence of MethodView
    spacing : float or None [m]
    surcharges : sequence of (from point [m], to point [m], pressure [Pa])
    horizontal_acceleration : float [m/s2]
        Positive where the ground is pushed towards +x.
    """

    title: str
    case_text: str
    positions: Floats
    triangles: NDArray[np.integer]
    triangle_material: NDArray[np.integer]
    materials: Sequence[str]
    material_rows: Sequence[Mapping[str, str]] = ()
    outlines: Sequence[tuple[str, Sequence[Floats]]] = ()
    supports: Mapping[str, str] = field(default_factory=dict)
    loads: Sequence[str] | str = ()
    image_path: Path | None = None
    methods: Sequence[MethodView] = ()
    spacing: float | None = None
    surcharges: Sequence[tuple[Point, Point, float]] = ()
    horizontal_acceleration: float = 0.0
