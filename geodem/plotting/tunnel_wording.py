"""What is told of a tunnel, in the report and on the terminal alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geodem.plotting import wording
from geodem.units import show

NAMES = {
    "strength-reduction": "Factor of safety", "load-increase": "Load factor", "gravity-increase": "Gravity factor",
}  # fmt: skip


def length(value: float) -> str:
    """A length with four digits."""
    return show(float(f"{value:.4g}"), "length")


def stress(value: float) -> str:
    """A stress with four digits."""
    return show(float(f"{value:.4g}"), "stress")


def answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What an engineer asks first: convergence, yielded ground, supports, factors."""
    lines: list[tuple[str, str]] = []
    collapse = result.get("collapse")
    if collapse:
        lines.append(
            (
                f"{collapse['excavation']} does not stand without support",
                f": no rest beyond {100.0 * collapse['relaxed_stable']:.3g} to "
                f"{100.0 * collapse['relaxed_failed']:.3g} % of relaxation, a pressure of "
                f"{stress(collapse['pressure_failed_Pa'])} to {stress(collapse['pressure_stable_Pa'])} on the wall.",
            )
        )
    for name, row in (result.get("excavations") or {}).items():
        lines.append(
            (
                f"{name}: mean convergence {length(row['mean_convergence_m'])}",
                f" (crown {length(row['crown_m'])} down, invert {length(row['invert_m'])} up, width "
                f"{length(row['horizontal_m'])} less; {100.0 * row['relaxed']:.4g} % relaxed). {yielded(row)}",
            )
        )
        if row["settlement_m"] > 0.0:
            lines.append(("", f"  The surface settles by {length(row['settlement_m'])}."))
    for row in result.get("linings") or ():
        used = row["compressive_utilisation"]
        more = "" if used is None else f", {100.0 * used:.3g} % of its compressive strength"
        lines.append(
            (
                f"Lining {row['name']}: thrust {force(row['largest_thrust_N_per_m'])}",
                f", moment {row['largest_moment_Nm_per_m'] / 1e3:.4g} kN m per m, largest compression "
                f"{stress(row['largest_compression_Pa'])}{more}.",
            )
        )
    for row in result.get("bolts") or ():
        largest = show(float(f"{row['largest_force_N']:.4g}"), "force")
        lines.append(
            (
                f"{row['name']}: largest force {largest}",
                f", {100.0 * row['utilisation']:.3g} % of yield; {row['yielded_pieces']} of {row['pieces']} pieces "
                "yielded.",
            )
        )
    for entry in result.get("factors") or ():
        lines.append(factor_line(entry))
    return lines


def yielded(row: Mapping[str, Any]) -> str:
    """The yielded ground of an opening in words."""
    if row["yielded_area_m2"] <= 0.0:
        return "No ground has yielded."
    return f"Yielded ground {row['yielded_area_m2']:.4g} m2, as a ring of {row['plastic_radius_ratio']:.4g} radii."


def force(value: float) -> str:
    """A force per metre."""
    return show(float(f"{value:.4g}"), "line_load")


def factor_line(entry: Mapping[str, Any]) -> tuple[str, str]:
    """One factor, with what kind it is."""
    name = NAMES[entry["kind"]]
    tail = "" if entry["kind"] == "strength-reduction" else " A load multiplier, not a factor of safety."
    if entry["value"] is None:
        side = (
            f"above {entry['stable']:g}: nothing failed up to there"
            if entry["failed"] is None and entry["stable"] is not None
            else f"below {entry['failed']:g}"
            if entry["failed"] is not None
            else "not found"
        )
        return f"{name} {side}", f" ({entry['kind'].replace('-', ' ')}).{tail}"
    value = wording.factor(entry["value"], entry["stable"], entry["failed"])
    ends = f"stable at {entry['stable']:.4g}, failed at {entry['failed']:.4g}"
    return f"{name} {value}", f" ({entry['kind'].replace('-', ' ')}; {ends}).{tail}"
