"""What `geodem check` tells of a tunnel: ground, stages, supports, and what a run will cost."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .case.tunnel import TunnelCase
from .check_printing import escaped, expected_time, print_notices, show_rounded
from .errors import InputErrors
from .io.files import write_whole
from .plotting.tunnel_pictures import check_picture
from .tunnel_building import build_tunnel, unsuited_section
from .tunnel_view import make_view
from .tunnelling.collapse import make_search
from .tunnelling.digging import Digging
from .tunnelling.plan import Stage, UniformStress

if TYPE_CHECKING:
    from rich.console import Console

PROBE_STEPS = 50
STEPS_PER_INCREMENT = 6.0
"""Over the square root of the number of particles, as the tunnels of the reference problems take them."""
STEPS_PER_SEARCH = 150.0
"""Of all trials of a search over that root."""


def check_tunnel(case: TunnelCase, picture: Path, console: Console) -> dict[str, Any]:
    """Build the ground, dig everything at once without relaxing it, draw what will stand, and estimate the cost.

    Raises
    ------
    InputError, InputErrors
    """
    errors = unsuited_section(case)
    if errors:
        raise InputErrors(errors)
    ground, plan = build_tunnel(case)
    digging = Digging(ground, plan, increments=case.increments)
    for stage in plan.stages:
        digging.set_up(stage)
    simulation = make_search(digging, "strength-reduction", tolerance=0.1).simulation
    simulation.run(1)
    begun = time.perf_counter()
    simulation.run(PROBE_STEPS)
    per_step = (time.perf_counter() - begun) / PROBE_STEPS
    root = ground.model.particles**0.5
    expected = {"stages": case.increments * STEPS_PER_INCREMENT * root * per_step}
    if case.ground_reaction:
        expected["ground reaction"] = expected["stages"]
    expected |= dict.fromkeys(case.methods, STEPS_PER_SEARCH * root * per_step)

    model = ground.model
    console.print(f"[bold]{escaped(case.title)}[/]")
    (left, bottom), (right, top) = model.positions.min(axis=0), model.positions.max(axis=0)
    console.print(
        f"Section: {right - left:.4g} m wide (x from {left:.5g} to {right:.5g} m), {top - bottom:.4g} m high "
        f"(y from {bottom:.5g} to {top:.5g} m)"
    )
    near = digging.wall_spacing(digging.dug)
    console.print(
        f"Model: {model.particles:,} particles (seed {case.seed}), {show_rounded(near, 'length')} apart "
        f"on the walls, up to {show_rounded(ground.particles.spacing, 'length')} away from them"
    )
    console.print("Sides: " + ", ".join(f"{side} {support}" for side, support in case.boundary.items()))
    console.print(f"Initial stress: {_stress(case)}")
    for number, stage in enumerate(case.stages, start=1):
        console.print(f"Stage {number}, {escaped(stage.name)}: {escaped(_stage(stage))}")
    for part, seconds in expected.items():
        low, high = expected_time(seconds / 3), expected_time(seconds * 3)
        console.print(
            f"Expected time: {part} {expected_time(seconds)} (from {low} to {high}), compiling not counted"
        )
    print_notices(case.notices, ground.particles.messages, console)
    for words in case.questions:
        console.print(f"[yellow]note[/] {escaped(words)}")
    write_whole(picture, check_picture(make_view(case, digging)))
    console.print(f"Picture: {escaped(str(picture))}")
    return {
        "particles": model.particles, "spacing_m": ground.particles.spacing, "memory_bytes": model.nbytes(),
        "expected_s": expected,
    }  # fmt: skip


def _stress(case: TunnelCase) -> str:
    if isinstance(case.initial, UniformStress):
        horizontal, vertical = (
            show_rounded(v, "stress") for v in (case.initial.horizontal, case.initial.vertical)
        )
        return f"{horizontal} horizontally, {vertical} vertically, the same everywhere; no weight"
    return f"weight above and surcharges, K0 = {case.initial.k0:g}"


def _stage(stage: Stage) -> str:
    parts = [f"excavate {', '.join(stage.excavate)}"] if stage.excavate else []
    parts += [f"install {', '.join(stage.install)}"] if stage.install else []
    parts += [] if stage.relax is None else [f"relax to {100.0 * stage.relax:g} %"]
    parts += [] if stage.pressure is None else [f"pressure {show_rounded(stage.pressure, 'stress')}"]
    return ", ".join(parts)
