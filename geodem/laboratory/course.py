"""The course of a drive: a fast pilot that finds how far it is to the peak, the test itself, and its curves."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from . import pace as paces
from .driven import Driven
from .rig import Watch

Floats = NDArray[np.float64]

RATIO = 0.1
"""Unbalanced ratio at the peak above which a warning is given: more than in compression, since tension is sudden."""

FARTHER = 3.0
"""How much farther and faster a pilot goes on that has not come to the peak."""

Reading = Callable[[Driven], float]
"""One more column of the curves."""


class Course:
    """Curves of a drive, look by look.

    Parameters
    ----------
    driven : Driven
    per_force : float
        What the load counts as over its force [Pa/N].
    more : dict of str to Reading
        Further columns by name.
    """

    def __init__(self, driven: Driven, per_force: float, more: dict[str, Reading] | None = None) -> None:
        self.driven = driven
        self.per_force = per_force
        self.more = more or {}
        self.rows: list[tuple[float, ...]] = []
        self.top = -math.inf
        self.look()

    def look(self) -> float:
        """Take down where everything is; the stress."""
        driven = self.driven
        s = driven.simulation
        force = driven.force()
        modes = s.record[: len(s.assembly.bonds), 0]
        self.rows.append(
            (
                s.steps, driven.displacement(), force, self.per_force * force, int((modes == 1).sum()),
                int((modes == 2).sum()), s.unbalanced_ratio(), *(read(driven) for read in self.more.values()),
            )
        )  # fmt: skip
        self.top = max(self.top, force)
        return force

    def until_failure(
        self, *, every: int, fall: float, longest: float, beyond: float = 0.0, watch: Watch | None = None
    ) -> tuple[bool, str]:
        """Move until the load has fallen to `fall` of its peak and the drive is `beyond` [m]; whether it has, and why.

        Parameters
        ----------
        every : int
            Steps between looks.
        longest : float
            Drive at which it ends without failure [m].
        """
        fallen = False
        while True:
            self.driven.simulation.run(every)
            force = self.look()
            way = self.rows[-1][1]
            if watch is not None:
                watch(way, self.per_force * force, (len(self.rows) - 1) / paces.LOOKS)
            fallen = fallen or (self.top > 0.0 and force < fall * self.top)
            if fallen and way >= beyond:
                return True, f"the load has fallen to {force / self.top:.0%} of its peak"
            if way > longest:
                return False, f"no failure up to a displacement of {1e3 * longest:.3g} mm"

    def curves(self) -> dict[str, Floats]:
        """By name."""
        names = (
            "steps", "displacement", "force", "axial_stress", "tension_cracks", "shear_cracks", "unbalanced_ratio",
            *self.more,
        )  # fmt: skip
        return dict(zip(names, np.array(self.rows, dtype=float).T, strict=True))


@dataclass(frozen=True, eq=False)
class Driving:
    """How a drive is carried out.

    Attributes
    ----------
    per_force : float
        Stress over force [Pa/N].
    high : float
        Particles that a wave passes on its way through the specimen.
    overshoot : float
        Displacement at the peak over `Driven.scale`, at a guess.
    share : float
        Displacement at the peak over that of the fast pilot's.
    fall : float
        Share of the peak at which the test ends.
    beyond : float
        It goes on until the displacement is this many times that at the peak [-].
    """

    per_force: float
    high: float
    overshoot: float
    share: float
    fall: float
    beyond: float = 0.0


@dataclass(frozen=True, eq=False)
class Carried:
    """What came of a drive.

    Attributes
    ----------
    driven : Driven
        At the end.
    curves : dict of str to (k,)
    failed : bool
    reason : str
    steps : int
        Of the pilot too.
    top : int
        Place of the peak in the curves.
    rate : float
        Drive per step [m].
    per_force : float
        As of `Driving`.
    """

    driven: Driven
    curves: dict[str, Floats]
    failed: bool
    reason: str
    steps: int
    top: int
    rate: float
    per_force: float

    def numbers(self, top: int) -> dict[str, float]:
        """What every test tells of its peak at a place in the curves."""
        curves, driven = self.curves, self.driven
        return {
            "stiffness": driven.stiffness,
            "first_break_stress": self.per_force * driven.stiffness * driven.first_break,
            "peak_displacement": float(curves["displacement"][top]),
            "unbalanced_ratio": float(curves["unbalanced_ratio"][max(top - 5, 0) : top + 1].mean()),
            "tension_cracks_at_peak": float(curves["tension_cracks"][top]),
            "shear_cracks_at_peak": float(curves["shear_cracks"][top]),
            "bonds": float(len(driven.simulation.assembly.bonds)),
            "rate_per_step": self.rate,
        }

    def warnings(self, numbers: dict[str, float], pace: float) -> list[str]:
        """Of what makes a strength doubtful."""
        found = []
        if numbers["unbalanced_ratio"] > RATIO:
            found.append(
                f"forces of inertia are not small at the peak (unbalanced ratio {numbers['unbalanced_ratio']:.2g}): "
                f"load more slowly (pace above {pace:g})"
            )
        if not self.failed:
            found.append(f"{self.reason}: the strength is the largest stress that was reached, not a peak")
        return found


def carry_out(
    mounted: Callable[[], Driven],
    driving: Driving,
    *,
    pace: float,
    expected: float | None = None,
    more: dict[str, Reading] | None = None,
    watch: Watch | None = None,
) -> Carried:
    """Drive a specimen past its peak.

    Parameters
    ----------
    mounted : callable
        Makes it anew.
    driving : Driving
    pace : float
        See `geodem.laboratory.pace`.
    expected : float, optional
        Displacement at the peak [m]; a fast pilot finds it where it is left out.
    more : dict of str to Reading
        Further columns of the curves.

    Raises
    ------
    InputError
        A pace that is none, or as of `Driven`.
    """
    if not (math.isfinite(pace) and pace > 0.0):
        raise InputError("pace", "these are no steps per particle", f"Give {paces.PACE:g}", value=pace)
    steps = 0
    ended: tuple[Course, float, bool, str] | None = None
    if not paces.sound(expected):
        ended = _pilot(mounted, driving, more)
        course, rate, failed, reason = ended
        steps = course.driven.simulation.steps
        curves = course.curves()
        expected = driving.share * float(curves["displacement"][np.argmax(curves["force"])])
    assert expected is not None
    if ended is None or failed:
        course, rate, failed, reason = _driven_by(mounted, driving, expected, pace, more, watch)
        steps += course.driven.simulation.steps
    # else: what does not fail when it is driven fast does not when it is driven slowly
    curves = course.curves()
    return Carried(
        course.driven, curves, failed, reason, steps, int(np.argmax(curves["force"])), rate, driving.per_force
    )


def _pilot(
    mounted: Callable[[], Driven], driving: Driving, more: dict[str, Reading] | None
) -> tuple[Course, float, bool, str]:
    """Fast, and where there was no peak, farther and faster once more."""
    driven = mounted()
    driven.begin(0.0)
    size = float(driven.specimen.size.max())
    guess = driving.overshoot * driven.scale
    while True:
        ended = _driven_by(mounted, driving, guess, paces.PILOT, more, None)
        if ended[2] or paces.LONGEST * guess >= paces.MOST_STRAIN * size:
            return ended
        guess *= FARTHER


def _driven_by(
    mounted: Callable[[], Driven],
    driving: Driving,
    expected: float,
    pace: float,
    more: dict[str, Reading] | None,
    watch: Watch | None,
) -> tuple[Course, float, bool, str]:
    """The course, its drive per step [m], whether it failed, and why it ended."""
    driven = mounted()
    rate = paces.rate_of(expected, driving.high, pace)
    driven.begin(rate)
    course = Course(driven, driving.per_force, more)
    failed, reason = course.until_failure(
        every=paces.looks_every(expected, rate), fall=driving.fall,
        longest=min(paces.LONGEST * expected, paces.MOST_STRAIN * float(driven.specimen.size.max())),
        beyond=driving.beyond * expected, watch=watch,
    )  # fmt: skip
    return course, rate, failed, reason
