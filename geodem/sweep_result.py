"""What came of a sweep: result.json and the table sweep.csv."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from . import units
from .case.document_places import steps_of, value_at
from .case.sweep import SweepCase, SweepRun
from .case.toml_text import toml_value
from .io.files import read_json, write_whole
from .sweep_record import RUNS, RunRecord, folder_of


def assemble(case: SweepCase, records: Mapping[int, RunRecord], out: Path) -> dict[str, Any]:
    """The content of result.json, but for what the run itself knows.

    Parameters
    ----------
    case : SweepCase
    records : mapping of int to RunRecord
        By number; runs that are not in it wait.
    out : pathlib.Path
        Folder of the sweep.
    """
    runs = [_row(case, run, records.get(run.number, RunRecord("waiting")), out) for run in case.runs]
    columns = list(case.table)
    if case.default_table:
        kept = [k for k in range(len(columns)) if any(row["values"][k] is not None for row in runs)]
        columns = [columns[k] for k in kept]
        for row in runs:
            row["values"] = [row["values"][k] for k in kept]
    failed = [row for row in runs if row["status"] == "failed"]
    warnings = [
        f"run {row['number']} failed ({row['told']}): {row['message'].strip().splitlines()[-1]}"
        for row in failed
    ]
    return {
        "workflow": case.workflow,
        "title": case.title,
        "kind_of_result": f"sweep: a case of the kind {case.kind}, run with several values",
        "of": case.kind,
        "total": len(runs),
        "finished": sum(row["status"] == "done" for row in runs),
        "failed": len(failed),
        "parameters": [_parameter(case, key) for key in case.keys],
        "columns": columns,
        "runs": runs,
        "run_time_s": round(sum(row["seconds"] for row in runs), 3),
        "notices": list(case.notices),
        "warnings": [*case.questions, *warnings],
    }


def write_table(path: Path, result: Mapping[str, Any]) -> None:
    """sweep.csv: a line a run; numbers of a parameter in the unit of its first value, which its name says.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    names = [f"{entry['key']} [{entry['unit'] or '-'}]" for entry in result["parameters"]]
    writer.writerow(["run [-]", *names, *result["columns"], "status [-]", "run time [s]"])
    for row in result["runs"]:
        values = [_cell(value) for value in (*row["parameters"], *row["values"])]
        writer.writerow([row["number"], *values, row["status"], _cell(row["seconds"])])
    write_whole(path, buffer.getvalue())


def _row(case: SweepCase, run: SweepRun, record: RunRecord, out: Path) -> dict[str, Any]:
    result = read_json(folder_of(run, out) / "result.json") if record.status == "done" else None
    values = [value_at(result, steps_of(place, at=name)) for name, place in case.table.items()]
    return {
        "number": run.number,
        "folder": f"{RUNS}/{run.name}",
        "told": run.told,
        "parameters": [_number(case, key, value) for key, value in run.values.items()],
        "values": [value if isinstance(value, int | float | str) else None for value in values],
        "status": record.status,
        "seconds": record.seconds,
        "message": record.message,
    }


def _parameter(case: SweepCase, key: str) -> dict[str, Any]:
    """A varied key: whether its values are numbers, and the unit that they are told in."""
    unit = _unit(case, key)
    return {"key": key, "unit": unit or "", "number": unit is not None}


def _unit(case: SweepCase, key: str) -> str | None:
    """Unit of the first value; None where the values are not numbers of one kind."""
    found = [units.split(value) for value in _values(case, key)]
    kinds = {None if each is None else each[2] for each in found}
    first = found[0]
    return first[1] if len(kinds) == 1 and first is not None else None


def _values(case: SweepCase, key: str) -> Sequence[Any]:
    return [run.values[key] for run in case.runs]


def _number(case: SweepCase, key: str, value: Any) -> Any:
    """A value as a number in the unit of its parameter, or as text."""
    unit = _unit(case, key)
    if unit is None:
        return value if isinstance(value, int | float | str) else toml_value(value)
    number, own, dimension = units.split(value) or ("", "", "")
    if own == unit:
        return float(number)
    return units.in_unit(units.parse(value, dimension, place=key), unit)


def _cell(value: Any) -> str:
    if value is None:
        return ""
    return repr(value) if isinstance(value, float) else str(value)
