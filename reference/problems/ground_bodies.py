"""Bodies from pictures, slices, grids and terrain, and their particles: `python -m reference run ground-bodies`.

Areas, volumes and masses of every material against closed forms, or against what other libraries count in the same
file. Draws docs/pictures/body_*.png.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.body import Body
from geodem.builders.body_filling import BodyFilling, add_body
from geodem.builders.fill_body import fill_body
from geodem.builders.grid_sources import grid_from_image, grid_from_slices, grid_from_vtk
from geodem.builders.segmentation import Segmentation, segment
from geodem.builders.terrain import Layer
from geodem.builders.terrain_files import read_terrain

from . import ground_bodies_pictures as pictures
from .ground_bodies_sources import (
    LEGEND,
    MINE,
    SECTION_AREAS,
    SECTION_SCALE,
    VOXEL,
    balls_in_clay,
    channels_file,
    channels_volumes,
    classes_by_scikit_image,
    draw_section,
    elevation_file,
    photograph,
    terrain_volumes,
)
from .rows import Row, relative

BOUND = 0.005
"""Of areas, volumes and masses."""
CONTACT = {"normal_stiffness": 1e8, "shear_stiffness": 5e7, "friction_coefficient": 0.5}


@dataclass(frozen=True)
class Filled:
    """A body with its particles, and what its sizes are held to."""

    name: str
    body: Body
    filling: BodyFilling
    expected: Mapping[str, float]
    densities: Mapping[str, float]
    source: str
    seconds: float


def run() -> list[Row]:
    """Every body; draws them all."""
    rows: list[Row] = []
    for make in (drawing, slices, voxels, terrain):
        filled = make()
        rows += compare(filled)
        pictures.draw(filled.name, filled.filling)
    for name in ("gravel", "brick"):
        filled, cut = photographed(name)
        rows += compare(filled) + counted(name, cut, filled)
        pictures.draw_segmentation(name, photograph(name), cut, filled.filling)
    return rows


def compare(filled: Filled) -> list[Row]:
    """Size of the body, size represented by particles, and mass in an assembly, of every material."""
    body, filling = filled.body, filled.filling
    unit = "area [m2]" if body.dimension == 2 else "volume [m3]"
    build = AssemblyBuilder(body.dimension)
    for name in filling.materials:
        build.add_material(name, density=filled.densities[name], contact=CONTACT)
    added = add_body(build, filling, filled.densities)
    mass = build.build().mass[added.ids]
    rows = []
    label = f"{filled.name}, {filling.particles} particles"
    for number, share in enumerate(filling.shares):
        size = filled.expected[share.name]
        weighed = float(mass[filling.material == number].sum())
        for quantity, value, expected in (
            (f"{unit} of {share.name}, body", float(body.sizes[number]), size),
            (f"{unit} of {share.name}, particles", share.represented, size),
            (f"mass [kg] of {share.name}", weighed, size * filled.densities[share.name]),
        ):
            rows.append(relative(label, quantity, value, expected, BOUND, filled.seconds, filled.source))
    return rows


def drawing(particles: int = 6000) -> Filled:
    """A drawing of three layers and a boulder, with a legend."""
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        path = draw_section(Path(folder) / "section.png")
        body = grid_from_image(path, scale=SECTION_SCALE, legend=LEGEND)
    filling = fill_body(body, particles=particles, seed=1)
    densities = {"soil": 1800.0, "clay": 1950.0, "rock": 2500.0, "boulder": 2650.0}
    seconds = time.perf_counter() - started
    return Filled("drawing", body, filling, SECTION_AREAS, densities, "polygons and circle as drawn", seconds)


def slices(particles: int = 20_000) -> Filled:
    """Slices through balls in clay."""
    started = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        expected = balls_in_clay(Path(folder))
        legend = {"#b07d4f": "clay", "#7f8c99": "ball"}
        body = grid_from_slices(folder, voxel=VOXEL, legend=legend)
    filling = fill_body(body, particles=particles, seed=1)
    densities = {"clay": 1900.0, "ball": 2600.0}
    seconds = time.perf_counter() - started
    return Filled("slices", body, filling, expected, densities, "box and spheres as drawn", seconds)


def voxels(particles: int = 30_000) -> Filled:
    """River channels in a flood plain: pyvista's example, every facies but the first one is channel."""
    started = time.perf_counter()
    body = grid_from_vtk(channels_file(), thresholds=[0.5], materials=("plain", "channel"))
    filling = fill_body(body, particles=particles, seed=1)
    densities = {"plain": 1900.0, "channel": 2050.0}
    seconds = time.perf_counter() - started
    return Filled("channels", body, filling, channels_volumes(), densities, "voxels counted by VTK", seconds)


def terrain(particles: int = 40_000) -> Filled:
    """A cut-out of matplotlib's elevation model around a hill, with a weathered layer."""
    started = time.perf_counter()
    whole = read_terrain(elevation_file(), degrees=True)
    part = whole.crop(*MINE["corners"])
    body = part.body(base=MINE["base"], layers=[Layer("weathered", MINE["depth"]), Layer("rock")])
    filling = fill_body(body, particles=particles, seed=1)
    densities = {"weathered": 2200.0, "rock": 2500.0}
    seconds = time.perf_counter() - started
    expected = terrain_volumes(part)
    return Filled("terrain", body, filling, expected, densities, "trapezoids of the heights, SciPy", seconds)


SEGMENTS: dict[str, tuple[dict[str, Any], tuple[str | None, str]]] = {
    # gaps between the stones are dark, and the light is uneven; bricks are darker than mortar
    "gravel": ({"lighting": 20.0, "smoothing": 1.0, "smallest": 40, "grains": 1, "apart": 12.0}, (None, "stone")),
    "brick": ({"smoothing": 1.0, "smallest": 80, "grains": 0}, ("brick", "mortar")),
}  # fmt: skip
PIXEL = {"gravel": 0.5e-3, "brick": 2e-3}
"""Sides of a pixel [m], as nobody has said: stones of a few millimetres, bricks of some ten centimetres."""


def photographed(name: str, particles: int = 20_000) -> tuple[Filled, Segmentation]:
    """One of scikit-image's photographs."""
    started = time.perf_counter()
    options, materials = SEGMENTS[name]
    cut = segment(photograph(name), **options)
    body = cut.body(PIXEL[name], materials)
    filling = fill_body(body, particles=particles, arrangement="hexagonal")
    _, light = classes_by_scikit_image(photograph(name), **_filters(options))
    share = {0: float(1.0 - light.mean()), 1: float(light.mean())}
    whole = light.size * PIXEL[name] ** 2
    expected = {material: share[k] * whole for k, material in enumerate(materials) if material}
    densities = dict.fromkeys(expected, 2650.0)
    seconds = time.perf_counter() - started
    return Filled(name, body, filling, expected, densities, "scikit-image's filters", seconds), cut


def counted(name: str, cut: Segmentation, filled: Filled) -> list[Row]:
    """Threshold and pieces beside scikit-image's, and that hardly a piece is without a particle."""
    from skimage.measure import label

    options, _ = SEGMENTS[name]
    threshold, light = classes_by_scikit_image(photograph(name), **_filters(options))
    found = len(np.unique(filled.filling.group[filled.filling.group >= 0]))
    pieces = float(cut.grains.max() + 1)
    label_name = f"{name}, {filled.filling.particles} particles"
    by = "scikit-image"
    rows = [
        relative(label_name, "Otsu's threshold [-]", cut.thresholds[0], threshold, 1e-3, filled.seconds, by),
        relative(
            label_name,
            "pieces with particles",
            float(found),
            pieces,
            0.01,
            filled.seconds,
            "pieces told apart",
        ),
    ]
    if "apart" not in options:
        own = float(label(light == bool(options["grains"]), connectivity=1).max())
        rows.append(relative(label_name, "pieces", pieces, own, 0.0, filled.seconds, by))
    return rows


def _filters(options: Mapping[str, Any]) -> dict[str, Any]:
    """Those of the options that choose classes, not pieces."""
    return {key: options[key] for key in ("lighting", "smoothing", "smallest") if key in options}
