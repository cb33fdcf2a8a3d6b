"""Trends of granular flow: `python -m reference run granular`; draws docs/pictures/granular_flow.png.

Collapse of columns over their aspect ratio, a silo after Janssen, hoppers after Beverloo.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from . import granular_hopper, granular_silo
from .granular_column import Collapse, collapse, half_width, stiffness_for
from .granular_grains import DIAMETER, GRAVITY, Floats, exponent
from .rows import Row, at_most

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"

GRAINS = {2: 1500, 3: 2500}
SEEDS = {2: (1, 2, 3), 3: (1, 2)}
LOW = {2: (0.5, 1.0, 2.0)}
TALL = {2: (4.0, 7.0, 12.0), 3: (3.0, 6.0, 12.0)}

# exponents of the run-out over the aspect ratio, relative bound and source
LOW_POWERS = ((1.0, 0.1, "Lube et al. 2005, Lajeunesse et al. 2005, Staron & Hinch 2005"),)
TALL_POWERS = {
    2: (
        (0.7, 0.1, "discs: Staron & Hinch 2005"),
        (2.0 / 3.0, 0.15, "experiments in channels: Lube et al. 2005, Lajeunesse et al. 2005"),
    ),
    3: ((0.5, 0.1, "experiments: Lube et al. 2004, Lajeunesse et al. 2005"),),
}

Runs = dict[float, list[Collapse]]


def columns(dimension: int, aspects: tuple[float, ...], seeds: tuple[int, ...]) -> Runs:
    """Collapses by the aspect ratio that was asked for."""
    found: Runs = {}
    for aspect in aspects:
        tall = aspect * half_width(dimension, aspect, GRAINS[dimension]) / DIAMETER
        found[aspect] = [
            collapse(dimension, aspect, grains=GRAINS[dimension], stiffness=stiffness_for(tall), seed=seed)
            for seed in seeds
        ]
    return found


def means(runs: Runs) -> tuple[Floats, Floats, Floats]:
    """Aspect ratio, mean run-out and its scatter over seeds."""
    aspect = np.array([np.mean([run.aspect for run in group]) for group in runs.values()])
    run_out = np.array([np.mean([run.run_out for run in group]) for group in runs.values()])
    scatter = np.array([np.ptp([run.run_out for run in group]) / 2.0 for group in runs.values()])
    return aspect, run_out, scatter


def power_rows(name: str, what: str, runs: Runs, powers: tuple[tuple[float, float, str], ...]) -> list[Row]:
    """Exponent of the mean run-outs, and how far apart those of single seeds are."""
    aspect, run_out, _ = means(runs)
    power = exponent(aspect, run_out)
    seeds = len(next(iter(runs.values())))
    own = [
        exponent(
            np.array([group[k].aspect for group in runs.values()]),
            np.array([group[k].run_out for group in runs.values()]),
        )
        for k in range(seeds)
    ]
    seconds = sum(run.seconds for group in runs.values() for run in group)
    overlap = max(run.overlap for group in runs.values() for run in group)
    label = f"{what}: exponent of the run-out over a"
    return [
        *(
            Row(name, label, power, expected, power / expected - 1.0, bound, seconds, source)
            for expected, bound, source in powers
        ),
        at_most(name, f"{what}: exponents of the seeds apart, at most", max(own) - min(own), 0.15, seconds,
                f"seeds 1 to {seeds}"),
        at_most(name, f"{what}: mean overlap over d while it spreads, at most", overlap, 0.01, seconds, "hard grains"),
    ]  # fmt: skip


class Flows(NamedTuple):
    """Everything that is run."""

    low: Runs
    tall: Runs
    round: Runs
    silo: granular_silo.Profile
    hopper: list[list[granular_hopper.Discharge]]  # by friction


def flows() -> Flows:
    """Run all of them, some minutes."""
    beds = {friction: granular_hopper.bed(1, friction) for friction in granular_hopper.FRICTIONS}
    return Flows(
        columns(2, LOW[2], SEEDS[2]),
        columns(2, TALL[2], SEEDS[2]),
        columns(3, TALL[3], SEEDS[3]),
        granular_silo.mean_profile([granular_silo.profile(granular_silo.silo(seed)) for seed in SEEDS[2]]),
        [
            [granular_hopper.discharge(d * DIAMETER, friction, *bed) for d in granular_hopper.OPENINGS]
            for friction, bed in beds.items()
        ],
    )


def rows_of(found: Flows) -> list[Row]:
    """Every figure beside its bound."""
    flat = f"column collapse, {GRAINS[2]} discs"
    return [
        *power_rows(flat, "a 0.5 to 2", found.low, LOW_POWERS),
        *power_rows(flat, "a 4 to 12", found.tall, TALL_POWERS[2]),
        *power_rows(f"column collapse, {GRAINS[3]} spheres", "a 3 to 12", found.round, TALL_POWERS[3]),
        *granular_silo.rows_of(found.silo),
        *(row for runs in found.hopper for row in granular_hopper.rows_of(runs)),
    ]


def draw(found: Flows) -> bytes:
    """Run-outs, stress with depth, rates of flow."""
    from geodem.plotting.theme import FAILED, INK, SOFT, STABLE, new_figure, png, quiet_axes, style

    flat, silo, hopper = {**found.low, **found.tall}, found.silo, found.hopper
    with style():
        figure = new_figure(11.0, 3.8)
        left, middle, right = figure.subplots(1, 3)
        for runs, colour, label, power in (
            (flat, STABLE, "2D", 2.0 / 3.0),
            (found.round, FAILED, "round columns", 0.5),
        ):
            aspect, run_out, scatter = means(runs)
            left.errorbar(aspect, run_out, yerr=scatter, fmt="o", color=colour, markersize=4.5, label=label)
            tall = aspect > 2.5
            line = np.exp(np.mean(np.log(run_out[tall]) - power * np.log(aspect[tall])))
            span = np.array([aspect[tall].min() / 1.2, 1.2 * aspect.max()])
            left.plot(span, line * span**power, "--", color=colour, linewidth=1.0,
                      label="a^(2/3)" if power > 0.6 else "a^(1/2)")  # fmt: skip
        aspect, run_out, _ = means(flat)
        low = aspect < 2.5
        line = np.exp(np.mean(np.log(run_out[low] / aspect[low])))
        left.plot([0.4, 2.5], [0.4 * line, 2.5 * line], ":", color=STABLE, linewidth=1.0, label="a")
        left.set_xscale("log")
        left.set_yscale("log")
        left.set_xlabel("aspect ratio a = h/r0")
        left.set_ylabel("run-out (r - r0)/r0")
        left.set_title("Column collapse")
        width = granular_silo.WIDTH
        ratio, expected = granular_silo.janssen(silo)
        depth = np.linspace(0.0, silo.fill, 101)
        law = 1.0 - np.exp(-4.0 * granular_silo.WALL_FRICTION * ratio * depth / width)
        middle.plot(
            silo.vertical / expected, silo.depth / width, "o", color=STABLE, markersize=4.0, label="measured"
        )
        middle.plot(law, depth / width, "-", color=INK, linewidth=0.9, label=f"Janssen, K = {ratio:.2f}")
        middle.plot(silo.density * GRAVITY * depth[:40] / expected, depth[:40] / width, ":", color=SOFT, linewidth=0.9,
                    label="weight")  # fmt: skip
        middle.set_xlim(0.0, 1.5)
        middle.invert_yaxis()
        middle.set_xlabel("vertical stress over rho g D/(4 mu K)")
        middle.set_ylabel("depth over D")
        middle.set_title("Silo")
        wide = np.array(granular_hopper.OPENINGS)
        for group, colour in zip(hopper, (FAILED, STABLE), strict=False):
            right.plot(wide - 1.5, [1e3 * run.rate for run in group], "o", color=colour, markersize=4.5,
                       label=f"friction {group[0].friction:g}")  # fmt: skip
        fine = np.linspace(wide.min(), wide.max(), 50)
        flow = [1e3 * granular_hopper.beverloo(d * DIAMETER, hopper[0][0].density) for d in fine]
        right.plot(fine - 1.5, flow, "-", color=INK, linewidth=0.9, label="Beverloo, C = 0.58")
        right.set_xscale("log")
        right.set_yscale("log")
        right.set_xlabel("D/d - 1.5")
        right.set_ylabel("rate of flow [g/s]")
        right.set_title("Hopper")
        for axes in (left, right):
            for axis in (axes.xaxis, axes.yaxis):
                axis.set_major_formatter("{x:g}")
        for axis in (right.xaxis, right.yaxis):
            axis.set_minor_formatter("{x:g}")
        for axes in (left, middle, right):
            axes.legend(loc="best")
            quiet_axes(axes)
        return png(figure)


def run() -> list[Row]:
    """All of them, and the picture."""
    found = flows()
    PICTURES.mkdir(parents=True, exist_ok=True)
    (PICTURES / "granular_flow.png").write_bytes(draw(found))
    return rows_of(found)
