"""Make the particles of a case of ground, judge them, and write their folder: result, report, frames, filling."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .breaking.facts import scene_facts
from .breaking.scene import BondedScene
from .builders.body import Surface
from .builders.body_filling import BodyFilling
from .builders.body_filling_file import load_filling, save_filling
from .case.ground import GroundCase
from .errors import InputError, StoppedError
from .ground_building import GroundBody, fill, make_body
from .ground_cost import cost
from .ground_files import read_surfaces, write_particles, write_surfaces
from .ground_result import assemble
from .io.checkpoint import checksum
from .io.files import cannot_write, read_json
from .io.run_folder import RunFolder
from .plotting.ground_pictures import ground_pictures
from .plotting.ground_report import write_ground_report
from .run_progress import RunUpdate
from .scene_building import make_filling, scene_of

QUICK_PARTICLES = 2000
FILLING = "filling.npz"
PARTICLES = "particles-000000.vtkhdf"
SURFACES = "surfaces-000000.vtkhdf"
WRITTEN = (FILLING, PARTICLES, SURFACES, "figures/*.png")
"""What a run writes beside the files of every run."""

NEEDED = ("report.html", FILLING, PARTICLES)
"""What a finished run has."""


Watch = Callable[[RunUpdate], None]


@dataclass(frozen=True)
class Ground:
    """A body with its particles, and what was found of them."""

    made: GroundBody
    filling: BodyFilling
    result: dict[str, Any]
    scene: BondedScene | None = None

    @property
    def surfaces(self) -> Sequence[Surface]:
        """Named boundaries of the body."""
        return self.made.body.surfaces


def make_ground(
    case: GroundCase, *, watch: Watch | None = None, stop_asked: Callable[[], bool] | None = None
) -> Ground:
    """Body, particles and everything that is told of them; nothing is written.

    Raises
    ------
    InputError
        A source that cannot be used, materials that do not fit it, particles that do not fit the body.
    StoppedError
        `stop_asked` said so between two stages.
    """

    def stage(words: str) -> None:
        if stop_asked is not None and stop_asked():
            raise StoppedError("stopped")
        if watch is not None:
            watch(RunUpdate("build", words))

    stage(f"reading the {case.source.kind}")
    if case.scene is None:
        made = make_body(case)
        stage("placing particles")
        filling = fill(case, made.body)
        scene = None
    else:
        own = replace(case.scene, source=case.source, particles=case.particles)
        made, filling = make_filling(own, title=case.title, allow_implausible=case.allow_implausible)
        stage("cutting joints, setting bolts")
        scene = scene_of(own, made.body, filling)
    stage("looking at contacts and cost")
    price = cost(case, filling, None if scene is None else scene.assembly)
    result = assemble(case, made, filling, price)
    if scene is not None:
        result |= {"scene": scene_facts(scene), "warnings": [*result["warnings"], *scene.warnings]}
    stage("drawing")
    return Ground(made, filling, result, scene)


def run_ground(
    case: GroundCase,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Watch | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Make the particles of a case and write its folder; one that holds them already is left as it is.

    Parameters
    ----------
    case : GroundCase
    out : pathlib.Path
        Folder of the results.
    threads : int, optional
        All cores if left out; the bits do not depend on it.
    quickly : bool
        About 2,000 particles, for a first look.
    overwrite : bool
        Replace the results of another case in that folder.
    watch : callable, optional
        Is given a `RunUpdate` at every stage.
    stop_asked : callable, optional
    command : str
        For the report.

    Returns
    -------
    dict
        The content of result.json.

    Raises
    ------
    InputError
        Bad input; nothing has been written over.
    StoppedError
        `stop_asked` said so; nothing has been written.
    """
    from ._jit import set_threads

    count = set_threads(threads)
    case = quick(case) if quickly else case
    beside, copies = portable(case)
    run = RunFolder(out, beside.as_run_text(), _identity(case, copies), written=WRITTEN, sources=copies)
    if not overwrite and (stored := run.finished(NEEDED)) is not None:
        return stored
    ground = make_ground(case, watch=watch, stop_asked=stop_asked)
    run.claim(overwrite=overwrite)
    return _write(ground, run, {"threads": count, "quick": quickly, "command": command})


def _write(ground: Ground, run: RunFolder, facts: dict[str, Any]) -> dict[str, Any]:
    """Everything that a run leaves; result.json last, so that one that says "done" has all beside it."""
    out = run.path
    # an older result is no longer that of what is written now
    run.void()
    run.write_case()
    try:
        save_filling(ground.filling, out / FILLING)
    except OSError as error:
        raise cannot_write(out / FILLING, error) from error
    filling = ground.filling
    densities = {row["name"]: row["density_kg_m3"] for row in ground.result["materials"]}
    write_particles(out / PARTICLES, filling, filling.density(densities))
    if ground.surfaces:
        write_surfaces(out / SURFACES, ground.surfaces)
    made = ground.made
    pictures, undrawn = ground_pictures(
        filling, ground.surfaces, title=ground.result["title"], picture=made.picture,
        segmentation=made.segmentation, scene=ground.scene,
    )  # fmt: skip
    warnings = {"warnings": [*ground.result["warnings"], *undrawn]}
    result = run.whole(ground.result | facts | warnings)
    write_ground_report(out / "report.html", result, pictures, run.case_text)
    return run.finish(result)


def resume_ground(folder: Path, case: GroundCase, **options: Any) -> dict[str, Any]:
    """What a finished run left; there is nothing between beginning and end to go on from."""
    return run_ground(case, folder, **options)


def redraw_ground(folder: Path, case: GroundCase) -> Path:
    """Make the report and its figures again from what a folder holds; returns the report's path.

    Raises
    ------
    InputError
        The result or the filling is not there, or the source that a photograph's figure needs.
    """
    stored = read_json(folder / "result.json")
    if stored is None:
        raise InputError(
            str(folder / "result.json"),
            "there is no result",
            f"Make it with: geodem run {folder} --out {folder}",
        )
    filling = load_filling(folder / FILLING)
    surfaces = read_surfaces(folder / SURFACES) if (folder / SURFACES).is_file() else ()
    photograph = make_body(case) if case.source.kind == "photograph" else None
    scene = None
    if case.scene is not None:
        own = replace(case.scene, source=case.source, particles=case.particles)
        scene = scene_of(own, make_filling(own)[0].body, filling)
    pictures, _ = ground_pictures(
        filling, surfaces, title=stored["title"],
        picture=None if photograph is None else photograph.picture,
        segmentation=None if photograph is None else photograph.segmentation, scene=scene,
    )  # fmt: skip
    text = (folder / "case.toml").read_text(encoding="utf-8")
    write_ground_report(folder / "report.html", stored, pictures, text)
    return folder / "report.html"


def quick(case: GroundCase) -> GroundCase:
    """The case with few particles, for a first look."""
    options = case.particles
    if options.arrangement == "pixel" or options.grading is not None:
        why = "one in each pixel" if options.arrangement == "pixel" else "the grading says their sizes"
        return replace(case, notices=(*case.notices, f"--quick changes nothing: {why}."))
    count = min(options.particles or QUICK_PARTICLES, QUICK_PARTICLES)
    notice = f"--quick: about {count} particles instead of the case's own."
    return replace(
        case, particles=replace(options, particles=count, radius=None), notices=(*case.notices, notice)
    )


def portable(case: GroundCase) -> tuple[GroundCase, dict[str, Path]]:
    """The case with its files beside it, as it stands in the folder of the results, and where they come from."""
    source, copies = case.source.beside()
    return replace(case, source=source), copies


def _identity(case: GroundCase, copies: dict[str, Path]) -> str:
    """Of a case as it is run and of what its files hold."""
    held: dict[str, Any] = {"case": portable(case)[0].as_run_text()}
    for name, path in copies.items():
        files = sorted(entry for entry in path.iterdir() if entry.is_file()) if path.is_dir() else [path]
        for file in files:
            try:
                held[f"{name} {file.name}"] = np.frombuffer(file.read_bytes(), dtype=np.uint8)
            except OSError as error:
                raise InputError(
                    f"source.{case.source.kind}", f"the file cannot be read ({error.strerror})", "Put it back.",
                    value=str(file),
                ) from error  # fmt: skip
    return checksum(held)
