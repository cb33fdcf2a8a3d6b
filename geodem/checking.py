"""What `geodem check` and `geodem info` tell: the model as built, what it will cost, and what is installed."""

from __future__ import annotations

import os
import shutil
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._jit import cache_folder, set_threads
from .analysis import Analysis
from .case import load_case
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
    from rich.table import Table

    from .plotting.check_picture import write_check_picture

    case = load_case(path)
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

    table = Table(title=case.title, show_header=True)
    for head in (
        "material",
        "area [m2]",
        "share",
        "unit weight",
        "cohesion",
        "friction",
        "dilation",
        "tension",
    ):
        table.add_column(head)
    total = sum(analysis.section.area(name) for name in model.material_names)
    for row in make_view(analysis).material_rows:
        area = analysis.section.area(row["name"])
        table.add_row(
            row["name"], f"{area:.5g}", f"{100 * area / total:.2f} %", row["unit weight"], row["cohesion"],
            row["friction angle"], row["dilation angle"], row["tensile strength"],
        )  # fmt: skip
    console.print(table)
    low, high = model.positions.min(axis=0), model.positions.max(axis=0)
    console.print(
        f"section {low[0]:g} to {high[0]:g} m wide, {low[1]:g} to {high[1]:g} m high, {total:.5g} m2"
    )
    console.print(
        f"{model.particles} particles ({case.packing}, seed {case.seed}), spacing {analysis.particles.spacing:.4g} m"
    )
    console.print(
        f"{len(model.triangles)} triangles, {model.stress_points} stress points, {model.nbytes() / 1e6:.1f} MB"
    )
    console.print(
        f"elastic settlement under gravity {show(simulation.elastic.mean_displacement, 'length')} in the mean"
    )
    for method, seconds in expected.items():
        console.print(f"{method}: about {seconds:.2g} s (from {seconds / 3:.1g} to {seconds * 3:.2g} s)")
    for text in (*case.notices, *analysis.particles.messages):
        console.print(f"[dim]taken: {text}[/]")
    for text in (*case.questions, *dilation_warnings(case)):
        console.print(f"[yellow]note[/] {text}")
    target = picture or Path(f"{default_folder(path).name.removesuffix('-result')}-check.png")
    write_check_picture(target, make_view(analysis))
    console.print(f"Picture: {target}")
    return {
        "particles": model.particles,
        "spacing_m": analysis.particles.spacing,
        "memory_bytes": model.nbytes(),
        "expected_s": expected,
    }


def show_info(console: Console) -> None:
    """Print versions, threads and what is found to compare with."""
    import numba

    for name, version in versions().items():
        console.print(f"{name} {version}")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    console.print(f"threads {set_threads(None)} of {cores} cores, layer {numba.config.THREADING_LAYER}")
    console.print(f"compiled kernels {cache_folder()}")
    for name, program in (("YADE", "yade"), ("LIGGGHTS", "liggghts")):
        console.print(f"{name}: {shutil.which(program) or f'not found (Debian: apt-get install {program})'}")
    beside = Path(__file__).resolve().parent.parent / "reference" / "limit_equilibrium.py"
    console.print(
        f"limit equilibrium: {'found' if beside.is_file() else 'not found (comes with the source checkout)'}"
    )
