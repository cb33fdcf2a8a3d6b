"""One case from its file to its result: build, search, measure, write; stoppable at any moment and resumable.

Everything that decides is a function of the case, so a run that was stopped and resumed any number of times ends
with the same bits as one that was not.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from ._jit import compile_seconds
from ._version import __version__
from .builders.filling import TooFewParticlesError
from .builders.particles import Particles
from .builders.section import Section
from .building import case_identity, make_model, make_particles, make_section
from .case import Case
from .errors import InputError, StoppedError
from .io.checkpoint import SEARCH, read_checkpoint, write_checkpoint
from .laws import GROUND_LAWS
from .measure.failing_zone import FailingZone, failing_zone
from .model import Model
from .provenance import sources_digest
from .record import MethodRecord, write_trials
from .run_progress import LEAST, Work, together
from .simulation import Simulation
from .stability.bracket import Trial, bracket
from .stability.criteria import Criteria
from .stability.forecast import Planned
from .stability.methods import GravityIncrease, StrengthReduction, make_method
from .stability.search import Progress, Search, Snapshot

COARSE_PARTICLES = 1000
LEVEL_RATIO = 4.0
"""Brackets are found on about a thousand particles and carried to the fine model in steps of about this ratio."""

SMALLEST_RATIO = 1.6
"""A fine model with fewer coarse models' particles than this is searched directly."""

COARSE_TOLERANCE = 0.005
FIRST_STEP = 0.3
NEXT_STEP = {StrengthReduction.kind: 0.005, GravityIncrease.kind: 0.015}
NEXT_START = {StrengthReduction.kind: 0.995, GravityIncrease.kind: 0.98}
"""Where a finer search starts, over the factor of the coarser one, whose particles are a little too strong, and more so
for gravity increase; and its first step."""

CHECKPOINT_SECONDS = 5.0

FILLING = 2.0
"""Time of placing the particles of a model that is still to come over that of the first one, which is not graded."""


class Update(NamedTuple):
    """What a run tells whoever watches it."""

    stage: str  # "build", "search", "measure", "neighbours", "report"
    text: str
    progress: Progress | None = None
    seconds_left: float = math.nan
    seconds_most: float = math.nan
    work: Work | None = None  # of all searches, steps times particles
    each: float = math.nan  # seconds of a unit of it


class Analysis:
    """A case being worked on in a folder.

    Parameters
    ----------
    case : Case
    folder : pathlib.Path or None
        Where checkpoints go; None keeps everything in memory.
    watch : callable, optional
        Called with an `Update` after every batch of steps and at every stage.
    stop_asked : callable, optional
        Asked after every batch; True stops with a checkpoint and `StoppedError`.
    closing : float
        Seconds that follow the search: pictures, say. For the time left that is told.
    """

    def __init__(
        self,
        case: Case,
        folder: Path | None = None,
        *,
        watch: Callable[[Update], None] | None = None,
        stop_asked: Callable[[], bool] | None = None,
        closing: float = 0.0,
    ) -> None:
        self.case = case
        self.folder = folder
        self.closing = closing
        self.watch = watch or (lambda update: None)
        self.stop_asked = stop_asked or (lambda: False)
        self.section: Section | None = None
        self.particles: Particles | None = None
        self.model: Model | None = None
        self.records: dict[str, MethodRecord] = {}
        self.criteria = Criteria()
        self.seconds = 0.0
        self.compile_seconds = 0.0
        self.seconds_to_first_step: float | None = None
        self._started = time.perf_counter()
        self._compiled_before = compile_seconds()
        self._saved = 0.0
        self._plan: list[Planned] = []
        self._done_trials: list[Trial] = []
        self._building = 0.0
        self._to_place = 0
        self._coarse: Model | None = None
        self._coarse_count: int | None = None
        self.bracketed = False
        self.focus = 1.0

    # --- building -----------------------------------------------------------------------------------------------

    def build(self) -> Model:
        """Section, particles and model of the case.

        Raises
        ------
        InputError
        """
        self.watch(Update("build", "reading the section"))
        self.section = make_section(self.case)
        self.watch(Update("build", "placing particles"))
        self.records = {kind: MethodRecord(kind) for kind in self.case.methods}
        self._use(self._fill(self.case.particles, self.case.spacing))
        assert self.model is not None
        self._building = self.wall_seconds()
        return self.model

    def _use(self, particles: Particles) -> None:
        self.particles = particles
        self.model = make_model(self.case, particles)

    def _fill(
        self, particles: int | None, spacing: float | None, focus: FailingZone | None = None
    ) -> Particles:
        assert self.section is not None
        return make_particles(self.case, self.section, particles=particles, spacing=spacing, focus=focus)

    # --- searching ----------------------------------------------------------------------------------------------

    def search(self) -> None:
        """Search the factor of every method that is not done.

        Raises
        ------
        StoppedError
            `stop_asked` said so; the checkpoint is written.
        """
        assert self.model is not None
        self._plan = self._planned()
        if not self.bracketed:
            self._bracket_coarsely()
        for kind, record in self.records.items():
            if record.done:
                continue
            self._plan = self._planned(record)
            self._search_fine(record)
            if kind == StrengthReduction.kind and any(not m.dilation_given for m in self._frictional()):
                self._search_zero_dilation(record)
            record.done = True
            self.save()

    def _planned(self, beginning: MethodRecord | None = None) -> list[Planned]:
        """Searches still to come; `beginning`: after the fine one of this method, which begins now."""
        assert self.model is not None
        levels = [] if self.bracketed else self._levels()
        open_ = [record for record in self.records.values() if not record.done]
        tolerance = max(COARSE_TOLERANCE, self.case.tolerance)
        plan = [
            Planned(level, tolerance, NEXT_STEP[record.kind] if number else FIRST_STEP)
            for number, level in enumerate(levels)
            for record in open_
        ]
        for record in open_:
            if record is not beginning:
                found = bool(levels) or record.coarse_value is not None
                step = NEXT_STEP[record.kind] if found else FIRST_STEP
                plan.append(Planned(self.model.particles, self.case.tolerance, step))
            if record.kind == StrengthReduction.kind and any(
                not m.dilation_given for m in self._frictional()
            ):
                coarse = levels[0] if levels else self._coarse_count or self.model.particles
                plan.append(Planned(coarse, tolerance, 0.03))
        return plan

    def _bracket_coarsely(self) -> None:
        """Bracket every method on ever finer models, each with its particles where the one before failed."""
        for record in self.records.values():  # a run that was stopped here begins them again
            record.coarse, record.coarse_value = [], None
        zone = None
        known = 0
        levels = self._levels()
        for number, level in enumerate(levels):
            if level <= known:
                continue
            # the coarse ones that follow, and the fine one anew
            self._to_place = len(levels) - number - 1 + (self.case.particles is not None)
            found_model = self._coarse_model(level, zone)
            if found_model is None:
                continue
            known, model = found_model
            if self._coarse is None:
                self._coarse_count, self._coarse = found_model
            found = [self._search_coarse(record, model) for record in self.records.values()]
            # a given spacing is the user's word; a given number leaves open where the particles are
            if self.case.particles is not None:
                zone = failing_zone(model, [snapshot.state for snapshot in found if snapshot is not None])
        if zone is not None:
            self.watch(Update("build", "placing particles where the coarse model failed"))
            self.focus = zone.ratio
            self._use(self._fill(self.case.particles, None, zone))
        self._to_place = 0
        self.bracketed = True
        self.save()

    def _levels(self) -> list[int]:
        """Numbers of particles of the models to bracket on, in equal ratios; none where the fine model is small."""
        assert self.model is not None
        ratio = self.model.particles / COARSE_PARTICLES
        if ratio < SMALLEST_RATIO:
            return []
        levels = max(1, round(math.log(ratio) / math.log(LEVEL_RATIO)))
        return [round(COARSE_PARTICLES * ratio ** (level / levels)) for level in range(levels)]

    def _coarse_model(self, count: int, zone: FailingZone | None) -> tuple[int, Model] | None:
        """Particles asked for (`count`, or what thin seams need) and their model; None where that saves nothing."""
        assert self.model is not None
        for _ in range(2):
            try:
                return count, make_model(self.case, self._fill(count, None, zone))
            except TooFewParticlesError as error:
                count = error.needed
                if SMALLEST_RATIO * count > self.model.particles:
                    break
            except InputError:
                break
        return None

    def _coarsest(self) -> Model:
        """The first model that was bracketed on, made again where a run was resumed; else the fine one."""
        assert self.model is not None
        if self._coarse is None and self._coarse_count is not None:
            self._coarse = make_model(self.case, self._fill(self._coarse_count, None))
        return self._coarse or self.model

    def _frictional(self) -> list[Any]:
        return [m for m in self.case.materials.values() if m.friction_angle > 0.0]

    def _search_coarse(self, record: MethodRecord, model: Model) -> Snapshot | None:
        """Bracket one method on a coarse model; returns its lowest failed state."""
        simulation = Simulation(model, energy=False)
        found = record.coarse_value
        search = Search(
            simulation,
            make_method(record.kind, simulation),
            self.criteria,
            tolerance=max(COARSE_TOLERANCE, self.case.tolerance),
            start=1.0 if found is None else round(NEXT_START[record.kind] * found, 4),
            step=FIRST_STEP if found is None else NEXT_STEP[record.kind],
            model="coarse",
        )
        if self._plan:
            del self._plan[0]
        record.coarse_value = search.run(self._on_coarse_batch).value
        record.coarse += search.trials
        self._done_trials += search.trials
        return search.failed

    def _search_zero_dilation(self, record: MethodRecord) -> None:
        """The same with psi = 0, on the coarse model: what the silent choice psi = phi is worth."""
        model = self._coarsest()
        flat = model.with_parameters([GROUND_LAWS[model.law].without_dilation(p) for p in model.parameters])
        simulation = Simulation(flat, energy=False)
        found = bracket(record.fine).value
        search = Search(
            simulation,
            make_method(record.kind, simulation),
            self.criteria,
            tolerance=max(COARSE_TOLERANCE, self.case.tolerance),
            start=1.0 if found is None else round(0.97 * found, 4),
            step=0.03,
            model="coarse",
        )
        self.watch(Update("search", f"{record.kind} without dilation"))
        if self._plan:
            del self._plan[0]
        search.run(self._on_coarse_batch)
        record.zero_dilation = search.trials

    def _search_fine(self, record: MethodRecord) -> None:
        assert self.model is not None
        simulation = Simulation(self.model)
        found, kind = record.coarse_value, record.kind
        start, step = (1.0, FIRST_STEP) if found is None else (NEXT_START[kind] * found, NEXT_STEP[kind])
        search = Search(
            simulation,
            make_method(record.kind, simulation),
            self.criteria,
            tolerance=self.case.tolerance,
            start=round(start, 4),
            step=step,
            trials=record.fine,
            stable=record.stable,
            failed=record.failed,
        )
        if record.current is not None and record.state is not None:
            search.continue_trial(record.current, record.history, record.state)
        known = len(record.fine)

        def on_batch(search: Search) -> None:
            nonlocal known
            record.stable, record.failed = search.stable, search.failed
            record.current, record.history = search.current, search.history
            record.state = simulation.state
            self._tell(search)
            ended = len(search.trials) > known
            known = len(search.trials)
            if ended or time.perf_counter() - self._saved > CHECKPOINT_SECONDS:
                self.save()
            if self.stop_asked():
                self.save()
                raise StoppedError(f"stopped in the search for {record.kind}")

        search.run(on_batch)
        record.state = None

    def _on_coarse_batch(self, search: Search) -> None:
        self._tell(search)
        stop = self.stop_asked()
        if stop or time.perf_counter() - self._saved > CHECKPOINT_SECONDS:
            self.save(search)
        if stop:
            raise StoppedError("stopped on the coarse model")

    def _tell(self, search: Search) -> None:
        if self.seconds_to_first_step is None:
            self.seconds_to_first_step = self.wall_seconds()
        work = self._work(search)
        known = work.done > LEAST * (work.done + work.left)
        each = search.pace(self._done_trials) if known else math.nan
        beside = FILLING * self._to_place * self._building + self.closing
        left, most = (each * part + beside for part in (work.left, work.most))
        text = f"{search.method.kind} on {search.simulation.model.particles:,} particles"
        self.watch(Update("search", text, search.progress(), left, most, work, each))

    def _work(self, search: Search) -> Work:
        """Steps times particles of all searches; of this one, which is under way, and of those still to come."""
        records = self.records.values()
        known = [
            part for r in records for part in (r.coarse, r.fine, r.zero_dilation) if part is not search.trials
        ]
        done = sum(trial.steps * trial.particles for part in known for trial in part)
        return together([Work(done, 0.0), search.work(), *(planned.work() for planned in self._plan)])

    # --- checkpoints --------------------------------------------------------------------------------------------

    def save(self, under_way: Search | None = None) -> None:
        """Write the checkpoint and the history so far (nothing without a folder).

        `under_way`: a search on a coarse model, which a resumed run begins again.
        """
        if self.folder is None or self.particles is None:
            return
        write_checkpoint(self.folder / "checkpoint.h5", self.to_tree())
        write_trials(self.folder / "history.csv", self.records.values(), under_way)
        self._saved = time.perf_counter()

    def to_tree(self) -> dict[str, Any]:
        """Everything that a resumed run needs."""
        particles = self.particles
        assert particles is not None
        return {
            "geodem": __version__,
            "sources": sources_digest(),
            "case": case_identity(self.case),
            "notices": list(self.case.notices),
            "questions": list(self.case.questions),
            "mesh": {
                "positions": particles.positions,
                "triangles": particles.triangles,
                "triangle_material": particles.triangle_material,
                "boundary_edges": particles.boundary_edges,
                "materials": list(particles.materials),
                "spacing": particles.spacing,
                "messages": list(particles.messages),
            },
            "bracketed": self.bracketed,
            "focus": self.focus,
            "coarse_count": self._coarse_count,
            "methods": {kind: record.to_tree() for kind, record in self.records.items()},
            "seconds": self.wall_seconds(),
            "compile_seconds": self.compiled_seconds(),
            "seconds_to_first_step": self.seconds_to_first_step,
        }

    @classmethod
    def from_checkpoint(cls, case: Case, folder: Path, **options: Any) -> Analysis:
        """Go on from the checkpoint in a folder.

        Raises
        ------
        InputError
            The checkpoint is damaged or belongs to another case or version.
        """
        path = folder / "checkpoint.h5"
        tree = read_checkpoint(path)
        try:
            return cls._from_tree(case, folder, tree, options)
        except (KeyError, TypeError, AttributeError, IndexError) as error:
            raise InputError(str(path), f"the checkpoint lacks a part ({error})", SEARCH.again) from error

    @classmethod
    def _from_tree(cls, case: Case, folder: Path, tree: dict[str, Any], options: dict[str, Any]) -> Analysis:
        path = folder / "checkpoint.h5"
        if tree["geodem"] != __version__ or tree["sources"] != sources_digest():
            raise InputError(
                str(path),
                f"it was written by another geodem ({tree['geodem']}), whose numbers may differ",
                "Run the case again: geodem run CASE --out DIR --overwrite",
            )
        if tree["case"] != case_identity(case):
            raise InputError(
                str(folder / "case.toml"),
                "the case or its picture is not what the checkpoint beside it was made of",
                "Undo the change, or run it as a case of its own: geodem run CASE --out ANOTHER",
            )
        # the file in the folder has every default written out, so what was taken by default is known here only
        case = replace(case, notices=tuple(tree["notices"]), questions=tuple(tree["questions"]))
        self = cls(case, folder, **options)
        self.section = make_section(case)
        self.particles = particles_from_tree(tree["mesh"])
        self.model = make_model(self.case, self.particles)
        self.records = {kind: MethodRecord.from_tree(tree["methods"][kind]) for kind in case.methods}
        self.bracketed, self.focus = tree["bracketed"], tree["focus"]
        self._coarse_count = tree["coarse_count"]
        self.seconds, self.compile_seconds = tree["seconds"], tree["compile_seconds"]
        self.seconds_to_first_step = tree["seconds_to_first_step"]
        return self

    def wall_seconds(self) -> float:
        """Wall time of this case over all its runs [s]."""
        return self.seconds + time.perf_counter() - self._started

    def compiled_seconds(self) -> float:
        """Of that, compiling [s]."""
        return self.compile_seconds + compile_seconds() - self._compiled_before

    def done(self) -> bool:
        """Whether every method has its factor."""
        return bool(self.records) and all(record.done for record in self.records.values())


def particles_from_tree(mesh: Mapping[str, Any]) -> Particles:
    """The particles of a checkpoint tree's "mesh"."""
    return Particles(
        positions=mesh["positions"],
        triangles=mesh["triangles"],
        triangle_material=mesh["triangle_material"],
        materials=tuple(mesh["materials"]),
        boundary_edges=mesh["boundary_edges"],
        spacing=mesh["spacing"],
        messages=tuple(mesh["messages"]),
    )
