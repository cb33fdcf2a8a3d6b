"""Run a laboratory case in its folder: every test on every specimen, several at a time, each kept as it is finished."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from .case.laboratory import LaboratoryCase
from .errors import InputError
from .io.checkpoint import checksum
from .io.files import read_json
from .io.history import write_history
from .io.run_folder import RunFolder
from .laboratory import pace as paces
from .laboratory.entries import envelope_entry, group_entry, material_entry, property_entry
from .laboratory.files import HISTORY_COLUMNS, history_line, write_tests
from .laboratory.orders import FinishedTest, TestOrder, find_test, specimen_of
from .laboratory.specimen import COARSE
from .laboratory.summary import group_tests, material_properties, summarise_envelope
from .laboratory.workers import Overview, Workers, workers_allowed
from .plotting.laboratory_report import write_laboratory_report

QUICK_ACROSS = 16.0
QUICK_SEEDS = 2
QUICK_PACE = 0.5
"""Of a quick run: particles across, specimens, and share of the pace."""

WRITTEN = ("tests/*.h5", "curves/*.csv", "figures/*.png", "particles-*.vtkhdf", "cracks-*.vtkhdf")
"""What a run writes beside the files of every run."""

Watch = Callable[[Overview], None]


def run_laboratory(
    case: LaboratoryCase,
    out: Path,
    *,
    threads: int | None = None,
    quickly: bool = False,
    overwrite: bool = False,
    watch: Watch | None = None,
    stop_asked: Callable[[], bool] | None = None,
    command: str = "",
) -> dict[str, Any]:
    """Run a laboratory case and write its folder; tests that are finished there are not made again.

    Parameters
    ----------
    case : LaboratoryCase
    out : pathlib.Path
        Folder of the results.
    threads : int, optional
        Tests that run at a time, each on one thread; as many as cores if left out. The bits do not depend on it.
    quickly : bool
        Coarse specimens, two of each, loaded twice as fast: for a first look.
    overwrite : bool
        Replace the results of another case in that folder.
    watch : callable, optional
        Is given an `Overview` now and then.
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
        `stop_asked` said so; the same call goes on.
    """
    case = quick(case) if quickly else case
    orders = orders_of(case, quickly)
    _check(case, orders)
    run = RunFolder(out, case.as_run_text(), _identity(orders), written=WRITTEN)
    if run.claim(overwrite=overwrite):
        stored = run.stored()
        if stored["status"] == "done" and _all_there(orders, out):
            return stored
    count = workers_allowed(threads)
    facts = {"quick": quickly, "threads": count, "command": command}

    def partial() -> dict[str, Any]:
        tests = _finished(orders, out)
        result = run.whole(assemble(case, tests) | facts, "stopped")
        draw_laboratory(out, result, tests, run.case_text)
        return result

    with run.going(assemble(case, []) | facts, partial):
        growing = _growing_history(orders, out, watch)
        with Workers(count, out / "tests", watch=growing, stop_asked=stop_asked) as workers:
            workers.run(orders)
        tests = _finished(orders, out)
        result = run.whole(assemble(case, tests) | facts)
        draw_laboratory(out, result, tests, run.case_text)
        return run.finish(result)


def _growing_history(orders: Sequence[TestOrder], folder: Path, watch: Watch | None) -> Watch:
    """A watch that writes history.csv anew with every test that ends, and passes on what it is told."""
    lines = {test.order.name: history_line(test) for test in _finished(orders, folder)}

    def told(overview: Overview) -> None:
        if overview.last is not None:
            lines[overview.last.order.name] = history_line(overview.last)
            known = [lines[order.name] for order in orders if order.name in lines]
            write_history(folder / "history.csv", HISTORY_COLUMNS, known)
        if watch is not None:
            watch(overview)

    return told


def resume_laboratory(folder: Path, case: LaboratoryCase, **options: Any) -> dict[str, Any]:
    """Go on with a stopped run; `case` is the one in its folder, options and errors as of `run_laboratory`."""
    stored = read_json(folder / "result.json") or {}
    if stored.get("identity") != _identity(orders_of(*_as_run(case, stored))):
        raise InputError(
            str(folder / "case.toml"), "the case was changed since the run was begun",
            "Run it into another folder: geodem lab CASE --out DIR",
        )  # fmt: skip
    return run_laboratory(case, folder, quickly=bool(stored.get("quick")), **options)


def redraw_laboratory(folder: Path, case: LaboratoryCase) -> Path:
    """Make report, figures, curves and frames again from the finished tests; returns the report's path.

    Raises
    ------
    InputError
        No test of this case, by this version, is there.
    """
    stored = read_json(folder / "result.json") or {}
    case, quickly = _as_run(case, stored)
    tests = _finished(orders_of(case, quickly), folder)
    if not tests:
        raise InputError(
            str(folder / "tests"), "there is no finished test of this case and this version of geodem",
            f"Go on with: geodem resume {folder}",
        )  # fmt: skip
    draw_laboratory(folder, stored, tests, (folder / "case.toml").read_text(encoding="utf-8"))
    return folder / "report.html"


def _as_run(case: LaboratoryCase, stored: dict[str, Any]) -> tuple[LaboratoryCase, bool]:
    quickly = bool(stored.get("quick"))
    return (quick(case) if quickly else case), quickly


def orders_of(case: LaboratoryCase, quickly: bool = False) -> list[TestOrder]:
    """Every test of a case on every specimen."""
    common = case.specimen.arguments()
    # as the case that is written says it
    common["height"] = common["height"] or 2.0 * case.specimen.width
    pace = (QUICK_PACE if quickly else 1.0) * paces.PACE
    return [
        TestOrder(test.kind, {**common, "seed": case.seed + k}, case.material, stress=stress, pace=pace)
        for test in case.tests
        for stress in (test.stresses or (0.0,))
        for k in range(case.seeds)
    ]


def quick(case: LaboratoryCase) -> LaboratoryCase:
    """The case for a first look: coarse, and two specimens at most."""
    across = min(QUICK_ACROSS, case.specimen.across)
    seeds = min(QUICK_SEEDS, case.seeds)
    notice = (
        f"--quick: {across:g} particles across, {seeds} specimens of each test, loaded {1.0 / QUICK_PACE:g} times as "
        "fast: strengths come out some percent too high, and scatter more"
    )
    specimen = replace(case.specimen, across=across)
    return replace(case, specimen=specimen, seeds=seeds, notices=(*case.notices, notice))


def draw_laboratory(
    folder: Path, result: dict[str, Any], tests: Sequence[FinishedTest], case_text: str
) -> None:
    """Report, figures, history, curves and frames of tests that are finished."""
    write_history(folder / "history.csv", HISTORY_COLUMNS, map(history_line, tests))
    write_tests(folder, tests)
    write_laboratory_report(folder / "report.html", result, tests, case_text)


def assemble(case: LaboratoryCase, tests: Sequence[FinishedTest]) -> dict[str, Any]:
    """The content of result.json, but for what the run itself knows: its time, threads and command."""
    groups = group_tests(tests)
    warnings = [*case.questions, *specimen_warnings(case.specimen.across)]
    try:
        envelope = summarise_envelope(groups)
    except InputError as error:
        envelope = None
        warnings.append(f"no envelope: {error.problem}")
    for test in tests:
        warnings += [f"{test.order.name}: {text}" for text in test.record.warnings]
    return {
        "workflow": case.workflow,
        "title": case.title,
        "kind_of_result": "laboratory: quasi-static tests; stress and strain positive in compression",
        "particles": len(tests[0].radii) if tests else 0,
        "dimension": case.specimen.dimension,
        "specimen": {
            "packing": case.specimen.packing,
            "shape": case.specimen.shape,
            "across": case.specimen.across,
            "size_m": tests[0].size.tolist() if tests else [],
            "specimens": case.seeds,
        },
        "material": material_entry(case.material),
        "properties": {entry.key: property_entry(entry) for entry in material_properties(groups, envelope)},
        "tests": [group_entry(group) for group in groups],
        "envelope": None if envelope is None else envelope_entry(envelope),
        "cracks": {
            mode: sum(getattr(test.record.cracks, mode) for test in tests) for mode in ("tension", "shear")
        },
        "steps": sum(test.record.steps for test in tests),
        "compile_time_s": round(sum(test.compile_seconds for test in tests), 3),
        "test_time_s": round(sum(test.seconds for test in tests), 3),
        "seed": case.seed,
        "notices": list(case.notices),
        "warnings": warnings,
        "digest": checksum({"tests": [test.digest() for test in tests]}),
    }


def specimen_warnings(across: float) -> list[str]:
    """What must be known of a specimen that is coarse."""
    if across >= COARSE:
        return []
    return [
        f"{across:g} particles across: below {COARSE}, strength and friction depend on how many there are"
    ]


def _check(case: LaboratoryCase, orders: Sequence[TestOrder]) -> None:
    """What is wrong with a case is told before anything is written or run."""
    case.material.check()
    quickest = {2: "triangular", 3: "fcc"}[case.specimen.dimension]
    for order in {order.kind: order for order in orders}.values():
        # a random packing takes time, and is made of the same sizes
        specimen = dict(order.specimen)
        if specimen["packing"] == "random":
            specimen["packing"] = quickest
        specimen_of(replace(order, specimen=specimen))


def _identity(orders: Sequence[TestOrder]) -> str:
    """Of a case as it is run, whatever the version."""
    return checksum({"orders": [asdict(order) for order in orders]})


def _all_there(orders: Sequence[TestOrder], folder: Path) -> bool:
    there = (folder / "report.html").is_file()
    return there and len(_finished(orders, folder)) == len(orders)


def _finished(orders: Sequence[TestOrder], folder: Path) -> list[FinishedTest]:
    return [test for order in orders if (test := find_test(_file(folder, order), order)) is not None]


def _file(folder: Path, order: TestOrder) -> Path:
    return folder / "tests" / f"{order.name}.h5"
