"""What a case of breaking ground found, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

NAMES = {"gravity-increase": "Gravity factor", "strength-reduction": "Strength factor of the bonded ground"}
LIMITS = (
    "The ground is bonded particles in true motion with local damping; it fails by breaking. Every trial goes on from "
    "the highest state that stands, its load or strength changed gradually."
)


def answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Lines that a run ends with: what stands out, and what comes after it."""
    lines = [(factor_words(factor), _bracket(factor)) for factor in result["factors"]]
    if not lines:
        lines.append((f"{len(result['stages'])} stages done.", ""))
    lines.append((cracks_words(result), fragments_words(result)))
    return lines


def factor_words(factor: Mapping[str, Any]) -> str:
    """The factor, or what is known of it."""
    name = NAMES[factor["kind"]]
    if factor["value"] is not None:
        return f"{name} {factor['value']:.3g}"
    if factor["stable"] is not None:
        return f"{name} above {factor['stable']:.3g}"
    if factor["failed"] is not None:
        return f"{name} below {factor['failed']:.3g}"
    return f"{name} unknown"


def _bracket(factor: Mapping[str, Any]) -> str:
    ends = [
        f"{word} {factor[key]:.4g}"
        for key, word in (("stable", "stands at"), ("failed", "failed at"))
        if factor[key] is not None
    ]
    return f"({'; '.join(ends) or 'nothing decided'}). {meaning(factor)}"


def meaning(factor: Mapping[str, Any]) -> str:
    """What the factor is."""
    return f"{factor['meaning'][0].upper()}{factor['meaning'][1:]}."


def cracks_words(result: Mapping[str, Any]) -> str:
    """Cracks by mode."""
    cracks = result["cracks"]
    return f"{cracks['tension'] + cracks['shear']:,} cracks:"


def fragments_words(result: Mapping[str, Any]) -> str:
    """Modes and pieces."""
    cracks, pieces = result["cracks"], result["fragments"]
    return (
        f"{cracks['tension']:,} in tension, {cracks['shear']:,} in shear. {pieces['pieces']:,} "
        f"piece{'s' if pieces['pieces'] != 1 else ''} of more than one particle at the end, the largest with "
        f"{100.0 * pieces['largest_share_of_mass']:.3g} % of the mass; {pieces['single_particles']:,} loose particles."
    )


def failure_words(factor: Mapping[str, Any]) -> str:
    """Where the lowest failed trial began to break."""
    failure = factor["failure"]
    if not failure.get("new_cracks"):
        return "It failed without a new crack." if factor["failed"] is not None else ""
    where = " and ".join(dict.fromkeys(failure["first_in"]))
    centre = ", ".join(f"{x:.4g}" for x in failure["first_centre_m"])
    return (
        f"In the lowest failed trial {failure['new_cracks']:,} bonds broke; the first tenth of them mostly in {where} "
        f"({100.0 * failure['first_share']:.0f} %), around ({centre}) m."
    )


def trial_rows(factor: Mapping[str, Any]) -> tuple[Sequence[str], list[list[str]]]:
    """Header and rows of the trials of a factor."""
    header = ("factor [-]", "verdict", "why", "steps", "unbalanced [-]", "moved [m]")
    rows = [
        [
            f"{trial['factor']:.4g}", trial["verdict"], trial["criterion"], f"{trial['steps']:,}",
            f"{trial['unbalanced']:.1e}", f"{trial['displacement']:.3g}",
        ]
        for trial in factor["trials"]
    ]  # fmt: skip
    return header, rows
