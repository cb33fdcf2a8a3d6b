"""Run a case of run-out: search the failure of the slope, hand it over to discs, let them flow, write the folder."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._jit import compile_seconds, set_threads
from .analysis import Analysis, Update, particles_from_tree
from .building import make_model, source_bytes
from .case.runout import BEYOND, RunoutCase
from .errors import InputError, StoppedError
from .io.checkpoint import checksum
from .io.files import read_json, remove
from .io.history import continued_history, write_history
from .io.run_folder import PARTS, RunFolder
from .model import Model
from .particle_simulation import ParticleSimulation
from .plotting.runout_pictures import runout_pictures
from .plotting.runout_report import write_runout_report
from .record import MethodRecord
from .run_progress import Pace, RunUpdate, Work, together
from .runout.flow import Flow, Look
from .runout.friction import disc_friction
from .runout.handing import HandOver, hand_over
from .runout.source import Source, failed_source, released_velocity
from .runout_result import FRAME_LOOKS, assemble, write_frames

Floats = NDArray[np.float64]
Watch = Callable[[RunUpdate], None]
SEARCHING = "searching the failure"

QUICK_DISCS = 500
WRITTEN = ("*.vtkhdf", "*.vtkhdf.series", "figures/*.png")
KEPT_SECONDS = 20.0
CLOSING = 1.5
"""Time of pictures and report, about [s]."""
FLOW_STEPS = 1500.0
"""Steps of a flow over the root of the number of discs."""
FLOW_WORK = 7.0, 3500.0
"""Of a step of a flow: steps times particles of a search that take as long, for each disc and besides."""
HAND_OVER = 0.2
"""Time of handing over to discs over that of the flow."""
COLUMNS = (
    "time [s]", "centre of gravity, x [m]", "centre of gravity, y [m]", "kinetic energy [J/m]",
    "potential energy [J/m]", "elastic energy [J/m]", "dissipated energy [J/m]", "front [m]",
    "largest speed [m/s]",
)  # fmt: skip


class Stopping:
    """Who watches and who may stop a run."""

    def __init__(self, watch: Watch | None, asked: Callable[[], bool] | None) -> None:
        self.watch = watch or (lambda update: None)
        self.asked = asked or (lambda: False)
        self.searched = 0.0  # work of the search, steps times particles

    def tell(self, stage: str, text: str, detail: str = "") -> None:
        """One word to the user, or the end of the run."""
        if self.asked():
            raise StoppedError(f"stopped: {text}")
        self.watch(RunUpdate(stage, text, detail))


def run_runout(
    case: RunoutCase,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Watch | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Run a case and write its folder; one that holds its result already is left as it is.

    Parameters
    ----------
    case : RunoutCase
    out : pathlib.Path
        Folder of the results.
    threads : int, optional
        All cores if left out; the bits do not depend on it.
    quickly : bool
        About 1,000 particles, 500 discs and a wide tolerance, for a first look.
    overwrite : bool
        Replace the results of another case in that folder.
    watch, stop_asked : callable, optional
    command : str
        For the report.

    Returns
    -------
    dict
        The content of result.json.

    Raises
    ------
    InputError
        Bad input; nothing has been written over. Or a slope whose failed state cannot be handed over.
    StoppedError
        `stop_asked` said so; `resume_runout` goes on.
    """
    count = set_threads(threads)
    case = quick(case) if quickly else case
    run = _folder(case, out)
    if not overwrite and (stored := run.finished()) is not None:
        return stored
    told = Stopping(watch, stop_asked)
    told.tell("build", "placing particles")
    Analysis(case.slope).build()
    run.claim(overwrite=overwrite)
    head = {
        "workflow": case.workflow, "title": case.title, "quick": quickly, "threads": count, "command": command,
        "seed": case.slope.seed,
    }  # fmt: skip
    compiled = compile_seconds()
    with run.going(head):
        model, record = _search(case, run, told)
        hand = _hand_over(case, _source(case, model, record), told)
        flow, places = _flow(hand, run, told)
        told.tell("report", "pictures and report")
        result = assemble(case, model, record, hand, flow)
        result["compile_time_s"] = round(compile_seconds() - compiled, 3)
        write_history(out / "history.csv", COLUMNS, flow.looks)
        write_frames(out, flow, places)
        pictures = runout_pictures(hand, flow, places, result["deposit"])
        write_runout_report(out / "report.html", run.whole(result), pictures, run.case_text)
        return run.finish(result)


def resume_runout(folder: Path, case: RunoutCase, **options: Any) -> dict[str, Any]:
    """Go on with a stopped run, to the bits of one that was never stopped."""
    quickly = bool((read_json(folder / "result.json") or {}).get("quick"))
    return run_runout(case, folder, quickly=quickly, **options)


def redraw_runout(folder: Path, case: RunoutCase) -> Path:
    """Make report and pictures again from what a folder holds; returns the report's path.

    Raises
    ------
    InputError
        The run is not finished.
    """
    run = _folder(case, folder)
    stored, kept = read_json(folder / "result.json"), run.part("search")
    if stored is None or kept is None or stored.get("status") != "done":
        raise InputError(
            str(folder), "there is no finished run", f"Run it with: geodem run {folder} --out {folder}"
        )
    told = Stopping(None, None)
    model, record = _search(case, run, told)
    hand = _hand_over(case, _source(case, model, record), told)
    flow, places = _flow(hand, run, told)
    pictures = runout_pictures(hand, flow, places, stored["deposit"])
    write_runout_report(folder / "report.html", stored, pictures, run.case_text)
    return folder / "report.html"


def quick(case: RunoutCase) -> RunoutCase:
    """The case with few particles and discs, for a first look."""
    from .building import quick as quick_slope

    return RunoutCase(
        quick_slope(case.slope), replace(case.runout, discs=min(case.runout.discs, QUICK_DISCS))
    )


def _folder(case: RunoutCase, out: Path) -> RunFolder:
    beside, copies = case.beside()
    text = beside.as_run_text()
    held: dict[str, Any] = {"case": text}
    content = source_bytes(case.slope.section)
    if content is not None:
        held["file"] = np.frombuffer(content, dtype=np.uint8)
    return RunFolder(out, text, checksum(held), written=WRITTEN, sources=copies)


def _search(case: RunoutCase, run: RunFolder, told: Stopping) -> tuple[Model, MethodRecord]:
    """The model that the failure was found on, and what was found."""
    kept = run.part("search")
    if kept is None:
        flow = (1.0 + HAND_OVER) * flow_work(case.runout.discs)

        def watch(update: Update) -> None:
            if update.work is None:
                told.watch(RunUpdate("search", SEARCHING, update.text))
                return
            work = together([update.work, Work(0.0, flow)])
            told.searched = work.done
            left, most = (update.each * part + CLOSING for part in (work.left, work.most))
            told.watch(RunUpdate("search", SEARCHING, update.text, left, most, work))

        told.tell("search", SEARCHING)
        analysis = Analysis(case.slope, watch=watch, stop_asked=told.asked)
        analysis.build()
        analysis.search()
        kept = analysis.to_tree()
        run.keep("search", {"mesh": kept["mesh"], "methods": kept["methods"], "focus": kept["focus"]})
    model = make_model(case.slope, particles_from_tree(kept["mesh"]))
    return model, MethodRecord.from_tree(kept["methods"]["strength-reduction"])


def flow_work(discs: int) -> float:
    """Of a flow of so many discs, about, in the unit of the search for its source: steps times particles."""
    each, besides = FLOW_WORK
    return FLOW_STEPS * math.sqrt(discs) * (each * discs + besides)


def _source(case: RunoutCase, model: Model, record: MethodRecord) -> Source:
    """What the failed trial hands over."""
    if record.failed is None:
        raise InputError(
            "runout",
            "the slope does not fail at any factor that was tried",
            "There is nothing that runs out.",
        )
    state, energy = record.failed.state, record.failed.energy
    densities = [case.slope.materials[name].density for name in model.material_names]
    source = failed_source(model, state, densities, what=case.runout.mass)
    if case.runout.start == "rest":
        return source
    velocity = released_velocity(model, state, densities, source.moving, energy.damping + energy.kinetic)
    return failed_source(model, state, densities, what=case.runout.mass, velocity=velocity)


def _hand_over(case: RunoutCase, source: Source, told: Stopping) -> HandOver:
    told.tell("hand over", "handing over to discs")
    own = case.runout
    used = {name: case.slope.materials[name] for name in source.materials}
    weight = source.material_mass / source.material_mass.sum()
    modulus = float(sum(share * m.young_modulus for share, m in zip(weight, used.values(), strict=True)))
    return hand_over(
        source,
        [disc_friction(own.residual_friction[name]) for name in source.materials],
        discs=own.discs,
        beyond=BEYOND * source.height if own.beyond is None else own.beyond,
        restitution=own.restitution,
        young_modulus=modulus,
        seed=case.slope.seed,
    )


def _flow(hand: HandOver, run: RunFolder, told: Stopping) -> tuple[Flow, Floats]:
    """The flow to its end, and the discs at every few looks (k, n, 2) [m]."""
    kept = run.part("flow")
    flow = Flow.of(hand)
    places = [flow.start]
    if kept is not None:
        simulation = ParticleSimulation.resume(run.path / PARTS / f"flow-{kept['look']:05d}.h5")
        flow.simulation, flow.looks = simulation, [Look(*row) for row in kept["looks"].tolist()]
        places = list(kept["places"])
    else:
        for path in run.path.glob("*.vtkhdf*"):
            remove(path)
    saved = time.perf_counter()
    first = flow.work()
    pace = Pace(compile_seconds, done=first.done, closing=CLOSING)
    # in the unit of the search
    unit = flow_work(int(flow.moving.sum())) / (first.done + first.left)
    with continued_history(run.path / "history.csv", COLUMNS, flow.looks) as history:
        while not (flow.at_rest or flow.too_long):
            if told.asked():
                _keep(flow, places, run)
                raise StoppedError(f"stopped {flow.simulation.time:.3g} s after the hand-over")
            look = flow.advance()
            history.write(*look)
            if (len(flow.looks) - 1) % FRAME_LOOKS == 0:
                places.append(flow.simulation.positions)
            detail = f"{look.time:.3g} s, fastest {look.fastest:.3g} m/s"
            work = flow.work()
            whole = Work(told.searched + unit * work.done, unit * work.left, unit * work.most)
            told.watch(RunUpdate("flow", "letting the discs flow", detail, *pace.left(work), whole))
            if time.perf_counter() - saved > KEPT_SECONDS:
                _keep(flow, places, run)
                saved = time.perf_counter()
        _keep(flow, places, run)
    return flow, np.array(places)


def _keep(flow: Flow, places: list[Floats], run: RunFolder) -> None:
    """The flow as it is, to be gone on with: first its simulation, then what names it."""
    number = len(flow.looks) - 1
    folder = run.path / PARTS
    flow.simulation.save(folder / f"flow-{number:05d}.h5")
    run.keep("flow", {"look": number, "looks": np.array(flow.looks), "places": np.array(places)})
    for path in folder.glob("flow-*.h5"):
        if path.name != f"flow-{number:05d}.h5":
            remove(path)
