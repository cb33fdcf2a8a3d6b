"""The section of a cutting tool: face with a rake, tip, wear flat, relief face, as one rigid wall.

The tool moves along +x with its lowest point at a depth below the surface. The rake angle is that between the face and
the normal of the path, positive where the face leans back so that the chip runs up on it; the clearance angle is that
between the relief face and the path. Terms as in Nishimatsu 1972, The mechanics of rock cutting, Int. J. Rock Mech.
Min. Sci. 9:261-270, and in Evans & Pomeroy 1966, The Strength, Fracture and Workability of Coal.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..assembly import Wall
from ..boundaries import walls
from ..errors import InputError, InputErrors

Floats = NDArray[np.float64]

PARTS = ("face", "tip", "flat", "relief", "body")
"""Parts of a tool, in the order of their numbers."""
FACE, TIP, FLAT, RELIEF, BODY = range(len(PARTS))

NAME = "tool"
"""Of the wall."""

ARC = math.radians(15.0)
"""Largest turn from segment to segment along a round tip."""

LEAST_WEDGE = math.radians(5.0)
"""A wedge sharper than this between face and relief face is no tool."""


@dataclass(frozen=True)
class Tool:
    """Section of a tool, its lowest point at the origin or, of a flat, its foremost one.

    Attributes
    ----------
    rake : float
        [rad]; between -90 and 90 degrees.
    clearance : float
        [rad]; more than 0.
    height : float
        Of the face above the lowest point [m].
    wear_flat : float
        Length [m]; 0: none.
    tip_radius : float
        [m]; 0: sharp.
    friction_angle : float
        Between tool and ground [rad].
    """

    rake: float
    clearance: float
    height: float
    friction_angle: float
    wear_flat: float = 0.0
    tip_radius: float = 0.0

    @property
    def wedge(self) -> float:
        """Angle between face and relief face [rad]."""
        return 0.5 * math.pi - self.rake - self.clearance

    @property
    def ratio(self) -> float:
        """Normal over cutting force on a face that the ground slides up on: tan(friction angle - rake) [-]."""
        return math.tan(self.friction_angle - self.rake)

    def check(self) -> None:
        """Raise InputErrors for all that makes it no tool."""
        found = []
        if not (math.isfinite(self.rake) and abs(self.rake) < 0.5 * math.pi):
            found.append(
                InputError(
                    "tool, rake", "this is no rake", "Give between -90 and 90 deg", value=_degrees(self.rake)
                )
            )
        elif not (math.isfinite(self.clearance) and self.clearance > 0.0):
            found.append(
                InputError(
                    "tool, clearance", "the tool would rub on the ground behind it",
                    "Give more than 0 deg, 10 deg for instance", value=_degrees(self.clearance),
                )
            )  # fmt: skip
        elif self.wedge < LEAST_WEDGE:
            left = 90.0 - math.degrees(self.rake + LEAST_WEDGE)
            found.append(
                InputError(
                    "tool, rake",
                    f"with a clearance of {_degrees(self.clearance)} it leaves a wedge of "
                    f"{_degrees(self.wedge)}: no clearance or no tool",
                    f"Give rake and clearance together at most {90.0 - math.degrees(LEAST_WEDGE):g} deg"
                    + (f": a clearance of at most {left:g} deg here" if left > 0.0 else ""),
                    value=_degrees(self.rake),
                )
            )
        for name, value, least in (
            ("height", self.height, "more than 0"),
            ("wear_flat", self.wear_flat, "0 or more"),
            ("tip_radius", self.tip_radius, "0 or more"),
        ):
            if not (math.isfinite(value) and (value > 0.0 or (value == 0.0 and name != "height"))):
                found.append(
                    InputError(f"tool, {name}", "this is no length", f"Give metres, {least}", value=value)
                )
        if not (math.isfinite(self.friction_angle) and 0.0 <= self.friction_angle < 0.5 * math.pi):
            found.append(
                InputError(
                    "tool, friction_angle", "this is no friction angle",
                    "Give 0 deg or more, less than 90 deg", value=_degrees(self.friction_angle),
                )
            )  # fmt: skip
        if not found and self._arc_height() > 0.5 * self.height:
            found.append(
                InputError(
                    "tool, tip_radius", "the round tip takes up most of the face",
                    f"Give at most {0.5 * self.height * self.tip_radius / self._arc_height():.4g} m, or a higher face",
                    value=self.tip_radius,
                )
            )  # fmt: skip
        if found:
            raise InputErrors(found) if len(found) > 1 else found[0]

    def _arc_height(self) -> float:
        """Height at which the round tip goes over into the face [m]."""
        return self.tip_radius * (1.0 + math.sin(self.rake)) if self.tip_radius else 0.0

    def outline(self) -> tuple[Floats, NDArray[np.int64]]:
        """Corners (k, 2) [m] of the closed section, from the top of the face down, and the part (k,) of every side.

        Side j goes from corner j to the next one. The flat is level and ends behind the tip; a round tip is tangent to
        the face and to the flat or, without one, to the relief face.
        """
        self.check()
        up = np.array([-math.sin(self.rake), math.cos(self.rake)])
        back = np.array([-math.cos(self.clearance), math.sin(self.clearance)])
        corners, parts = [], []
        radius = self.tip_radius
        tip = np.zeros(2)
        if radius:
            arc = self._arc()
            # where the straight face would meet the level of the lowest point
            tip = arc[0] - up * arc[0, 1] / up[1]
        top = tip + up * self.height / up[1]
        corners.append(top)
        parts.append(FACE)
        if radius:
            corners += list(arc)
            parts += [TIP] * (len(arc) - 1)
        else:
            corners.append(tip)
        if self.wear_flat:
            parts.append(FLAT)
            corners.append(corners[-1] + np.array([-self.wear_flat, 0.0]))
        parts.append(RELIEF)
        start = corners[-1]
        # as long behind the face as that is high, or to where the relief face comes up to the top
        long = min(
            self.height + max(start[0] - top[0], 0.0),
            (self.height - start[1]) / math.tan(self.clearance),
        )
        end = start + back * long / math.cos(self.clearance)
        corners.append(end)
        parts.append(BODY)
        if end[1] < self.height * (1.0 - 1e-9):
            corners.append(np.array([end[0], self.height]))
            parts.append(BODY)
        return np.array(corners), np.array(parts, dtype=np.int64)

    def _arc(self) -> Floats:
        """Corners of the round tip from the face to the flat or the relief face; its lowest point is the origin."""
        # the lowest point is a corner; a normal at angle a below the path is (cos a, -sin a)
        down = 0.5 * math.pi
        spans = (
            [(-self.rake, down)] if self.wear_flat else [(-self.rake, down), (down, down + self.clearance)]
        )
        angles = [np.linspace(a, b, math.ceil((b - a) / ARC - 1e-9) + 1) for a, b in spans]
        angle = np.concatenate([angles[0], *(more[1:] for more in angles[1:])])
        centre = np.array([0.0, self.tip_radius])
        return centre + self.tip_radius * np.stack([np.cos(angle), -np.sin(angle)], axis=1)

    def foremost(self, depth: float) -> float:
        """How far the tool reaches ahead of its lowest point, up to a height of `depth` [m]."""
        corners, _ = self.outline()
        ends = np.concatenate([corners, corners[:1]])
        reach = [float(x) for x, y in corners if y <= depth]
        for (x0, y0), (x1, y1) in itertools.pairwise(ends):
            if (y0 - depth) * (y1 - depth) < 0.0:
                reach.append(float(x0 + (x1 - x0) * (depth - y0) / (y1 - y0)))
        return max(reach)

    def wall(self, place: Floats, contact: dict[str, float] | None = None) -> Wall:
        """The tool as a wall with its lowest point at `place` (2,) [m], at rest; `contact` besides its friction."""
        corners, _ = self.outline()
        own = {"friction_coefficient": math.tan(self.friction_angle), **(contact or {})}
        return walls.segments(NAME, corners + np.asarray(place), closed=True, centre=place, contact=own)


def _degrees(value: float) -> str:
    return f"{math.degrees(value):g} deg"
