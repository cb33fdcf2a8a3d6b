"""Run a calibration in its folder: bonds for a rock, their material file, fresh specimens that show what they are."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from .calibration.entries import calibration_entries, statements
from .calibration.fit import ROUNDS, SPECIMENS, Calibration, calibrate, first_fit, material_of
from .calibration.outcomes import StoredOutcomes
from .calibration.targets import RockTargets, check_targets
from .calibration.trial import SpecimenOptions
from .case import parse_calibration
from .case.laboratory import CalibrationCase
from .case.material_file import PROPERTIES, Calibrated, write_material
from .case.table import quoted
from .errors import InputError, InputErrors, StoppedError
from .io.checkpoint import checksum
from .io.files import read_json
from .io.history import write_history
from .io.run_folder import RunFolder
from .laboratory import pace as paces
from .laboratory.entries import envelope_entry, group_entry, material_entry, property_entry
from .laboratory.files import write_tests
from .laboratory.material import BondedMaterial
from .laboratory.orders import FinishedTest, TestOrder, find_test
from .laboratory.specimen import COARSE
from .laboratory.summary import group_tests, material_properties, summarise_envelope
from .laboratory.workers import Workers, workers_allowed
from .plotting.calibration_report import write_calibration_report

MATERIAL_FILE = "material.toml"

SHOWN = 3
"""Fresh specimens on which the bonds are shown."""

CONFINEMENTS = (0.25, 0.5, 1.0)
"""Of the tests that show the envelope, over that up to which the friction angle is asked for."""

FRESH = 50_021
"""Seeds of the fresh specimens begin so far behind the first one of the calibration."""

QUICK_ACROSS = 16.0
QUICK_ROUNDS = 1
QUICK_SPECIMENS = 2
QUICK_PACE = 0.5
"""Of a quick run: particles across, rounds, specimens of a round and fresh ones, share of the pace."""

TRIAL = (("direct-tension", 0.0), ("uniaxial-compression", 0.0), ("triaxial-compression", 1.0))
"""Tests of a specimen that is tried, and their confinement over that up to which the friction angle is asked for."""

TRIAL_SHARE = 0.46
"""Time of a trial over that of the same tests in the laboratory: no pilots, and ended soon after the peak."""

WRITTEN = (
    MATERIAL_FILE, "tests/*.h5", "tests/trial-*.json", "curves/*.csv", "figures/*.png", "particles-*.vtkhdf",
    "cracks-*.vtkhdf",
)  # fmt: skip
"""What a run writes beside the files of every run."""


def run_calibration(
    case: CalibrationCase,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Callable[[Any], None] | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Calibrate bonds and write the folder; what was tested there already is not tested again.

    Parameters
    ----------
    case : CalibrationCase
    out : pathlib.Path
        Folder of the results.
    threads : int, optional
        Specimens that are tested at a time, each on one thread; as many as cores if left out. The bits do not depend
        on it.
    quickly : bool
        Coarse specimens, one round of two, loaded twice as fast: for a first look.
    overwrite : bool
        Replace the results of another case in that folder.
    watch : callable, optional
        Is given `geodem.calibration.fit.Progress`, and an `Overview` while the bonds are shown on fresh specimens.
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
        Bad input, targets that contradict each other; nothing has been written over.
    StoppedError
        `stop_asked` said so; the same call goes on.
    """
    faults = check_targets(case.targets, case.specimen.dimension)
    if faults:
        raise faults[0] if len(faults) == 1 else InputErrors(faults)
    first_fit(case.targets, case.specimen.dimension)  # that there is a map
    identity = checksum(
        {"targets": asdict(case.targets), "specimen": asdict(options_of(case, quickly)), "seed": case.seed}
    )
    across = options_of(case, quickly).across
    text = replace(case, specimen=replace(case.specimen, across=across)).as_run_text()
    run = RunFolder(out, text, identity, written=WRITTEN)
    if run.claim(overwrite=overwrite):
        stored = run.stored()
        if stored["status"] == "done" and (out / "report.html").is_file():
            return stored
    count = workers_allowed(threads)
    with run.going({**_head(case), "quick": quickly, "threads": count, "command": command}):
        found = _calibrate(case, out, quickly, count, watch, stop_asked)
        tests = _show(found, out, quickly, count, watch, stop_asked)
        result = run.whole(assemble(case, found, tests))
        write_material(out / MATERIAL_FILE, found.material, calibrated(found, statements(found)))
        _draw(out, result, found, tests)
        return run.finish(result)


def calibration_of(given: Mapping[str, object], title: str) -> CalibrationCase:
    """A case from the properties of a rock alone.

    Parameters
    ----------
    given : dict
        Keys of ``[rock]`` with texts such as "69 GPa", `dimension` and `seed`; None stands for what is left out.
    title : str

    Raises
    ------
    InputErrors
        As of `geodem.case.parse_calibration`.
    """
    values = {name: value for name, value in given.items() if value is not None}
    lines = ['workflow = "calibration"', f"title = {quoted(title)}"]
    if "seed" in values:
        lines.append(f"seed = {values.pop('seed')}")
    if "dimension" in values:
        lines += ["", "[specimen]", f"dimension = {values.pop('dimension')}"]
    lines += ["", "[rock]"]
    for name, value in values.items():
        bare = name == "poisson_ratio" and _is_number(str(value))
        lines.append(f"{name} = {value if bare else quoted(str(value))}")
    return parse_calibration("\n".join(lines) + "\n", Path())


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text)) and text.strip()[:1].isdigit()
    except ValueError:
        return False


def resume_calibration(folder: Path, case: CalibrationCase, **options: Any) -> dict[str, Any]:
    """Go on with a stopped run; `case` is the one in its folder, options and errors as of `run_calibration`."""
    quickly = bool((read_json(folder / "result.json") or {}).get("quick"))
    return run_calibration(case, folder, quickly=quickly, **options)


def redraw_calibration(folder: Path, case: CalibrationCase) -> Path:
    """Make everything but the numbers again from the finished tests; returns the report's path.

    Raises
    ------
    InputError
        The calibration is not finished, or was made by another version.
    """
    stored = read_json(folder / "result.json") or {}
    quickly = bool(stored.get("quick"))
    try:
        found = _calibrate(case, folder, quickly, 1, None, lambda: True)
        tests = _show(found, folder, quickly, 1, None, lambda: True)
    except StoppedError:
        raise InputError(
            str(folder), "the calibration is not finished, or another version of geodem made it",
            f"Go on with: geodem resume {folder}",
        ) from None  # fmt: skip
    _draw(folder, stored, found, tests)
    return folder / "report.html"


def expected_orders(case: CalibrationCase) -> list[TestOrder]:
    """The tests that a calibration makes at most, of the bonds that the map gives at first.

    Raises
    ------
    InputError
        As of `run_calibration`.
    """
    _, _, fit = first_fit(case.targets, case.specimen.dimension)
    material = material_of(fit, case.targets, case.title)
    specimen = _specimen(options_of(case, False))
    sides = case.targets.sides
    trials = [
        TestOrder(kind, {**specimen, "seed": seed}, material, stress=confined * sides, fall=0.85)
        for seed in range(ROUNDS * SPECIMENS)
        for kind, confined in TRIAL
    ]
    return trials + _orders(case.targets, material, specimen, case.seed, SHOWN, paces.PACE)


def options_of(case: CalibrationCase, quickly: bool) -> SpecimenOptions:
    """Specimens of a case, coarse and loaded fast where it is for a first look."""
    s = case.specimen
    across = min(s.across, QUICK_ACROSS) if quickly else s.across
    return SpecimenOptions(
        dimension=s.dimension, width=s.width, across=across, size_ratio=s.size_ratio, shape=s.shape,
        pace=(QUICK_PACE if quickly else 1.0) * paces.PACE,
    )  # fmt: skip


def _calibrate(
    case: CalibrationCase,
    folder: Path,
    quickly: bool,
    workers: int,
    watch: Callable[[Any], None] | None,
    stop_asked: Callable[[], bool] | None,
) -> Calibration:
    fewer = {"rounds": QUICK_ROUNDS, "specimens": QUICK_SPECIMENS} if quickly else {}
    # fresh specimens follow
    orders = expected_orders(case)
    of_trial, shown = orders[: len(TRIAL)], orders[ROUNDS * SPECIMENS * len(TRIAL) :]
    after = sum(order.cost() for order in shown) / (TRIAL_SHARE * sum(order.cost() for order in of_trial))
    return calibrate(
        case.targets, options_of(case, quickly), seed=case.seed, name=case.title, workers=workers,
        done=StoredOutcomes(folder / "tests"), watch=watch, stop_asked=stop_asked,
        after=after * (QUICK_SPECIMENS / SHOWN if quickly else 1.0), **fewer,
    )  # fmt: skip


def _show(
    found: Calibration,
    folder: Path,
    quickly: bool,
    workers: int,
    watch: Callable[[Any], None] | None,
    stop_asked: Callable[[], bool] | None,
) -> list[FinishedTest]:
    """Tests of the bonds on specimens that the calibration has not seen, their whole curves and envelope."""
    orders = _orders(
        found.targets, found.material, _specimen(found.options), found.seed,
        QUICK_SPECIMENS if quickly else SHOWN, found.options.pace,
    )  # fmt: skip
    kept = [find_test(folder / "tests" / f"{order.name}.h5", order) for order in orders]
    if all(test is not None for test in kept):
        return [test for test in kept if test is not None]
    with Workers(workers, folder / "tests", watch=watch, stop_asked=stop_asked) as hands:
        return hands.run(orders)


def _orders(
    targets: RockTargets,
    material: BondedMaterial,
    specimen: Mapping[str, Any],
    seed: int,
    specimens: int,
    pace: float,
) -> list[TestOrder]:
    pressures = [float(f"{share * targets.sides:.3g}") for share in CONFINEMENTS]
    kinds = [("uniaxial-compression", 0.0), ("direct-tension", 0.0)]
    kinds += [("triaxial-compression", pressure) for pressure in pressures]
    return [
        TestOrder(
            kind, {**specimen, "seed": FRESH + specimens * seed + k}, material, stress=stress, pace=pace
        )
        for kind, stress in kinds
        for k in range(specimens)
    ]


def _specimen(options: SpecimenOptions) -> dict[str, Any]:
    """Arguments of `make_specimen`, without the seed."""
    return {name: value for name, value in asdict(options).items() if name != "pace"}


def _draw(folder: Path, result: Mapping[str, Any], found: Calibration, tests: Sequence[FinishedTest]) -> None:
    _write_rounds(folder / "history.csv", found)
    write_tests(folder, tests)
    case_text = (folder / "case.toml").read_text(encoding="utf-8")
    material_text = (folder / MATERIAL_FILE).read_text(encoding="utf-8")
    write_calibration_report(folder / "report.html", result, found, tests, case_text, material_text)


def _write_rounds(path: Path, found: Calibration) -> None:
    """One line a round: the bonds that were tested, and the means over their specimens."""
    units = {"stress": "Pa", "angle": "rad", "dimensionless": "-"}
    micro = list(found.rounds[0].fit.micro)
    columns = ["round [-]", "specimens [-]", "effective modulus [Pa]", "bond tensile strength [Pa]"]
    columns += [f"{name} [-]" for name in micro]
    columns += [f"{name} [{units[kind]}]" for name, kind in PROPERTIES.items()]
    lines = [
        (
            number, len(each.outcomes), each.fit.effective_modulus, each.fit.tensile_strength,
            *(each.fit.micro[name] for name in micro), *(each.mean(name) for name in PROPERTIES),
        )
        for number, each in enumerate(found.rounds, start=1)
    ]  # fmt: skip
    write_history(path, columns, lines)


def calibrated(found: Calibration, remarks: Sequence[str]) -> Calibrated:
    """How the material was found, for its file."""
    o = found.options
    return Calibrated(
        found.targets, dict(found.achieved), dimension=o.dimension, packing="random", width=o.width, across=o.across,
        size_ratio=o.size_ratio, seed=found.seed, tests=found.tests, remarks=tuple(remarks),
    )  # fmt: skip


def assemble(case: CalibrationCase, found: Calibration, tests: Sequence[FinishedTest]) -> dict[str, Any]:
    """The content of result.json, but for what the run itself knows: its time, threads and command."""
    groups = group_tests(tests)
    envelope = summarise_envelope(groups)
    warnings = [*case.questions, *statements(found)]
    if found.options.across < COARSE:
        coarse = f"{found.options.across:g} particles across"
        warnings.append(f"{coarse}: below {COARSE}, strength and friction depend on how many there are")
    outcomes = [outcome for each in found.rounds for outcome in each.outcomes]
    warnings += [
        f"specimen {outcome['seed']}: {text}" for outcome in outcomes for text in outcome["warnings"]
    ]
    for test in tests:
        warnings += [f"{test.order.name}: {text}" for text in test.record.warnings]
    same_bits = [{k: v for k, v in outcome.items() if "seconds" not in k} for outcome in outcomes]
    cracks = {mode: sum(getattr(t.record.cracks, mode) for t in tests) for mode in ("tension", "shear")}
    return {
        **calibration_entries(found),
        "material": material_entry(found.material),
        "material_file": MATERIAL_FILE,
        "fresh": {
            "properties": {entry.key: property_entry(entry) for entry in material_properties(groups, envelope)},
            "tests": [group_entry(group) for group in groups],
            "envelope": None if envelope is None else envelope_entry(envelope),
        },
        "cracks": cracks,
        "specimens_tested": found.tests,
        "steps": sum(int(outcome["steps"]) for outcome in outcomes) + sum(test.record.steps for test in tests),
        "compile_time_s": round(
            sum(test.compile_seconds for test in tests) + sum(outcome["compile_seconds"] for outcome in outcomes), 3
        ),
        "warnings": warnings,
        "digest": checksum(
            {
                "outcomes": same_bits,
                "material": asdict(found.material),
                "tests": [test.digest() for test in tests],
            }
        ),
    }  # fmt: skip


def _head(case: CalibrationCase) -> dict[str, Any]:
    """What is known before anything is run."""
    s = case.specimen
    return {
        "workflow": case.workflow,
        "title": case.title,
        "kind_of_result": "calibration: bonds of which specimens have the properties of a rock",
        "dimension": s.dimension,
        "specimen": {"packing": "random", "shape": s.shape, "across": s.across, "width_m": s.width},
        "targets": {
            name: (None if math.isnan(value) else value) for name, value in asdict(case.targets).items()
        },
        "seed": case.seed,
        "notices": list(case.notices),
        "warnings": list(case.questions),
        "steps": 0,
        "compile_time_s": 0.0,
    }
