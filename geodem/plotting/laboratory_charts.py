"""Charts of the laboratory: stress against strain, how a specimen cracks, and the envelope with Mohr's circles."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.laboratory.orders import FinishedTest
from geodem.laboratory.summary import EnvelopeSummary, TestGroup
from geodem.plotting.particles import SHEAR, TENSION
from geodem.plotting.theme import INK, SOFT, displacement_colours, halo, new_figure, quiet_axes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

LOADS = {
    "brazilian": "tension in the middle by the load [MPa]",
    "direct-shear": "shear stress [MPa]",
    "three-point-bending": "stress of the extreme fibre [MPa]",
}
"""What is drawn upwards where it is no axial stress."""

PASCAL = 1e-6
"""Stresses are drawn in MPa."""


def curves_chart(groups: Sequence[TestGroup]) -> Figure:
    """Stress against strain, one line a specimen, one colour a confinement; strain across to the left where known.

    Parameters
    ----------
    groups : sequence of TestGroup
        Of tests that are driven the same way.
    """
    figure = new_figure(7.7, 4.2)
    axes = figure.add_subplot()
    quiet_axes(axes)
    along, label = _abscissa(groups[0])
    sideways = along == "axial_strain" and groups[0].kind.endswith("compression")
    for group, colour in zip(groups, _shades(len(groups)), strict=True):
        shown = group.typical
        for test in group.tests:
            curves = test.record.curves
            strain, stress = _scaled(curves[along], along), PASCAL * curves["axial_stress"]
            main = test is shown
            look: dict[str, Any] = {
                "color": colour,
                "linewidth": 1.9 if main else 0.8,
                "alpha": 1.0 if main else 0.6,
                "zorder": 4.0 if main else 3.0,
            }
            axes.plot(strain, stress, label=_named(group) if main else None, **look)
            if sideways:
                top = _last_shown(stress)
                axes.plot(
                    100.0 * curves["gauge_lateral"][:top], stress[:top], linestyle=(0, (4, 1.5)), **look
                )
            if along == "axial_strain":
                _elastic(axes, test, look, sideways=sideways)
            peak = int(np.argmax(stress))
            axes.plot(
                strain[peak], stress[peak], "o", color=colour, markersize=5.0 if main else 3.0, zorder=5.0
            )
    if sideways:
        axes.axvline(0.0, color=SOFT, linewidth=0.8)
        _within(axes, groups)
        label = "strain across, dashed (left)            axial strain (right) [%]"
    else:
        axes.set_xlim(left=0.0)
    axes.set_xlabel(label)
    axes.set_ylabel(LOADS.get(groups[0].kind, "axial stress [MPa]"))
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def cracking_chart(group: TestGroup) -> Figure:
    """Stress, volumetric strain and cracks against axial strain for the group's typical specimen."""
    record = group.typical.record
    curves = record.curves
    strain, stress = 100.0 * curves["axial_strain"], PASCAL * curves["axial_stress"]
    figure = new_figure(7.7, 4.6)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.5, 1.0])
    for axes in (above, below):
        quiet_axes(axes)
    above.plot(strain, stress, color=INK, linewidth=1.6)
    above.set_ylabel("axial stress [MPa]")
    peak = int(np.argmax(stress))
    above.plot(strain[peak], stress[peak], "o", color=INK, markersize=5.0)
    for name, words in (
        ("crack_initiation_stress", "crack initiation"),
        ("crack_damage_stress", "crack damage"),
    ):
        value = PASCAL * record.numbers.get(name, math.nan)
        if math.isfinite(value):
            at = float(np.interp(value, stress[: peak + 1], strain[: peak + 1]))
            above.plot([at, strain[-1]], [value, value], color=SOFT, linewidth=0.9, linestyle=(0, (4, 2)))
            above.annotate(
                f"{words} {value:.3g} MPa", (at, value), xytext=(8, -4), textcoords="offset points",
                va="top", fontsize=8.5, color=SOFT, path_effects=halo(),
            )  # fmt: skip
    above.set_ylim(bottom=0.0)
    right = above.twinx()
    volumetric = 100.0 * (curves["gauge_axial"] + _sides(group) * curves["gauge_lateral"])
    shown = slice(0, _last_shown(stress))
    right.plot(strain[shown], volumetric[shown], color="#00755b", linewidth=1.2)
    right.set_ylabel("volumetric strain of the middle [%],\ncontraction up", color="#00755b")
    right.tick_params(axis="y", colors="#00755b", length=3.0)
    for name, colour in (("tension", TENSION), ("shear", SHEAR)):
        below.plot(strain, curves[f"{name}_cracks"], color=colour, linewidth=1.6, label=f"cracks by {name}")
    below.axvline(strain[peak], color=SOFT, linewidth=0.8, linestyle=(0, (4, 2)))
    below.set_ylabel("cracks [-]")
    below.set_xlabel("axial strain [%]")
    below.legend(loc="upper left")
    below.set_ylim(bottom=0.0)
    below.set_xlim(left=0.0)
    return figure


def envelope_chart(envelope: EnvelopeSummary, tension: float | None = None) -> Figure:
    """Mohr's circles with the straight envelope, and strength against confinement with Hoek and Brown's curve.

    Parameters
    ----------
    envelope : EnvelopeSummary
    tension : float, optional
        Tensile strength [Pa], positive.
    """
    figure = new_figure(7.7, 3.9)
    left, right = figure.subplots(1, 2, width_ratios=[1.25, 1.0])
    across = PASCAL * np.array(envelope.confinement)
    along = PASCAL * np.array(envelope.strength)
    whole = envelope.whole
    _circles(left, across, along, tension, whole.friction_angle, PASCAL * whole.cohesion)
    quiet_axes(right)
    right.plot(across, along, "o", color=INK, markersize=4.5, zorder=4.0, label="tests", clip_on=False)
    top = 1.08 * float(across.max())
    at = np.linspace(0.0, top, 200)
    slope = (1.0 + math.sin(whole.friction_angle)) / (1.0 - math.sin(whole.friction_angle))
    ucs = PASCAL * whole.intercept
    right.plot(at, ucs + slope * at, color="#0b4f8a", linewidth=1.6, label="Mohr-Coulomb")
    if math.isfinite(whole.m_i):
        curve = at + np.sqrt(whole.m_i * ucs * at + ucs**2)
        right.plot(at, curve, color="#c2410c", linewidth=1.4, linestyle=(0, (5, 2)), label="Hoek-Brown")
    right.set_xlim(0.0, top)
    right.set_ylim(bottom=0.0)
    right.set_xlabel("confinement [MPa]")
    right.set_ylabel("strength [MPa]")
    right.legend(loc="lower right")
    return figure


def _circles(
    axes: Axes, across: Floats, along: Floats, tension: float | None, friction: float, cohesion: float
) -> None:
    quiet_axes(axes)
    angle = np.linspace(0.0, math.pi, 181)
    confinements = np.unique(across)
    for confinement, colour in zip(confinements, _shades(len(confinements)), strict=True):
        own = along[across == confinement]
        for k, strength in enumerate([*own, own.mean()]):
            middle, radius = 0.5 * (strength + confinement), 0.5 * (strength - confinement)
            mean = k == len(own)
            axes.plot(
                middle + radius * np.cos(angle), radius * np.sin(angle), color=colour,
                linewidth=1.6 if mean else 0.6, alpha=1.0 if mean else 0.45,
            )  # fmt: skip
    if tension is not None:
        radius = 0.5 * PASCAL * tension
        axes.plot(radius * (np.cos(angle) - 1.0), radius * np.sin(angle), color=TENSION, linewidth=1.6)
    largest = along.max()
    start = -PASCAL * tension if tension is not None else 0.0
    normal = np.array([max(start, -cohesion / math.tan(friction)) if friction else start, 0.8 * largest])
    axes.plot(normal, cohesion + normal * math.tan(friction), color=INK, linewidth=1.4, zorder=5.0)
    axes.annotate(
        f"c = {cohesion:.3g} MPa, φ = {math.degrees(friction):.1f}°", (0.97, 0.95), xycoords="axes fraction",
        va="top", ha="right", fontsize=9.0, path_effects=halo(),
    )  # fmt: skip
    axes.set_aspect("equal", adjustable="box")
    axes.axvline(0.0, color=SOFT, linewidth=0.8)
    axes.set_xlim(min(1.15 * start, -0.03 * largest), 1.03 * largest)
    axes.set_ylim(0.0, 0.62 * largest)
    axes.set_xlabel("normal stress [MPa], compression positive")
    axes.set_ylabel("shear stress [MPa]")


def _elastic(axes: Axes, test: FinishedTest, look: dict[str, Any], *, sideways: bool) -> None:
    """The elastic part that a test begins with, which is solved for: from the pressure on all sides on."""
    curves, numbers = test.record.curves, test.record.numbers
    young, floor = numbers.get("young_modulus", math.nan), numbers.get("confinement", 0.0)
    load = float(curves["axial_stress"][0]) - floor
    if not (math.isfinite(young) and load > 0.0):
        return
    thin = {**look, "linewidth": 0.6 * look["linewidth"], "linestyle": (0, (1, 1.5))}
    stress = PASCAL * np.array([floor, floor + load])
    end = float(curves["axial_strain"][0])
    axes.plot(100.0 * np.array([end - load / young, end]), stress, **thin)
    if sideways:
        end = float(curves["gauge_lateral"][0])
        axes.plot(100.0 * np.array([end + numbers["poisson_ratio"] * load / young, end]), stress, **thin)


def _shades(count: int) -> list[tuple[float, float, float, float]]:
    """Colours from light to dark."""
    colours = displacement_colours()
    return [colours(0.45 + 0.5 * k / max(count - 1, 1)) if count > 1 else colours(0.8) for k in range(count)]


def _named(group: TestGroup) -> str:
    if group.stress:
        return f"{PASCAL * group.stress:g} MPa"
    return group.kind.replace("-", " ") if not group.kind.endswith("compression") else "unconfined"


def _abscissa(group: TestGroup) -> tuple[str, str]:
    curves = group.tests[0].record.curves
    if "axial_strain" in curves:
        return "axial_strain", "axial strain [%]"
    if "displacement" in curves:
        return "displacement", "displacement [mm]"
    return "steps", "step [-]"


def _scaled(values: Floats, name: str) -> Floats:
    return values * {"axial_strain": 100.0, "displacement": 1e3}.get(name, 1.0)


def _sides(group: TestGroup) -> float:
    """Directions across the axis: in 2D the third one is not looked at."""
    return float(group.typical.record.positions.shape[1] - 1)


def _last_shown(stress: Floats) -> int:
    """How far strains of the middle mean something: once the load has fallen the middle is in pieces."""
    peak = int(np.argmax(stress))
    after = np.flatnonzero(stress[peak:] < 0.9 * stress[peak])
    return peak + int(after[0]) + 1 if len(after) else len(stress)


def _within(axes: Axes, groups: Sequence[TestGroup]) -> None:
    """Limits that leave the strain across no more room than it is worth."""
    right = max(100.0 * float(t.record.curves["axial_strain"].max()) for g in groups for t in g.tests)
    axes.set_xlim(-0.75 * right, 1.03 * right)
