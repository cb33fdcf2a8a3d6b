"""What is told of a run-out, in the report and on the terminal alike."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

SIGN = (
    "The failure is quasi-static: its steps are no times. The flow is true motion: its times, speeds and distances "
    "are real for dry ground with the residual friction given."
)


def headline(result: Mapping[str, Any]) -> str:
    """Run-out and angle of reach."""
    found = result["deposit"]
    return f"Run-out {found['run_out_m']:.3g} m, angle of reach {found['angle_of_reach_deg']:.1f} deg"


def deposit_rows(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Shape of the deposit."""
    found, flow = result["deposit"], result["flow"]
    x, y = found["centre_m"]
    return [
        ("run-out, from the toe before to the front", f"{found['run_out_m']:.4g} m"),
        ("fall height, from the crest before to the ground at the front", f"{found['fall_height_m']:.4g} m"),
        ("horizontal distance of these two", f"{found['reach_m']:.4g} m"),
        ("angle of reach", f"{found['angle_of_reach_deg']:.2f} deg"),
        ("angle that the centre of gravity travelled at", f"{found['travel_angle_deg']:.2f} deg"),
        ("centre of gravity at rest", f"({x:.5g}, {y:.5g}) m"),
        ("greatest height of the deposit", f"{found['height_m']:.4g} m"),
        ("share that did not move by half a disc", f"{100.0 * found['left_behind']:.1f} %"),
        ("share that lies loose", f"{100.0 * found['loose']:.1f} %"),
        ("largest speed of a disc", f"{flow['largest_speed_m_s']:.3g} m/s"),
        ("at rest after" if flow["at_rest"] else "not at rest after", f"{flow['time_s']:.3g} s"),
    ]


def moved_rows(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What was handed over."""
    moved, hand = result["moved"], result["hand_over"]
    what = "the mass that slides" if moved["what"] == "failing" else "all that the supports do not hold"
    start = "at rest" if moved["start"] == "rest" else "with what the search took out as damping"
    factor = result["factors"][0]["value"]
    return [
        ("factor of safety of the slope", "none" if factor is None else f"{factor:.4g}"),
        ("handed over", f"{what}, {start}"),
        ("area", f"{moved['area_m2']:.4g} m2"),
        ("mass", f"{moved['mass_kg_m']:.4g} kg per m"),
        ("height", f"{moved['height_m']:.4g} m"),
        (
            "discs",
            f"{result['discs']:,} of {hand['mean_diameter_m']:.3g} m in the mean, {result['held_discs']:,} held",
        ),
        ("settlement of the discs while they came to rest", f"{1e3 * hand['settlement_m']:.3g} mm"),
        (
            "all discs were then moved to the centre of gravity of the ground, by",
            f"({', '.join(f'{1e3 * part:.3g}' for part in hand['shift_m'])}) mm",
        ),
    ]


def conserved_rows(result: Mapping[str, Any]) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Header and rows of what is kept in the hand-over."""
    header = ("", "before", "after", "unit", "difference")
    rows: list[tuple[str, ...]] = [
        (row["name"], f"{row['before']:.10g}", f"{row['after']:.10g}", row["unit"], f"{row['error']:.2g}")
        for row in result["hand_over"]["conserved"]
    ]
    return header, rows


def answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Lines at the end of a run."""
    moved, flow, hand = result["moved"], result["flow"], result["hand_over"]
    end = "at rest" if flow["at_rest"] else "not yet at rest"
    return [
        (headline(result), ""),
        ("", f"  {moved['mass_kg_m']:.3g} kg per m of ground, {end} after {flow['time_s']:.3g} s"),
        ("", f"  centre of gravity from the failure: {result['deposit']['travel_angle_deg']:.1f} deg"),
        ("", f"  energy jump of the hand-over {100.0 * hand['energy_jump']:.2g} %"),
    ]
