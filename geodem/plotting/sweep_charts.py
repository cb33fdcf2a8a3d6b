"""Charts of a sweep: a result over every parameter, one line for each set of values that the others have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from geodem.plotting.theme import (
    INK,
    OTHER_CIRCLES,
    SOFT,
    STABLE,
    displacement_colours,
    new_figure,
    quiet_axes,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PANELS = 3
"""Parameters that a figure shows side by side."""

LEGEND = 8
"""Lines that are named; where there are more, their colours still tell them apart."""

DECADES = 30.0
"""Largest over smallest value beyond which an axis is logarithmic."""


def sweep_chart(result: Mapping[str, Any], column: int) -> Figure | None:
    """A column of the table over the parameters; None where fewer than two runs have a number there.

    Parameters
    ----------
    result : mapping
        Of a sweep.
    column : int
        Place in `result["columns"]`.
    """
    rows = [row for row in result["runs"] if _is_number(row["values"][column])]
    if len(rows) < 2:
        return None
    shown = [
        k for k in range(len(result["parameters"])) if len({str(row["parameters"][k]) for row in rows}) > 1
    ]
    shown = shown[:PANELS]
    if not shown:
        return None
    width = {1: 6.2, 2: 9.2, 3: 11.5}[len(shown)]
    figure = new_figure(width, 3.7)
    panels: list[Axes] = list(figure.subplots(1, len(shown), sharey=True, squeeze=False)[0])
    for axes, parameter in zip(panels, shown, strict=True):
        _panel(axes, result, rows, column, parameter)
    panels[0].set_ylabel(result["columns"][column])
    if logarithmic([row["values"][column] for row in rows]):
        panels[0].set_yscale("log")
    return figure


def logarithmic(values: Sequence[float]) -> bool:
    """Whether values span so much that only logarithms show the small ones."""
    return min(values) > 0.0 and max(values) / min(values) >= DECADES


def _panel(
    axes: Axes, result: Mapping[str, Any], rows: Sequence[Mapping[str, Any]], column: int, own: int
) -> None:
    entry = result["parameters"][own]
    quiet_axes(axes)
    series: dict[tuple[Any, ...], list[tuple[Any, float]]] = {}
    for row in rows:
        others = tuple(value for k, value in enumerate(row["parameters"]) if k != own)
        series.setdefault(others, []).append((row["parameters"][own], row["values"][column]))
    places = {value: k for k, value in enumerate(dict.fromkeys(row["parameters"][own] for row in rows))}
    colours = _colours(len(series))
    for colour, (others, points) in zip(colours, series.items(), strict=True):
        at = [(x if entry["number"] else places[x], y) for x, y in points]
        if entry["number"]:
            at.sort()
        axes.plot(
            *zip(*at, strict=True),
            "-o",
            color=colour,
            linewidth=1.4,
            markersize=4.5,
            label=_told(result, own, others),
        )
    if entry["number"]:
        if logarithmic([row["parameters"][own] for row in rows]):
            axes.set_xscale("log")
    else:
        axes.set_xticks(list(places.values()), [str(value) for value in places])
        axes.set_xlim(-0.4, len(places) - 0.6)
    axes.set_xlabel(named(entry))
    if 1 < len(series) <= LEGEND:
        legend = axes.legend(title=_others(result, own), labelcolor=INK, handlelength=1.6)
        legend.get_title().set_color(SOFT)
        legend.get_title().set_fontsize(8.5)


def named(entry: Mapping[str, Any]) -> str:
    """A parameter with its unit."""
    if not entry["number"]:
        return str(entry["key"])
    return f"{entry['key']} [{entry['unit'] or '-'}]"


def shown(value: Any) -> str:
    """A value of a parameter or a column, to four significant digits."""
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _others(result: Mapping[str, Any], own: int) -> str:
    return ", ".join(
        named(entry).rpartition(".")[2] for k, entry in enumerate(result["parameters"]) if k != own
    )


def _told(result: Mapping[str, Any], own: int, others: tuple[Any, ...]) -> str:
    return ", ".join(shown(value) for value in others)


def _colours(count: int) -> list[Any]:
    """Of lines: one by itself, few that differ, many from pale to deep."""
    if count == 1:
        return [STABLE]
    if count <= len(OTHER_CIRCLES):
        return list(OTHER_CIRCLES[:count])
    scale = displacement_colours()
    return [scale(0.3 + 0.7 * k / (count - 1)) for k in range(count)]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
