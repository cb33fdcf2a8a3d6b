"""The collapsed columns of all codes over one another, with the band of the seeds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PICTURE = Path(__file__).parents[2] / "docs" / "pictures" / "compare_column.png"
NAMES = {"geodem": "geodem", "yade": "YADE", "liggghts": "LIGGGHTS"}
COLOURS = {
    ("yade", "geodem"): "#0072b2", ("yade", "yade"): "#d55e00",
    ("liggghts", "geodem"): "#8a3b78", ("liggghts", "liggghts"): "#009e73",
}  # fmt: skip
TITLES = {"yade": "Local damping", "liggghts": "Dashpots in the contacts"}


def draw(rows: Sequence[Mapping[str, Any]], width: float, step: float, path: Path = PICTURE) -> None:
    """Write the picture: a panel of profiles for every code that geodem stands beside, and one of the fronts.

    Parameters
    ----------
    rows : sequence of mapping
        beside, code, seed, height (b,), times and front (f,), as `column` stores them.
    width, step : float
        Of the column and of a bin, in mean diameters.
    """
    from geodem.plotting.theme import new_figure, png, quiet_axes, style

    beside = [code for code in TITLES if any(row["beside"] == code for row in rows)]
    with style():
        figure = new_figure(3.9 * (len(beside) + 1), 3.5)
        *panels, last = figure.subplots(1, len(beside) + 1)
        for axes, other in zip(panels, beside, strict=True):
            for code in ("geodem", other):
                heights = _curves(rows, other, code, "height")
                places = (np.arange(heights.shape[1]) + 0.5) * step
                _band(axes, places, heights, (other, code))
            axes.axvline(width, color="#5f6c7b", linewidth=0.8, linestyle=":")
            axes.set_title(TITLES[other])
            axes.set_xlabel("distance from the back wall / d")
            axes.set_xlim(0.0, _reach(rows, step))
        panels[0].set_ylabel("height / d")
        for other in beside:
            for code in ("geodem", other):
                times = _curves(rows, other, code, "times")[0]
                label = f"{NAMES[code]}, {TITLES[other].lower()}"
                _band(last, times, _curves(rows, other, code, "front"), (other, code), label)
        last.set_title("Front (95th percentile)")
        last.set_xlabel("time / sqrt(d/g)")
        last.set_ylabel("distance / width of the column")
        for axes in (*panels, last):
            axes.set_ylim(bottom=0.0)
            axes.legend(loc="best")
            quiet_axes(axes)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(png(figure))


def _curves(rows: Sequence[Mapping[str, Any]], beside: str, code: str, name: str) -> np.ndarray:
    return np.array([row[name] for row in rows if row["beside"] == beside and row["code"] == code])


def _reach(rows: Sequence[Mapping[str, Any]], step: float) -> float:
    """To where there is more than a hundredth of a diameter anywhere."""
    heights = np.array([row["height"] for row in rows])
    return float((np.flatnonzero(heights.max(axis=0) > 0.01).max() + 2) * step)


def _band(axes: Axes, x: np.ndarray, y: np.ndarray, key: tuple[str, str], label: str | None = None) -> None:
    """The mean of the seeds, and all between the lowest and the highest; `key`: beside which code, and whose."""
    axes.fill_between(x, y.min(axis=0), y.max(axis=0), color=COLOURS[key], alpha=0.25, linewidth=0.0)
    axes.plot(
        x, y.mean(axis=0), color=COLOURS[key], linestyle="-" if key[1] == "geodem" else "--", linewidth=1.6,
        label=label or NAMES[key[1]],
    )  # fmt: skip
