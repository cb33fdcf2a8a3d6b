"""What `geodem check` tells of a slope: the model as built, and what it will cost."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .analysis import Analysis
from .case import Case
from .check_printing import escaped, expected_time, print_notices, show_rounded
from .outputs import make_view
from .result import dilation_warnings
from .simulation import Simulation

if TYPE_CHECKING:
    from rich.console import Console

TYPICAL_STEPS = {"strength-reduction": 45.0, "gravity-increase": 110.0}
"""Steps of all fine trials of a search over the square root of the number of particles, as the ten published
slopes take them in the mean; single cases lie between a third and three times of it."""

PROBE_STEPS = 50


def check_slope(case: Case, picture: Path, console: Console) -> dict[str, Any]:
    """Build a slope, draw it and estimate its cost.

    Returns
    -------
    dict
        What was printed: particles, spacing, memory, expected seconds of each method.

    Raises
    ------
    InputError
    """
    from .plotting.check_picture import write_check_picture

    analysis = Analysis(case)
    model = analysis.build()
    assert analysis.particles is not None
    assert analysis.section is not None
    simulation = Simulation(model)
    simulation.run(1)
    start = time.perf_counter()
    simulation.run(PROBE_STEPS)
    per_step = (time.perf_counter() - start) / PROBE_STEPS
    steps = {method: TYPICAL_STEPS[method] * model.particles**0.5 for method in case.methods}
    expected = {method: count * per_step for method, count in steps.items()}

    view = make_view(analysis)
    console.print(f"[bold]{escaped(case.title)}[/]")
    _print_materials(analysis, view.material_rows, console)
    (left, bottom), (right, top) = model.positions.min(axis=0), model.positions.max(axis=0)
    total = sum(analysis.section.area(name) for name in model.material_names)
    console.print(
        f"Section: {right - left:.4g} m wide (x from {left:.5g} to {right:.5g} m), {top - bottom:.4g} m high "
        f"(y from {bottom:.5g} to {top:.5g} m), {total:.4g} m2"
    )
    how = f"{case.packing}, seed {case.seed}"
    if case.particles is None and case.spacing is None:
        how = "the nodes of the mesh"
    console.print(
        f"Model: {model.particles:,} particles ({how}) about "
        f"{show_rounded(analysis.particles.spacing, 'length')} apart, {len(model.triangles):,} triangles, "
        f"{model.stress_points:,} stress points, {model.nbytes() / 1e6:.1f} MB"
    )
    held = ", ".join(f"{side} {support}" for side, support in view.supports.items())
    console.print(f"Supports: {held}")
    console.print(f"Loads: {escaped('; '.join(view.loads) or 'its own weight only')}")
    console.print(
        "Elastic settlement under these loads: "
        f"{show_rounded(simulation.elastic.mean_displacement, 'length')} (mean of what moves)"
    )
    for method, seconds in expected.items():
        low, high = expected_time(seconds / 3), expected_time(seconds * 3)
        console.print(
            f"Expected time: {method} {expected_time(seconds)} (from {low} to {high}), compiling not counted"
        )
    print_notices(case.notices, analysis.particles.messages, console)
    for text in (*case.questions, *dilation_warnings(case)):
        console.print(f"[yellow]note[/] {escaped(text)}")
    write_check_picture(picture, view)
    console.print(f"Picture: {escaped(str(picture))}")
    return {
        "particles": model.particles,
        "spacing_m": analysis.particles.spacing,
        "memory_bytes": model.nbytes(),
        "expected_s": expected,
    }


def _print_materials(analysis: Analysis, rows: Sequence[Mapping[str, str]], console: Console) -> None:
    """Properties down, materials across: so that it fits a narrow terminal."""
    from rich.table import Table

    assert analysis.section is not None
    areas = {row["name"]: analysis.section.area(row["name"]) for row in rows}
    total = sum(areas.values())
    table = Table(show_header=True, box=None, pad_edge=False)
    table.add_column("")
    for row in rows:
        table.add_column(row["name"], no_wrap=True)
    shares = [f"{areas[row['name']]:.4g} m2 ({100 * areas[row['name']] / total:.1f} %)" for row in rows]
    table.add_row("area", *shares)
    for key in rows[0]:
        if key != "name":
            table.add_row(key, *(row[key] for row in rows))
    console.print(table)
