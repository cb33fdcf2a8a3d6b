"""From a section and a number or a spacing to a mesh of particles: forecast, fill, solve for the number."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from geodem.builders.memory import available_bytes
from geodem.builders.outline import Boundary, Floats, Graph, join, place_along
from geodem.builders.packing import Inside, cells, insert_at_random, lattice, rows_across
from geodem.builders.size_field import Layout, SizeField, lay_out
from geodem.builders.triangulation import Mesh
from geodem.errors import InputError

if TYPE_CHECKING:
    from geodem.builders.section import Section

Packing = Literal["random", "hexagonal"]
Thin = Literal["refine", "refuse"]

EQUILATERAL = 0.25 * math.sqrt(3.0)
# particle, its triangles, springs of a run and its outputs
BYTES_PER_PARTICLE = 1000
COUNT_TOLERANCE = 0.02
# refined places take too much where the spacing elsewhere is this much larger than an even one would be
STARVED = 1.6
# growth of the spacing away from refined places, the steeper ones where particles are short; beyond the last,
# smallest angles fall below 20 degrees
GRADINGS = (0.25, 0.4, 0.6)


class TooFewParticlesError(InputError):
    """Corners, thin regions or refined places use up all particles; `needed` of them are enough."""

    def __init__(self, problem: str, remedy: str, *, value: int, needed: int) -> None:
        super().__init__("particles", problem, remedy, value=value)
        self.needed = needed


@dataclass(frozen=True)
class FillTask:
    """What is asked of a packing, apart from its spacing; `gradings` are those that may be tried for `grading`."""

    section: Section
    graph: Graph
    free: Floats
    packing: Packing
    seed: int
    layers: int
    thin: Thin
    shapes: tuple[tuple[Any, float], ...]
    focus: tuple[tuple[Any, float], ...]
    grading: float
    gradings: tuple[float, ...]
    most: int


@dataclass(frozen=True)
class Draft:
    """Lines filled and count foreseen for one spacing."""

    layout: Layout
    boundary: Boundary
    inside: Inside
    grid: tuple[Floats, Floats]
    count: float


def draft_filling(task: FillTask, base: float) -> Draft:
    """Particles on the lines and a forecast of their total for a base spacing."""
    import shapely

    layout = lay_out(
        task.section,
        task.graph,
        task.free,
        base,
        layers=task.layers,
        grading=task.grading,
        shapes=(*task.shapes, *((geometry, ratio * base) for geometry, ratio in task.focus)),
        heed_thin=task.thin == "refine",
    )
    foreseen = int(0.25 * task.layers * len(layout.thin.places)) if task.thin == "refine" else 0
    if foreseen > task.most:
        raise too_many(foreseen, "layers", task.layers, task.most)
    field = layout.field
    runs, _ = place_along(layout.chains, field, field.smallest)
    boundary = join(layout.chains, runs, task.graph.vertices)
    inside = Inside(task.section.outline, boundary)
    grid = cells(field, task.section.bounds, inside)
    outer = _outer_edges(boundary, task.section)
    holes = sum(len(part.interiors) for part in shapely.get_parts(task.section.outline).tolist())
    pieces = shapely.get_num_geometries(task.section.outline)
    # Euler: triangles = 2 n - boundary edges - 2 (pieces - holes)
    count = 0.5 * (wanted_triangles(field, grid, inside) + outer) + pieces - holes
    return Draft(layout, boundary, inside, grid, float(count))


def wanted_triangles(field: SizeField, grid: tuple[Floats, Floats], inside: Inside) -> float:
    import shapely

    centres, sides = grid
    ground = shapely.contains_xy(inside.ground, centres[:, 0], centres[:, 1])
    local = np.full(int(ground.sum()), field.base) if field.uniform else field(centres[ground])
    return float((sides[ground] ** 2 / (EQUILATERAL * local**2)).sum())


def _outer_edges(boundary: Boundary, section: Section) -> int:
    """Number of edges with ground on one side only."""
    import shapely

    a, b = boundary.positions[boundary.edges[:, 0]], boundary.positions[boundary.edges[:, 1]]
    off = 1e-3 * np.column_stack([a[:, 1] - b[:, 1], b[:, 0] - a[:, 0]])
    left, right = 0.5 * (a + b) + off, 0.5 * (a + b) - off
    both = shapely.contains_xy(section.outline, left[:, 0], left[:, 1])
    both &= shapely.contains_xy(section.outline, right[:, 0], right[:, 1])
    return int((~both).sum())


def fill(task: FillTask, draft: Draft) -> tuple[Mesh, int]:
    """Particles inside, as they fall, joined; and the number that fits the spacing."""
    field, inside = draft.layout.field, draft.inside
    rng = np.random.default_rng(task.seed)
    held = np.concatenate([draft.boundary.positions, task.free])
    rows = rows_across(draft.boundary, field, inside, task.layers)
    regular = np.empty((0, 2))
    grid = draft.grid
    if task.packing == "hexagonal":
        regular = lattice(field, task.section.bounds, inside, np.concatenate([held, rows]))
        # a lattice cannot be graded: refined places are filled as in a random packing
        fine = np.zeros(len(grid[0]), dtype=bool) if field.uniform else field(grid[0]) < 0.9 * field.base
        grid = (grid[0][fine], grid[1][fine])
    still = np.concatenate([held, rows, regular])
    loose = insert_at_random(still, field, grid, inside, rng) if len(grid[0]) else np.empty((0, 2))
    positions = np.concatenate([still, loose])
    movable = np.arange(len(positions)) >= len(still)
    if len(regular):
        # the lattice ends at an arbitrary distance from the lines; its rim closes the gap
        movable[len(held) + len(rows) : len(still)] = inside.clearance(regular) < 1.5 * field.base
    mesh = Mesh(
        positions=positions,
        edges=draft.boundary.edges,
        held=np.arange(len(positions)) < len(held),
        movable=movable,
        spacing=field(positions),
        inside=inside,
    )
    mesh.follow_lines()
    natural = len(mesh.positions)
    if task.packing == "random":
        natural += round(mesh.shortage())
    return mesh, natural


def settle(task: FillTask, field: SizeField, mesh: Mesh, count: int | None) -> Mesh:
    """Bring the number to `count`, then smooth until the triangles are good."""
    if count is not None and (task.packing == "random" or abs(len(mesh.positions) - count) > 0.01 * count):
        mesh.reach_count(count, field)
    mesh.relax(3 if task.packing == "random" else 2, 1.5)
    mesh.follow_lines()
    mesh.polish(4)
    mesh.mend_slivers(field, 4)
    return mesh


def pack_count(task: FillTask, count: int) -> tuple[Draft, Mesh]:
    """Solve for the spacing that gives `count` particles, then pack.

    Where refined places leave too few particles for the rest, the spacing may grow faster away from them.
    """
    west, south, east, north = task.section.bounds
    coarsest = 0.5 * min(east - west, north - south)
    even = math.sqrt(task.section.outline.area / (2.0 * EQUILATERAL * count))
    for grading in task.gradings:
        last = grading == task.gradings[-1]
        task = replace(task, grading=grading)
        try:
            draft = _solve_spacing(task, draft_filling(task, min(coarsest, even)), count, 1.0, coarsest)
        except TooFewParticlesError:
            if last:
                raise
            continue
        if last or draft.layout.field.base <= STARVED * even:
            break
    draft, mesh = _solve_by_filling(task, draft, count, coarsest)
    for _ in range(3):
        mesh = settle(task, draft.layout.field, mesh, count)
        found = len(mesh.positions)
        if abs(found - count) <= max(COUNT_TOLERANCE * count, 2.0):
            return draft, mesh
        # mending took more particles out of narrow places, or put more in, than the count allows
        draft = draft_filling(task, min(coarsest, draft.layout.field.base * math.sqrt(found / count)))
        mesh, _ = fill(task, draft)
    problem = f"the corners and boundaries of the section lead to {found} particles"
    remedy = f"Give {found} particles, or a spacing instead of their number."
    if found < count:
        raise InputError("particles", problem, remedy, value=count)
    raise TooFewParticlesError(problem, remedy, value=count, needed=found)


def _solve_by_filling(task: FillTask, draft: Draft, count: int, coarsest: float) -> tuple[Draft, Mesh]:
    """Correct the forecast by what a filling gives, until that is `count` within what can be made up for."""
    mesh, natural = fill(task, draft)
    for _ in range(3):
        if abs(natural - count) <= 0.03 * count:
            break
        # the forecast knows neither rows nor how particles stand at the lines; its error hardly changes
        draft = _solve_spacing(task, draft, count, natural / draft.count, coarsest)
        mesh, natural = fill(task, draft)
    return draft, mesh


def _solve_spacing(task: FillTask, draft: Draft, count: int, bias: float, coarsest: float) -> Draft:
    """Draft whose forecast, times `bias`, is `count`: secant steps in logarithms, between the nearest two.

    The forecast jumps where a region becomes thin or a vertex a corner; what is left after a few steps is
    made up by inserting or taking out particles.
    """
    slope = -2.0
    low, high = 0.0, coarsest
    best = draft
    for _ in range(8):
        error = math.log(draft.count * bias / count)
        if abs(error) < abs(math.log(best.count * bias / count)):
            best = draft
        if abs(error) < 0.01:
            break
        base = draft.layout.field.base
        if base >= coarsest and error > 0.02:
            raise _budget_eaten(task, draft, count, draft.count * bias)
        # a refined region answers little to the base spacing, never more than the square
        step = min(max(-error / slope, -1.0), 1.0)
        low, high = (base, high) if error > 0.0 else (low, base)
        target = min(coarsest, base * math.exp(step))
        if not low < target <= high:
            target = math.sqrt(low * high) if low > 0.0 else 0.5 * high
        if high < 1.002 * low:
            break
        other = draft_filling(task, target)
        moved = math.log(other.layout.field.base / base)
        if moved:
            slope = min(max(math.log(other.count / draft.count) / moved, -2.2), -0.3)
        draft = other
    return best


def _budget_eaten(task: FillTask, draft: Draft, count: int, least: float) -> TooFewParticlesError:
    thin = draft.layout.thin
    needed = math.ceil(1.1 * least / 10.0) * 10
    if not len(thin.places):
        return TooFewParticlesError(
            "too few for the corners and refined places of this section",
            f"Give at least {needed}.",
            value=count,
            needed=needed,
        )
    worst = int(np.argmin(thin.thickness))
    name = task.section.regions[int(thin.region[worst])].material
    return TooFewParticlesError(
        f"the region of {name!r} is only {thin.thickness[worst]:.3g} m thick, and its {task.layers} layers "
        "use up all particles",
        f"Give at least {needed} particles, or fewer layers.",
        value=count,
        needed=needed,
    )


def refuse_thin(task: FillTask, draft: Draft) -> None:
    thin = draft.layout.thin
    if task.thin == "refine" or not len(thin.places):
        return
    worst = int(np.argmin(thin.thickness))
    name = task.section.regions[int(thin.region[worst])].material
    fine = float(thin.thickness[worst]) / task.layers
    raise InputError(
        "thin",
        f"the region of {name!r} is only {thin.thickness[worst]:.3g} m thick, so that a spacing of "
        f"{draft.layout.field.base:.3g} m gives it fewer than {task.layers} layers",
        f"Give a spacing of {fine:.3g} m everywhere (about {uniform_count(task.section, fine)} particles), "
        'or thin = "refine".',
        value=task.thin,
    )


def uniform_count(section: Section, spacing: float) -> int:
    return math.ceil(section.outline.area / (2.0 * EQUILATERAL * spacing**2))


def too_many(count: int, place: str, value: object, most: int) -> InputError:
    return InputError(
        place,
        f"about {count} particles need {count * BYTES_PER_PARTICLE / 1e9:.1f} GB, more than the free memory",
        f"Stay below {most} particles: a larger spacing, fewer particles or fewer layers in thin regions.",
        value=value,
    )


def most_particles() -> int:
    """Particles that the free memory holds; 10 million where the system does not tell."""
    free = available_bytes()
    return 10_000_000 if free is None else free // BYTES_PER_PARTICLE
