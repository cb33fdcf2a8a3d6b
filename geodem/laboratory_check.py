"""What `geodem check` tells of tests on specimens, and of a calibration: a specimen, and what the tests will cost."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from .case import CalibrationCase, LaboratoryCase
from .check_printing import escaped, expected_time, print_notices

if TYPE_CHECKING:
    from rich.console import Console


def check_tests(case: LaboratoryCase | CalibrationCase, picture: Path, console: Console) -> dict[str, Any]:
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
    console.print(f"[bold]{escaped(case.title)}[/]")
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
    low, high = expected_time(seconds / 2), expected_time(seconds * 3)
    console.print(
        f"Expected time: {expected_time(seconds)} ({low} to {high}) with {processes} tests at "
        f"a time{memory}, compiling not counted"
    )
    print_notices(case.notices, (), console)
    for text in case.questions:
        console.print(f"[yellow]note[/] {escaped(text)}")
    write_bare_specimen(picture, specimen, found.bonds, case.title)
    console.print(f"Picture: {escaped(str(picture))}")
    return {
        "particles": specimen.particles,
        "bonds": len(found.bonds),
        "time_step_s": found.time_step,
        "memory_bytes": found.memory_bytes,
        "expected_s": seconds,
        "tests": len(orders),
    }
