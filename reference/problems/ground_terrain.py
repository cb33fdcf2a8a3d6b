"""Factor of safety of a section through a surveyed terrain: `python -m reference run ground-terrain`.

A line across the steepest side of a valley in matplotlib's elevation model (Jacksboro fault, Tennessee). Nobody
surveyed its strength: the properties are those of a weathered sandstone, chosen so that the slope is near its limit.
Strength reduction is held to the method of slices on the same section. Draws docs/pictures/terrain_section.png.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Literal

import numpy as np

import geodem
from geodem.builders.section import Section
from geodem.builders.terrain import Layer, Terrain
from geodem.builders.terrain_files import read_terrain
from reference.limit_equilibrium import Ground, Soil, search

from .ground_bodies_sources import elevation_file
from .rows import Row, relative

GRAVITY = 9.81
# columns and row of the grid that the line runs along
LINE = ((206, 62), (234, 62))
BASE = 400.0
"""Of the section [m]; the valley floor is at 538 m."""
DEPTH = 80.0
"""Of the weathered layer [m]."""
PROPERTIES = {
    "sandstone": (2300.0, 150e3, 30.0),
    "weathered": (2200.0, 80e3, 28.0),
    "rock": (2400.0, 600e3, 38.0),
}
"""Density [kg/m3], cohesion [Pa], friction angle [deg], which is the dilation angle too."""
LAYERS = {
    "one material": (Layer("sandstone"),),
    "two layers": (Layer("weathered", DEPTH), Layer("rock")),
}
BOUNDS = {"one material": 0.02, "two layers": 0.03}
"""Circles cannot follow the lower side of a layer, and few particles lie across it."""
PARTICLES = 4000


def run() -> list[Row]:
    """Area of the section, and the factor of each way to layer it."""
    started = time.perf_counter()
    terrain = read_terrain(elevation_file(), degrees=True)
    rows = []
    for name, layers in LAYERS.items():
        section = line_section(terrain, layers)
        rows.append(_area(name, terrain, section, started))
        begun = time.perf_counter()
        found = factor(section)
        seconds = time.perf_counter() - begun
        rows += [
            relative(
                f"terrain, {name}, {PARTICLES} particles", f"factor of safety beside {method}", found,
                slices(section, method), BOUNDS[name], seconds, "method of slices, critical circle",
            )
            for method in ("bishop", "spencer")
        ]  # fmt: skip
        if name == "two layers":
            from .ground_terrain_picture import draw

            draw(terrain, section, line_places(terrain))
    return rows


def line_places(terrain: Terrain) -> np.ndarray:
    """The two ends of the line (2, 2) [m]."""
    return terrain.origin + np.array(LINE) * terrain.spacing


def line_section(terrain: Terrain, layers: tuple[Layer, ...]) -> Section:
    """The section below the line."""
    return terrain.section_along(line_places(terrain), base=BASE, layers=layers)


def factor(section: Section, particles: int = PARTICLES) -> float:
    """Factor by strength reduction: the middle of the bracket."""
    ground = {
        name: geodem.GroundProperties.of(
            density,
            young_modulus=1e9,
            poisson_ratio=0.3,
            cohesion=cohesion,
            friction_angle=math.radians(angle),
            dilation_angle=math.radians(angle),
            tensile_strength=math.inf,
        )
        for name, (density, cohesion, angle) in _present(section).items()
    }
    model = geodem.build_ground(
        geodem.fill_section(section, particles=particles),
        ground,
        boundary={"left": "roller", "right": "roller", "bottom": "fixed"},
    )
    found = geodem.Search(geodem.Simulation(model), geodem.StrengthReduction(), tolerance=0.01).run()
    if found.value is None:
        raise RuntimeError(f"no bracket was found: {found}")
    return found.value


def slices(section: Section, method: Literal["bishop", "spencer"]) -> float:
    """Factor of the critical circle by "bishop" or "spencer"."""
    soils = {
        name: Soil(density * GRAVITY, cohesion, math.radians(angle))
        for name, (density, cohesion, angle) in _present(section).items()
    }
    regions = [(region.material, [np.array(region.polygon.exterior.coords)]) for region in section.regions]
    return float(search(Ground(regions, soils), method).factor)


def _present(section: Section) -> Mapping[str, tuple[float, float, float]]:
    return {name: PROPERTIES[name] for name in section.materials}


def _area(name: str, terrain: Terrain, section: Section, started: float) -> Row:
    """Area of the section beside the trapezoidal rule on the heights of the survey along the line."""
    from scipy.integrate import trapezoid

    (first, row), (last, _) = LINE
    expected = float(trapezoid(terrain.elevation[first : last + 1, row] - BASE, dx=terrain.spacing[0]))
    seconds = time.perf_counter() - started
    return relative(
        f"terrain, {name}", "area of the section [m2]", float(section.outline.area), expected, 1e-9, seconds,
        "trapezoids of the heights, SciPy",
    )  # fmt: skip
