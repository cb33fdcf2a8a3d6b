"""A sweep, from its text: the case, the values, the runs that come of them; every error at once."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..kinds import KINDS, kind_of
from .document import parse_document, read_text
from .document_places import steps_of
from .head import CaseHead, read_head
from .source_files import find_file
from .sweep import SweepCase, SweepRun, judge
from .sweep_values import EXAMPLE, read_list, read_varied
from .table import Table, listed, nearest

KEYS = (
    "workflow", "title", "case", "vary", "together", "runs", "table", "processes", "threads", "allow_runs",
    "allow_implausible",
)  # fmt: skip
MANY = 1000
"""Runs beyond which a sweep must say that so many are meant."""
MOST_PROCESSES = 1000
MOST = 100_000
"""Runs of a sweep, meant or not: every one is read before anything is run."""


def load_sweep(path: Path | str) -> SweepCase:
    """Read a sweep: a file, or a folder that holds case.toml; raises as `parse_sweep`."""
    return parse_sweep(*read_text(path))


def load_unjudged(path: Path | str) -> SweepCase:
    """Read a sweep as `load_sweep`, without a look at the cases of its runs: for one of them, or for none."""
    return read_sweep(*read_text(path))


def parse_sweep(text: str, folder: Path) -> SweepCase:
    """Read a sweep from its text, and the case of every run.

    Parameters
    ----------
    text : str
        TOML.
    folder : pathlib.Path
        What the path of its case is relative to.

    Raises
    ------
    InputError
        The text is no TOML, or a case of another workflow.
    InputErrors
        All that is wrong in it, in its order; or else all that is wrong in the case of any run.
    """
    case = read_sweep(text, folder)
    judge(case)
    return case


def read_sweep(text: str, folder: Path) -> SweepCase:
    """As `parse_sweep`, without a look at the cases of the runs."""
    head = read_head(text, folder, "sweep", KEYS, example="Cohesion and friction")
    top, findings = head.top, head.findings
    base_file, base = _base(top, folder)
    varied = read_varied(top)
    list_file = find_file(top, "runs", folder) if "runs" in top else None
    rows = read_list(list_file, findings) if list_file is not None else []
    together = _together(top, varied)
    processes = top.integer("processes", smallest=1, remedy="Write a whole number such as 2.")
    if processes is not None and processes > MOST_PROCESSES:
        top.error(
            "processes", f"no machine does so many at a time ({MOST_PROCESSES:,} at most)", "Leave it out."
        )
    threads = top.integer("threads", smallest=1, remedy="Write a whole number such as 1.")
    table = _table(top, base)
    if not varied and "vary" not in top and "runs" not in top:
        top.missing("vary", f"Add [vary] with a key of the case and its values: KEY = {EXAMPLE}.")
    allowed = top.integer("allow_runs", smallest=1, remedy="Write how many runs are meant.")
    if allowed is not None and allowed > MOST:
        top.error("allow_runs", f"no sweep has more than {MOST:,} runs", "Make several sweeps of it.")
    runs = _runs(head, varied, together, rows, allowed)
    common = head.close()
    assert base_file is not None
    assert base is not None
    kind = kind_of(base)
    # that of the kind stands in the file of a sweep as it is run
    default = "table" not in top or table == kind.table
    return SweepCase(
        **common, kind=kind.name, base=base, base_file=base_file, varied=varied, together=together,
        table=table, default_table=default, runs=runs, listed=tuple(rows), list_file=list_file,
        processes=processes, threads=threads, allow_runs=allowed,
    )  # fmt: skip


def _base(top: Table, folder: Path) -> tuple[Path | None, dict[str, Any] | None]:
    """The case that is varied: its file, and its document."""
    if "case" not in top:
        top.missing("case", 'Write case = "slope.toml": a case file, or the folder that holds its case.toml.')
        return None, None
    name = top.text("case", remedy='Write case = "slope.toml".')
    if name is None:
        return None, None
    place = folder / name
    try:
        text, beside = read_text(place)
        document = parse_document(text)
    except InputError as error:
        top.findings.error("case", error.problem, error.remedy, value=name)
        return None, None
    if kind_of(document).name == "sweep":
        top.error("case", "this is a sweep, too", "Vary all keys in one sweep, as a grid.")
        return None, None
    return beside / (place.name if place.is_file() else "case.toml"), document


def _together(top: Table, varied: Mapping[str, Sequence[Any]]) -> tuple[tuple[str, ...], ...]:
    example = '[["material.soil.cohesion", "material.soil.friction_angle"]]'
    found: list[tuple[str, ...]] = []
    for index, keys in enumerate(top.items("together", example=example)):
        place = f"together[{index}]"
        if not isinstance(keys, list) or len(keys) < 2 or not all(isinstance(key, str) for key in keys):
            top.findings.error(
                place, "a list of two keys at least is needed here", f"Write together = {example}."
            )
            continue
        unknown = [key for key in keys if key not in varied]
        taken = [key for key in keys if any(key in group for group in found)]
        for key in unknown:
            hint = f"{nearest(key, varied)}Varied are: {listed(varied)}."
            top.findings.error(place, "this key is not varied", hint, value=key)
        for key in taken:
            top.findings.error(
                place, "this key goes together with others already", "Name it once.", value=key
            )
        lengths = {key: len(varied[key]) for key in keys if key not in unknown}
        if len(set(lengths.values())) > 1:
            told = ", ".join(f"{key} has {length}" for key, length in lengths.items())
            top.findings.error(place, f"the lists are not equally long: {told}", "Give each as many values.")
        elif not unknown and not taken:
            found.append(tuple(keys))
    return tuple(found)


def _table(top: Table, base: Mapping[str, Any] | None) -> dict[str, str]:
    """What is tabulated; what the kind of the case has where nothing is said."""
    if "table" not in top:
        default = {} if base is None else dict(KINDS[kind_of(base).name].table)
        if default:
            top.findings.default("table", ", ".join(default))
        return default
    content = top.content["table"]
    example = '[table] with "factor of safety [-]" = "factors[kind=strength-reduction].value"'
    if not isinstance(content, dict):
        top.error("table", "a table is needed here", f"Write {example}.")
        return {}
    found = {}
    table = Table(top.findings, "table", content, tuple(content))
    for name in content:
        place = table.text(name, remedy=f"Write {example}.")
        if not (name.endswith("]") and " [" in name):
            table.error(
                name, "this name has no unit", f'Write "{name} [-]", or the unit that result.json has.'
            )
        if place is None:
            continue
        try:
            steps_of(place, at=table.at(name))
        except InputError as error:
            top.findings.errors.append(error)
        found[name] = place
    return found


def _runs(
    head: CaseHead,
    varied: Mapping[str, tuple[Any, ...]],
    together: Sequence[tuple[str, ...]],
    rows: Sequence[Mapping[str, Any]],
    allowed: int | None,
) -> tuple[SweepRun, ...]:
    """The grid: every value of every key with every one of the others, the last key the fastest."""
    both = [key for key in varied if rows and key in rows[0]]
    for key in both:
        head.findings.error(f"vary.{key}", "the file of runs has this key, too", "Keep one of the two.")
    groups: list[list[dict[str, Any]]] = [[dict(row) for row in rows]] if rows else []
    done: set[str] = set()
    for key in varied:
        if key in done:
            continue
        keys = next((group for group in together if key in group), (key,))
        done.update(keys)
        groups.append(
            [dict(zip(keys, values, strict=True)) for values in zip(*(varied[k] for k in keys), strict=True)]
        )
    count = 1
    for group in groups:
        count *= len(group)
    if count > max(MANY, allowed or 0):
        head.findings.error(
            "vary",
            f"this makes {count:,} runs",
            f"Give fewer values; or, if it is meant, add allow_runs = {count}.",
        )
    if head.findings.errors:
        return ()
    order = itertools.product(*groups)
    return tuple(
        SweepRun(number, {key: value for part in parts for key, value in part.items()})
        for number, parts in enumerate(order, start=1)
    )
