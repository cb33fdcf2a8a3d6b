"""The hole of P14 on the nodes of a graded mesh: docs/pictures/mesh_hole.png."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geodem.plotting.theme import FAILED, INK, new_figure, png, style

from .ground_elastic import kirsch_stress, polar
from .ground_meshes_hole import Field

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"
SEEN = 2.6
"""Half the side of the picture [m]."""
COLOURS = 128
BAND = 0.06
"""Particles so near to the horizontal axis, over their distance, are drawn."""


def draw(fields: Sequence[Field], folder: Path = PICTURES) -> Path:
    """The mesh with the largest compression on the left, stresses along the horizontal axis on the right."""
    from matplotlib.tri import Triangulation
    from PIL import Image

    first = fields[0]
    with style():
        figure = new_figure(8.0, 3.6)
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
        axes: Any = left
        xx, yy, xy = first.stress.T[:3] / 1e6
        most = -(0.5 * (xx + yy) - np.hypot(0.5 * (xx - yy), xy))
        x, y = first.particles.positions.T
        mesh = Triangulation(x, y, first.particles.triangles)
        tinted = axes.tricontourf(mesh, most, levels=np.arange(0.0, 81.0, 5.0), cmap="viridis", extend="both")
        axes.triplot(mesh, color="white", linewidth=0.15, alpha=0.6)
        axes.set(xlim=(-SEEN, SEEN), ylim=(-SEEN, SEEN), aspect="equal", xlabel="x [m]", ylabel="y [m]")
        axes.set_title("Largest compression on the nodes")
        figure.colorbar(tinted, ax=axes, label="[MPa]")
        axes = right
        r = np.linspace(1.0, 3.8, 200)
        exact = -kirsch_stress(np.column_stack([r, 0.0 * r]), 1.0, -10e6, -30e6) / 1e6
        axes.plot(r, exact[:, 1], color=INK, label="Kirsch 1898")
        axes.plot(r, exact[:, 0], color=INK)
        for field, colour, marker in zip(fields, ("#1f77b4", FAILED), ("o", "x"), strict=True):
            positions = field.particles.positions
            distance = np.hypot(*positions.T)
            near = (np.abs(positions[:, 1]) < BAND * distance) & (distance < 3.8)
            found = -polar(field.stress[near], positions[near]) / 1e6
            label = field.name.removeprefix("P14 ")
            axes.plot(distance[near], found[:, 1], marker, color=colour, markersize=3.0, label=label)
            axes.plot(distance[near], found[:, 0], marker, color=colour, markersize=3.0)
        axes.annotate("hoop", (1.5, 48.0), color=INK)
        axes.annotate("radial", (1.5, 16.0), color=INK)
        axes.set(
            xlabel="distance from the middle over the radius [-]",
            ylabel="compression [MPa]",
            ylim=(-2.0, 84.0),
        )
        axes.set_title("Along the horizontal axis")
        axes.legend(loc="upper right")
        picture = Image.open(io.BytesIO(png(figure))).convert("RGB")
    path = folder / "mesh_hole.png"
    picture.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, kmeans=4, dither=Image.Dither.NONE).save(
        path, optimize=True
    )
    return path
