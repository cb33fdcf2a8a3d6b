"""How many steps a search for a factor still needs, for the time left that is told.

A trial slows down as its factor comes near to the critical one: what fails leaves its balance ever more slowly, and
what holds takes ever longer to come to rest. Steps of a trial on 3000 particles at the relative distance d of its
factor from the critical one, as measured on the slope over a seam of `geodem new slope`: about 165/sqrt(d) where it
fails, 250 + 15/d where it holds; they grow as the square root of the number of particles, as waves need to cross the
section.

Where in a bracket the critical factor is nobody knows. So a trial at its middle is expected to take the mean over all
distances that may be, the step limit where it would take longer; what has gone on for long is near to the critical
factor. Once it has gone on for some looks it says more itself: the unbalanced force falls to that of rest, or the
displacement grows to that of failure, at a pace that changes slowly. A few trials take a large part of all the time, so
what a search takes at most is told as well: all at the step limit.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, inf, isnan, log, log2, nan, sqrt
from typing import NamedTuple

from ..run_progress import Work
from .bracket import Trial, bracket
from .criteria import Criteria

_PARTICLES = 3000.0
_FAILS, _HOLDS, _RESTS = 165.0, 250.0, 15.0
_FAR = 0.2
"""Distance of the trials that look for the other side of the bracket."""

_TRUSTED = 750.0
"""Steps at which what a trial says itself counts as much as what is expected of any."""

FEWEST = 10
"""Looks from which on a trial says itself how long it still takes."""


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

    def work(self) -> Work:
        """Steps times particles that it will take."""
        first = 2.0 * mean_steps(min(self.step, _FAR), self.particles)
        count = halvings_left(2.0 * self.step, self.tolerance)
        # the second trial is on the other side of the critical factor as often as not
        after = [halvings(width, self.tolerance, self.particles) for width in (self.step, 2.0 * self.step)]
        expected = self.particles * (first + 0.5 * sum(after))
        return Work(0.0, expected, max(expected, self.particles * (2 + count) * _limit(self.particles)))


def expected_steps(distance: float, particles: int, failed: bool | None = None) -> float:
    """Steps of a trial at a relative distance from the critical factor; None: it may fail or hold."""
    limit = _limit(particles)
    d = max(distance, 1e-9)
    scale = sqrt(particles / _PARTICLES)
    fails, holds = min(_FAILS / sqrt(d) * scale, limit), min((_HOLDS + _RESTS / d) * scale, limit)
    return 0.5 * (fails + holds) if failed is None else fails if failed else holds


def mean_steps(distance: float, particles: int, gone: float = 0.0) -> float:
    """Steps of a trial that is anywhere nearer to the critical factor than a distance, once it has gone on for some.

    Parameters
    ----------
    distance : float
        The largest that may be [-].
    particles : int
    gone : float
        Steps so far: that it has not ended by then says that it is near.
    """
    scale, limit = sqrt(particles / _PARTICLES), _limit(particles)
    if gone >= limit:
        return gone
    whole = likely = 0.0
    for failed in (True, False):
        far = min(distance, _distance(max(gone / scale, 1e-9), failed))
        near = min(far, _distance(limit / scale, failed))
        if failed:
            area = 2.0 * _FAILS * (sqrt(far) - sqrt(near))
        else:
            area = _HOLDS * (far - near) + _RESTS * log(far / near)
        whole += scale * area + limit * near
        likely += far
    return whole / likely


def trial_left(
    history: Sequence[tuple[int, float, float]], settlement: float, limit: float, criteria: Criteria
) -> float:
    """Steps until a trial ends, by the pace of the last third of its looks; NaN while these are too few.

    Parameters
    ----------
    history : sequence of (steps, unbalanced force ratio [-], displacement of what moves [m])
    settlement : float
        What displacements are measured by [m].
    limit : float
        Steps at which it ends anyway.
    criteria : Criteria
    """
    if len(history) < FEWEST:
        return nan
    steps, ratio, displacement = history[-1]
    since, before, there = history[-1 - len(history) // 3]
    found = max(limit - steps, 0.0)
    if 0.0 < ratio < before:
        falling = log(before / ratio) / (steps - since)
        found = min(found, max(log(ratio / criteria.stable_ratio), 0.0) / falling)
    if displacement > there:
        speed = (displacement - there) / (steps - since)
        far = criteria.failed_settlements * settlement - displacement
        own = criteria.own_settlements * settlement - (displacement - history[0][2])
        found = min(found, max(far, own, 0.0) / speed)
    return found


def _distance(steps: float, failed: bool) -> float:
    """At which a trial on `_PARTICLES` particles takes so many steps; infinite where none is so short."""
    if failed:
        return (_FAILS / steps) ** 2
    return _RESTS / (steps - _HOLDS) if steps > _HOLDS else inf


def _limit(particles: int) -> float:
    return max(Criteria().steps_per_length * sqrt(particles), 4000.0)


def halvings_left(width: float, tolerance: float) -> int:
    """How often a bracket of a relative width is still to be halved."""
    return max(0, ceil(log2(max(width, 1e-12) / tolerance) - 1e-9))


def halvings(width: float, tolerance: float, particles: int) -> float:
    """Steps of the trials that narrow a bracket of a relative width to the tolerance."""
    count = halvings_left(width, tolerance)
    return sum(mean_steps(0.5 * width / 2.0**k, particles) for k in range(count))


def work_left(
    trials: Sequence[Trial],
    current_steps: int,
    particles: int,
    *,
    tolerance: float,
    step: float,
    running: bool,
    seen: float = nan,
) -> Work:
    """Steps times particles that a search under way still takes, by its trials and the one at hand.

    Of that one: its steps so far, and as many as it seems to take still, see `trial_left`.
    """
    now = bracket(trials)
    if now.value is None:
        far = min(step * 2 ** len(trials), _FAR)
        width = 2.0 * step * 2 ** len(trials)
        steps, count = mean_steps(far, particles), 1
    else:
        far = 0.5 * now.width
        width, steps, count = now.width, 0.0, 0
    steps += halvings(width, tolerance, particles)
    count += halvings_left(width, tolerance)
    most = count * _limit(particles)
    if running:
        left = mean_steps(far, particles, current_steps) - current_steps
        if not isnan(seen):
            # the unbalanced force falls fast at first: what early looks say counts little
            share = current_steps / (current_steps + _TRUSTED)
            left = share * seen + (1.0 - share) * left
        steps += left - mean_steps(far, particles)
        most -= current_steps
    expected = particles * max(steps, 0.0)
    return Work(0.0, expected, max(expected, particles * most))


def pace(trials: Sequence[Trial], seconds: float, current_steps: int, particles: int) -> float:
    """Seconds of a step of a particle by what has been done; infinite where nothing has."""
    work = sum(t.steps * t.particles for t in trials) + current_steps * particles
    return (sum(t.seconds for t in trials) + seconds) / work if work else inf
