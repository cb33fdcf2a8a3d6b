"""What `geodem check` tells of a case of cutting: ground, tool, steps and expected time."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .case.cutting import CuttingCase
from .check_printing import escaped, expected_time, print_notices, show_rounded

if TYPE_CHECKING:
    from rich.console import Console

PROBE_STEPS = 50
BATCHES = 4


def check_cutting(case: CuttingCase, picture: Path, console: Console) -> dict[str, Any]:
    """Ground and tool of a case, a few steps of its cut, and what the whole would take."""
    from .cutting_building import make_cut, pace_of, speed_warning
    from .io.files import write_whole
    from .plotting.cutting_pictures import start_picture

    begun = time.perf_counter()
    cut = make_cut(case)
    course = cut.begin()
    s = course.simulation
    s.run(2)
    batches = []
    for _ in range(BATCHES):
        start = time.perf_counter()
        s.run(PROBE_STEPS)
        batches.append((time.perf_counter() - start) / PROBE_STEPS)
    steps = course.expected_steps
    per_step = min(batches)
    plan, placed = cut.plan, cut.placed
    pace = pace_of(cut, s)
    warnings = [*cut.warnings, *speed_warning(pace), *pace.doubts(cut.strength, plan.damping)]
    expected = steps * per_step + (time.perf_counter() - begun)
    console.print(f"[bold]{escaped(case.title)}[/]")
    for name, value in (
        ("Particles", f"{cut.assembly.particles:,}, mean diameter {show_rounded(placed.diameter, 'length')}"),
        ("Bonds", f"{len(cut.assembly.bonds):,}"),
        ("Depth", f"{show_rounded(plan.depth, 'length')}, {plan.depth / placed.diameter:.1f} mean diameters"),
        ("First touch", f"tip at x = {placed.contact:.5g} m"),
        ("Time step", f"{s.time_step:.3g} s, critical {s.critical_time_step:.3g} s"),
        ("Steps", f"about {steps:,}"),
        ("Memory", f"about {s.nbytes() / 1e6:.0f} MB"),
        ("Expected time", f"about {expected_time(expected)} on this machine"),
    ):
        console.print(f"{name}: {escaped(value)}")
    print_notices(case.notices, case.questions, console)
    for text in warnings:
        console.print(f"[yellow]note[/] {escaped(text)}")
    write_whole(picture, start_picture(cut))
    console.print(f"Picture: {escaped(str(picture))}")
    return {
        "particles": int(cut.assembly.particles), "steps": steps, "time_step_s": float(s.time_step),
        "memory_bytes": s.nbytes(), "warnings": warnings, "expected_s": expected,
    }  # fmt: skip
