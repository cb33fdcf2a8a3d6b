"""How many steps a search for a factor still needs, for the time left that is told.

A trial slows down as its factor comes near to the critical one: what fails leaves its balance ever more slowly, and
what holds takes ever longer to come to rest. Steps of a trial on 3000 particles at the relative distance d of its
factor from the critical one, as measured on the slope over a seam of `geodem new slope`: about 165/sqrt(d) where it
fails, 250 + 15/d where it holds; they grow as the square root of the number of particles, as waves need to cross the
section.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, inf, log2, sqrt
from typing import NamedTuple

from .bracket import Trial, bracket
from .criteria import Criteria

_PARTICLES = 3000.0
_FAR = 0.2
"""Distance of the trials that look for the other side of the bracket."""


class Planned(NamedTuple):
    """A search that is still to come.

    Attributes
    ----------
    particles : int
    tolerance : float
    step : float
        First step outwards: small where a coarser model has told about where the factor is.
    """

    particles: int
    tolerance: float
    step: float

    def work(self) -> float:
        """Steps times particles that it will take."""
        first = 2.0 * expected_steps(0.5 * min(self.step, _FAR), self.particles)
        return self.particles * (first + halvings(2.0 * self.step, self.tolerance, self.particles))


def expected_steps(distance: float, particles: int, failed: bool | None = None) -> float:
    """Steps of a trial at a relative distance from the critical factor; None: it may fail or hold."""
    limit = Criteria().max_steps(particles)
    d = max(distance, 1e-5)
    scale = sqrt(particles / _PARTICLES)
    fails, holds = min(165.0 / sqrt(d) * scale, limit), min((250.0 + 15.0 / d) * scale, limit)
    return 0.5 * (fails + holds) if failed is None else fails if failed else holds


def halvings_left(width: float, tolerance: float) -> int:
    """How often a bracket of a relative width is still to be halved."""
    return max(0, ceil(log2(max(width, 1e-12) / tolerance) - 1e-9))


def halvings(width: float, tolerance: float, particles: int) -> float:
    """Steps of the trials that narrow a bracket of a relative width to the tolerance."""
    count = halvings_left(width, tolerance)
    # the critical factor may be anywhere in the bracket: half of its middle's distances are below a quarter of it
    return sum(expected_steps(0.25 * width / 2.0**k, particles) for k in range(count))


def work_left(
    trials: Sequence[Trial],
    current_steps: int,
    particles: int,
    *,
    tolerance: float,
    step: float,
    running: bool,
) -> float:
    """Steps times particles that a search under way still takes, by its trials and the steps of the one at hand."""
    now = bracket(trials)
    if now.value is None:
        looking = expected_steps(min(0.5 * step * 2 ** len(trials), _FAR), particles)
        steps = looking + halvings(2.0 * step * 2 ** len(trials), tolerance, particles)
    else:
        steps = halvings(now.width, tolerance, particles)
        looking = expected_steps(0.25 * now.width, particles)
    if running:
        # one that has gone on for longer than expected is said to need a part of that again
        steps += max(looking - current_steps, 0.3 * current_steps) - looking
    return particles * max(steps, 0.0)


def pace(trials: Sequence[Trial], seconds: float, current_steps: int, particles: int) -> float:
    """Seconds of a step of a particle by what has been done; infinite where nothing has."""
    work = sum(t.steps * t.particles for t in trials) + current_steps * particles
    return (sum(t.seconds for t in trials) + seconds) / work if work else inf
