"""Sets of joints: parallel joints a spacing apart, through and through or broken by bridges, with seeded scatter."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geodem.builders.joints import Joint, box_of, clipped, dip_normal, disc, plane, polyline
from geodem.errors import InputError

Floats = NDArray[np.float64]

MOST = 100_000
"""Joints in a set: beyond, its spacing is a mistake."""


@dataclass(frozen=True)
class JointScatter:
    """How a set scatters; the same seed gives the same joints.

    Attributes
    ----------
    seed : int
    angle : float
        Standard deviation of the orientation [rad], of each of two tilts in 3D.
    spacing : float
        Each joint is shifted across the set by up to this share of the spacing either way [-].
    trace : float
        Traces and gaps are longer or shorter by up to this share [-], below 1.
    phase : bool
        Traces of neighbouring joints begin anywhere, not side by side.
    """

    seed: int
    angle: float = 0.0
    spacing: float = 0.0
    trace: float = 0.0
    phase: bool = True

    def check(self) -> None:
        """Raise InputError for what is out of range."""
        for name, value, most in (
            ("angle", self.angle, 0.5 * math.pi),
            ("spacing", self.spacing, 0.5),
            ("trace", self.trace, 0.95),
        ):
            if not 0.0 <= value <= most:
                raise InputError(
                    f"joint set, scatter of {name}",
                    "it is out of range",
                    f"Give 0 to {most:.3g}",
                    value=value,
                )


def joint_set_2d(
    bounds: ArrayLike,
    material: str,
    *,
    angle: float,
    spacing: float,
    trace: float = math.inf,
    gap: float = 0.0,
    origin: ArrayLike = (0.0, 0.0),
    scatter: JointScatter | None = None,
) -> list[Joint]:
    """Parallel joints in a section.

    Parameters
    ----------
    bounds : (2, 2) float [m]
        Lowest and highest coordinates of the body; joints end there.
    material : str
        Of the joints.
    angle : float
        Of their direction above the x axis, counter-clockwise [rad].
    spacing : float
        Across the joints [m].
    trace : float
        Length of a joint [m]; infinite: through and through.
    gap : float
        Bridge of rock from the end of one to the beginning of the next along the same line [m].
    origin : (2,) float [m]
        One line runs through it, and a trace begins there where no phase scatters.
    scatter : JointScatter, optional

    Raises
    ------
    InputError
        Lengths that are none, or so short that the joints are too many.
    """
    box, lengths = _checked(bounds, 2, spacing, trace, gap, scatter)
    along = np.array([math.cos(angle), math.sin(angle)])
    rng = None if scatter is None else np.random.default_rng(scatter.seed)
    start = np.asarray(origin, dtype=float)
    found = []
    for shift in _shifts(box, start, np.array([-along[1], along[0]]), spacing, scatter, rng):
        foot = start + shift * np.array([-along[1], along[0]])
        way = along
        if rng is not None and scatter is not None and scatter.angle > 0.0:
            turned = angle + scatter.angle * rng.standard_normal()
            way = np.array([math.cos(turned), math.sin(turned)])
        low, high = _stretch(box, foot, way)
        for first, last in _traces(low, high, lengths, scatter, rng):
            cut = clipped(polyline([foot + first * way, foot + last * way], material), box)
            if cut is not None:
                found.append(cut)
    return found


def joint_set_3d(
    bounds: ArrayLike,
    material: str,
    *,
    dip: float,
    dip_direction: float,
    spacing: float,
    trace: float = math.inf,
    gap: float = 0.0,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    scatter: JointScatter | None = None,
) -> list[Joint]:
    """Parallel joints in a body: planes, or round joints in rows on each plane.

    Parameters
    ----------
    bounds : (2, 3) float [m]
    material : str
    dip, dip_direction : float
        See `geodem.builders.joints.dip_normal` [rad].
    spacing : float
        Across the joints [m].
    trace : float
        Diameter of a joint [m]; infinite: through and through.
    gap : float
        Bridge between neighbours on a plane, along strike and along dip [m].
    origin : (3,) float [m]
        One plane runs through it.
    scatter : JointScatter, optional

    Raises
    ------
    InputError
        As of `joint_set_2d`.
    """
    box, lengths = _checked(bounds, 3, spacing, trace, gap, scatter)
    normal = dip_normal(dip, dip_direction)
    strike = np.array([-math.cos(dip_direction), math.sin(dip_direction), 0.0])
    down = np.cross(normal, strike)
    rng = None if scatter is None else np.random.default_rng(scatter.seed)
    start = np.asarray(origin, dtype=float)

    def tilted() -> Floats:
        if rng is None or scatter is None or scatter.angle == 0.0:
            return normal
        tilt = scatter.angle * rng.standard_normal(2)
        vector = normal + math.tan(tilt[0]) * strike + math.tan(tilt[1]) * down
        return np.asarray(vector / np.linalg.norm(vector))

    found = []
    for shift in _shifts(box, start, normal, spacing, scatter, rng):
        foot = start + shift * normal
        if math.isinf(trace):
            found += _whole(partial(plane, foot, tilted(), box, material))
            continue
        for low, high in _traces(*_stretch(box, foot, down), lengths, scatter, rng):
            row = foot + 0.5 * (low + high) * down
            for first, last in _traces(*_stretch(box, row, strike), lengths, scatter, rng):
                radius = 0.5 * min(last - first, high - low)
                one = disc(row + 0.5 * (first + last) * strike, tilted(), radius, material)
                cut = clipped(one, box)
                if cut is not None:
                    found.append(cut)
    return found


def _whole(make: Callable[[], Joint]) -> list[Joint]:
    """A plane, or nothing where it passes by the body."""
    try:
        return [make()]
    except InputError:
        return []


def _checked(
    bounds: ArrayLike, dimension: int, spacing: float, trace: float, gap: float, scatter: JointScatter | None
) -> tuple[Floats, tuple[float, float]]:
    box = box_of(bounds)
    if box.shape[1] != dimension:
        raise InputError("bounds", f"these are not those of a body in {dimension}D", "Take the other set")
    if not (math.isfinite(spacing) and spacing > 0.0):
        raise InputError(
            "joint set, spacing", "this is no spacing", "Give metres, more than 0", value=spacing
        )
    if not trace > 0.0:
        raise InputError("joint set, trace", "this is no length", "Give metres, more than 0", value=trace)
    if not (math.isfinite(gap) and gap >= 0.0):
        raise InputError("joint set, gap", "this is no gap", "Give metres, 0 or more", value=gap)
    if scatter is not None:
        scatter.check()
    size = float(np.linalg.norm(box[1] - box[0]))
    count = (size / spacing + 1.0) * (size / (trace + gap) + 1.0) ** (dimension - 1)
    if count > MOST:
        raise InputError(
            "joint set", f"it would have some {count:.0f} joints", "Give a wider spacing or longer traces",
            value=spacing,
        )  # fmt: skip
    return box, (trace, gap)


def _stretch(box: Floats, foot: Floats, way: Floats) -> tuple[float, float]:
    """From where to where along a direction a line through `foot` may be in a box [m]."""
    corners = np.array(np.meshgrid(*box.T, indexing="ij")).reshape(box.shape[1], -1).T
    along = (corners - foot) @ way
    return float(along.min()), float(along.max())


def _shifts(
    box: Floats,
    origin: Floats,
    normal: Floats,
    spacing: float,
    scatter: JointScatter | None,
    rng: np.random.Generator | None,
) -> Floats:
    """Distances [m] of the joints from the origin, along the normal."""
    low, high = _stretch(box, origin, normal)
    numbers = np.arange(math.ceil(low / spacing - 1e-9), math.floor(high / spacing + 1e-9) + 1, dtype=float)
    if rng is not None and scatter is not None and scatter.spacing > 0.0:
        numbers = numbers + rng.uniform(-scatter.spacing, scatter.spacing, len(numbers))
    return np.asarray(spacing * numbers)


def _traces(
    low: float,
    high: float,
    lengths: tuple[float, float],
    scatter: JointScatter | None,
    rng: np.random.Generator | None,
) -> list[tuple[float, float]]:
    """Beginnings and ends [m] of the traces along a line from low to high; one begins at 0."""
    trace, gap = lengths
    if math.isinf(trace):
        return [(low, high)]
    pitch = trace + gap
    at = pitch * math.floor(low / pitch)
    if rng is not None and scatter is not None and scatter.phase:
        at -= pitch * rng.uniform()
    found = []
    while at < high:
        length, bridge = trace, gap
        if rng is not None and scatter is not None and scatter.trace > 0.0:
            length *= 1.0 + scatter.trace * rng.uniform(-1.0, 1.0)
            bridge *= 1.0 + scatter.trace * rng.uniform(-1.0, 1.0)
        if at + length > low:
            found.append((at, at + length))
        at += length + bridge
    return found
