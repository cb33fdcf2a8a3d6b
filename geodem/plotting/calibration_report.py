"""The report of a calibration: the rock that was asked for beside the one that was come to, and how it breaks."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geodem.calibration.fit import OF_TARGETS, Calibration
from geodem.io.files import write_whole
from geodem.laboratory.orders import FinishedTest
from geodem.laboratory.summary import Property, Spread, group_tests, material_properties, summarise_envelope
from geodem.plotting import laboratory_sections as parts
from geodem.plotting import page, sections
from geodem.plotting.laboratory_report import run_section, write_figures
from geodem.plotting.laboratory_wording import rounded
from geodem.plotting.page import text
from geodem.plotting.theme import CIRCLE, FAINT, INK, SLIP, SOFT, new_figure, png, quiet_axes, style, svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TITLES = {
    "young_modulus": ("Young's modulus", "stress", "young_modulus_Pa"),
    "poisson_ratio": ("Poisson's ratio", "dimensionless", "poisson_ratio"),
    "uniaxial_compressive_strength": (
        "uniaxial compressive strength",
        "stress",
        "uniaxial_compressive_strength_Pa",
    ),
    "tensile_strength": ("direct tensile strength", "stress", "tensile_strength_Pa"),
    "friction_angle": ("friction angle", "angle", "friction_angle_rad"),
}
"""Of every property: its name, its quantity, and its name among those of the laboratory."""

SHARES = 0.12
"""What the chart of the rounds shows at least, to both sides of the target."""


def write_calibration_report(
    path: Path,
    result: Mapping[str, Any],
    found: Calibration,
    tests: Sequence[FinishedTest],
    case_text: str,
    material_text: str,
) -> None:
    """Write the report and, into ``figures`` beside it, its figures.

    Parameters
    ----------
    path : pathlib.Path
        The HTML file; replaced whole or not at all.
    result : dict
        What result.json holds.
    found : Calibration
    tests : sequence of FinishedTest
        Of the bonds on fresh specimens.
    case_text, material_text : str
        The two files.

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    groups = group_tests(tests)
    envelope = summarise_envelope(groups)
    properties = material_properties(groups, envelope)
    pictures = parts.make_figures(groups, envelope)
    with style():
        chart = rounds_chart(found, properties)
        pictures["rounds"] = sections.Picture(png(chart), svg=svg(chart))
    content = [
        ("answer", "Answer", _answer(result, found, properties)),
        ("rounds", "Rounds", _rounds(found, pictures)),
        ("fresh", "Fresh specimens", _fresh(properties, parts.tests_table(groups))),
        ("curves", "Curves", parts.curves_section(groups, pictures)),
        ("envelope", "Envelope", parts.envelope_section(envelope, pictures)),
        ("specimens", "Specimens", parts.specimens_section(groups, pictures)),
        ("material", "Material file", page.section("material", "Material file", page.toml(material_text))),
        ("run", "Run", run_section(result)),
        ("case", "Case file", page.section("case", "Case file", page.toml(case_text)) if case_text else ""),
    ]
    present = [(anchor, name, body) for anchor, name, body in content if body]
    html = page.document(
        f"{result['title']}: calibration",
        {anchor: name for anchor, name, _ in present},
        "\n".join(body for *_, body in present),
    )
    write_figures(path.parent / "figures", pictures)
    write_whole(path, html)


def rounds_chart(found: Calibration, fresh: Sequence[Property]) -> Figure:
    """Every property over its target: the specimens of each round, the interval at the end, and the fresh specimens."""
    figure = new_figure(7.7, 3.6)
    axes = figure.subplots(1, len(OF_TARGETS), sharey=False)
    by_key = {entry.key: entry.spread for entry in fresh}
    ticks = [*range(1, len(found.rounds) + 1), len(found.rounds) + 1, len(found.rounds) + 2]
    for axis, name in zip(axes, OF_TARGETS, strict=True):
        title, _, key = TITLES[name]
        wanted = getattr(found.targets, name)
        quiet_axes(axis)
        axis.axhline(1.0, color=SOFT, linewidth=1.0, linestyle=(0, (4, 2)))
        for number, each in enumerate(found.rounds, start=1):
            values = np.array([float(outcome[name]) for outcome in each.outcomes]) / wanted
            axis.plot(
                np.full(len(values), number), values, "o", color=FAINT, markeredgecolor=SOFT, markersize=3.5
            )
            axis.plot([number - 0.28, number + 0.28], [values.mean()] * 2, color=INK, linewidth=1.8)
        got = found.achieved[name]
        below, above = (got.value - got.low) / wanted, (got.high - got.value) / wanted
        axis.errorbar(
            [ticks[-2]], [got.value / wanted],
            yerr=[[below], [above]], fmt="s", color=CIRCLE, markersize=5.0, capsize=3.0, linewidth=1.6,
        )  # fmt: skip
        spread = by_key.get(key, Spread(math.nan, math.nan, 0))
        if spread.specimens:
            error = 0.0 if math.isnan(spread.deviation) else spread.deviation / wanted
            axis.errorbar(
                [ticks[-1]], [spread.mean / wanted], yerr=[[error], [error]], fmt="D", color=SLIP, markersize=4.5,
                capsize=3.0, linewidth=1.4,
            )  # fmt: skip
        low, high = axis.get_ylim()
        reach = max(abs(low - 1.0), abs(high - 1.0), SHARES)
        axis.set_ylim(1.0 - reach, 1.0 + reach)
        axis.set_xlim(0.4, ticks[-1] + 0.6)
        axis.set_xticks(ticks, [*(str(k) for k in ticks[:-2]), "end", "fresh"], rotation=60)
        axis.set_title(title.replace(" ", "\n", 1) if len(title) > 15 else title, fontsize=8.5)
    axes[0].set_ylabel("over the target [-]")
    return figure


def _answer(result: Mapping[str, Any], found: Calibration, fresh: Sequence[Property]) -> str:
    reached = sum(entry["reached"] for entry in result["properties"].values())
    number = "all" if reached == len(OF_TARGETS) else f"{reached} of {len(OF_TARGETS)}"
    narrow = (
        "with intervals as narrow as is wanted" if result["narrow"] else "with intervals that are still wide"
    )
    rows = []
    by_key = {entry.key: entry for entry in fresh}
    for name in OF_TARGETS:
        title, quantity, key = TITLES[name]
        entry = result["properties"][name]
        low, high = (rounded(entry[end], quantity) for end in ("low", "high"))
        own = by_key.get(key)
        rows.append(
            (
                title,
                rounded(entry["target"], quantity),
                rounded(entry["achieved"], quantity),
                f"{low} to {high}",
                f"{entry['difference_percent']:+.1f} %",
                "-" if own is None else parts.shown(own.spread, quantity),
            )
        )
    header = ("property", "target", "achieved", "95 % interval of the mean", "difference", "fresh specimens")
    blocks = [
        f'<header id="answer">\n<p class="case-title">{text(result["title"])}</p>',
        f'<h1>Calibration: <span class="number">{text(number)}</span> properties reached '
        f'<span class="how">{text(narrow)}</span></h1>',
        page.table(header, rows, numbers=(1, 2, 3, 4, 5)),
    ]
    told = (
        f"The bonds are those that {found.tests} specimens in {len(found.rounds)} rounds led to; the interval is that "
        "of the mean over all specimens there could be, from the scatter of those tested and the error of the map. The "
        "fresh specimens are others, tested afterwards: mean and standard deviation of a single one."
    )
    blocks.append(f"<p>{text(told)}</p>")
    blocks.append(f'<p class="static">{text(parts.SIGN)}')
    if result["dimension"] == 2:
        blocks.append(text(parts.PLATE))
    blocks.append("</p>")
    if result["missed"]:
        said = page.bullets(result["missed"])
        blocks.append(f'<div class="note"><p><strong>What these bonds cannot have</strong></p>{said}</div>')
    warnings = [line for line in result.get("warnings") or () if line not in result["missed"]]
    if warnings:
        blocks.append(f'<div class="note"><p><strong>Warnings</strong></p>{page.bullets(warnings)}</div>')
    return "\n".join([*blocks, "</header>"])


def _rounds(found: Calibration, pictures: Mapping[str, sections.Picture]) -> str:
    picture = pictures["rounds"]
    assert picture.svg is not None
    caption = (
        "Every property over its target. Circles: specimens of a round, bar: their mean. Square: what all rounds "
        "together say of the bonds that were chosen, with its interval. Diamond: fresh specimens of them, with the "
        "standard deviation of one."
    )
    micro = list(found.rounds[0].fit.micro)
    rows = [
        (
            str(number),
            rounded(each.fit.effective_modulus, "stress"),
            rounded(each.fit.tensile_strength, "stress"),
            *(f"{each.fit.micro[name]:.4g}" for name in micro),
        )
        for number, each in enumerate(found.rounds, start=1)
    ]
    header = (
        "round",
        "effective modulus",
        "bond tensile strength",
        *(name.replace("_", " ") for name in micro),
    )
    return page.section(
        "rounds", "Rounds",
        page.figure(picture.svg, caption, alternative="rounds of the calibration", kind="image/svg+xml"),
        "<h3>Bonds of every round</h3>", page.table(header, rows, numbers=range(len(header))),
    )  # fmt: skip


def _fresh(properties: Sequence[Property], tests: str) -> str:
    said = (
        "The bonds of the material file on specimens that the calibration has not seen, tested beyond their peaks and "
        "at several confinements."
    )
    return page.section(
        "fresh", "Fresh specimens", f"<p>{text(said)}</p>", parts.properties_table(properties), tests
    )
