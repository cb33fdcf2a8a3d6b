"""Parts of a report on tests of the laboratory: their figures, and the blocks of the page that hold them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from geodem.laboratory.orders import KINDS
from geodem.laboratory.summary import EnvelopeSummary, Property, Spread, TestGroup
from geodem.plotting import laboratory_charts as charts
from geodem.plotting import page
from geodem.plotting.laboratory_specimen import can_draw, specimen_chart
from geodem.plotting.laboratory_wording import deviation_shown, rounded, spread
from geodem.plotting.page import text
from geodem.plotting.sections import Picture
from geodem.plotting.theme import png, style, svg
from geodem.units import show

SIGN = (
    "Stress and strain are positive in compression; strengths, in tension too, are given as positive numbers."
)

PLATE = (
    "In two dimensions the specimen is a plate one metre deep that is free at its faces (plane stress): E and nu are "
    "those of a plate, and forces are per metre."
)


def make_figures(groups: Sequence[TestGroup], envelope: EnvelopeSummary | None) -> dict[str, Picture]:
    """Figures by name: curves-KIND, cracking, envelope, specimen-KIND-STRESS."""
    found: dict[str, Picture] = {}
    with style():
        for name, together in _families(groups).items():
            chart = charts.curves_chart(together)
            found[f"curves-{name}"] = Picture(png(chart), svg=svg(chart))
        pressed = _first(groups, "uniaxial-compression") or _first(groups, "triaxial-compression")
        if pressed is not None:
            chart = charts.cracking_chart(pressed)
            found["cracking"] = Picture(png(chart), svg=svg(chart))
        if envelope is not None:
            pulled = _first(groups, "direct-tension")
            chart = charts.envelope_chart(envelope, None if pulled is None else pulled.strength.mean)
            found["envelope"] = Picture(png(chart), svg=svg(chart))
        for group in groups:
            if not can_draw(group.typical):
                found[specimen_name(group)] = Picture(png(specimen_chart(group.typical, title_of(group))))
    return found


def specimen_name(group: TestGroup) -> str:
    """Of the figure of a group's typical specimen."""
    return f"specimen-{group.typical.order.name}"


def title_of(group: TestGroup) -> str:
    """Kind and stress in words."""
    words = group.kind.replace("-", " ").replace("brazilian", "Brazilian test")
    words = words[0].upper() + words[1:]
    kind = KINDS.get(group.kind)
    at = f" at {show(group.stress, 'stress')}" if group.stress else ""
    called = f" {kind.stress}" if at and kind is not None and kind.stress != "confinement" else ""
    return f"{words}{at}{called}"


def shown(found: Spread, quantity: str) -> str:
    """A mean with its standard deviation and unit."""
    return spread(found.mean, found.deviation, quantity)


def properties_table(properties: Iterable[Property]) -> str:
    """Mean, scatter, specimens and what each is from."""
    rows = [
        (
            entry.name,
            rounded(entry.spread.mean, entry.quantity),
            "-"
            if math.isnan(entry.spread.deviation)
            else deviation_shown(entry.spread.mean, entry.spread.deviation, entry.quantity),
            _percent(entry.spread),
            entry.spread.specimens,
            entry.source,
        )
        for entry in properties
    ]
    header = ("property", "mean", "standard deviation", "of the mean", "specimens", "from")
    return page.table(header, rows, numbers=(1, 2, 3, 4))


def tests_table(groups: Iterable[TestGroup]) -> str:
    """One line a kind of test and stress."""
    rows = []
    for group in groups:
        failed = sum(test.record.failed for test in group.tests)
        angle = group.number("failure_angle")
        cracks = [test.record.cracks for test in group.tests]
        peak = group.number("peak_strain")
        rows.append(
            (
                title_of(group),
                len(group.tests),
                shown(group.strength, "stress"),
                f"{100.0 * peak.mean:.3g} %" if peak.specimens else "-",
                f"{sum(c.tension for c in cracks) / len(cracks):,.0f}",
                f"{sum(c.shear for c in cracks) / len(cracks):,.0f}",
                shown(angle, "angle") if angle.specimens else "-",
                "all" if failed == len(group.tests) else f"{failed}",
            )
        )
    header = (
        "test", "specimens", "strength", "strain at the peak", "cracks, tension", "cracks, shear",
        "failure plane to the axis", "with a peak",
    )  # fmt: skip
    return page.table(header, rows, numbers=range(1, 8))


def curves_section(groups: Sequence[TestGroup], pictures: Mapping[str, Picture]) -> str:
    """Curves of every family of tests, and how the specimen cracks."""
    blocks = []
    for name in _families(groups):
        caption = f"{_caption(name)} One line a specimen; bold: that of the middle strength. Dots: strengths."
        blocks.append(_figure(pictures[f"curves-{name}"], caption, "stress against strain"))
    if "cracking" in pictures:
        caption = (
            "The typical specimen: cracks begin, the middle begins to dilate (crack damage), the load falls. Crack "
            "initiation is the stress at which one in a hundred of the cracks before the peak is there (Potyondy & "
            "Cundall 2004), crack damage that at which the volumetric strain is largest."
        )
        blocks.append(_figure(pictures["cracking"], caption, "stress, volumetric strain and cracks"))
    return page.section("curves", "Curves", *blocks)


def envelope_section(envelope: EnvelopeSummary | None, pictures: Mapping[str, Picture]) -> str:
    """Mohr's circles and the two envelopes; nothing without confined tests."""
    if envelope is None or "envelope" not in pictures:
        return ""
    whole = envelope.whole
    said = (
        f"The straight line through all strengths: friction angle {math.degrees(whole.friction_angle):.1f} deg, "
        f"cohesion {rounded(whole.cohesion, 'stress')}; the strengths lie {100.0 * whole.misfit:.1f} % from it "
        "in the root mean square."
    )
    if math.isfinite(whole.m_i):
        said += f" Hoek and Brown's curve through the same points (s = 1): mi = {whole.m_i:.1f}."
    caption = (
        "Left: Mohr's circles, thin for every specimen, bold for the means, with the straight envelope. Right: "
        "strength against confinement."
    )
    return page.section(
        "envelope", "Envelope", f"<p>{text(said)}</p>",
        _figure(pictures["envelope"], caption, "Mohr circles and envelope"),
    )  # fmt: skip


def specimens_section(groups: Sequence[TestGroup], pictures: Mapping[str, Picture]) -> str:
    """The typical specimen of every test at its end."""
    blocks, missing = [], ""
    for group in groups:
        name = specimen_name(group)
        if name not in pictures:
            missing = can_draw(group.typical)
            continue
        record = group.typical.record
        caption = (
            f"{title_of(group)}, specimen {group.typical.order.seed}, at the end of its test ({record.reason}): "
            "colour by how far particles moved, short lines: cracks where they opened, red by tension, blue by shear."
        )
        blocks.append(page.figure(pictures[name].png, caption, alternative=title_of(group), wide=False))
    body = f'<div class="grid">{"".join(blocks)}</div>' if blocks else ""
    note = f"<p>{text(missing)}</p>" if missing else ""
    return page.section("specimens", "Specimens", body, note)


def _figure(picture: Picture, caption: str, alternative: str) -> str:
    if picture.svg is not None:
        return page.figure(picture.svg, caption, alternative=alternative, kind="image/svg+xml")
    return page.figure(picture.png, caption, alternative=alternative)


def _families(groups: Sequence[TestGroup]) -> dict[str, list[TestGroup]]:
    """Groups that share a chart: compression at all confinements, every other kind by itself."""
    found: dict[str, list[TestGroup]] = {}
    for group in groups:
        name = "compression" if group.kind.endswith("axial-compression") else group.kind
        found.setdefault(name, []).append(group)
    return {name: sorted(family, key=lambda group: group.stress) for name, family in found.items()}


def _caption(family: str) -> str:
    if family == "compression":
        return (
            "Compression: axial stress against axial strain, and against the strain across; dotted: the elastic part, "
            "which is solved for."
        )
    words = "Brazilian test" if family == "brazilian" else family.replace("-", " ").capitalize()
    return f"{words}: stress on the way to failure."


def _first(groups: Sequence[TestGroup], kind: str) -> TestGroup | None:
    return next((group for group in groups if group.kind == kind), None)


def _percent(spread: Spread) -> str:
    if not math.isfinite(spread.deviation) or spread.mean == 0.0:
        return "-"
    return f"{100.0 * spread.deviation / abs(spread.mean):.1f} %"
