"""DICE2D's slope and frame (Zhao 2015, sections 4.3.3 and 4.3.4): the workflows as they are, measured against its text.

The drawings are lost; what the sections are read from and what is assumed stands in workflows/rock_slope and
workflows/frame_on_rock. The text gives what stands and what fails at whole multiples of gravity: a factor between two
of them is held to the half between. For the slope, whose weak layer and rock bridge are lost with the drawing, a
quarter of the text's "approximately 4".
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from geodem.breaking_run import run_breaking
from geodem.case import load_any
from geodem.case.breaking import BreakingCase

from .rows import Row, at_most, relative

HOME = Path(__file__).resolve().parents[2]
ROOT = HOME / "workflows"
RUNS = HOME / "runs" / "reference"
"""Where the runs lie, with their reports."""
SLOPE = "text: steady below 4 g, approximately 4; drawing lost"
FRAME = "text: stable at 3 g, structure and base break at 4 g"
CAVERN = "text: stable at 1 g, collapses at 2 g"
BOLTED = "text: stands at 8 g"
MECHANICS = "friction grows with gravity, so that gravity may grow more than strength may fall"
GIVEN = "asked for in the case"
WEAK = "text: the weak layer fails first"
FIRST = "text: the cavern fails first"
CAVERN_MIDDLE, CAVERN_SPAN = (322.5, 235.0), 100.0
"""[m], workflows/frame_on_rock/draw.py."""


def carried_out(case: BreakingCase, name: str) -> tuple[dict[str, Any], float]:
    """Result of a case, and seconds it took; a run of the same version that is there is gone on with."""
    result = run_breaking(case, RUNS / name)
    return result, float(result["wall_time_s"])


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


def weak_share(found: dict[str, Any]) -> float:
    """Of the cracks in the last state that stands, those with a particle of the weak layer [-]."""
    pairs = found["cracks_when_stable"]
    count = [row["tension"] + row["shear"] for row in pairs]
    weak = [n for n, row in zip(count, pairs, strict=True) if "weak" in row["materials"]]
    return sum(weak) / max(1, sum(count))


def slope() -> list[Row]:
    """The slope without bolts, with one particle a pixel and with particles at random; with bolts."""
    case = workflow("rock_slope")
    result, seconds = carried_out(case, "rock_slope")
    gravity, strength = factor(result, "gravity-increase"), factor(result, "strength-reduction")
    share, ratio = weak_share(gravity), strength["value"] / gravity["value"]
    last = next(t for t in gravity["trials"] if t["factor"] == gravity["stable"])
    few = replace(case.scene.particles, arrangement="random", particles=result["particles"], radius=None)
    alone = tuple(one for one in case.stages if one.kind != "strength-reduction")
    other, more = carried_out(
        replace(case, stages=alone, scene=replace(case.scene, particles=few)), "rock_slope_random"
    )
    at_random = factor(other, "gravity-increase")["value"]
    return [
        relative("slope", "gravity factor [-]", gravity["value"], 4.0, 0.25, seconds, SLOPE),
        width("slope", gravity, 0.0),
        width("slope", strength, 0.0),
        at_most("slope", "strength factor over gravity factor [-]", ratio, 1.0, 0.0, MECHANICS),
        Row(
            "slope", "share of cracks in the weak layer, stable [-]", share, 1.0, share - 1.0, 0.1, 0.0, WEAK
        ),
        at_most("slope", "unbalanced force, stable [-]", last["unbalanced"], 2e-3, 0.0, "settlement steady"),
        relative("slope, random", "gravity factor [-]", at_random, 4.0, 0.25, more, SLOPE),
        *bolted(),
    ]


def bolted() -> list[Row]:
    """The slope with bolts."""
    result, seconds = carried_out(workflow("bolted_slope"), "bolted_slope")
    found = factor(result, "gravity-increase")
    less = min(0.0, found["stable"] / 8.0 - 1.0)
    return [
        Row("bolted slope", "stands at gravity times [-]", found["stable"], 8.0, less, 1e-9, seconds, BOLTED),
        width("bolted slope", found, 0.0),
    ]


def cavern() -> list[Row]:
    """The frame without and with a cavern below it."""
    plain, seconds = carried_out(workflow("frame_on_rock"), "frame_on_rock")
    hollow, more = carried_out(workflow("frame_over_cavern"), "frame_over_cavern")
    first, second = factor(plain, "gravity-increase"), factor(hollow, "gravity-increase")
    away = float(np.linalg.norm(np.array(second["failure"]["first_centre_m"]) - np.array(CAVERN_MIDDLE)))
    ratio, near = second["value"] / first["value"], away / CAVERN_SPAN
    return [
        relative("frame", "gravity factor [-]", first["value"], 3.5, 0.5 / 3.5, seconds, FRAME),
        width("frame", first, 0.0),
        relative("frame over cavern", "gravity factor [-]", second["value"], 1.5, 0.5 / 1.5, more, CAVERN),
        width("frame over cavern", second, 0.0),
        at_most("frame over cavern", "factor over that of the frame [-]", ratio, 1.0, 0.0, "text: lower"),
        at_most("frame over cavern", "first cracks from its middle over span [-]", near, 1.0, 0.0, FIRST),
    ]
