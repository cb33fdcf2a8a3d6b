"""DICE2D's slope and frame (Zhao 2015, sections 4.3.3 and 4.3.4): the workflows as they are, measured against its text.

The drawings are lost; what the sections are read from and what is assumed stands in workflows/rock_slope and
workflows/frame_on_rock. The text gives what stands and what fails at whole multiples of gravity: a factor between two
of them is held to the half between. For the slope, whose weak layer and rock bridge are lost with the drawing, a
quarter of the text's "approximately 4".
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from geodem.breaking_run import run_breaking
from geodem.case import load_any
from geodem.case.breaking import BreakingCase

from .rows import Row, at_most, relative

ROOT = Path(__file__).resolve().parents[2] / "workflows"
SLOPE = "text: steady below 4 g, approximately 4; drawing lost"
FRAME = "text: stable at 3 g, structure and base break at 4 g"
CAVERN = "text: stable at 1 g, collapses at 2 g"
BOLTED = "text: stands at 8 g"
MECHANICS = "friction grows with gravity, so that gravity may grow more than strength may fall"
GIVEN = "asked for in the case"
CAVERN_MIDDLE, CAVERN_SPAN = (322.5, 235.0), 100.0
"""[m], workflows/frame_on_rock/draw.py."""


def carried_out(case: BreakingCase) -> tuple[dict[str, Any], float]:
    """Result of a case, and seconds it took."""
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        result = run_breaking(case, Path(folder) / "out")
    return result, time.perf_counter() - begun


def workflow(name: str) -> BreakingCase:
    """A case of workflows/."""
    case = load_any(ROOT / name)
    assert isinstance(case, BreakingCase)
    return case


def factor(result: dict[str, Any], kind: str) -> dict[str, Any]:
    """The factor of that kind."""
    found: dict[str, Any] = next(each for each in result["factors"] if each["kind"] == kind)
    return found


def width(name: str, found: dict[str, Any], seconds: float) -> Row:
    """How wide a bracket is."""
    wide = (found["failed"] - found["stable"]) / found["value"]
    return at_most(name, f"{found['kind']}, width of the bracket [-]", wide, 0.05, seconds, GIVEN)


def weak_share(result: dict[str, Any]) -> float:
    """Of the cracks at the end, those with a particle of the weak layer [-]."""
    pairs = result["cracks"]["by_materials"]
    count = [row["tension"] + row["shear"] for row in pairs]
    weak = [n for n, row in zip(count, pairs, strict=True) if "weak" in row["materials"]]
    return sum(weak) / max(1, sum(count))


def slope() -> list[Row]:
    """The slope without bolts, with one particle a pixel and with particles at random; with bolts."""
    case = workflow("rock_slope")
    stands = replace(
        case, stages=tuple(
            replace(one, values={**one.values, "goes_on": "stable"}) if one.kind == "gravity-increase" else one
            for one in case.stages if one.kind != "strength-reduction"
        ),
    )  # fmt: skip
    result, seconds = carried_out(case)
    gravity, strength = factor(result, "gravity-increase"), factor(result, "strength-reduction")
    before, more = carried_out(stands)
    rows = [
        relative("slope", "gravity factor [-]", gravity["value"], 4.0, 0.25, seconds, SLOPE),
        width("slope", gravity, 0.0),
        width("slope", strength, 0.0),
        at_most(
            "slope", "strength factor over gravity factor [-]",
            strength["value"] / gravity["value"], 1.0, 0.0, MECHANICS
        ),
        Row(
            "slope", "share of the cracks that lie in the weak layer, last state that stands [-]", weak_share(before),
            1.0, weak_share(before) - 1.0, 0.1, more, "text: the weak layer fails first",
        ),
        _steady(before),
    ]  # fmt: skip
    at_random = replace(
        case.scene.particles, arrangement="random", particles=result["particles"], radius=None
    )
    other, seconds = carried_out(replace(stands, scene=replace(case.scene, particles=at_random)))
    rows.append(
        relative(
            "slope, random",
            "gravity factor [-]",
            factor(other, "gravity-increase")["value"],
            4.0,
            0.25,
            seconds,
            SLOPE,
        )
    )
    bolted, seconds = carried_out(workflow("bolted_slope"))
    found = factor(bolted, "gravity-increase")
    rows += [
        Row(
            "bolted slope", "highest gravity at which it stands [-]", found["stable"], 8.0,
            min(0.0, found["stable"] / 8.0 - 1.0), 1e-9, seconds, BOLTED,
        ),
        width("bolted slope", found, 0.0),
    ]  # fmt: skip
    return rows


def _steady(result: dict[str, Any]) -> Row:
    """How far the measured point still went in the last quarter of the highest trial that stands, over a diameter."""
    found = factor(result, "gravity-increase")
    trial = next(t for t in found["trials"] if t["factor"] == found["stable"])
    return at_most(
        "slope", "unbalanced force in the last state that stands [-]", trial["unbalanced"], 2e-3, 0.0,
        "at rest: settlement steady",
    )  # fmt: skip


def cavern() -> list[Row]:
    """The frame without and with a cavern below it."""
    plain, seconds = carried_out(workflow("frame_on_rock"))
    hollow, more = carried_out(workflow("frame_over_cavern"))
    first, second = factor(plain, "gravity-increase"), factor(hollow, "gravity-increase")
    away = float(np.linalg.norm(np.array(second["failure"]["first_centre_m"]) - np.array(CAVERN_MIDDLE)))
    return [
        relative("frame", "gravity factor [-]", first["value"], 3.5, 0.5 / 3.5, seconds, FRAME),
        width("frame", first, 0.0),
        relative("frame over cavern", "gravity factor [-]", second["value"], 1.5, 0.5 / 1.5, more, CAVERN),
        width("frame over cavern", second, 0.0),
        at_most(
            "frame over cavern", "gravity factor over that without cavern [-]",
            second["value"] / first["value"], 1.0, 0.0,
            "text: the cavern lowers it",
        ),
        at_most(
            "frame over cavern", "first cracks of the failure from its middle, over its span [-]",
            away / CAVERN_SPAN, 1.0,
            0.0, "text: the cavern fails first",
        ),
    ]  # fmt: skip
