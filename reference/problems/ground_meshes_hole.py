"""P14 from a .geo file: the stresses around a hole on the nodes of a graded mesh, and with particles filled in."""

from __future__ import annotations

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from geodem.builders.from_mesh import particles_from_mesh, section_from_mesh
from geodem.builders.mesh_reading import read_mesh
from geodem.builders.particles import Particles, fill_section
from geodem.integrators.direct_solve import solve_elastic

from .ground_elastic import boundary_traction, ground, kirsch_stress, material, polar
from .ground_meshes_sources import HALF, hole_geo
from .rows import Row, relative

Floats = NDArray[np.float64]


class Field(NamedTuple):
    """Particles around the hole and the stress of each (n, 3) xx, yy, xy [Pa]."""

    name: str
    particles: Particles
    stress: Floats


def fields(folder: Path, *, fine: float = 0.04, coarse: float = 0.25) -> tuple[list[Field], list[Row]]:
    """P14 on the nodes of a graded mesh, and with particles that `fill_section` fills in."""
    path = folder / "hole.geo"
    path.write_text(hole_geo(fine, coarse))
    started = time.perf_counter()
    mesh = read_mesh(path)
    on_nodes = particles_from_mesh(mesh)
    seconds = time.perf_counter() - started
    first, rows = solve("P14 on the nodes of a graded mesh", on_nodes, seconds)
    started = time.perf_counter()
    ground_section = section_from_mesh(mesh)
    ring = shapely.LineString(ground_section.regions[0].polygon.interiors[0])
    filled = fill_section(
        ground_section,
        spacing=0.8 * coarse,
        refine=[(ring, fine)],
        grading=0.12,
        points=[(1, 0), (0, 1), (-1, 0), (0, -1)],
    )
    second, more = solve("P14 filled in", filled, time.perf_counter() - started)
    return [first, second], rows + more


def hole(folder: Path) -> list[Row]:
    """The figures alone."""
    return fields(folder)[1]


def solve(name: str, filled: Particles, seconds: float) -> tuple[Field, list[Row]]:
    """Stresses around the hole under 10 MPa horizontally and 30 MPa vertically: Kirsch 1898.

    The outer sides carry the tractions of the exact solution, so that the size of the plate does not matter.
    """
    started = time.perf_counter()
    positions = filled.positions

    def exact(points: Floats) -> Floats:
        return kirsch_stress(points, 1.0, -10e6, -30e6)

    outer: NDArray[np.bool_] = np.asarray((np.abs(positions) > HALF - 1e-9).any(axis=1))
    held = np.zeros((len(positions), 2), dtype=bool)
    # on the axes of symmetry nothing moves across them
    for axis in (0, 1):
        for sign in (-1.0, 1.0):
            end = np.zeros(2)
            end[axis] = sign * HALF
            held[int(np.argmin(np.hypot(*(positions - end).T))), 1 - axis] = True
    model = ground(
        filled, material(young=10e9, poisson=0.25), held=held, load=boundary_traction(filled, outer, exact)
    )
    _, stress = solve_elastic(model, model.load)
    found = model.particle_mean(stress)
    seconds += time.perf_counter() - started
    r = np.hypot(*positions.T)
    rows = []
    for where, spot, axis, value in (("side", (1.0, 0.0), 1, 80e6), ("crown", (0.0, 1.0), 0, 0.0)):
        at = int(np.argmin(np.hypot(*(positions - spot).T)))
        error = (-found[at, axis] - value) / 80e6
        rows.append(
            Row(name, f"sigma_theta at the {where} wall [Pa], error over 80 MPa", -found[at, axis], value, error, 0.1,
                seconds, "Kirsch 1898")
        )  # fmt: skip
    around = (r >= 1.25) & (r <= 0.95 * HALF)
    error = float(np.abs(found[around] - exact(positions[around])).max())
    rows.append(
        Row(name, "worst stress error from 1.25 a on, over 30 MPa", error, 0.0, error / 30e6, 0.03, seconds,
            "Kirsch 1898")
    )  # fmt: skip
    near = around & (r <= 3.0) & (np.abs(positions[:, 1]) < 0.1 * r)
    own, wanted = (
        polar(found[near], positions[near])[:, :2],
        polar(exact(positions[near]), positions[near])[:, :2],
    )
    for column, symbol in enumerate(("sigma_r", "sigma_theta")):
        off = own[:, column] / wanted[:, column] - 1.0
        worst = int(np.argmax(np.abs(off)))
        rows.append(
            relative(name, f"{symbol} along the horizontal axis, 1.25 a to 3 a, the worst [Pa]",
                     -own[worst, column], -wanted[worst, column], 0.03, seconds, "Kirsch 1898")
        )  # fmt: skip
    return Field(name, filled, found), rows
