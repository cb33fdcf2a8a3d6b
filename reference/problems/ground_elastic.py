"""Elastic ground with closed-form answers: a flat deposit, a hole in a stressed plate, a thick cylinder."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from geodem.builders.ground import held_freedoms
from geodem.builders.particles import Particles, fill_section
from geodem.builders.section import Region, Section
from geodem.integrators.direct_solve import solve_elastic
from geodem.laws.ground import mohr_coulomb
from geodem.model import Model, build_model
from geodem.simulation import Simulation

from .rows import Row, relative

Floats = NDArray[np.float64]
Stress = Callable[[Floats], Floats]

ARC = 128
"""Corners given for a quarter of a circle; the particles are spread along them."""


def material(
    *, young: float, poisson: float, cohesion: float = 1e30, friction: float = 0.0
) -> mohr_coulomb.MohrCoulombParameters:
    """Mohr-Coulomb parameters with psi = phi and no tension cut-off; angles in degrees."""
    angle = math.radians(friction)
    return mohr_coulomb.parameters(
        young_modulus=young,
        poisson_ratio=poisson,
        cohesion=cohesion,
        friction_angle=angle,
        dilation_angle=angle,
        tensile_strength=math.inf,
    )


def section(outline: Any) -> Section:
    """A section of one material from a shapely polygon."""
    return Section((Region("ground", outline),))


def quarter_arc(radius: float, *, clockwise: bool = False) -> Floats:
    """Corners (ARC + 1, 2) [m] of a quarter circle around the origin, from (r, 0) to (0, r) or back."""
    angle = np.linspace(0.0, 0.5 * math.pi, ARC + 1)
    points = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points[0, 1] = points[-1, 0] = 0.0
    return points[::-1] if clockwise else points


def ground(
    particles: Particles,
    parameters: Any,
    *,
    held: NDArray[np.bool_],
    load: Floats | None = None,
    unit_weight: float = 0.0,
    split: Sequence[tuple[int, int]] = (),
) -> Model:
    """A model of one material with loads (n, 2) [N/m] and a unit weight [N/m3]."""
    return build_model(
        particles.positions,
        particles.triangles,
        particles.triangle_material,
        material_names=particles.materials,
        law="mohr_coulomb",
        parameters=[parameters],
        densities=[unit_weight],
        gravity=(0.0, -1.0),
        load=np.zeros_like(particles.positions) if load is None else load,
        held=held,
        split=split,
    )


def boundary_traction(particles: Particles, on: NDArray[np.bool_], stress: Stress) -> Floats:
    """Nodal forces (n, 2) [N/m] of a stress field on the boundary edges between particles in `on`.

    Two Gauss points an edge, exact for a stress that varies up to the square along it.
    """
    positions, edges = particles.positions, particles.boundary_edges
    edges = edges[on[edges].all(axis=1)]
    start, end = positions[edges[:, 0]], positions[edges[:, 1]]
    along = end - start
    outwards = np.stack([along[:, 1], -along[:, 0]], axis=1)
    load = np.zeros_like(positions)
    for share in (0.5 - 0.5 / math.sqrt(3.0), 0.5 + 0.5 / math.sqrt(3.0)):
        xx, yy, xy = stress(start + share * along).T
        force = 0.5 * np.stack(
            [xx * outwards[:, 0] + xy * outwards[:, 1], xy * outwards[:, 0] + yy * outwards[:, 1]], axis=1
        )
        np.add.at(load, edges[:, 0], (1.0 - share) * force)
        np.add.at(load, edges[:, 1], share * force)
    return load


def polar(stress: Floats, positions: Floats) -> Floats:
    """(n, 3) stresses xx, yy, xy turned to rr, tt, rt around the origin."""
    angle = np.arctan2(positions[:, 1], positions[:, 0])
    c, s = np.cos(angle), np.sin(angle)
    xx, yy, xy = stress.T[:3]
    rr = xx * c * c + yy * s * s + 2.0 * xy * s * c
    rt = (yy - xx) * s * c + xy * (c * c - s * s)
    return np.stack([rr, xx + yy - rr, rt], axis=1)


def kirsch_stress(positions: Floats, radius: float, horizontal: float, vertical: float) -> Floats:
    """Stress (n, 3) xx, yy, xy around a hole in a plate under far stresses: Kirsch 1898."""
    x, y = positions.T
    r, angle = np.hypot(x, y), np.arctan2(y, x)
    mean, deviator = 0.5 * (horizontal + vertical), 0.5 * (horizontal - vertical)
    k = (radius / r) ** 2
    cosine, sine = np.cos(2.0 * angle), np.sin(2.0 * angle)
    rr = mean * (1.0 - k) + deviator * (1.0 - 4.0 * k + 3.0 * k * k) * cosine
    tt = mean * (1.0 + k) - deviator * (1.0 + 3.0 * k * k) * cosine
    rt = -deviator * (1.0 + 2.0 * k - 3.0 * k * k) * sine
    c, s = np.cos(angle), np.sin(angle)
    return np.stack(
        [
            rr * c * c + tt * s * s - 2.0 * rt * s * c,
            rr * s * s + tt * c * c + 2.0 * rt * s * c,
            (rr - tt) * s * c + rt * (c * c - s * s),
        ],
        axis=1,
    )


def geostatic(particles: int = 2500) -> list[Row]:
    """A level deposit on a fixed base between rollers: sigma_yy = gamma z, sigma_xx = nu/(1 - nu) sigma_yy.

    40 m wide, 20 m deep. Read at depths of 10 to 16 m; once solved, once relaxed by steps with high strength
    from a stress-free start.
    """
    unit_weight, poisson, depth = 20e3, 0.3, 20.0
    started = time.perf_counter()
    filled = fill_section(section(shapely.box(0.0, 0.0, 40.0, depth)), particles=particles)
    held = held_freedoms(filled, {"left": "roller", "right": "roller", "bottom": "fixed"})
    model = ground(
        filled,
        material(young=50e6, poisson=poisson, cohesion=1e7, friction=30.0),
        held=held,
        unit_weight=unit_weight,
    )
    simulation = Simulation(model)
    below = (filled.positions[:, 1] > 4.0) & (filled.positions[:, 1] < 10.0)
    coefficient = poisson / (1.0 - poisson)
    rows = []
    solved = simulation.particle_stress()
    at = time.perf_counter() - started
    simulation.begin(np.zeros_like(simulation.elastic.stress))
    simulation.relax(1e-7)
    relaxed = simulation.particle_stress()
    for label, stress, seconds in (
        ("solved", solved, at),
        ("relaxed", relaxed, time.perf_counter() - started),
    ):
        overburden = -unit_weight * (depth - filled.positions[below, 1])
        vertical = stress[below, 1] / overburden
        ratio = stress[below, 0] / stress[below, 1]
        worst = vertical[np.argmax(np.abs(vertical - 1.0))]
        rows.append(
            relative(
                "geostatic", f"mean sigma_yy / gamma z, {label}", float(vertical.mean()), 1.0, 1e-3, seconds
            )
        )
        rows.append(
            relative("geostatic", f"worst sigma_yy / gamma z, {label}", float(worst), 1.0, 0.02, seconds)
        )
        rows.append(
            relative("geostatic", f"mean K0, {label}", float(ratio.mean()), coefficient, 1e-2, seconds)
        )
    return rows


def kirsch(particles: int = 2500) -> list[Row]:
    """Hole of radius 1 m under 10 MPa horizontally and 30 MPa vertically: 80 MPa at the side wall.

    A quarter of a plate of 8 m by 8 m; its outer sides carry the tractions of the exact solution, so that its
    size does not matter. The wall stress is that of the one particle on the wall at the side, as it stands; it is
    a mean over the ground next to it, over which the exact stress falls.
    """
    horizontal, vertical, radius, size = -10e6, -30e6, 1.0, 4.0
    started = time.perf_counter()
    hole = quarter_arc(radius, clockwise=True)
    outline = shapely.Polygon([*hole, (size, 0.0), (size, size), (0.0, size)])
    # the spacing falls with the number of particles everywhere alike
    fine = 0.03 * radius * math.sqrt(2500.0 / particles)
    filled = fill_section(
        section(outline),
        particles=particles,
        refine=[(shapely.LineString(hole), fine)],
        grading=0.1,
        points=[hole[0], hole[-1]],
    )
    positions = filled.positions

    def exact(points: Floats) -> Floats:
        return kirsch_stress(points, radius, horizontal, vertical)

    outer = (positions[:, 0] > size - 1e-9) | (positions[:, 1] > size - 1e-9)
    held = held_freedoms(filled, {"left": "roller", "bottom": "roller"})
    model = ground(
        filled, material(young=10e9, poisson=0.25), held=held, load=boundary_traction(filled, outer, exact)
    )
    _, stress = solve_elastic(model, model.load)
    found = model.particle_mean(stress)
    seconds = time.perf_counter() - started
    side = int(np.argmin(np.hypot(positions[:, 0] - radius, positions[:, 1])))
    rows = [
        relative(
            "P14 Kirsch",
            "sigma_theta of the particle on the side wall [Pa]",
            -found[side, 1],
            80e6,
            0.03,
            seconds,
        )
    ]
    distance = np.hypot(*positions.T)
    around = (distance >= 1.25 * radius) & (distance <= 3.8 * radius)
    error = found[around] - exact(positions[around])
    weight = model.particle_area[around, None]
    root = math.sqrt(float((error**2 * weight).sum() / weight.sum() / 3.0))
    rows.append(
        Row(
            "P14 Kirsch",
            "rms stress error at 1.25 a to 3.8 a over 30 MPa",
            root,
            0.0,
            root / 30e6,
            0.01,
            seconds,
        )
    )
    worst = float(np.abs(error).max())
    rows.append(
        Row(
            "P14 Kirsch",
            "worst stress error at 1.25 a to 3.8 a over 30 MPa",
            worst,
            0.0,
            worst / 30e6,
            0.03,
            seconds,
        )
    )
    return rows


def lame(particles: int = 2500) -> list[Row]:
    """Thick cylinder, radii 1 and 2 m, 10 MPa inside, E 10 GPa, nu 0.25, plane strain.

    sigma_r = A - B/r^2, sigma_theta = A + B/r^2; inner displacement 1.875 mm, sigma_theta 16.667 MPa there. A
    quarter. The wall stress is the mean over all wall particles but those on the symmetry lines and next to them.
    """
    inner, outer, pressure, young, poisson = 1.0, 2.0, 10e6, 10e9, 0.25
    started = time.perf_counter()
    corners = [*quarter_arc(outer), *quarter_arc(inner, clockwise=True)]
    ends = [(inner, 0.0), (outer, 0.0), (0.0, inner), (0.0, outer)]
    filled = fill_section(section(shapely.Polygon(corners)), particles=particles, points=ends)
    positions = filled.positions
    distance = np.hypot(*positions.T)
    wall = distance < inner + 1e-3 * filled.spacing + inner * (1.0 - math.cos(0.25 * math.pi / ARC))
    held = held_freedoms(filled, {"left": "roller", "bottom": "roller"})

    def uniform(points: Floats) -> Floats:
        return np.tile([-pressure, -pressure, 0.0], (len(points), 1))

    model = ground(
        filled,
        material(young=young, poisson=poisson),
        held=held,
        load=boundary_traction(filled, wall, uniform),
    )
    moved, stress = solve_elastic(model, model.load)
    found = polar(model.particle_mean(stress), positions)
    seconds = time.perf_counter() - started
    b = pressure / (outer**2 / inner**2 - 1.0)
    exact = (1.0 + poisson) / young * b * ((1.0 - 2.0 * poisson) * inner + outer**2 / inner)
    radial = (moved * positions).sum(axis=1) / distance
    clear = wall & (positions.min(axis=1) > 2.0 * filled.spacing)
    hoop = b * (1.0 + outer**2 / inner**2)
    inside = (
        (distance > 1.25 * inner) & (distance < 0.95 * outer) & (positions.min(axis=1) > 2.0 * filled.spacing)
    )
    theta = b * (1.0 + outer**2 / distance[inside] ** 2)
    rho = b * (1.0 - outer**2 / distance[inside] ** 2)
    error = math.sqrt(float(np.mean((found[inside, 1] - theta) ** 2 + (found[inside, 0] - rho) ** 2)))
    return [
        relative(
            "P15 Lame", "mean inner displacement [m]", float(radial[wall].mean()), exact, 0.005, seconds
        ),
        relative(
            "P15 Lame",
            "mean sigma_theta of the wall particles [Pa]",
            float(found[clear, 1].mean()),
            hoop,
            0.03,
            seconds,
        ),
        Row(
            "P15 Lame",
            "rms stress error at r >= 1.25 a over 16.667 MPa",
            error,
            0.0,
            error / hoop,
            0.01,
            seconds,
        ),
    ]
