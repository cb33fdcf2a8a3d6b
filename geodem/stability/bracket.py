"""Which factor to try next: a pure function of the trials so far, so a search can stop and go on anywhere."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

Verdict = Literal["stable", "failed", "undecided"]


@dataclass(frozen=True)
class Trial:
    """One factor tried.

    Attributes
    ----------
    factor : float
    verdict : "stable", "failed" or "undecided"
    criterion : str
        The rule that decided, in words.
    steps : int
    unbalanced : float
        Unbalanced force ratio at the end [-].
    displacement : float
        Mean displacement of what moves, from the settled state, at the end [m].
    particles : int
    model : "coarse" or "fine"
    seconds : float
        Wall time (never used in a decision).
    history : list of (steps, unbalanced force ratio [-], displacement of what moves [m])
    """

    factor: float
    verdict: Verdict
    criterion: str
    steps: int
    unbalanced: float
    displacement: float
    particles: int
    model: Literal["coarse", "fine"]
    seconds: float = 0.0
    history: list[tuple[int, float, float]] = field(default_factory=list, compare=False)

    def as_dict(self, *, history: bool = False) -> dict[str, Any]:
        """Plain data for JSON."""
        data = asdict(self)
        if not history:
            del data["history"]
        return data


@dataclass(frozen=True)
class Bracket:
    """What the trials say: the highest stable factor below the lowest failed one, and undecided ones between."""

    stable: float | None
    failed: float | None
    undecided: tuple[float, ...]

    @property
    def value(self) -> float | None:
        """Middle of the bracket; None while one side is open."""
        return None if self.stable is None or self.failed is None else 0.5 * (self.stable + self.failed)

    @property
    def width(self) -> float:
        """(failed - stable) / value [-]; infinite while one side is open."""
        value = self.value
        if value is None or self.stable is None or self.failed is None:
            return float("inf")
        return (self.failed - self.stable) / value


def bracket(trials: Sequence[Trial]) -> Bracket:
    """The bracket of a set of trials.

    A stable factor above a failed one does not count: failure rules, on the safe side.
    """
    failed = min((t.factor for t in trials if t.verdict == "failed"), default=None)
    below = [t.factor for t in trials if t.verdict == "stable" and (failed is None or t.factor < failed)]
    stable = max(below, default=None)
    undecided = sorted(
        t.factor
        for t in trials
        if t.verdict == "undecided"
        and (stable is None or t.factor > stable)
        and (failed is None or t.factor < failed)
    )
    return Bracket(stable, failed, tuple(undecided))


def next_factor(
    trials: Sequence[Trial], *, start: float, step: float, tolerance: float, limits: tuple[float, float]
) -> float | None:
    """The factor to try next, or None when the search is done.

    Parameters
    ----------
    trials : sequence of Trial
        What has been tried on this model.
    start : float
        First factor.
    step : float
        Relative step outwards while one side is open (0.3: times or divided by 1.3); it doubles every time.
    tolerance : float
        Width of [stable, failed] over its middle that ends the search. An undecided factor splits the bracket:
        the search then ends when both gaps beside it are that narrow.
    limits : (lowest, highest)
        The search ends outside of these, with the bracket open.
    """
    if not trials:
        return start
    now = bracket(trials)
    tried = sorted(t.factor for t in trials)
    if now.failed is None:
        outwards = sum(t.factor > start for t in trials)
        factor = tried[-1] * (1.0 + step * 2**outwards)
        return _within(factor, limits, tried)
    if now.stable is None:
        outwards = sum(t.factor < start for t in trials)
        factor = tried[0] / (1.0 + step * 2**outwards)
        return _within(factor, limits, tried)
    edges = [now.stable, *now.undecided, now.failed]
    # beside the known edges only: between two undecided factors nothing is to be learned for the bracket
    gaps = [(edges[1] - edges[0], edges[0], edges[1]), (edges[-1] - edges[-2], edges[-2], edges[-1])]
    width, low, high = max(gaps)
    if width <= tolerance * 0.5 * (now.stable + now.failed) * (1.0 + 1e-9):
        return None
    return 0.5 * (low + high)


def _within(factor: float, limits: tuple[float, float], tried: Sequence[float]) -> float | None:
    clipped = min(max(factor, limits[0]), limits[1])
    return None if clipped in tried else clipped
