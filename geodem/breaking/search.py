"""Search for a factor of bonded ground, by gravity or by strength; every trial goes on from a state that stands.

Trials are true motion under local damping: the load or the strength is changed gradually from the last state that
stands, then held until the ground is at rest, has failed, or nobody can tell (`geodem.breaking.criteria`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..io.checkpoint import Tree
from ..stability.bracket import Bracket, Trial, bracket, next_factor
from .criteria import Criteria, most_moved
from .site import BATCH, Site, table_of
from .watching import Watcher


@dataclass(frozen=True)
class Method:
    """What a factor does.

    Attributes
    ----------
    kind : str
        As it is called everywhere.
    meaning : str
        What the factor is.
    lowest, highest : float
        Where a search ends with its bracket open.
    """

    kind: str
    meaning: str
    lowest: float
    highest: float

    def value(self, site: Site) -> float:
        """The factor that a site is at."""
        return site.gravity_factor if self.kind == GRAVITY.kind else site.strength_factor

    def apply(self, site: Site, factor: float) -> None:
        """Bring a site to a factor at once."""
        if self.kind == GRAVITY.kind:
            site.set_gravity(factor)
        else:
            site.set_strength(factor)


GRAVITY = Method(
    "gravity-increase",
    "load factor: gravity at which the ground fails over gravity; not a factor of safety",
    0.02,
    1000.0,
)
STRENGTH = Method(
    "strength-reduction",
    "strength of bonds and friction over the strength at which the ground fails",
    0.02,
    200.0,
)
METHODS = {method.kind: method for method in (GRAVITY, STRENGTH)}


@dataclass(frozen=True)
class SearchPlan:
    """How a factor is looked for.

    Attributes
    ----------
    kind : str
        Name in `METHODS`.
    start, step : float
        First factor, and the relative step outwards, which doubles, until both sides are known [-].
    tolerance : float
        Width of [stable, failed] over its middle [-].
    highest : float
        The search ends there with the bracket open [-].
    criteria : Criteria
    goes_on : str
        What later stages go on from: "start", where the search began, "stable" or "failed".
    """

    kind: str
    start: float = 1.0
    step: float = 0.5
    tolerance: float = 0.05
    highest: float = 100.0
    criteria: Criteria = field(default_factory=Criteria)
    goes_on: str = "start"

    @property
    def method(self) -> Method:
        """What the factor does."""
        return METHODS[self.kind]


@dataclass
class Search:
    """A search under way; everything that goes on from a stop is in `tree`.

    Attributes
    ----------
    plan : SearchPlan
    base : Tree
        The site at the start.
    trials : list of Trial
    stable, failed : Tree or None
        The sites of the highest stable and the lowest failed trial.
    rows : list of tuples
        History of all trials, see `Site.columns`.
    """

    plan: SearchPlan
    base: Tree
    trials: list[Trial] = field(default_factory=list)
    stable: Tree | None = None
    failed: Tree | None = None
    rows: list[tuple[float, ...]] = field(default_factory=list)

    @property
    def bracket(self) -> Bracket:
        """What the trials say."""
        return bracket(self.trials)

    def next_factor(self) -> float | None:
        """The factor to try next; None when the search is done."""
        plan = self.plan
        limits = (plan.method.lowest, min(plan.highest, plan.method.highest))
        found = next_factor(
            self.trials, start=plan.start, step=plan.step, tolerance=plan.tolerance, limits=limits
        )
        return None if found is None else round(found, 5)

    def run(self, watcher: Watcher, kept: Callable[[Search], None] | None = None) -> Site:
        """Run to the end; the site that later stages go on from. `kept` is called after every trial.

        Raises
        ------
        StoppedError
            The watcher said so; the trial under way is lost, those before are not.
        """
        while (factor := self.next_factor()) is not None:
            self._try(factor, watcher)
            if kept is not None:
                kept(self)
        return self._end()

    def _try(self, factor: float, watcher: Watcher) -> None:
        begun = time.perf_counter()
        method, criteria = self.plan.method, self.plan.criteria
        now = self.bracket
        higher = now.stable is not None and now.stable < factor
        site = Site.from_tree(self.stable if higher and self.stable is not None else self.base)
        first = method.value(site)
        site.place = (site.place[0], factor)
        site.history = []
        s = site.simulation
        size = len(site.origin), s.dimension
        if factor != first:
            ramp = criteria.ramp_steps(*size)
            watcher.told(f"factor {factor:.4g}, being reached")
            site.ramp(lambda share: method.apply(site, first + share * (factor - first)), ramp, watcher)
        method.apply(site, factor)
        most = limit = criteria.most_steps(*size)
        since = site.positions_of_all()
        looks: list[tuple[int, float, float]] = []
        answer = None
        while answer is None:
            site.advance(BATCH, watcher)
            ways = np.sqrt((site.displacement(since) ** 2).sum(axis=1))
            way = most_moved(ways, criteria.moving_share)
            looks.append((len(looks) * BATCH + BATCH, s.unbalanced_ratio(), way))
            answer = criteria.judge(looks, site.diameter, most)
            if answer is not None and answer[0] == "undecided" and most <= criteria.longer * limit:
                most, answer = most + limit, None
            watcher.told(
                f"factor {factor:.4g}, {looks[-1][0]:,} of at most {most:,} steps, "
                f"moved {way / site.diameter:.2g} diameters"
            )
        total = self._total(site)
        verdict, criterion = criteria.count_all(answer, total, site.diameter)
        steps, ratio, _ = looks[-1]
        self.trials.append(
            Trial(
                factor, verdict, criterion, steps, ratio, total, s.assembly.particles, "fine",
                time.perf_counter() - begun, looks,
            )
        )  # fmt: skip
        self.rows += site.history
        self._remember(site, factor, verdict)

    def _total(self, site: Site) -> float:
        """Way of what moves most since the search began, beyond the settlement of unbroken ground [m]."""
        begun = Site.from_tree(self.base)
        added = site.gravity_factor - begun.gravity_factor
        ways = site.displacement(begun.positions_of_all()) - added * site.per_gravity[site.number]
        return most_moved(np.sqrt((ways**2).sum(axis=1)), self.plan.criteria.moving_share)

    def _end(self) -> Site:
        """The site that later stages go on from, with the history of all trials."""
        wanted = {"stable": self.stable, "failed": self.failed}.get(self.plan.goes_on)
        site = Site.from_tree(wanted if wanted is not None else self.base)
        site.history = [*Site.from_tree(self.base).history, *self.rows]
        site.place = (site.place[0], math.nan)
        return site

    def _remember(self, site: Site, factor: float, verdict: str) -> None:
        now = self.bracket
        site.history = []
        if now.stable == factor and verdict == "stable":
            self.stable = site.tree()
        elif now.failed == factor and verdict == "failed":
            self.failed = site.tree()
            if self.stable is not None and now.stable is None:
                self.stable = None

    # ------------------------------------------------------------------ kept and brought back

    def tree(self) -> Tree:
        """What goes on from a stop, as a checkpoint tree."""
        found: Tree = {
            "plain": {"trials": [trial.as_dict(history=True) for trial in self.trials]},
            "rows": table_of(self.rows),
        }
        for name, tree in (("stable", self.stable), ("failed", self.failed)):
            if tree is not None:
                found[name] = tree
        return found

    def take_up(self, tree: dict[str, Any]) -> None:
        """Go on where `tree` was made."""
        self.trials = [
            Trial(**{**row, "history": [tuple(look) for look in row["history"]]})
            for row in tree["plain"]["trials"]
        ]
        self.rows = [tuple(row) for row in tree["rows"].tolist()]
        self.stable, self.failed = tree.get("stable"), tree.get("failed")
