"""What is told of a cut, in the report and on the terminal alike."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from geodem.units import show

LOOSE = "The ground has no bonds: nothing breaks off."
RATIO = (
    "On the face the ground pushes at the friction angle to its normal where it slides up, so that normal over cutting "
    "force is tan(friction angle - rake)."
)


def line_load(value: float) -> str:
    """A force per metre of width with three digits."""
    if not math.isfinite(value):
        return "none"
    size = abs(value)
    unit, per = ("N/m", 1.0) if size < 1e3 else ("kN/m", 1e-3) if size < 1e6 else ("MN/m", 1e-6)
    return f"{value * per:.3g} {unit}"


def stress(value: float) -> str:
    """A specific energy with three digits."""
    return show(float(f"{value:.3g}"), "stress") if math.isfinite(value) else "none"


def length(value: float) -> str:
    """A length with three digits."""
    return show(float(f"{value:.3g}"), "length") if math.isfinite(value) else "none"


def degrees(value: float | None) -> str:
    """An angle with one digit after the point."""
    return "none" if value is None else f"{math.degrees(value):.1f} deg"


def headline(result: Mapping[str, Any]) -> str:
    """The force at which chips break, the mean one and what it took to cut; ground without bonds has no chips."""
    cutting = result["forces"]["cutting_N_per_m"]
    peaks = f"Chips break at {line_load(cutting['mean_of_peaks'])}, mean c" if result["bonds"] else "C"
    energy = stress(result["specific_energy_Pa"])
    return f"{peaks}utting force {line_load(cutting['mean'])}, specific energy {energy}"


def force_rows(result: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Rows of the table of forces: name, mean of peaks, peak, mean, scatter."""
    rows = []
    for key, name in (("cutting_N_per_m", "cutting force"), ("normal_N_per_m", "normal force")):
        f = result["forces"][key]
        values = (f["mean_of_peaks"], f["peak"], f["mean"], f["standard_deviation"])
        rows.append((name, *(line_load(value) for value in values)))
    return rows


def part_rows(result: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Rows of the table of parts of the tool: name, cutting, normal; those that felt nothing are left out."""
    return [
        (name, line_load(part["cutting"]), line_load(part["normal"]))
        for name, part in result["forces"]["parts_N_per_m"].items()
        if part["cutting"] or part["normal"]
    ]


def face_line(result: Mapping[str, Any]) -> str:
    """The direction of the force on the face beside what friction makes it."""
    f = result["forces"]
    if f["face_angle_rad"] is None:
        return "The face felt hardly any force after entry."
    share = f["sliding_share_of_face"]
    sliding = ""
    if f["sliding_face_angle_rad"] is not None:
        sliding = (
            f" {100.0 * share:.0f} % of the pressure on the face slides up it, inclined by "
            f"{degrees(f['sliding_face_angle_rad'])}; the rest sticks."
        )
    return (
        f"The force on the face is inclined by {degrees(f['face_angle_rad'])} to the path; the friction angle less the "
        f"rake is {degrees(f['expected_face_angle_rad'])}.{sliding}"
    )


def chip_rows(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What was cut off."""
    c = result["chips"]
    if not result["bonds"]:
        return [("chips", LOOSE)]
    rows = [
        ("chips", f"{c['chips']:,}"),
        (
            "single grains",
            f"{c['single_grains']:,} ({100.0 * c['share_of_single_grains']:.0f} % of the mass cut)",
        ),
        ("volume cut over depth times way", f"{c['volume_over_nominal']:.2f}"),
    ]
    if "largest_m" in c:
        wide, high = c["largest_box_m"]
        rows += [
            ("largest chip", f"{length(c['largest_m'])}; its box {length(wide)} by {length(high)}"),
            ("half of the chips' mass is smaller than", length(c["d50_m"])),
        ]
    return rows


def crack_rows(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Cracks and where they ran."""
    c = result["cracks"]
    if not result["bonds"]:
        return []
    return [
        ("cracks", f"{c['tension']:,} in tension, {c['shear']:,} in shear"),
        ("more than a grain ahead of the tip", f"{c['ahead']:,}, up to {length(c['ahead_m'])}"),
        ("below the path of the tip", f"{c['below']:,}, down to {length(c['below_m'])}"),
    ]


def energy_rows(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The account at the end."""
    e = result["energy"]
    rows = [
        (name.removesuffix("_J_per_m"), f"{value:.4g} J/m")
        for name, value in e.items()
        if name.endswith("_J_per_m")
    ]
    return [*rows, ("imbalance", f"{100.0 * e['imbalance']:.3f} %")]


def tool_rows(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The tool and its way."""
    t = result["tool"]
    return [
        ("rake, clearance", f"{degrees(t['rake_rad'])}, {degrees(t['clearance_rad'])}"),
        ("friction angle", degrees(t["friction_angle_rad"])),
        ("wear flat, tip radius", f"{length(t['wear_flat_m'])}, {length(t['tip_radius_m'])}"),
        ("depth", f"{length(t['depth_m'])} ({t['depth_over_diameter']:.1f} mean diameters)"),
        ("speed", f"{t['speed_m_per_s']:.4g} m/s, reached on {length(t['ramp_m'])}"),
        ("way", f"{length(t['way_m'])}; means after {length(result['forces']['after_m'])}"),
    ]


def answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What a run ends with."""
    c = result["chips"]
    chips = LOOSE
    if result["bonds"]:
        chips = f"{c['chips']:,} chips and {c['single_grains']:,} single grains; {crack_rows(result)[0][1]}."
    return [
        (headline(result), ", forces per metre of width."),
        ("", face_line(result)),
        ("", chips),
    ]
