"""What is told of a body and its particles, in the report and on the terminal alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from geodem.plotting.wording import seconds
from geodem.units import show

SIGN = "Nothing has moved yet: these are the particles that a run would begin with."


def material_rows(result: Mapping[str, Any]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Header and rows of the table of materials."""
    flat = result["dimension"] == 2
    size = "m2" if flat else "m3"
    mass = "kg/m" if flat else "kg"
    header = (
        "material", "particles", f"source [{size}]", f"represented [{size}]", "difference [%]",
        "density [kg/m3]", f"mass [{mass}]", "mass difference [%]",
    )  # fmt: skip
    rows: list[tuple[str, ...]] = [
        (
            row["name"], f"{row['particles']:,}", f"{row['source_size']:.5g}", f"{row['represented_size']:.5g}",
            signed(row["difference_percent"]), f"{row['density_kg_m3']:.5g}", f"{row['mass']:.5g}",
            signed(row["mass_difference_percent"]),
        )
        for row in result["materials"]
    ]  # fmt: skip
    return header, rows


def signed(percent: float) -> str:
    """A difference [%] with three digits after the point."""
    # what rounds to nothing has no sign
    return f"{percent:+.3f}" if abs(percent) >= 5e-4 else "0.000"


def contact_rows(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """How particles touch."""
    found = result["contacts"]
    share = f"{100.0 * (found['reach'] - 1.0):.0f} %"
    return [
        (f"neighbours of a particle, gaps up to {share} of the radii", f"{found['coordination']:.2f} in the mean"),
        ("particles without neighbours", f"{found['loose']:,}"),
        ("largest overlap, of the smaller radius", _overlap(found["largest_overlap"])),
        ("share of the room that particles fill", f"{result['solid_fraction']:.4f}"),
        ("radii", f"{rounded(result['smallest_radius_m'])} to {rounded(result['largest_radius_m'])}"),
        *([("grains or blocks told apart", f"{result['grains']:,}")] if result["grains"] else []),
    ]  # fmt: skip


def _overlap(share: float) -> str:
    # of a lattice only rounding is left
    return "none" if share < 1e-9 else f"{100.0 * share:.2g} %"


def cost_rows(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What a run of them takes."""
    found = result["cost"]
    rows = [("memory of a run", f"about {found['memory_bytes'] / 1e6:,.0f} MB")]
    if found["why"]:
        return [*rows, ("time step", f"not known: {found['why']}")]
    return [
        *rows,
        ("bonds", f"{found['bonds']:,}"),
        ("critical time step", f"{found['critical_time_step_s']:.3g} s; half of it is usual"),
        ("1000 steps", f"about {seconds(found['seconds_per_1000_steps'])} of run time"),
    ]


def size_line(result: Mapping[str, Any]) -> str:
    """Where the body lies."""
    low, high = result["bounds_m"]
    return ", ".join(
        f"{axis} from {a:.5g} to {b:.5g} m" for axis, a, b in zip("xyz", low, high, strict=False)
    )


def headline(result: Mapping[str, Any]) -> str:
    """How many particles of what."""
    kind = "discs" if result["dimension"] == 2 else "spheres"
    number = len(result["materials"])
    return f"{result['particles']:,} {kind} of {'1 material' if number == 1 else f'{number} materials'}"


def rounded(value: float) -> str:
    """A length with three digits."""
    return show(float(f"{value:.3g}"), "length")


def answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What particles there are, in bold, and what they are of every material."""
    lines = [(headline(result), "")]
    for row in result["materials"]:
        size, mass = signed(row["difference_percent"]), signed(row["mass_difference_percent"])
        told = f"{row['particles']:,}, differ from the source by {size} % in size and {mass} % in mass"
        lines.append(("", f"  {row['name']}: {told}"))
    return lines
