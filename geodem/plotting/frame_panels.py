"""Several moments of discs side by side, from the frames of a run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geodem.io.files import write_whole
from geodem.io.frame_reading import ParticleFrame
from geodem.plotting.theme import INK, material_colour, new_figure, png, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Floats = NDArray[np.float64]

WIDTH = 7.7
"""Of the picture [inch]."""


def write_frame_panels(
    path: Path | str,
    frames: Sequence[ParticleFrame],
    *,
    titles: Sequence[str],
    columns: int = 2,
    walls: Sequence[Floats] = (),
    colours: Sequence[str] | None = None,
    shades: Sequence[NDArray[np.float64]] | None = None,
    view: tuple[float, float, float, float] | None = None,
) -> bytes:
    """Draw discs at several moments, true to scale; returns the PNG.

    Parameters
    ----------
    path : path
        A PNG file.
    frames : sequence of ParticleFrame
    titles : sequence of str
        Of the panels.
    columns : int
        Panels beside each other.
    walls : sequence of (k, 2) [m]
        Lines.
    colours : sequence of str, optional
        Of the materials.
    shades : sequence of (n,), optional
        For every frame factors on the lightness of its discs [-].
    view : (left, right, bottom, top), optional
        What is shown [m]; all discs where it is left out.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    from matplotlib.colors import to_rgb

    left, right, bottom, top = view or _extent(frames)
    rows = -(-len(frames) // columns)
    tall = (WIDTH - 0.7) / columns * (top - bottom) / (right - left)
    with style():
        figure = new_figure(WIDTH, rows * (tall + 0.35) + 0.3)
        panels = np.ravel(figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False))
        for number, axes in enumerate(panels):
            if number >= len(frames):
                axes.set_axis_off()
                continue
            frame = frames[number]
            kinds = range(int(frame.material.max(initial=0)) + 1)
            fills = np.array([to_rgb(colours[k] if colours else material_colour(k)) for k in kinds])
            faces = fills[frame.material]
            if shades is not None:
                faces = faces * shades[number][:, None]
            _draw(axes, frame, faces, (right - left) * columns)
            for wall in walls:
                axes.plot(*np.asarray(wall).T, color=INK, linewidth=1.1, zorder=3.0)
            axes.set_xlim(left, right)
            axes.set_ylim(bottom, top)
            axes.set_aspect("equal")
            axes.tick_params(length=3.0, width=0.8)
            axes.set_title(titles[number])
        picture = png(figure)
    write_whole(Path(path), picture)
    return picture


def _extent(frames: Sequence[ParticleFrame]) -> tuple[float, float, float, float]:
    low = np.min([(f.positions - f.radii[:, None]).min(axis=0) for f in frames], axis=0)
    high = np.max([(f.positions + f.radii[:, None]).max(axis=0) for f in frames], axis=0)
    margin = 0.03 * float((high - low).max())
    return low[0] - margin, high[0] + margin, low[1] - margin, high[1] + margin


def _draw(axes: Axes, frame: ParticleFrame, faces: Floats, span: float) -> None:
    from matplotlib.collections import EllipseCollection

    size = 2.0 * frame.radii
    points = 72.0 * WIDTH / span * float(np.median(size))
    axes.add_collection(
        EllipseCollection(
            size, size, np.zeros(len(size)), units="xy", offsets=frame.positions, offset_transform=axes.transData,
            facecolors=faces, edgecolors=0.6 * faces, linewidths=float(np.clip(0.06 * points, 0.0, 0.5)), zorder=2.0,
            rasterized=True,
        ),
        autolim=False,
    )  # fmt: skip
