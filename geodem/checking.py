"""What `geodem check` and `geodem info` tell: the model as built, what it will cost, and what is installed."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._jit import cache_folder, set_threads
from .analysis import Analysis
from .case import CalibrationCase, Case, GroundCase, LaboratoryCase, load_any
from .outputs import make_view
from .provenance import versions
from .result import dilation_warnings
from .simulation import Simulation
from .units import show
from .workflow import default_folder

if TYPE_CHECKING:
    from rich.console import Console

TYPICAL_STEPS = {"strength-reduction": 45.0, "gravity-increase": 110.0}
"""Steps of all fine trials of a search over the square root of the number of particles, as the ten published
slopes take them in the mean; single cases lie between a third and three times of it."""

PROBE_STEPS = 50


def check_case(path: Path, picture: Path | None, console: Console) -> dict[str, Any]:
    """Build a case, draw it and estimate its cost.

    Parameters
    ----------
    path : path of a case
    picture : path of the PNG; named after the case if left out
    console : rich.console.Console

    Returns
    -------
    dict
        What was printed: particles, spacing, areas, memory, expected seconds.

    Raises
    ------
    InputError
    """
    from .plotting.check_picture import write_check_picture

    case = load_any(path)
    if isinstance(case, GroundCase):
        return _check_ground(case, path, picture, console)
    if not isinstance(case, Case):
        return _check_tests(case, path, picture, console)
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
    console.print(f"[bold]{_escaped(case.title)}[/]")
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
    console.print(f"Loads: {_escaped('; '.join(view.loads) or 'its own weight only')}")
    console.print(
        "Elastic settlement under these loads: "
        f"{show_rounded(simulation.elastic.mean_displacement, 'length')} (mean of what moves)"
    )
    for method, seconds in expected.items():
        console.print(
            f"Expected time: {method} {_time(seconds)} (from {_time(seconds / 3)} to {_time(seconds * 3)}), "
            "compiling not counted"
        )
    _print_notices(case.notices, analysis.particles.messages, console)
    for text in (*case.questions, *dilation_warnings(case)):
        console.print(f"[yellow]note[/] {_escaped(text)}")
    target = picture or Path(f"{default_folder(path).name.removesuffix('-result')}-check.png")
    write_check_picture(target, view)
    console.print(f"Picture: {_escaped(str(target))}")
    return {
        "particles": model.particles,
        "spacing_m": analysis.particles.spacing,
        "memory_bytes": model.nbytes(),
        "expected_s": expected,
    }


def _check_tests(
    case: LaboratoryCase | CalibrationCase, path: Path, picture: Path | None, console: Console
) -> dict[str, Any]:
    """Specimens of a laboratory case or of a calibration."""
    from .laboratory.estimate import estimate
    from .laboratory.workers import workers_allowed
    from .plotting.laboratory_specimen import write_bare_specimen

    if isinstance(case, LaboratoryCase):
        from .laboratory_run import orders_of

        orders = orders_of(case)
    else:
        from .calibration_run import expected_orders

        orders = expected_orders(case)
    found = estimate(orders)
    specimen, processes = found.specimen, workers_allowed(None)
    console.print(f"[bold]{_escaped(case.title)}[/]")
    size = " x ".join(f"{1e3 * value:.4g} mm" for value in specimen.size)
    console.print(
        f"Specimen: {size}, {specimen.particles:,} particles ({specimen.packing}, seed {case.seed}), "
        f"{specimen.across:.3g} across, {1e3 * specimen.diameter:.3g} mm in the mean, "
        f"{len(found.bonds):,} bonds, {2.0 * len(found.bonds) / specimen.particles:.2f} of a particle"
    )
    console.print(
        f"Time step: {found.time_step:.3g} s (masses are those of a quasi-static test: no physical time), "
        f"{1e3 * found.step_seconds:.3g} ms of run time a step"
    )
    counts = {kind: sum(order.kind == kind for order in orders) for kind in found.steps}
    for kind, steps in found.steps.items():
        console.print(f"Tests: {counts[kind]} of {kind}, about {steps:,.0f} steps")
    seconds = found.seconds(processes)
    memory = f", {found.memory_bytes / 1e6:.0f} MB of memory each" if found.memory_bytes else ""
    console.print(
        f"Expected time: {_time(seconds)} ({_time(seconds / 2)} to {_time(seconds * 3)}) with {processes} tests at "
        f"a time{memory}, compiling not counted"
    )
    _print_notices(case.notices, (), console)
    for text in case.questions:
        console.print(f"[yellow]note[/] {_escaped(text)}")
    target = picture or Path(f"{default_folder(path).name.removesuffix('-result')}-check.png")
    write_bare_specimen(target, specimen, found.bonds, case.title)
    console.print(f"Picture: {_escaped(str(target))}")
    return {
        "particles": specimen.particles,
        "bonds": len(found.bonds),
        "time_step_s": found.time_step,
        "memory_bytes": found.memory_bytes,
        "expected_s": seconds,
        "tests": len(orders),
    }


def _check_ground(case: GroundCase, path: Path, picture: Path | None, console: Console) -> dict[str, Any]:
    """Body and particles of a case of ground."""
    from rich.table import Table

    from .errors import InputError
    from .ground_run import make_ground
    from .io.files import write_whole
    from .plotting import ground_wording as words
    from .plotting.ground_pictures import check_figure

    ground = make_ground(case)
    result = ground.result
    console.print(f"[bold]{_escaped(case.title)}[/]")
    console.print(f"{words.headline(result)}, {words.size_line(result)}")
    header, rows = words.material_rows(result)
    table = Table(show_header=True, box=None, pad_edge=False)
    table.add_column("")
    for row in rows:
        table.add_column(row[0], justify="right")
    for k, name in enumerate(header[1:], start=1):
        table.add_row(_escaped(name), *(row[k] for row in rows))
    console.print(table)
    for name, value in (*words.contact_rows(result), *words.cost_rows(result)):
        console.print(f"{name[0].upper()}{name[1:]}: {_escaped(value)}")
    named = ", ".join(f"{entry['name']} ({entry['facets']:,})" for entry in result["surfaces"])
    if named:
        console.print(f"Boundaries: {_escaped(named)}")
    _print_notices(result["notices"], (), console)
    for text in result["warnings"]:
        console.print(f"[yellow]note[/] {_escaped(text)}")
    target = picture or Path(f"{default_folder(path).name.removesuffix('-result')}-check.png")
    try:
        drawn = check_figure(ground.filling, ground.surfaces, title=case.title)
    except InputError as error:
        console.print(f"[yellow]note[/] no picture: {_escaped(f'{error.problem}. {error.remedy}')}")
    else:
        write_whole(target, drawn)
        console.print(f"Picture: {_escaped(str(target))}")
    return result


def _print_notices(notices: Sequence[str], more: Sequence[str], console: Console) -> None:
    """Defaults under one heading, what else was noted under another."""
    taken = [text for text in notices if " is not given: " in text]
    noted = [*(text for text in notices if text not in taken), *more]
    for head, texts in (("Taken by default", taken), ("Noted", noted)):
        if texts:
            console.print(f"{head}:")
        for text in texts:
            console.print(f"  [dim]{_escaped(text)}[/]")


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


def show_rounded(value: float, dimension: str) -> str:
    """Three significant digits with a fitting unit."""
    return show(float(f"{value:.3g}"), dimension)


def _time(seconds: float) -> str:
    if seconds < 60.0:
        return f"{seconds:.1g} s" if seconds < 10.0 else f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def _escaped(text: str) -> str:
    from rich.markup import escape

    return escape(text)


def show_info(console: Console) -> None:
    """Print versions, threads and what is found to compare with."""
    for name, version in versions().items():
        console.print(f"{name} {version}")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    console.print(f"threads {set_threads(None)} of {cores} cores")
    console.print(f"compiled kernels {cache_folder()}")
    for name, program in (("YADE", "yade"), ("LIGGGHTS", "liggghts")):
        console.print(f"{name}: {shutil.which(program) or f'not found (Debian: apt-get install {program})'}")
    beside = Path(__file__).resolve().parent.parent / "reference" / "limit_equilibrium.py"
    console.print(
        f"limit equilibrium: {'found' if beside.is_file() else 'not found (comes with the source checkout)'}"
    )
