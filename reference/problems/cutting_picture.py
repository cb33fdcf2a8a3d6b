"""Specific energy and peaks of cuts over depth on log axes: docs/pictures/cutting_energy.png."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.plotting.theme import INK, new_figure, png, style

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"
COLOURS = ("#8c6d31", "#1f77b4", "#d62728", "#2ca02c")


class Line(NamedTuple):
    """One ground: depths [mm], specific energy [J/m3], depths over (toughness/strength)^2, peaks over depth, strength.

    What is not a number is not drawn.
    """

    name: str
    depth: NDArray[np.float64]
    energy: NDArray[np.float64]
    lengths: NDArray[np.float64]
    peaks: NDArray[np.float64]


def draw(lines: Sequence[Line], folder: Path = PICTURES) -> Path:
    """Two panels: specific energy over depth of every ground; peaks over scaled depth of rocks."""
    with style():
        figure = new_figure(8.0, 3.6)
        panels: Any = figure.subplots(1, 2)
        for line, colour in zip(lines, COLOURS, strict=True):
            panels[0].loglog(line.depth, 1e-6 * line.energy, "o-", color=colour, label=line.name)
            if np.isfinite(line.lengths).all():
                panels[1].loglog(line.lengths, line.peaks, "o", color=colour, label=line.name)
        ends = np.concatenate([line.lengths for line in lines])
        across = np.array([np.nanmin(ends), np.nanmax(ends)])
        peaks = np.concatenate([line.peaks[np.isfinite(line.lengths)] for line in lines])
        middle = np.exp(np.nanmean(np.log(ends)))
        level = np.exp(np.log(peaks).mean())
        panels[1].loglog(across, level * (across / middle) ** -0.5, "--", color=INK, label="power -1/2")
        panels[0].set(xlabel="depth [mm]", ylabel="specific energy [MJ/m$^3$]")
        panels[1].set(
            xlabel="depth / (toughness / strength)$^2$ [-]", ylabel="peaks / (depth x strength) [-]"
        )
        for panel in panels:
            panel.legend()
        path = folder / "cutting_energy.png"
        path.write_bytes(png(figure))
    return path
