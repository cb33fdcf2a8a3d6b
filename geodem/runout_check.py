"""What `geodem check` tells of a case of run-out: its slope, and what its flow will cost."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from .case.runout import RunoutCase
from .check_printing import expected_time, show_rounded
from .slope_check import check_slope

if TYPE_CHECKING:
    from rich.console import Console

FLOW_SECONDS = 8e-6
"""Of a flow over the number of discs to the power of 2.0: their number by steps that grow with its root, and looks."""


def check_runout(case: RunoutCase, picture: Path, console: Console) -> dict[str, Any]:
    """Build the slope, draw it, and estimate the cost of its failure and of the flow.

    Raises
    ------
    InputError
    """
    found = check_slope(case.slope, picture, console)
    own = case.runout
    seconds = FLOW_SECONDS * own.discs**2.0
    what = "the mass that fails" if own.mass == "failing" else "all that the supports do not hold"
    console.print(
        f"Flow: {what} as about {own.discs:,} discs; {expected_time(seconds)}, compiling not counted"
    )
    if own.beyond is not None:
        console.print(f"Level ground beyond the section: {show_rounded(own.beyond, 'length')}")
    return {**found, "expected_s": {**found["expected_s"], "flow": seconds}}
