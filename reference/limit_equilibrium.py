"""Factor of safety by the method of slices: Bishop's simplified method and Spencer's, with a search for the
critical circle.

Rules that every number here obeys
----------------------------------
- The full Mohr-Coulomb cone: a base may be in tension, and no tension crack is assumed. How much of the base
  is in tension is told with the answer.
- A surface is refused where m_alpha = cos(alpha) + sin(alpha) tan(phi)/F (in Spencer's method the same with
  alpha less the inclination of the interslice forces) is below 0.2 in any slice whose base has friction:
  there the normal force is a quotient of two small numbers and means nothing.
- A sliding mass is at least 2 % of the height of the slope thick at its thickest; without this, cohesionless
  ground would slide in a skin without thickness.
- Of Spencer's solutions on a circle only one within 30 % of Bishop's factor counts: the equations have
  further roots without meaning.
- A circle that reaches below the section follows the underside of the section instead.

Sources: A.W. Bishop, The use of the slip circle in the stability analysis of slopes, Geotechnique 5 (1955);
E. Spencer, A method of analysis of the stability of embankments assuming parallel inter-slice forces,
Geotechnique 17 (1967), here written for any surface.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.circles import Arcs, Method, admissible, arcs_through, circle_of, exact, follow, solve
from reference.ground import Array, Ground, NotASlopeError, Slices, Soil, Surcharge
from reference.slice_methods import Answer, remarks

__all__ = ["Answer", "Ground", "NotASlopeError", "Soil", "Surcharge", "bishop", "search", "spencer"]

REFUSED = 1e6
# Slices of even length see the steepest base and the greatest thickness less sharply than exact ones: what
# the search finds at the edge of a rule has to pass it on exact slices too.
SPARE_M_ALPHA, SPARE_THICKNESS = 1.3, 1.03
TITLE = {"bishop": "Bishop simplified", "spencer": "Spencer"}


def _on_circle(
    ground: Ground, circle: tuple[float, float, float], method: Method, slices: int, composite: bool
) -> Answer:
    answers = []
    for mirror in (False, True):
        facing = ground.mirrored() if mirror else ground
        try:
            arcs = circle_of(facing, (-circle[0] if mirror else circle[0], circle[1], circle[2]))
        except NotASlopeError:
            continue
        value, tilt, surface, cut, normal = exact(facing, arcs, method, slices, composite)
        if np.isfinite(value):
            answer = _report(facing, method, value, tilt, arcs, surface, cut, normal, 1)
            answers.append(_unmirror(answer) if mirror else answer)
    if not answers:
        raise NotASlopeError("the circle cuts off no mass that the method can judge")
    return min(answers, key=lambda answer: answer.factor)


def bishop(
    ground: Ground, circle: tuple[float, float, float], slices: int = 50, *, composite: bool = True
) -> Answer:
    """Bishop's simplified method on one circle.

    Parameters
    ----------
    circle : tuple of float
        x and y of the centre and radius [m].
    slices : int
        At least so many; more where the surface meets layers and bends of the ground.
    composite : bool
        A circle that leaves the section follows its underside; else it is refused.

    Raises
    ------
    NotASlopeError
        The circle cuts off no mass that the method can judge.
    """
    return _on_circle(ground, circle, "bishop", slices, composite)


def spencer(
    ground: Ground,
    surface: tuple[float, float, float] | ArrayLike,
    slices: int = 50,
    *,
    composite: bool = True,
) -> Answer:
    """Spencer's method on a circle (x, y, radius) or on a surface given by its points (n, 2) [m].

    A surface may begin below the ground: what lies above its upper end is then an empty tension crack.

    Raises
    ------
    NotASlopeError
        The surface cuts off no mass that the method can judge.
    """
    points = np.asarray(surface, dtype=np.float64)
    if points.ndim == 1:
        return _on_circle(
            ground, (float(points[0]), float(points[1]), float(points[2])), "spencer", slices, composite
        )
    from reference.noncircular import spencer_on_points

    return spencer_on_points(ground, points, slices)


# -- search --------------------------------------------------------------------------------------------------


def search(
    ground: Ground,
    method: Method = "bishop",
    slices: int = 50,
    *,
    composite: bool = True,
) -> Answer:
    """Critical circle of a section, whichever way its slopes face.

    Circles are told by where they leave and enter the ground (length along the ground surface) and by their
    central angle. A grid of them finds several separate minima, grids that shrink about these refine them,
    and the simplex method of Nelder and Mead finishes the best on slices that end at every layer.

    Parameters
    ----------
    method : {"bishop", "spencer"}
    slices : int
        Slices of the final circle.
    composite : bool
        Circles that leave the section follow its underside; else they are refused.

    Raises
    ------
    NotASlopeError
        The ground is flat, or no admissible circle exists.
    """
    if ground.height <= 1e-3 * float(np.ptp(ground.surface[:, 0])):
        raise NotASlopeError("the ground surface is level")
    answers, tried = [], 0
    for mirror in (False, True):
        facing = ground.mirrored() if mirror else ground
        hunt = _Hunt(facing, method, composite)
        answer = hunt.run(slices)
        tried += hunt.tried
        if answer is not None:
            answers.append(_unmirror(answer) if mirror else answer)
    if not answers:
        raise NotASlopeError("no circle cuts off a mass that can slide")
    return replace(min(answers, key=lambda answer: answer.factor), circles_tried=tried)


class _Hunt:
    """The search in ground that slides towards -x."""

    share_grid = np.linspace(0.06, 1.0, 14)

    def __init__(self, ground: Ground, method: Method, composite: bool) -> None:
        self.ground, self.method, self.composite = ground, method, composite
        step = np.hypot(*np.diff(ground.surface, axis=0).T)
        self.along = np.concatenate([[0.0], np.cumsum(step)])
        self.tried = 0

    def point(self, s: Array) -> Array:
        """Points (m, 2) of the ground surface at lengths s (m,) along it."""
        return np.column_stack([np.interp(s, self.along, self.ground.surface[:, i]) for i in (0, 1)])

    def arcs(self, p: Array) -> tuple[Arcs, NDArray[np.bool_]]:
        """Arcs of p (m, 3): length along the surface to the toe and to the crest, share of the angle."""
        toe, crest = self.point(p[:, 0]), self.point(p[:, 1])
        arcs, sound = arcs_through(toe, crest, p[:, 2])
        sound &= (p[:, 2] > 0.0) & (p[:, 2] <= 1.0) & (crest[:, 1] > toe[:, 1])
        return arcs, sound & (p[:, 0] >= 0.0) & (p[:, 1] <= self.along[-1])

    def factors(self, p: Array, n: int, method: Method) -> Array:
        """Factors (m,) on n slices of even length; infinite where refused."""
        arcs, sound = self.arcs(p)
        result = np.full(len(p), np.inf)
        rows = np.flatnonzero(sound)
        # Blocks that stay in the cache.
        for block in np.array_split(rows, max(1, len(rows) // 1000)):
            some = Arcs(*(v[block] for v in vars(arcs).values()))
            x = some.even_edges(n)
            y, allowed = follow(self.ground, some, x, self.composite)
            cut = self.ground.slices(x, y)
            allowed &= admissible(self.ground, cut, SPARE_THICKNESS)
            value = solve(method, cut, some, tolerance=1e-5, spare=SPARE_M_ALPHA)[0]
            result[block] = np.where(allowed & np.isfinite(value), value, np.inf)
        self.tried += len(rows)
        return result

    def stations(self) -> Array:
        """Lengths along the surface where trial circles begin and end: even, and at its sharpest bends."""
        even = np.linspace(0.0, self.along[-1], 49)
        legs = np.diff(self.ground.surface, axis=0)
        turn = np.abs(np.diff(np.unwrap(np.arctan2(legs[:, 1], legs[:, 0]))))
        sharp = np.sort(np.argsort(-turn)[:12]) + 1
        between = 0.5 * (self.along[sharp][:-1] + self.along[sharp][1:]) if len(sharp) > 1 else []
        return np.unique(np.concatenate([even, self.along[sharp], between]))

    def coarse(self, method: Method) -> Array:
        """Separate minima (k, 3) of the coarse grid, best first."""
        s = self.stations()
        i, j = np.triu_indices(len(s), 1)
        point = self.point(s)
        rises = (point[j, 1] - point[i, 1] > 0.05 * self.ground.height) & (point[j, 0] > point[i, 0])
        i, j = i[rises], j[rises]
        share = np.tile(self.share_grid, len(i))
        p = np.column_stack(
            [np.repeat(s[i], len(self.share_grid)), np.repeat(s[j], len(self.share_grid)), share]
        )
        value = self.factors(p, 20, method)
        scale = np.array([0.06 * self.along[-1], 0.06 * self.along[-1], 0.15])
        chosen: list[int] = []
        for row in np.argsort(value, kind="stable")[:4000]:
            if not np.isfinite(value[row]) or len(chosen) == 6:
                break
            if all(np.max(np.abs(p[row] - p[other]) / scale) > 1.0 for other in chosen):
                chosen.append(int(row))
        return p[chosen]

    def refine(self, p: Array, n: int, method: Method, rounds: int, spread: Array) -> tuple[Array, Array]:
        """Grids of 5 x 5 x 5 circles that shrink about each of p (k, 3)."""
        offsets = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 5)] * 3, indexing="ij"), axis=-1).reshape(
            -1, 3
        )
        best = np.full(len(p), np.inf)
        for _ in range(rounds):
            trial = p[:, None, :] + offsets * spread
            trial[..., 2] = np.clip(trial[..., 2], 1e-3, 1.0)
            trial[..., :2] = np.clip(trial[..., :2], 0.0, self.along[-1])
            value = self.factors(trial.reshape(-1, 3), n, method).reshape(len(p), -1)
            winner = np.argmin(value, axis=1)
            rows = np.arange(len(p))
            better = value[rows, winner] <= best
            p = np.where(better[:, None], trial[rows, winner], p)
            best = np.where(better, value[rows, winner], best)
            spread = 0.6 * spread
        order = np.argsort(best, kind="stable")
        return p[order], best[order]

    def run(self, slices: int) -> Answer | None:
        """The critical circle, or None where nothing slides this way."""
        from scipy.optimize import minimize

        p = self.coarse("bishop")
        if not len(p):
            return None
        spread = np.array([0.02 * self.along[-1], 0.02 * self.along[-1], 0.07])
        p, value = self.refine(p, 30, self.method, 7, spread)
        if not np.isfinite(value[0]):
            # Spencer's method refuses what Bishop's likes best: let it choose by itself.
            p = self.coarse(self.method)
            if not len(p):
                return None
            p, value = self.refine(p, 30, self.method, 7, spread)
        if not np.isfinite(value[0]):
            return None

        def objective(q: Array) -> float:
            arcs, sound = self.arcs(q[None, :])
            self.tried += 1
            if not sound[0]:
                return REFUSED
            factor = exact(self.ground, arcs, self.method, slices, self.composite)[0]
            return factor if np.isfinite(factor) else REFUSED

        # On the edge of what a method can judge, exact slices may be refused where even ones were not.
        results: list[Any] = []
        for start, rough in zip(p, value, strict=True):
            if len(results) == 2 or (results and rough > 1.01 * value[0]) or objective(start) >= REFUSED:
                continue
            simplex = start + np.vstack([np.zeros(3), np.diag(0.2 * spread)])
            result = minimize(
                objective,
                start,
                method="Nelder-Mead",
                options={"initial_simplex": simplex, "xatol": 1e-5, "fatol": 1e-6, "maxfev": 150},
            )
            results.append(result)
        if not results:
            return None
        best = min(results, key=lambda result: float(result.fun))
        arcs, _ = self.arcs(best.x[None, :])
        factor, tilt, surface, cut, normal = exact(self.ground, arcs, self.method, slices, self.composite)
        return _report(self.ground, self.method, factor, tilt, arcs, surface, cut, normal, self.tried)


# -- answers -------------------------------------------------------------------------------------------------


def _report(
    ground: Ground,
    method: Method,
    factor: float,
    tilt: float | None,
    arcs: Arcs,
    surface: Array,
    cut: Slices,
    normal: Array,
    tried: int,
) -> Answer:
    notes = remarks(ground, cut, normal)
    if np.any(
        np.hypot(surface[:, 0] - arcs.x_centre[0], surface[:, 1] - arcs.y_centre[0])
        < (1 - 1e-6) * arcs.radius[0]
    ):
        notes.append("The circle reaches below the section and follows its underside there.")
    centre = (float(arcs.x_centre[0, 0]), float(arcs.y_centre[0, 0]))
    radius = float(arcs.radius[0, 0])
    count = int(np.count_nonzero(cut.width > 0.0))
    return Answer(TITLE[method], factor, centre, radius, surface, count, tried, tuple(notes), tilt)


def _unmirror(answer: Answer) -> Answer:
    centre = None if answer.centre is None else (-answer.centre[0], answer.centre[1])
    return replace(answer, centre=centre, surface=answer.surface[::-1] * [-1.0, 1.0])
