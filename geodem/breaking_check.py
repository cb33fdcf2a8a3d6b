"""What `geodem check` tells of a case of breaking ground: what it is made of, its stages, and what a run will cost."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .breaking_building import build_works
from .case.breaking import BreakingCase
from .check_printing import escaped, expected_time, print_notices, show_rounded

if TYPE_CHECKING:
    from rich.console import Console

    from .breaking.site import Site

PROBE_STEPS = 50
TRIALS = 7
"""Of a search, about."""
SHARE_OF_LIMIT = 0.3
"""Of the step limit that comes to pass, about."""


def check_breaking(case: BreakingCase, picture: Path, console: Console) -> dict[str, Any]:
    """Build a case, draw it and estimate its cost; nothing is run.

    Raises
    ------
    InputError, InputErrors
        As of `geodem.breaking_building.build_works`.
    """
    from rich.table import Table

    from .io.files import write_whole
    from .plotting.breaking_pictures import site_figure
    from .plotting.theme import png, style

    works = build_works(case)
    scene, site = works.scene, works.site
    s = site.simulation
    console.print(f"[bold]{escaped(case.title)}[/]")
    console.print(
        f"{s.assembly.particles:,} particles of {show_rounded(site.diameter, 'length')} on average, "
        f"{len(s.assembly.bonds):,} bonds ({scene.assembly.bond_law or 'none'}), contacts {scene.assembly.contact_law}"
    )
    table = Table(show_header=True, box=None, pad_edge=False)
    for name in ("material", "particles", "of the source [m2]" if s.dimension == 2 else "of the source [m3]"):
        table.add_column(name, justify="left" if name == "material" else "right")
    for share in scene.filling.shares:
        table.add_row(escaped(share.name), f"{share.particles:,}", f"{share.source:.5g}")
    console.print(table)
    sides = ", ".join(f"{side} {kind}" for side, kind in case.scene.boundary.items() if kind != "free")
    console.print(f"Sides: {escaped(sides or 'all free')}. Damping {case.damping:g}.")
    console.print(f"Time step {s.time_step:.3g} s, critical {s.critical_time_step:.3g} s")
    steps = _expected_steps(case, site)
    per_step = _step_seconds(works.site)
    for number, stage in enumerate(case.stages, start=1):
        cost = expected_time(steps[number - 1] * per_step)
        console.print(f"Stage {number}: {escaped(stage.name)} ({stage.kind}), about {cost}")
    print_notices(case.notices, case.questions, console)
    for text in scene.warnings:
        console.print(f"[yellow]note[/] {escaped(text)}")
    with style():
        write_whole(picture, png(site_figure(site, "material", case.title, cracks=False)))
    console.print(f"Picture: {escaped(str(picture))}")
    return {
        "particles": s.assembly.particles,
        "bonds": len(s.assembly.bonds),
        "time_step_s": s.time_step,
        "expected_s": {
            f"{number} {stage.name}": count * per_step
            for number, (stage, count) in enumerate(zip(case.stages, steps, strict=True), start=1)
        },
    }


def _expected_steps(case: BreakingCase, site: Site) -> list[float]:
    """Steps of every stage, about: those of motion exactly, others by what they usually take of their limit."""
    from .breaking_building import criteria_of

    size = len(site.origin), site.simulation.dimension
    found = []
    for stage in case.stages:
        if "time" in stage.values:
            found.append(stage.values["time"] / site.simulation.time_step)
            continue
        if stage.kind == "remove-wall":
            found.append(0.0)
            continue
        criteria = criteria_of(stage)
        one = criteria.ramp_steps(*size) + SHARE_OF_LIMIT * criteria.most_steps(*size)
        found.append(one * (TRIALS if "tolerance" in stage.values else 1))
    return found


def _step_seconds(site: Site) -> float:
    """Run time of a step [s], measured; the site has moved after it."""
    s = site.simulation
    s.run(2)
    begun = time.perf_counter()
    s.run(PROBE_STEPS)
    return (time.perf_counter() - begun) / PROBE_STEPS
