"""Error against run time, every slope at every size: what an hour of machine buys."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEAST_PERCENT = 0.05
"""Smaller errors are drawn here: below it the width of the bracket is all that one sees."""

LIGHTEST, DARKEST = (
    (0.62, 0.79, 0.92),
    (0.02, 0.12, 0.25),
)  # red, green, blue of the smallest and largest size
TITLES = {"strength-reduction": "Strength reduction", "gravity-increase": "Gravity increase"}


def error_against_time(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """A PNG with one panel a method, both axes logarithmic.

    Parameters
    ----------
    rows : sequence of mapping
        With method, asked, seconds and error_percent; at least one.
    """
    from geodem.plotting.theme import new_figure, png, style

    sizes = sorted({row["asked"] for row in rows})
    methods = [method for method in TITLES if any(row["method"] == method for row in rows)]
    with style():
        figure = new_figure(4.4 * len(methods), 3.9)
        panels = figure.subplots(1, len(methods), squeeze=False, sharey=True)[0]
        for axes, method in zip(panels, methods, strict=True):
            _panel(axes, [row for row in rows if row["method"] == method], sizes)
            axes.set_title(TITLES[method])
        panels[0].set_ylabel("size of the error [%]")
        # sizes have the same colours in all panels
        handles, labels = max(
            (axes.get_legend_handles_labels() for axes in panels), key=lambda found: len(found[1])
        )
        figure.legend(
            handles, labels, title="median of", loc="outside lower center", ncols=min(len(labels), 4)
        )
        return png(figure)


def _panel(axes: Axes, rows: Sequence[Mapping[str, Any]], sizes: Sequence[int]) -> None:
    from geodem.plotting.theme import INK, quiet_axes

    middles = []
    for place, asked in enumerate(sizes):
        group = [row for row in rows if row["asked"] == asked]
        if not group:
            continue
        times = [float(row["seconds"]) for row in group]
        errors = [max(abs(float(row["error_percent"])), LEAST_PERCENT) for row in group]
        share = place / max(len(sizes) - 1, 1)
        colour = tuple(light + share * (dark - light) for light, dark in zip(LIGHTEST, DARKEST, strict=True))
        axes.plot(times, errors, "o", color=colour, markersize=4.0, alpha=0.75, markeredgewidth=0.0)
        middles.append((median(times), median(errors)))
        axes.plot(
            *middles[-1],
            "D",
            color=colour,
            markersize=9.0,
            markeredgecolor=INK,
            zorder=4,
            label=f"{asked:,} particles",
        )
    axes.plot(*zip(*middles, strict=True), "-", color=INK, linewidth=1.0, zorder=3)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("run time of one factor [s]")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
    quiet_axes(axes)
