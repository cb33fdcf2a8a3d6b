"""Ground at collapse with answers from limit analysis: a tunnel in clay, a strip footing."""

from __future__ import annotations

import math
import time

import numpy as np
import shapely
from numpy.typing import NDArray

from geodem.builders.ground import around_load_edge, held_freedoms, pressure_load, surface_between
from geodem.builders.particles import Particles, fill_section
from geodem.integrators.direct_solve import solve_elastic
from geodem.model import Model
from geodem.simulation import Simulation
from geodem.stability.criteria import Criteria
from geodem.stability.methods import GravityIncrease, LoadIncrease, Method
from geodem.stability.search import Search

from .ground_elastic import ground, material, quarter_arc, section
from .rows import Row, relative

TUNNEL = {  # C/D: sigma_s/c_u without weight, gamma D/c_u without surcharge
    1.0: ((2.427, 2.444), (2.00, 2.02)),
    2.0: ((3.436, 3.468), (1.498, 1.511)),
}
"""At collapse by finite-element limit analysis, lower and upper bound."""

BEARING = {0.0: math.pi + 2.0, 30.0: 30.14}
"""N_c of weightless ground: Prandtl 1921."""


def collapse_factor(model: Model, method: type[LoadIncrease] | type[GravityIncrease]) -> tuple[float, int]:
    """Middle of a bracket 0.5 % wide, sought from a factor of one on, and the steps it took."""
    simulation = Simulation(model, energy=False)
    driver: Method = method(simulation)
    search = Search(simulation, driver, Criteria(), tolerance=0.005)
    value = search.run().value
    assert value is not None
    return value, sum(trial.steps for trial in search.trials)


def tunnel_particles(cover: float, particles: int) -> Particles:
    """Half of the ground around a circular tunnel of diameter 1 m at a depth of `cover` metres to its crown.

    cover + 3 m wide and 1.5 m deep below the invert.
    """
    depth, width = cover + 0.5, cover + 3.0
    right = quarter_arc(0.5)
    # symmetry line, from the invert round the right side of the hole to the crown
    hole = np.concatenate([(right * [1.0, -1.0])[::-1], right[1:]])
    low, high = -2.0, depth
    outline = shapely.Polygon([(0.0, low), (width, low), (width, high), (0.0, high), *hole[::-1]])
    fine = 0.06 * math.sqrt(2500.0 / particles) * (1.0 + 0.3 * (cover - 1.0))
    return fill_section(
        section(outline),
        particles=particles,
        refine=[(shapely.LineString(hole), fine)],
        grading=0.1,
        points=[hole[0], hole[-1]],
    )


def tunnel(cover: float, kind: str, particles: int = 2500, poisson: float = 0.3) -> Row:
    """Collapse of an unlined circular tunnel in uniform clay (phi = 0), C/D = `cover`.

    `kind` "surcharge": weightless, pressure on the whole surface; "self-weight": gravity alone. The error is against
    the middle of lower and upper bound.
    """
    started = time.perf_counter()
    filled = tunnel_particles(cover, particles)
    positions = filled.positions
    held = held_freedoms(filled, {"left": "roller", "right": "roller", "bottom": "fixed"})
    clay = material(young=500.0, poisson=poisson, cohesion=1.0)
    if kind == "surcharge":
        edges = filled.boundary_edges
        top = edges[(positions[edges, 1] > positions[:, 1].max() - 1e-9).all(axis=1)]
        model = ground(filled, clay, held=held, load=pressure_load(positions, top, 1.0))
        bounds = TUNNEL[cover][0]
        found, _ = collapse_factor(model, LoadIncrease)
    else:
        model = ground(filled, clay, held=held, unit_weight=1.0)
        bounds = TUNNEL[cover][1]
        found, _ = collapse_factor(model, GravityIncrease)
    quantity = "sigma_s/c_u" if kind == "surcharge" else "gamma D/c_u"
    expected = 0.5 * (bounds[0] + bounds[1])
    seconds = time.perf_counter() - started
    return relative(f"P17 tunnel, C/D {cover:g}", f"{quantity} at collapse", found, expected, 0.015, seconds)


def footing_particles(friction: float, particles: int, seed: int = 1) -> Particles:
    """Half of the ground below a strip footing 2 m wide, refined at its edge.

    The failure mechanism of Prandtl reaches 2 m (phi 0) and 8.6 m (phi 30) beyond the edge.
    """
    width, depth = (5.0, 2.5) if friction == 0.0 else (12.0, 5.0)
    edge = (1.0, 0.0)
    below = shapely.LineString([(0.0, 0.0), edge])
    fine = (0.06 if friction == 0.0 else 0.09) * math.sqrt(2500.0 / particles)
    return fill_section(
        section(shapely.box(0.0, -depth, width, 0.0)),
        particles=particles,
        refine=[(below, fine)],
        grading=0.1,
        points=[edge],
        seed=seed,
    )


def footing_pressure(friction: float, particles: int = 2500, seed: int = 1) -> Row:
    """Uniform pressure on a strip of weightless ground, c = 1 Pa, psi = phi: q = N_c c."""
    started = time.perf_counter()
    filled = footing_particles(friction, particles, seed)
    held = held_freedoms(filled, {"left": "roller", "right": "roller", "bottom": "fixed"})
    strip = surface_between(filled, (0.0, 0.0), (1.0, 0.0), place="footing")
    model = ground(
        filled,
        material(young=1000.0, poisson=0.3, cohesion=1.0, friction=friction),
        held=held,
        load=pressure_load(filled.positions, strip, 1.0),
        split=around_load_edge(filled.triangles, _particle_at(filled, 1.0, 0.0)),
    )
    found, _ = collapse_factor(model, LoadIncrease)
    seconds = time.perf_counter() - started
    bound = 0.015 if friction == 0.0 else 0.025
    return relative(
        f"P29 footing, phi {friction:g}", "q/c, pressure", found, BEARING[friction], bound, seconds
    )


def footing_plate(friction: float, particles: int = 2500, *, rough: bool = True) -> list[Row]:
    """A rigid plate pushed into the same ground until its force grows no more.

    The plate holds the particles at 0 <= x <= 1 m. It is as wide as the ground that it strains: to half-way
    between its last particle and the next, as finite-difference codes count it. Over the bare 1 m the pressure is
    higher by that half of a spacing; the second row shows it, with a bound that is wider by as much.
    """
    started = time.perf_counter()
    filled = footing_particles(friction, particles)
    positions = filled.positions
    held = held_freedoms(filled, {"left": "roller", "right": "roller", "bottom": "fixed"})
    top = positions[:, 1] > -1e-9
    plate = top & (positions[:, 0] < 1.0 + 1e-9)
    width = 0.5 * (1.0 + float(positions[top & ~plate, 0].min()))
    held[plate, 1] = True
    if rough:
        held[plate, 0] = True
    model = ground(
        filled,
        material(young=1000.0, poisson=0.3, cohesion=1.0, friction=friction),
        held=held,
        split=around_load_edge(filled.triangles, _particle_at(filled, 1.0, 0.0)),
    )
    force = limit_force(model, plate)
    seconds = time.perf_counter() - started
    quantity = f"q/c, {'rough' if rough else 'smooth'} plate"
    bound = 0.015 if friction == 0.0 else 0.025
    name, expected = f"P29 footing, phi {friction:g}", BEARING[friction]
    return [
        relative(name, quantity, force / width, expected, bound, seconds),
        relative(name, f"{quantity}, over its bare width", force, expected, bound + width - 1.0, seconds),
    ]


def limit_force(model: Model, plate: NDArray[np.bool_]) -> float:
    """Force [N/m] on a plate that is pushed down in steps, once ten steps add less than 0.05 %.

    Every step adds the elastic answer of the ground to half a newton more, which is then relaxed with the plate
    at rest; the reaction is the unbalanced force of the held particles. Longer strides let the ground spring back
    within one, and end below the limit.
    """
    simulation = Simulation(model, energy=False)
    pushed = np.zeros_like(model.positions)
    pushed[plate, 1] = -1.0
    moved, unit = solve_elastic(model, np.zeros_like(pushed), matrix=simulation.matrix, prescribed=pushed)
    reaction = -(simulation.matrix @ moved.ravel()).reshape(-1, 2)[plate, 1].sum()
    step = 0.5 / reaction
    forces = [0.0]
    while len(forces) < 400:
        state = simulation.state
        simulation.begin(state.stress[:, :3] + step * unit, displacement=state.displacement + step * moved)
        simulation.relax(1e-4, max_steps=20_000)
        forces.append(float(simulation.state.force[plate, 1].sum()))
        if len(forces) > 20 and max(forces) < 1.0005 * max(forces[:-10]):
            break
    return forces[-1]


def _particle_at(filled: Particles, x: float, y: float) -> int:
    return int(np.argmin(np.hypot(filled.positions[:, 0] - x, filled.positions[:, 1] - y)))
