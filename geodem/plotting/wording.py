"""How numbers and verdicts are put into words."""

from __future__ import annotations

import re
from collections.abc import Mapping
from math import floor, isfinite, log10, nan
from typing import Any

from geodem.run_progress import time_left

NAMES = {"strength-reduction": "strength reduction", "gravity-increase": "gravity increase"}
QUANTITY = {"strength-reduction": "Factor of safety", "gravity-increase": "Gravity factor"}

GRAVITY_WARNING = (
    "The gravity factor is a load multiplier, NOT a factor of safety: it says how many times heavier the "
    "ground "
    "could be before it fails with its strength kept. The two are equal only where friction is zero or both "
    "are "
    "one; with friction they lie far apart (3.3 against 1.4 for one and the same 2:1 slope), since heavier "
    "ground also rubs harder."
)


def bound(value: float, other: float | None = None) -> str:
    """One end of a bracket: three decimals, more where the bracket is narrower than two units."""
    places = 3
    while other is not None and value != other and places < 9 and abs(other - value) * 10.0**places < 2.0:
        places += 1
    return f"{value:.{places}f}"


def factor(value: float, stable: float | None = None, failed: float | None = None) -> str:
    """The middle of a bracket: two decimals, more where it would round out of the bracket."""
    for places in range(2, 9):
        shown = f"{value:.{places}f}"
        if (stable is None or float(shown) >= stable) and (failed is None or float(shown) <= failed):
            return shown
    return f"{value:.9g}"


def found(entry: Mapping[str, Any]) -> tuple[str, str, str]:
    """What was found: quantity, number, and how, for an entry with kind, value, stable, failed.

    An open bracket is told as such: "above 2.000", "below 0.500", "not found".
    """
    kind, value, stable, failed = (entry.get(key) for key in ("kind", "value", "stable", "failed"))
    quantity, method = QUANTITY.get(str(kind), "Factor"), NAMES.get(str(kind), str(kind))
    if value is not None and stable is not None and failed is not None:
        how = f"stable at {bound(stable, failed)}, failed at {bound(failed, stable)}"
        return quantity, factor(value, stable, failed), f"({method}; {how})"
    if stable is not None:
        return quantity, f"above {bound(stable)}", f"({method}; stable at {bound(stable)}, no failure found)"
    if failed is not None:
        return (
            quantity,
            f"below {bound(failed)}",
            f"({method}; failed at {bound(failed)}, no stable state found)",
        )
    return quantity, "not found", f"({method}; no trial was decided)"


def verdict(entry: Mapping[str, Any]) -> str:
    """The answer of a strength reduction as a sentence or two."""
    stable, failed, value = (entry.get(key) for key in ("stable", "failed", "value"))
    if stable is None and failed is None:
        return "No trial was decided: this run says nothing about stability."
    if stable is not None and stable >= 1.0:
        if value is None:
            return f"The ground stands, and still stands with its strength divided by {bound(stable)}."
        return (
            "The ground stands. Cohesion and tan φ could both be divided by "
            f"{factor(value, stable, failed)} before "
            f"it fails: it uses {100.0 / value:.0f} % of its strength."
        )
    if failed is not None and failed <= 1.0:
        if value is None:
            return "The ground does not stand with the strengths given."
        return (
            "The ground does not stand with the strengths given: cohesion and tan φ would have to be "
            f"{1.0 / value:.2f} times as large."
        )
    if stable is None or failed is None:
        return "The search did not reach a factor of one: whether the ground stands was not decided."
    return "The ground is at its limit: a factor of one lies inside the bracket."


def gravity_verdict(entry: Mapping[str, Any]) -> str:
    """The answer of a gravity increase as a sentence."""
    stable, failed, value = (entry.get(key) for key in ("stable", "failed", "value"))
    if stable is not None and stable >= 1.0:
        limit = (
            ""
            if value is None
            else f" It fails when gravity is multiplied by {factor(value, stable, failed)}."
        )
        return "The ground stands under its own weight." + limit
    if failed is not None and failed <= 1.0:
        return "The ground does not stand under its own weight."
    if stable is None or failed is None:
        return "Whether the ground stands under its own weight was not decided."
    return "The ground is at its limit under its own weight: a factor of one lies inside the bracket."


def percent(ours: float, theirs: float) -> str:
    """Difference of ours from theirs in % of theirs, with its sign."""
    return f"{100.0 * (ours - theirs) / theirs:+.1f} %".replace("-", "\N{MINUS SIGN}")


def number(value: object, *, digits: int = 4) -> str:
    """A number as people read it: grouped thousands, powers of ten written out; other values as text."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return "none" if value is None else str(value)
    if not isfinite(value):
        return "none" if value != value else "unlimited"
    if isinstance(value, int) or (value == int(value) and abs(value) < 1e7):
        return f"{int(value):,}"
    size = floor(log10(abs(value)))
    if -3 <= size < 7:
        return f"{value:,.{max(digits - 1 - size, 0)}f}"
    return f"{value / 10.0**size:.{digits - 2}f}·10{str(size).translate(_RAISED)}"


def powers(words: str) -> str:
    """A sentence with its powers of ten written out: 1e-05 becomes 10 with a raised -5."""

    def written(match: re.Match[str]) -> str:
        power = f"10{str(int(match[2])).translate(_RAISED)}"
        return power if match[1] == "1" else f"{match[1]}·{power}"

    return re.sub(r"(\d+(?:\.\d+)?)e([+-]\d+)", written, words)


def answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Factors of a slope's result.json and what stands beside them, each with its words in bold first."""
    lines = []
    for entry in result["factors"]:
        quantity, shown, how = found(entry)
        meaning = (
            "" if entry["kind"] == "strength-reduction" else " A load multiplier, not a factor of safety."
        )
        lines.append((f"{quantity} {shown}", f" {how}.{meaning}"))
        flat = entry.get("zero_dilation")
        if flat is not None:
            quantity, shown, _ = found({**flat, "kind": entry["kind"]})
            given = "with a dilation angle of zero (none was given; it was taken equal"
            lines.append(("", f"  {quantity} {shown} {given}"))
            lines.append(("", f"  to the friction angle), on {flat['particles']:,} particles"))
    beside = [f"{neighbour['method']} {neighbour['factor']:.3f}" for neighbour in result["neighbours"]]
    if result.get("reference"):
        beside.append(f"published {result['reference']['factor']:g} ({result['reference']['source']})")
    if beside:
        lines.append(("", "Beside it: " + ", ".join(beside)))
    if result["neighbours_why"]:
        lines.append(("", f"No limit equilibrium beside it: {result['neighbours_why']}"))
    return lines


def seconds(value: object) -> str:
    """A duration: 0.21 s, 14.2 s, 3 min 20 s."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    if value < 60.0:
        return f"{value:.3g} s"
    minutes, rest = divmod(round(value), 60)
    return f"{minutes} min {rest} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def closing(progress: Any, seconds_left: float, seconds_most: float = nan) -> str:
    """How far the bracket of a search has closed (`geodem.stability.search.Progress`), and the time left."""
    stable, failed = progress.bracket.stable, progress.bracket.failed
    if stable is not None and failed is not None:
        where = f"between {stable:.4f} and {failed:.4f}"
    elif stable is not None:
        where = f"above {stable:.4f}"
    else:
        where = "not bracketed" if failed is None else f"below {failed:.4f}"
    count = progress.trials
    if count == 0:
        return "the first trial"
    trials = "1 trial" if count == 1 else f"{count} trials"
    left = time_left(seconds_left, seconds_most)
    return f"{where} after {trials}, {left}" if left else f"{where} after {trials}"


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
