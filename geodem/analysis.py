"""One case from its file to its result: build, search, measure, write; stoppable at any moment and resumable.

Everything that decides is a function of the case, so a run that was stopped and resumed any number of times ends
with the same bits as one that was not.
"""

from __future__ import annotations

import hashlib
import math
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import __version__
from ._jit import compile_seconds, set_threads
from .builders.ground import GroundProperties, Surcharge, build_ground
from .builders.particles import Particles, fill_section
from .builders.section import Section
from .case import Case, ImageSection, RegionSection
from .errors import InputError, StoppedError
from .io.checkpoint import checksum, read_checkpoint, write_checkpoint
from .laws import GROUND_LAWS
from .measure.energy import EnergyAccount
from .measure.failing_zone import FailingZone, failing_zone
from .model import Model
from .simulation import Simulation
from .stability.bracket import Bracket, Trial, bracket
from .stability.criteria import Criteria
from .stability.methods import GravityIncrease, StrengthReduction, make_method
from .stability.search import Progress, Search, Snapshot
from .state import FIELDS, State

Floats = NDArray[np.float64]

COARSE_PARTICLES = 1000
COARSE_BELOW = 0.6
"""A coarse model is used where it has at most this share of the fine model's particles."""

COARSE_TOLERANCE = 0.01
FIRST_STEP = 0.3
FINE_STEP = {StrengthReduction.kind: 0.01, GravityIncrease.kind: 0.02}
FINE_START = {StrengthReduction.kind: 0.995, GravityIncrease.kind: 0.97}
"""Where the fine search starts, over the coarse factor: coarse particles are a little too strong, and more so for
gravity increase."""

QUICK_PARTICLES = 1000
QUICK_TOLERANCE = 0.02

CHECKPOINT_SECONDS = 5.0

DILATION_GAP = math.radians(15.0)
"""Dilation this far below friction makes the factor depend on mesh and damping."""


class Update(NamedTuple):
    """What a run tells whoever watches it."""

    stage: str  # "build", "search", "measure", "neighbours", "report"
    text: str
    progress: Progress | None = None
    seconds_left: float = math.nan


@dataclass
class MethodRecord:
    """What is known of one method: all of it goes into the checkpoint."""

    kind: str
    coarse: list[Trial] = field(default_factory=list)
    fine: list[Trial] = field(default_factory=list)
    stable: Snapshot | None = None
    failed: Snapshot | None = None
    current: float | None = None
    history: list[tuple[int, float, float]] = field(default_factory=list)
    state: State | None = None
    zero_dilation: list[Trial] = field(default_factory=list)
    done: bool = False

    def to_tree(self) -> dict[str, Any]:
        """As a checkpoint tree."""
        tree: dict[str, Any] = {
            "kind": self.kind,
            "coarse": [t.as_dict(history=True) for t in self.coarse],
            "fine": [t.as_dict(history=True) for t in self.fine],
            "zero_dilation": [t.as_dict(history=True) for t in self.zero_dilation],
            "current": self.current,
            "history": self.history,
            "done": self.done,
        }
        for name, snapshot in (("stable", self.stable), ("failed", self.failed)):
            if snapshot is not None:
                tree[name] = {
                    "factor": snapshot.factor,
                    "energy": list(snapshot.energy),
                    "state": _state_tree(snapshot.state),
                }
        if self.state is not None and self.current is not None:
            tree["state"] = _state_tree(self.state)
        return tree

    @classmethod
    def from_tree(cls, tree: Mapping[str, Any]) -> MethodRecord:
        """From a checkpoint tree."""
        snapshots = {
            name: Snapshot(
                tree[name]["factor"], _state_from(tree[name]["state"]), EnergyAccount(*tree[name]["energy"])
            )
            for name in ("stable", "failed")
            if name in tree
        }
        return cls(
            kind=tree["kind"],
            coarse=[_trial(t) for t in tree["coarse"]],
            fine=[_trial(t) for t in tree["fine"]],
            zero_dilation=[_trial(t) for t in tree["zero_dilation"]],
            current=tree["current"],
            history=[(int(a), b, c) for a, b, c in tree["history"]],
            state=_state_from(tree["state"]) if "state" in tree else None,
            done=tree["done"],
            **snapshots,
        )


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
    """

    def __init__(
        self,
        case: Case,
        folder: Path | None = None,
        *,
        watch: Callable[[Update], None] | None = None,
        stop_asked: Callable[[], bool] | None = None,
    ) -> None:
        self.case = case
        self.folder = folder
        self.watch = watch or (lambda update: None)
        self.stop_asked = stop_asked or (lambda: False)
        self.warnings: list[str] = []
        self.section: Section | None = None
        self.particles: Particles | None = None
        self.model: Model | None = None
        self.records: dict[str, MethodRecord] = {}
        self.criteria = Criteria()
        self.seconds = 0.0
        self.compile_seconds = 0.0
        self._started = time.perf_counter()
        self._compiled_before = compile_seconds()
        self._saved = 0.0
        self._coarse: Model | None = None
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
        return self.model

    def _use(self, particles: Particles) -> None:
        self.particles = particles
        self.model = self._ground(particles)

    def _fill(
        self, particles: int | None, spacing: float | None, focus: FailingZone | None = None
    ) -> Particles:
        assert self.section is not None
        spec = self.case.section
        points = [point for s in self.case.loads.surcharge for point in (s.start, s.end)]
        return fill_section(
            self.section,
            particles=particles,
            spacing=spacing,
            packing=self.case.packing,
            seed=self.case.seed,
            layers=spec.layers,
            thin=spec.thin,
            refine=_refinements(self.section, spec),
            focus=() if focus is None else [focus],
            points=points,
        )

    def _ground(self, particles: Particles) -> Model:
        case = self.case
        boundary = {side: getattr(case.boundary, side) for side in ("left", "right", "bottom", "top")}
        return build_ground(
            particles,
            {name: ground_properties(material) for name, material in case.materials.items()},
            boundary=boundary,
            horizontal_acceleration=case.loads.horizontal_acceleration,
            surcharges=[Surcharge(s.start, s.end, s.pressure) for s in case.loads.surcharge],
        )

    def coarse_model(self) -> Model | None:
        """A model of about a thousand particles to bracket on; None where the fine one is hardly larger."""
        assert self.model is not None
        if self._coarse is None:
            if self.model.particles * COARSE_BELOW < COARSE_PARTICLES:
                return None
            for count in (COARSE_PARTICLES, 2 * COARSE_PARTICLES, 4 * COARSE_PARTICLES):
                if count > self.model.particles * COARSE_BELOW:
                    return None
                try:
                    self._coarse = self._ground(self._fill(count, None))
                    break
                except InputError:
                    continue  # a thin seam takes more particles than that
        return self._coarse

    # --- searching ----------------------------------------------------------------------------------------------

    def search(self) -> None:
        """Search the factor of every method that is not done.

        Raises
        ------
        StoppedError
            `stop_asked` said so; the checkpoint is written.
        """
        assert self.model is not None
        if not self.bracketed:
            self._bracket_coarsely()
        for kind, record in self.records.items():
            if record.done:
                continue
            self._search_fine(record)
            if kind == StrengthReduction.kind and any(not m.dilation_given for m in self._frictional()):
                self._search_zero_dilation(record)
            record.done = True
            self.save()

    def _bracket_coarsely(self) -> None:
        """Bracket every method on the coarse model, then place the particles anew where it failed."""
        coarse = self.coarse_model()
        failed = []
        if coarse is not None:
            for record in self.records.values():
                snapshot = self._search_coarse(record, coarse)
                failed += [] if snapshot is None else [snapshot.state]
            # a given spacing is the user's word; a given number leaves open where the particles are
            zone = failing_zone(coarse, failed) if self.case.particles is not None else None
            if zone is not None:
                self.watch(Update("build", "placing particles where the coarse model failed"))
                self.focus = zone.ratio
                self._use(self._fill(self.case.particles, None, zone))
        self.bracketed = True
        self.save()

    def _frictional(self) -> list[Any]:
        return [m for m in self.case.materials.values() if m.friction_angle > 0.0]

    def _search_coarse(self, record: MethodRecord, coarse: Model) -> Snapshot | None:
        """Bracket one method on the coarse model; returns its lowest failed state."""
        simulation = Simulation(coarse, energy=False)
        search = Search(
            simulation,
            make_method(record.kind, simulation),
            self.criteria,
            tolerance=max(COARSE_TOLERANCE, self.case.tolerance),
            step=FIRST_STEP,
            model="coarse",
        )
        search.run(self._on_coarse_batch)
        record.coarse = search.trials
        return search.failed

    def _search_zero_dilation(self, record: MethodRecord) -> None:
        """The same with psi = 0, on the coarse model: what the silent choice psi = phi is worth."""
        model = self.coarse_model() or self.model
        assert model is not None
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
        search.run(self._on_coarse_batch)
        record.zero_dilation = search.trials

    def _search_fine(self, record: MethodRecord) -> None:
        assert self.model is not None
        simulation = Simulation(self.model)
        found = bracket(record.coarse).value
        start, step = (1.0, FIRST_STEP) if found is None else (FINE_START[record.kind] * found, FINE_STEP[record.kind])
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
        if self.stop_asked():
            self.save()
            raise StoppedError("stopped while bracketing on the coarse model")

    def _tell(self, search: Search) -> None:
        progress = search.progress()
        left = progress.seconds_left
        waiting = sum(not r.done for r in self.records.values()) - 1
        if waiting > 0:
            so_far = sum(t.seconds for t in search.trials) + search.seconds
            left += waiting * (so_far + left)
        self.watch(Update("search", search.method.kind, progress, left))

    # --- checkpoints --------------------------------------------------------------------------------------------

    def save(self) -> None:
        """Write the checkpoint (nothing without a folder)."""
        if self.folder is None or self.particles is None:
            return
        write_checkpoint(self.folder / "checkpoint.h5", self.to_tree())
        self._saved = time.perf_counter()

    def to_tree(self) -> dict[str, Any]:
        """Everything that a resumed run needs."""
        particles = self.particles
        assert particles is not None
        return {
            "geodem": __version__,
            "sources": sources_digest(),
            "case": self.case.text,
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
            "methods": {kind: record.to_tree() for kind, record in self.records.items()},
            "seconds": self.wall_seconds(),
            "compile_seconds": self.compiled_seconds(),
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
        if tree["geodem"] != __version__ or tree["sources"] != sources_digest():
            raise InputError(
                str(path),
                f"it was written by another geodem ({tree['geodem']}), whose numbers may differ",
                "Run the case again: geodem run CASE --out DIR --overwrite",
            )
        self = cls(case, folder, **options)
        mesh = tree["mesh"]
        self.section = make_section(case)
        self.particles = Particles(
            positions=mesh["positions"],
            triangles=mesh["triangles"],
            triangle_material=mesh["triangle_material"],
            materials=tuple(mesh["materials"]),
            boundary_edges=mesh["boundary_edges"],
            spacing=mesh["spacing"],
            messages=tuple(mesh["messages"]),
        )
        self.model = self._ground(self.particles)
        self.records = {kind: MethodRecord.from_tree(tree["methods"][kind]) for kind in case.methods}
        self.bracketed, self.focus = tree["bracketed"], tree["focus"]
        self.seconds, self.compile_seconds = tree["seconds"], tree["compile_seconds"]
        return self

    def wall_seconds(self) -> float:
        """Wall time of this case over all its runs [s]."""
        return self.seconds + time.perf_counter() - self._started

    def compiled_seconds(self) -> float:
        """Of that, compiling [s]."""
        return self.compile_seconds + compile_seconds() - self._compiled_before

    # --- result -------------------------------------------------------------------------------------------------

    def done(self) -> bool:
        """Whether every method has its factor."""
        return bool(self.records) and all(record.done for record in self.records.values())

    def result(self) -> dict[str, Any]:
        """The content of result.json (DESIGN: contracts), without neighbours."""
        case, model, particles = self.case, self.model, self.particles
        assert model is not None
        assert particles is not None
        factors = [factor_entry(record, self.case) for record in self.records.values()]
        energy_of = next((r.failed for r in self.records.values() if r.failed is not None), None)
        steps = sum(t.steps for r in self.records.values() for t in (*r.coarse, *r.fine, *r.zero_dilation))
        final = {
            kind: {"stable": _arrays(record.stable), "failed": _arrays(record.failed)}
            for kind, record in self.records.items()
        }
        return {
            "workflow": case.workflow,
            "title": case.title,
            "status": "done" if self.done() else "stopped",
            "kind_of_result": "static: quasi-static relaxation, times have no physical meaning",
            "particles": model.particles,
            "stress_points": model.stress_points,
            "spacing_m": particles.spacing,
            "dimension": 2,
            "factors": factors,
            "steps": steps,
            "wall_time_s": round(self.wall_seconds(), 3),
            "compile_time_s": round(self.compiled_seconds(), 3),
            "threads": set_threads(None),
            "seed": case.seed,
            "tolerance": case.tolerance,
            "energy": {} if energy_of is None else energy_entry(energy_of),
            "cracks": {"tension": 0, "shear": 0},
            "reference": None
            if case.reference is None
            else {"factor": case.reference.factor, "source": case.reference.source},
            "versions": versions(),
            "spacing_where_it_failed": self.focus,
            "notices": [*case.notices, *particles.messages, *self._focus_notice()],
            "warnings": [*case.questions, *self.warnings, *dilation_warnings(case), *bracket_warnings(factors)],
            "digest": checksum(
                {"mesh": particles.positions, "trials": [_decided(r) for r in self.records.values()], "final": final}
            ),
        }

    def _focus_notice(self) -> list[str]:
        if self.focus >= 1.0:
            return []
        return [
            f"particles are {1.0 / self.focus:.2g} times as fine where the coarse model failed as elsewhere; a given "
            "spacing instead of a number of particles keeps them uniform"
        ]


# --- pieces -----------------------------------------------------------------------------------------------------


def make_section(case: Case) -> Section:
    """The section of a case, from its polygons or its picture."""
    spec = case.section
    if isinstance(spec, RegionSection):
        return Section.from_polygons(spec.regions)
    from .builders.from_image import section_from_image

    return section_from_image(
        spec.image,
        scale=spec.scale,
        legend=spec.legend,
        background=spec.background,
        y_axis=spec.y_axis,
        origin=spec.origin,
    )


def _refinements(section: Section, spec: RegionSection | ImageSection) -> list[tuple[Any, float]]:
    from shapely import box, union_all

    chosen = []
    for refinement in spec.refine:
        if refinement.box is not None:
            where = box(*refinement.box)
        else:
            where = union_all([r.polygon for r in section.regions if r.material == refinement.material])
        chosen.append((where, refinement.spacing))
    return chosen


def ground_properties(material: Any) -> GroundProperties:
    """Density and law parameters of a material of the case file."""
    parameters = GROUND_LAWS[material.law].parameters(
        young_modulus=material.young_modulus,
        poisson_ratio=material.poisson_ratio,
        cohesion=material.cohesion,
        friction_angle=material.friction_angle,
        dilation_angle=material.dilation_angle,
        tensile_strength=material.tensile_strength,
    )
    return GroundProperties(material.density, material.law, parameters)


def factor_entry(record: MethodRecord, case: Case) -> dict[str, Any]:
    """One entry of result.json's factors."""
    now = bracket(record.fine)
    method = StrengthReduction if record.kind == StrengthReduction.kind else GravityIncrease
    decided = {t.factor: t.criterion for t in record.fine}
    criterion = "; ".join(
        f"{word} at {factor:.5g}: {decided[factor]}"
        for word, factor in (("stable", now.stable), ("failed", now.failed))
        if factor is not None
    )
    entry: dict[str, Any] = {
        "kind": record.kind,
        "meaning": method.meaning,
        "value": now.value,
        "stable": now.stable,
        "failed": now.failed,
        "undecided": list(now.undecided),
        "criterion": criterion,
        "trials": [t.as_dict() for t in (*record.coarse, *record.fine)],
        "finished": record.done,
    }
    if record.zero_dilation:
        flat = bracket(record.zero_dilation)
        entry["zero_dilation"] = {
            "value": flat.value,
            "stable": flat.stable,
            "failed": flat.failed,
            "undecided": list(flat.undecided),
            "particles": record.zero_dilation[0].particles,
            "meaning": "the same with a dilation angle of zero; depends on the mesh",
        }
    return entry


def bracket_warnings(factors: list[dict[str, Any]]) -> list[str]:
    """What a reader must know of brackets that are open or hold undecided trials."""
    warnings = []
    for entry in factors:
        kind = entry["kind"]
        if not entry["finished"]:
            warnings.append(f"{kind}: the search was stopped before its bracket was closed; resume it")
        elif entry["failed"] is None:
            warnings.append(f"{kind}: nothing failed up to a factor of {entry['stable']:g}")
        elif entry["stable"] is None:
            warnings.append(f"{kind}: no stable state was found down to a factor of {entry['failed']:g}")
        if entry["undecided"]:
            text = ", ".join(f"{factor:.4g}" for factor in entry["undecided"])
            warnings.append(f"{kind}: undecided at {text} (neither at rest nor failing); the bracket includes them")
    return warnings


def dilation_warnings(case: Case) -> list[str]:
    """Materials whose dilation is so far below their friction that the factor depends on the mesh."""
    return [
        f"material.{m.name}: dilation angle {math.degrees(m.dilation_angle):.3g} deg is far below the friction angle "
        f"{math.degrees(m.friction_angle):.3g} deg: the factor is mesh-dependent"
        for m in case.materials.values()
        if m.friction_angle - m.dilation_angle > DILATION_GAP
    ]


def energy_entry(snapshot: Snapshot) -> dict[str, float]:
    """The energy account of a failed trial, from its start [J per m of length]."""
    account = snapshot.energy
    return {
        "factor": snapshot.factor,
        "external_work_J_per_m": account.external_work,
        "elastic_J_per_m": account.elastic,
        "plastic_J_per_m": account.plastic,
        "damping_J_per_m": account.damping,
        "kinetic_J_per_m": account.kinetic,
        "closure": account.closure,
    }


def versions() -> dict[str, str]:
    """Versions of what the numbers depend on."""
    import numba
    import scipy

    return {
        "geodem": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
    }


@lru_cache(maxsize=1)
def sources_digest() -> str:
    """Hash of geodem's own sources: a checkpoint is continued only by the code that began it."""
    digest = hashlib.sha256()
    root = Path(__file__).parent
    for path in sorted(root.rglob("*.py")):
        digest.update(str(path.relative_to(root)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def quick(case: Case) -> Case:
    """A coarser version of a case, for a first look."""
    particles = min(case.particles or QUICK_PARTICLES, QUICK_PARTICLES)
    tolerance = max(case.tolerance, QUICK_TOLERANCE)
    notice = f"--quick: {particles} particles and a tolerance of {tolerance:g} instead of the case's own"
    return replace(case, particles=particles, spacing=None, tolerance=tolerance, notices=(*case.notices, notice))


def _trial(data: Mapping[str, Any]) -> Trial:
    history = [(int(a), b, c) for a, b, c in data["history"]]
    return Trial(**{**data, "history": history})


def _decided(record: MethodRecord) -> list[list[Any]]:
    return [[t.factor, t.verdict, t.steps, t.unbalanced, t.displacement] for t in (*record.coarse, *record.fine)]


def _arrays(snapshot: Snapshot | None) -> dict[str, Floats]:
    return {} if snapshot is None else snapshot.state.arrays()


def _state_tree(state: State) -> dict[str, Any]:
    return {**state.arrays(), "numbers": state.numbers()}


def _state_from(tree: Mapping[str, Any]) -> State:
    return State(**{field.name: tree[field.name] for field in FIELDS}, **tree["numbers"])


def bracket_of(record: MethodRecord) -> Bracket:
    """The bracket of a method's fine search."""
    return bracket(record.fine)
