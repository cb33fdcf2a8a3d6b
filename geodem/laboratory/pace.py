"""How fast a test is driven, and whether that was slow enough.

What counts is how long the specimen takes to the peak over the time that a wave takes through it. That time is as many
steps as the specimen is particles high, so the pace is steps to the peak per particle of height.
"""

from __future__ import annotations

import math

PACE = 680.0
"""Steps to the peak per particle of height. At half of it the compressive strength comes out 6 % higher for granite and
the same for sandstone; at twice and four times of it 1 % lower for either."""

PILOT = 40.0
"""Pace of the pilot that only finds out how far it is to the peak."""

PILOT_SHARE = {"compression": 0.75, "tension": 0.95}
"""Strain at the peak over that of the pilot, which overshoots."""

LOOKS = 150
"""Looks at the curves on the way to the peak."""

LONGEST = 6.0
"""Strain over that at the expected peak, at which a test ends without failure."""

MOST_STRAIN = 0.2
"""No test goes farther: strains and sections here are those of small changes of shape."""


def rate_of(expected: float, high: float, pace: float) -> float:
    """Strain per step that reaches an expected strain at this pace in a specimen so many particles high."""
    return expected / (pace * max(high, 1.0))


def looks_every(expected: float, rate: float) -> int:
    """Steps between looks."""
    return max(1, round(expected / rate / LOOKS))


def longest(expected: float) -> float:
    """Strain at which a test is given up."""
    return min(LONGEST * expected, MOST_STRAIN)


def sound(value: float | None) -> bool:
    """Whether an expected strain can be used."""
    return value is not None and math.isfinite(value) and value > 0.0
