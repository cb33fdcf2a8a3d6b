"""Charts of a search: how the bracket closed, and how far the ground moved in each trial."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from geodem.plotting.theme import (
    FAILED,
    FAINT,
    PAPER,
    SOFT,
    STABLE,
    UNDECIDED,
    VERDICT_COLOURS,
    VERDICT_MARKERS,
    halo,
    new_figure,
    quiet_axes,
)
from geodem.plotting.views import MethodView

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

AXIS_NAMES = {
    "strength-reduction": "strength reduction factor [-]",
    "gravity-increase": "gravity factor (load multiplier) [-]",
}


def bracket_chart(method: MethodView) -> Figure:
    """Trials in the order run, and the bracket [stable, failed] that they close; at right its end, enlarged.

    Parameters
    ----------
    method : MethodView
        With at least one trial.
    """
    from matplotlib.ticker import MaxNLocator

    zoomed = method.stable is not None and method.failed is not None and len(method.trials) > 2
    figure = new_figure(7.7, 3.3)
    axes: list[Axes] = list(
        figure.subplots(1, 2 if zoomed else 1, squeeze=False, width_ratios=[1.55, 1.0] if zoomed else None)[0]
    )
    number = np.arange(1, len(method.trials) + 1)
    factors = np.array([float(trial["factor"]) for trial in method.trials])
    lows, highs = _running_bracket(method)
    for axis in axes:
        quiet_axes(axis)
        axis.grid(axis="x", visible=False)
        _draw_band(axis, number, lows, highs)
        for verdict, colour in VERDICT_COLOURS.items():
            for model in ("coarse", "fine"):
                own = np.array(
                    [
                        trial["verdict"] == verdict and trial.get("model", "fine") == model
                        for trial in method.trials
                    ],
                    dtype=bool,
                )
                if own.any():
                    axis.scatter(
                        number[own],
                        factors[own],
                        marker=VERDICT_MARKERS[verdict],
                        s=48 if verdict != "failed" else 58,
                        facecolor=PAPER if model == "coarse" else colour,
                        edgecolor=colour,
                        linewidth=1.4,
                        zorder=4.0,
                        label=verdict + (", coarse model" if model == "coarse" else ""),
                    )
        axis.xaxis.set_major_locator(MaxNLocator(integer=True))
        axis.set_xlabel("trial, in the order run")
    axes[0].set_ylabel(AXIS_NAMES.get(method.kind, "factor [-]"))
    axes[0].set_xlim(0.4, len(number) + 0.6)
    if zoomed:
        _zoom(axes[1], method, number)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(handles), 6), columnspacing=1.4)
    return figure


def history_chart(method: MethodView) -> Figure:
    """Displacement of what moves over relaxation steps, one line a trial; steps of a relaxation are not time."""
    figure = new_figure(7.7, 3.5)
    axes = figure.add_subplot()
    quiet_axes(axes)
    histories = [
        (f, v, np.asarray(s, float), np.asarray(u, float)) for f, v, s, u in method.histories if len(s)
    ]
    ends = [u[-1] for _, v, _, u in histories if v != "failed"]
    largest = max((float(np.nanmax(u)) for *_, u in histories), default=1.0)
    factor, unit = (1000.0, "mm") if largest < 0.2 else (1.0, "m")
    bracketing = {method.stable, method.failed}
    seen: set[str] = set()
    for value, verdict, steps, displacement in sorted(histories, key=lambda item: item[0] in bracketing):
        colour = VERDICT_COLOURS.get(verdict, UNDECIDED)
        main = value in bracketing
        axes.plot(
            steps,
            displacement * factor,
            color=colour,
            linewidth=2.0 if main else 1.0,
            alpha=1.0 if main else 0.55,
            linestyle=(0, (3, 2)) if verdict == "undecided" else "-",
            label=None if verdict in seen else verdict,
            zorder=4.0 if main else 3.0,
        )
        seen.add(verdict)
        axes.plot(
            steps[-1],
            displacement[-1] * factor,
            marker=VERDICT_MARKERS.get(verdict, "o"),
            markersize=6.0 if main else 4.0,
            color=colour,
            alpha=1.0 if main else 0.7,
            zorder=5.0,
        )
    _end_labels(axes, method, histories, factor)
    axes.set_xlabel("relaxation step [-] (not time)")
    axes.set_ylabel(f"displacement of what moves [{unit}]")
    axes.set_ylim(bottom=0.0)
    axes.set_xlim(left=0.0)
    axes.margins(x=0.02)
    if ends or histories:
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def _running_bracket(method: MethodView) -> tuple[np.ndarray, np.ndarray]:
    """Highest stable factor below the lowest failed one, and that one, after each trial; NaN while open.

    A finer model begins a bracket of its own.
    """
    lows, highs = [], []
    stable: list[float] = []
    failed: list[float] = []
    before = None
    for trial in method.trials:
        model = (trial.get("model", "fine"), trial.get("particles"))
        if model != before:
            stable, failed, before = [], [], model
        if trial["verdict"] == "stable":
            stable.append(float(trial["factor"]))
        elif trial["verdict"] == "failed":
            failed.append(float(trial["factor"]))
        high = min(failed, default=np.nan)
        below = [value for value in stable if not value >= high]
        lows.append(max(below, default=np.nan))
        highs.append(high)
    return np.array(lows), np.array(highs)


def _draw_band(axes: Axes, number: np.ndarray, lows: np.ndarray, highs: np.ndarray) -> None:
    """The bracket so far, as a band that narrows from trial to trial."""
    at = np.concatenate([number, [number[-1] + 1.0]])
    low, high = (np.concatenate([side, side[-1:]]) for side in (lows, highs))
    axes.fill_between(
        at, low, high, step="post", color=FAINT, alpha=0.55, linewidth=0, zorder=1.0, label="bracket"
    )
    axes.step(at, low, where="post", color=STABLE, linewidth=1.1, alpha=0.8, zorder=2.0)
    axes.step(at, high, where="post", color=FAILED, linewidth=1.1, alpha=0.8, zorder=2.0)


def _zoom(axes: Axes, method: MethodView, number: np.ndarray) -> None:
    """Limits around the final bracket and the factors written beside the trials that fall within."""
    assert method.stable is not None
    assert method.failed is not None
    width = max(method.failed - method.stable, 1e-6)
    low, high = method.stable - 1.6 * width, method.failed + 1.6 * width
    room = 0.5 * width  # for the numbers of the outermost
    inside = [
        (order, trial)
        for order, trial in zip(number.tolist(), method.trials, strict=True)
        if low <= float(trial["factor"]) <= high
    ]
    first = min((order for order, _ in inside), default=1)
    axes.set_ylim(low - room, high + room)
    axes.set_xlim(first - 0.7, len(number) + 0.9)
    axes.set_title("the end, enlarged", fontsize=9.0, fontweight="normal", color=SOFT)
    for order, trial in inside:
        value, verdict = float(trial["factor"]), str(trial["verdict"])
        axes.annotate(
            f"{value:.3f}", (order, value), xytext=(0, 8 if verdict == "failed" else -8),
            textcoords="offset points", ha="center", va="bottom" if verdict == "failed" else "top",
            fontsize=8.5,
            color=VERDICT_COLOURS.get(verdict, UNDECIDED), zorder=6.0, path_effects=halo(),
        )  # fmt: skip


def _end_labels(axes: Axes, method: MethodView, histories: list[Any], factor: float) -> None:
    """Factors at the ends of the lines: of the bracket always, of the others where there is room."""
    figure = axes.figure
    figure.canvas.draw()
    taken: list[tuple[float, float]] = []
    bracketing = {method.stable, method.failed}
    for value, verdict, steps, displacement in sorted(histories, key=lambda item: item[0] not in bracketing):
        point = (steps[-1], displacement[-1] * factor)
        x, y = axes.transData.transform(point)
        main = value in bracketing
        if any(abs(x - a) < 75 and abs(y - b) < 17 for a, b in taken) and not main:
            continue
        taken.append((x, y))
        axes.annotate(
            f"{value:.3f}", point, xytext=(6, 0), textcoords="offset points", ha="left", va="center",
            fontsize=8.5, fontweight="bold" if main else "normal",
            color=VERDICT_COLOURS.get(verdict, UNDECIDED), zorder=6.0, annotation_clip=False,
            path_effects=halo(),
        )  # fmt: skip
