"""How a tool is to cut, and whether it can: its place at the start, its path, what is held in its way."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly import Assembly
from ..errors import InputError, InputErrors
from .tool import Tool

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

LEAST_DEPTH = 1.0
"""Depth over the mean diameter below which nothing is cut: the path runs through half a row of particles."""

SHALLOW = 3.0
"""Depth over the mean diameter below which the roughness of the surface decides."""

CLEAR = 3.0
"""Mean diameters below the tip down to which held particles are let go where the tool enters."""

FLOOR = 2.0
"""Mean diameters that must be left below the tip, held ones not counted."""

ENTRY = 2.0
"""Way over the depth after which means are taken, where nothing is said."""

RAMP = 2.0
"""Way over the mean diameter on which the tool comes up to its speed, where nothing is said."""

HEIGHT = 4.0
"""Height of the face over the depth, where nothing is said."""

DAMPING = 0.3
"""Cundall's local damping where nothing is said: with more, mean forces grow with the speed of the tool."""

FRAMES = 20

FASTEST = 2e-2
"""Speed over that of compression waves in the ground, above which inertia decides."""


@dataclass(frozen=True)
class CuttingPlan:
    """A cut along +x.

    Attributes
    ----------
    tool : Tool
    depth : float
        Of the lowest point of the tool below the top of the ground [m].
    speed : float [m/s]
    distance : float
        Way of the tool from its start [m].
    start : float or None
        x of the tool's lowest point, or of the front end of its flat, at the start [m]; None: where the tool just
        touches the ground.
    ramp : float or None
        Way on which the speed rises [m]; two mean diameters where it is None.
    entry : float or None
        Way in the ground after which means are taken [m]; twice the depth where it is None.
    damping : float
        Cundall's local damping [-].
    frames : int
        Pictures, evenly over the way; the cut can be resumed at each.
    """

    tool: Tool
    depth: float
    speed: float
    distance: float
    start: float | None = None
    ramp: float | None = None
    entry: float | None = None
    damping: float = DAMPING
    frames: int = FRAMES

    def check(self) -> None:
        """Raise InputErrors for all that is wrong in itself."""
        found: list[InputError] = []
        try:
            self.tool.check()
        except InputErrors as errors:
            found += errors.errors
        except InputError as error:
            found.append(error)
        for name, value, unit in (
            ("depth", self.depth, "metres"),
            ("speed", self.speed, "m/s"),
            ("distance", self.distance, "metres"),
        ):
            if not (math.isfinite(value) and value > 0.0):
                problem = "the tool would move away from the ground" if value < 0.0 else "this cuts nothing"
                found.append(
                    InputError(
                        f"tool, {name}", problem, f"Give {unit}, more than 0; it moves along +x", value=value
                    )
                )
        if not found and self.tool.height <= self.depth:
            found.append(
                InputError(
                    "tool, height", f"the face ends below the surface at a depth of {self.depth:g} m",
                    f"Give more, {HEIGHT * self.depth:g} m for instance", value=self.tool.height,
                )
            )  # fmt: skip
        if not 0.0 <= self.damping < 1.0:
            found.append(
                InputError(
                    "tool, damping", "this is no local damping", "Give 0 to below 1", value=self.damping
                )
            )
        if self.frames < 1:
            found.append(
                InputError("tool, frames", "there is nothing to see", "Give 1 or more", value=self.frames)
            )
        if found:
            raise InputErrors(found) if len(found) > 1 else found[0]


@dataclass(frozen=True)
class Placed:
    """A cut placed in its ground.

    Attributes
    ----------
    place : (2,) [m]
        Of the tool's lowest point at the start.
    contact : float
        x of that point where the tool first touches the ground at its depth [m].
    end : float
        Its x at the end [m].
    top : float
        Level of the surface [m].
    diameter : float
        Mean, of the particles [m].
    ramp, entry : float
        [m]
    """

    place: Floats
    contact: float
    end: float
    top: float
    diameter: float
    ramp: float
    entry: float


def place_tool(plan: CuttingPlan, positions: Floats, radii: Floats, box: Floats) -> Placed:
    """Where the tool starts, touches and ends.

    Parameters
    ----------
    plan : CuttingPlan
    positions, radii : (n, 2), (n,) [m]
        Of the ground.
    box : (2, 2) [m]
        Lowest and highest coordinates of the ground.

    Raises
    ------
    InputError, InputErrors
        All that makes the cut impossible in this ground.
    """
    plan.check()
    diameter = 2.0 * float(radii.mean())
    low, high = np.asarray(box, dtype=float)
    found = _depth_errors(plan, diameter, float(high[1] - low[1]))
    if found:
        raise InputErrors(found) if len(found) > 1 else found[0]
    tip = float(high[1]) - plan.depth
    contact = _first_touch(plan.tool, positions, radii, tip)
    start = contact if plan.start is None else plan.start
    where = f"it first touches the ground with its tip at x = {contact:.6g} m"
    if start > contact + 1e-3 * diameter:
        beyond = start >= float(high[0])
        problem = (
            "the tool stands behind the ground and moves away from it along +x"
            if beyond
            else f"the tool would stand in the ground: {where}"
        )
        raise InputError(
            "tool, start", problem, f"Give at most {contact:.6g} m, or leave it out", value=plan.start
        )
    if start + plan.distance <= contact:
        raise InputError(
            "tool, distance", f"the tool does not reach the ground: {where}",
            f"Give more than {contact - start:.6g} m, or leave the start out", value=plan.distance,
        )  # fmt: skip
    last = float(high[0]) - plan.tool.foremost(plan.depth) - FLOOR * diameter
    if start + plan.distance > last:
        raise InputError(
            "tool, distance",
            f"the tool would end at x = {start + plan.distance:.6g} m, beyond the end of the ground at "
            f"{high[0]:.6g} m or in what is held there",
            f"Give at most {max(last - start, 0.0):.4g} m, or make the ground longer", value=plan.distance,
        )  # fmt: skip
    entry = ENTRY * plan.depth if plan.entry is None else plan.entry
    if not 0.0 <= entry < start + plan.distance - contact:
        raise InputError(
            "tool, entry",
            f"means are to be taken after {entry:.4g} m in the ground, but the tool goes only "
            f"{start + plan.distance - contact:.4g} m through it",
            "Give less, or a longer distance", value=entry,
        )  # fmt: skip
    ramp = RAMP * diameter if plan.ramp is None else plan.ramp
    return Placed(
        np.array([start, tip]), contact, start + plan.distance, float(high[1]), diameter, ramp, entry
    )


def _depth_errors(plan: CuttingPlan, diameter: float, thick: float) -> list[InputError]:
    least, most = LEAST_DEPTH * diameter, thick - FLOOR * diameter
    if plan.depth < least:
        return [
            InputError(
                "tool, depth", f"this is finer than a particle, whose mean diameter is {diameter:.4g} m",
                f"Give at least {least:.4g} m, better {SHALLOW:g} diameters or more, or make the particles smaller",
                value=plan.depth,
            )
        ]  # fmt: skip
    if plan.depth > most:
        return [
            InputError(
                "tool, depth", f"the ground is {thick:.4g} m thick, and {FLOOR:g} diameters must be left below the tip",
                f"Give at most {max(most, 0.0):.4g} m, or make the ground thicker", value=plan.depth,
            )
        ]  # fmt: skip
    return []


def _first_touch(tool: Tool, positions: Floats, radii: Floats, tip: float) -> float:
    """x of the tool's lowest point at which its section first touches a particle, coming from the left [m].

    Of every particle, the place at which it touches a side or a corner of the tool; the smallest is the first.
    """
    corners, _ = tool.outline()
    ends = np.concatenate([corners, corners[:1]])
    found = math.inf
    height = positions[:, 1] - tip
    for (x0, y0), (x1, y1) in itertools.pairwise(ends):
        # a corner touches where its distance is the radius
        reach = radii**2 - (height - y0) ** 2
        near = reach >= 0.0
        found = min(found, float((positions[near, 0] - np.sqrt(reach[near]) - x0).min(initial=math.inf)))
        length = math.hypot(x1 - x0, y1 - y0)
        # outward normal of a closed section that runs clockwise: down the face, back, up
        nx, ny = -(y1 - y0) / length, (x1 - x0) / length
        if nx <= 1e-12:
            continue
        # the point of the particle that touches a side is nearest to it
        foot = height - radii * ny
        share = (foot - y0) / (y1 - y0)
        on = (share >= 0.0) & (share <= 1.0)
        touch = positions[:, 0] - radii * nx - (x0 + share * (x1 - x0))
        found = min(found, float(touch[on].min(initial=math.inf)))
    if not math.isfinite(found):
        raise InputError("tool, depth", "no particle lies in the tool's way", "Give a larger depth")
    return found


def let_go(assembly: Assembly, placed: Placed, left: Mask) -> tuple[Assembly, int]:
    """The assembly without supports of particles on its left side that lie in the tool's way, and how many they were.

    Parameters
    ----------
    assembly : Assembly
    placed : Placed
    left : (n,) bool
        Particles held on the side where the tool enters.
    """
    from dataclasses import replace

    high = assembly.positions[:, 1] > placed.place[1] - CLEAR * placed.diameter
    free = left & high
    if not free.any():
        return assembly, 0
    held = assembly.held.copy()
    held[free] = False
    return replace(assembly, held=held), int(free.sum())


def wave_speed(young_modulus: float, density: float) -> float:
    """Of compression along a bar [m/s]."""
    return math.sqrt(young_modulus / density)
