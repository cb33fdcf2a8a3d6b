"""Results of the laboratory and of a calibration in the words of the commands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from geodem.laboratory.orders import TestOrder
from geodem.laboratory.workers import Overview
from geodem.run_progress import duration
from geodem.units import show


def quantity_of(key: str) -> str:
    """Kind of quantity of `geodem.units` from the unit at the end of a name in result.json."""
    ends = {"_Pa": "stress", "_rad": "angle", "_kg_per_m3": "density"}
    return next((kind for end, kind in ends.items() if key.endswith(end)), "dimensionless")


def rounded(value: float, quantity: str, digits: int = 3) -> str:
    """A value with its unit, to so many significant digits."""
    if quantity == "angle":
        return f"{float(f'{math.degrees(value):.{digits}g}'):g} deg"
    return show(float(f"{value:.{digits}g}"), quantity)


def spread(value: float, deviation: float | None, quantity: str) -> str:
    """A mean and, behind it, the standard deviation in the same unit, where there is one."""
    shown = rounded(value, quantity)
    if deviation is None or not math.isfinite(deviation):
        return shown
    return f"{shown} ± {deviation_shown(value, deviation, quantity)}"


def deviation_shown(value: float, deviation: float, quantity: str) -> str:
    """A standard deviation in the unit that its mean is shown in, to two significant digits."""
    if quantity != "stress":
        return rounded(deviation, quantity, 2)
    unit = rounded(value, quantity).rpartition(" ")[2]
    size = {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9}[unit]
    return f"{float(f'{deviation / size:.2g}'):g} {unit}"


def property_lines(properties: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """A line for each property of a laboratory's result.json: mean, scatter, specimens."""
    lines = []
    for key, entry in properties.items():
        quantity = quantity_of(key)
        deviation, count = entry["standard_deviation"], entry["specimens"]
        specimens = "1 specimen" if count == 1 else f"{count} specimens"
        name = entry["name"][0].upper() + entry["name"][1:]
        lines.append(f"{name} {spread(entry['mean'], deviation, quantity)} ({specimens})")
    return lines


def named(order: TestOrder) -> str:
    """A test in words."""
    at = f" at {show(order.stress, 'stress')}" if order.stress else ""
    return f"{order.kind}{at}, specimen {order.seed}"


def overview_lines(overview: Overview) -> tuple[str, list[str]]:
    """How far the tests are, and what is carried out now."""
    head = f"{overview.finished} of {overview.total} tests finished"
    lines = []
    for order, now in overview.running:
        if not math.isnan(now.compiling):
            where = f"compiling, about {duration(now.compiling)}"
        elif math.isnan(now.strain):
            where = "beginning"
        else:
            where = f"strain {100.0 * now.strain:.3f} %, {rounded(now.stress, 'stress')}"
        lines.append(f"{named(order)}: {where}")
    return head, lines


def calibration_lines(result: Mapping[str, Any]) -> list[str]:
    """A line for each property: what was wanted, what was come to, its interval."""
    lines = []
    for name, entry in result["properties"].items():
        quantity = {"Pa": "stress", "rad": "angle"}.get(entry["unit"], "dimensionless")
        low, high = (rounded(entry[end], quantity) for end in ("low", "high"))
        lines.append(
            f"{name.replace('_', ' ')} {rounded(entry['achieved'], quantity)} ({low} to {high}), "
            f"wanted {rounded(entry['target'], quantity)}"
        )
    return lines


def laboratory_answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Properties of a laboratory's result.json, in bold."""
    return [(line, "") for line in property_lines(result["properties"])]


def calibration_answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Properties that a calibration came to, in bold."""
    return [(line, "") for line in calibration_lines(result)]
