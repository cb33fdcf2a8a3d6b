"""Words on a scene: bonds, sides, joints, bolts, linings, initial stress, as pairs of name and value."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

SIDES = {
    "wall": "smooth wall", "rough": "rough wall", "roller": "rollers", "fixed": "fixed", "free": "free",
}  # fmt: skip


def scene_rows(facts: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Of `geodem.breaking.facts.scene_facts`."""
    rows = [("laws", f"{facts['bond_law'] or 'no bonds'}, contacts {facts['contact_law']}")]
    for entry in facts["bonds"]:
        one, other = entry["between"]
        where = f"within {one}" if one == other else f"between {one} and {other}"
        rows.append((f"bonds {where}", f"{entry['bonds']:,} ({entry['touching']:,} pairs touch)"))
    if facts["without_bond"]:
        rows.append(("particles without a bond", f"{facts['without_bond']:,}"))
    rows.append(("sides", ", ".join(map(_side, facts["supports"])) or "free"))
    rows.append(("gravity", f"({', '.join(f'{each:g}' for each in facts['gravity_m_s2'])}) m/s2"))
    for entry in facts["joints"]:
        size = f"{entry['size_m']:.4g} m" if "size_m" in entry else f"{entry['size_m2']:.4g} m2"
        number = "" if entry["joints"] == 1 else f"{entry['joints']:,} joints, "
        held = f", {entry['bonded']:,} of them bonded" if entry["bonded"] else ""
        rows.append((f"joint {entry['name']}", f"{number}{size}, crosses {entry['pairs']:,} pairs{held}"))
    for entry in facts["bolts"]:
        plate = ", with a plate" if entry["plate"] else ""
        rows.append(
            (
                f"bolt {entry['name']}",
                f"{entry['length_m']:.4g} m in {entry['pieces']} pieces, grouted to {entry['grouted_to']} "
                f"particles{plate}",
            )
        )
    for entry in facts["linings"]:
        rows.append(
            (f"lining {entry['name']}", f"{entry['length_m']:.4g} m, {entry['thickness_m']:.3g} m thick")
        )
    stress = facts["initial_stress"]
    if stress is not None:
        top, bottom = stress["pressure_at_top_Pa"], stress["pressure_at_bottom_Pa"]
        same = top == bottom
        rows.append(("initial stress", _tensor(bottom) + ("" if same else f" at {stress['bottom_m']:g} m, "
                     f"{_tensor(top)} at {stress['top_m']:g} m")))  # fmt: skip
    return rows


def _side(entry: Mapping[str, Any]) -> str:
    held = f" ({entry['held']:,} particles)" if entry["held"] else ""
    return f"{entry['side']} {SIDES[entry['support']]}{held}"


def _tensor(values: list[list[float]]) -> str:
    """Pressures in MPa by axis; shear stresses where there are any."""
    axes = "xyz"[: len(values)]
    words = [f"{axes[k]} {_mega(values[k][k])} MPa" for k in range(len(values))]
    words += [
        f"{axes[i]}{axes[j]} {_mega(values[i][j])} MPa"
        for i in range(len(values))
        for j in range(i + 1, len(values))
        if values[i][j] != 0.0
    ]
    return ", ".join(words)


def _mega(value: float) -> str:
    # no sign before nothing
    return f"{value / 1e6 + 0.0:.4g}"
