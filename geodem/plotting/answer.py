"""The head of the report: the factor, what it means, and what other methods say."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geodem.plotting import page, wording
from geodem.plotting.page import Markup, text
from geodem.plotting.views import ReportView

ORDER = ("strength-reduction", "gravity-increase")


def factors(result: Mapping[str, Any], view: ReportView) -> list[dict[str, Any]]:
    """Entries with kind, value, stable, failed, criterion and undecided, strength reduction first."""
    entries = [dict(entry) for entry in result.get("factors") or ()]
    kinds = {entry.get("kind") for entry in entries}
    entries += [
        {"kind": m.kind, "value": m.value, "stable": m.stable, "failed": m.failed, "criterion": m.criterion}
        for m in view.methods
        if m.kind not in kinds
    ]
    undecided = {method.kind: list(method.undecided) for method in view.methods}
    for entry in entries:
        if not entry.get("undecided"):
            entry["undecided"] = undecided.get(entry["kind"], [])
    return sorted(
        entries, key=lambda entry: ORDER.index(entry["kind"]) if entry["kind"] in ORDER else len(ORDER)
    )


def answer(result: Mapping[str, Any], view: ReportView) -> str:
    """The headline, the verdict in words, and other methods beside it."""
    entries = factors(result, view)
    blocks = [f'<header id="answer">\n<p class="case-title">{text(view.title)}</p>']
    if not entries:
        return "\n".join([*blocks, "<h1>No factor was asked for</h1>\n</header>"])
    main = entries[0]
    safety = main["kind"] == "strength-reduction"
    quantity, shown, how = wording.found(main)
    blocks.append(
        f'<h1>{text(quantity)} <span class="number">{text(shown)}</span> '
        f'<span class="how">{text(how)}</span></h1>'
    )
    said = wording.verdict(main) if safety else wording.gravity_verdict(main)
    blocks.append(f'<p class="verdict">{text(said)}</p>')
    if main.get("criterion"):
        blocks.append(f"<p>Decided by: {text(wording.powers(main['criterion']))}.</p>")
    for entry in entries:
        if isinstance(entry.get("zero_dilation"), Mapping):
            blocks.append(_zero_dilation(entry))
        if entry["undecided"]:
            blocks.append(_undecided(entry))
    if safety:
        blocks.append(_comparison(main, result))
    gravity = [entry for entry in entries if entry["kind"] == "gravity-increase"]
    for entry in gravity:
        quantity, shown, how = wording.found(entry)
        line = "" if entry is main else f"<p><strong>{text(quantity)} {text(shown)}</strong> {text(how)}</p>"
        blocks.append(f'<div class="note">{line}<p>{text(wording.GRAVITY_WARNING)}</p></div>')
    warnings = result.get("warnings") or ()
    if warnings:
        blocks.append(f'<div class="note"><p><strong>Warnings</strong></p>{page.bullets(warnings)}</div>')
    return "\n".join([*blocks, "</header>"])


def _comparison(main: Mapping[str, Any], result: Mapping[str, Any]) -> str:
    """The factor of safety beside those of other methods, as a table with a scale."""
    value, stable, failed = main.get("value"), main.get("stable"), main.get("failed")
    others: list[tuple[str, float, str]] = []
    for neighbour in result.get("neighbours") or ():
        if neighbour.get("factor") is not None:
            notes = " ".join(f"{str(note).rstrip('.')}." for note in neighbour.get("notes") or ())
            others.append((str(neighbour.get("method", "other method")), float(neighbour["factor"]), notes))
    for reference in (result.get("reference"), main.get("reference")):
        if isinstance(reference, Mapping):
            known = reference.get("factor", reference.get("value"))
            # a factor's own reference may repeat a value that is already listed
            if known is not None and all(abs(float(known) - value) > 1e-9 for _, value, _ in others):
                source = str(reference.get("source", reference.get("how", "")))
                others.append(("Published value", float(known), source))
    why = result.get("neighbours_why")
    reason = (
        f"<p>No limit equilibrium beside it: {text(why)}.</p>" if why and not result.get("neighbours") else ""
    )
    if not others:
        return reason
    known_values = [other for _, other, _ in others] + [v for v in (value, stable, failed) if v is not None]
    low, high = min(known_values), max(known_values)
    pad = max(0.08 * (high - low), 0.01 * high)
    bounds = (low - pad, high + pad)
    band = (stable, failed) if stable is not None and failed is not None else None
    rows: list[list[object]] = []
    if value is not None:
        mark = page.scale_bar(value, bounds, band=band, strong=True)
        shown = Markup(
            f"{text(wording.factor(value, stable, failed))} [{wording.bound(stable, failed)}, "
            f"{wording.bound(failed, stable)}]"
            if stable is not None and failed is not None
            else text(wording.number(value))
        )
        rows.append(["geodem, strength reduction", shown, "", mark, "this run"])
    for name, other, notes in others:
        difference = wording.percent(value, other) if value is not None else ""
        rows.append(
            [name, f"{other:.3f}", difference, page.scale_bar(other, bounds, band=band, strong=False), notes]
        )
    header = ["Method", "Factor of safety [-]", "geodem against it", "", "Notes"]
    return page.table(header, rows, numbers=(1, 2), kind="compare") + reason + _circles_miss(value, result)


def _circles_miss(value: float | None, result: Mapping[str, Any]) -> str:
    """A word of explanation where circles lie far above what was found."""
    circular = [
        float(neighbour["factor"])
        for neighbour in result.get("neighbours") or ()
        if neighbour.get("radius") is not None and neighbour.get("factor") is not None
    ]
    if value is None or not circular or min(circular) < 1.05 * value:
        return ""
    return (
        "<p>The factors on circles are well above: a circle cannot follow a weak layer, so that it "
        "overestimates "
        "the safety of ground that fails along one. Compare the traced slip surface below with the circles, "
        "and "
        "the factor with a non-circular surface.</p>"
    )


def _zero_dilation(entry: Mapping[str, Any]) -> str:
    """What the silent choice of a dilation angle equal to the friction angle is worth."""
    flat = entry["zero_dilation"]
    _, shown, how = wording.found({**flat, "kind": entry["kind"]})
    change = ""
    if entry.get("value") is not None and flat.get("value") is not None:
        change = f", {wording.percent(float(flat['value']), float(entry['value']))} from the factor above"
    return (
        '<div class="note"><p><strong>Dilation angle not given</strong>: it was taken equal to the friction '
        "angle, as limit equilibrium does in effect. With a dilation angle of zero, the other extreme, the same "
        f"search gives <strong>{text(shown)}</strong> {text(how)}{text(change)}; on "
        f"{text(wording.number(flat.get('particles')))} particles, and with some dependence on the mesh. Give "
        "dilation_angle to settle it.</p></div>"
    )


def _undecided(entry: Mapping[str, Any]) -> str:
    values = sorted(float(value) for value in entry["undecided"])
    count = "One trial was" if len(values) == 1 else f"{len(values)} trials were"
    listed = ", ".join(wording.bound(value) for value in values)
    method = wording.NAMES.get(entry["kind"], entry["kind"])
    return (
        f'<div class="note"><p><strong>{count} undecided</strong> in the {text(method)}, '
        f"at {text(listed)}: neither at "
        "rest nor running away when the steps ran out. Such a trial counts as neither stable nor failed; "
        "more steps or "
        "more particles may settle it.</p></div>"
    )
