"""The terrain with the line of the section, and the section: docs/pictures/terrain_section.png."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.builders.section import Section
from geodem.builders.terrain import Terrain
from geodem.plotting.theme import FAILED, INK, halo, material_colour, new_figure, png, style

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"
MARGIN = 2500.0
"""Around the line on the map [m]."""


def draw(terrain: Terrain, section: Section, line: NDArray[np.float64], folder: Path = PICTURES) -> Path:
    """Map above, section below."""
    from matplotlib.colors import LightSource
    from matplotlib.patches import Polygon

    near = terrain.crop(line.min(axis=0) - MARGIN, line.max(axis=0) + MARGIN)
    (west, south), (east, north) = near.bounds / 1e3
    with style():
        figure = new_figure(7.6, 7.0)
        engine: Any = figure.get_layout_engine()
        engine.set(w_pad=0.25, h_pad=0.08)
        above, below = figure.subplots(2, 1, height_ratios=(2.2, 1.0))
        axes: Any = above
        rows = near.elevation.T[::-1]
        shade = LightSource(azdeg=315.0, altdeg=40.0).hillshade(rows, dx=near.spacing[0], dy=near.spacing[1])
        extent = (west, east, south, north)
        tinted = axes.imshow(rows, extent=extent, cmap="terrain", vmin=100.0, vmax=1400.0)
        axes.imshow(shade, extent=extent, cmap="gray", alpha=0.35)
        axes.plot(*(line.T / 1e3), color=FAILED, linewidth=2.2, path_effects=halo(4.0))
        axes.set(xlabel="x [km]", ylabel="y [km]", title="Elevation model and the line of the section")
        bar = figure.colorbar(tinted, ax=axes, label="elevation [m]")
        bar.ax.set_ylim(float(rows.min()), float(rows.max()))
        axes = below
        for number, name in enumerate(section.materials):
            for region in section.regions:
                if region.material == name:
                    corners = np.array(region.polygon.exterior.coords)
                    axes.add_patch(
                        Polygon(corners, facecolor=material_colour(number), edgecolor=INK, linewidth=0.7, label=name)
                    )  # fmt: skip
        left, bottom, right, top = section.bounds
        axes.set(xlim=(left, right), ylim=(bottom, top + 30.0), aspect="equal")
        axes.set(xlabel="distance along the line [m]", ylabel="elevation [m]", title="Section, true to scale")
        axes.legend(loc="upper right")
        path = folder / "terrain_section.png"
        path.write_bytes(png(figure))
    return path
