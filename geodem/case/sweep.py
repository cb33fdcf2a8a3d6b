"""A sweep: one case of any kind over values of its keys."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..errors import InputError, InputErrors
from ..io.checkpoint import checksum
from ..kinds import KINDS, AnyCase, Kind
from .document_places import put, steps_of
from .sweep_files import digests, mirrored, named_files
from .toml_text import toml_text, toml_value


@dataclass(frozen=True)
class SweepRun:
    """One run of a sweep.

    Attributes
    ----------
    number : int
        From 1.
    values : mapping of str to object
        Value of every varied key, as TOML has it.
    """

    number: int
    values: Mapping[str, Any]

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"{self.number:04d}"

    @property
    def told(self) -> str:
        """Its values in words."""
        return ", ".join(f"{key} = {toml_value(value)}" for key, value in self.values.items())


@dataclass(frozen=True, eq=False)
class SweepCase:
    """A case and the values that it is run with.

    Attributes
    ----------
    title : str
    kind : str
        Of the case.
    base : mapping
        The document of the case.
    base_file : pathlib.Path
        The case file; paths in the case are relative to its folder.
    varied : mapping of str to tuple
        Values of every varied key.
    together : tuple of tuple of str
        Keys that are varied together: the first value of one with the first of the other.
    listed : tuple of mapping
        Values of keys that a file names, one entry a run.
    list_file : pathlib.Path or None
    table : mapping of str to str
        What is tabulated: name with unit, place in result.json.
    default_table : bool
        It is that of the kind; what no run has is left out.
    runs : tuple of SweepRun
    processes : int or None
        Runs at a time; as many as cores where None.
    threads : int or None
        Of a run; cores over processes where None.
    allow_runs : int or None
        So many runs are meant.
    notices, questions : tuple of str
    text : str
        The file.
    """

    title: str
    kind: str
    base: Mapping[str, Any]
    base_file: Path
    varied: Mapping[str, tuple[Any, ...]]
    together: tuple[tuple[str, ...], ...]
    table: Mapping[str, str]
    runs: tuple[SweepRun, ...]
    default_table: bool = False
    listed: tuple[Mapping[str, Any], ...] = ()
    list_file: Path | None = None
    processes: int | None = None
    threads: int | None = None
    allow_runs: int | None = None
    allow_implausible: tuple[str, ...] = field(default=())
    notices: tuple[str, ...] = field(default=())
    questions: tuple[str, ...] = field(default=())
    text: str = ""
    workflow: str = "sweep"

    @property
    def of(self) -> Kind:
        """The kind of its case."""
        return KINDS[self.kind]

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys that are varied, the slowest first."""
        return tuple(self.runs[0].values)

    def document(self, run: SweepRun) -> dict[str, Any]:
        """The case of a run, as TOML has it; raises InputError where the case has no such key."""
        document = copy.deepcopy(dict(self.base))
        # the name of its folder, which would stand in for it, is another one in the folder of the sweep
        document.setdefault("title", self.title)
        for key, value in run.values.items():
            place = f"vary.{key}"
            put(document, steps_of(key, at=place), copy.deepcopy(value), at=place)
        return document

    def read(self, run: SweepRun) -> AnyCase:
        """The case of a run; raises InputError, InputErrors."""
        return self.of.parse(toml_text(self.document(run)), self.base_file.parent)

    def identity(self, run: SweepRun, quickly: bool) -> str:
        """Of a run: its case and what is in the files that this names, whatever the version."""
        document = self.document(run)
        held = {
            "case": toml_text(document),
            "quick": quickly,
            "files": digests(document, self.base_file.parent),
        }
        return checksum(held)

    def beside(self) -> tuple[SweepCase, dict[str, Path]]:
        """The same with its case in a folder "source" beside it, and where all that is in there comes from."""
        values = [*self.varied.values(), *self.listed]
        names = named_files([self.base, values], self.base_file.parent)
        place, copies = mirrored(self.base_file, names)
        listed = None
        if self.list_file is not None:
            listed = Path("source") / f"runs-{self.list_file.name.removeprefix('runs-')}"
            copies[str(listed)] = self.list_file
        return replace(self, base_file=place, list_file=listed), copies

    def as_run_text(self) -> str:
        """The sweep as it is run, as TOML."""
        head: dict[str, Any] = {"workflow": self.workflow, "title": self.title, "case": str(self.base_file)}
        if self.list_file is not None:
            head["runs"] = str(self.list_file)
        for name in ("processes", "threads", "allow_runs"):
            if getattr(self, name) is not None:
                head[name] = getattr(self, name)
        if self.together:
            head["together"] = [list(keys) for keys in self.together]
        tables = {
            "vary": {key: list(values) for key, values in self.varied.items()},
            "table": dict(self.table),
        }
        return toml_text({**head, **{name: table for name, table in tables.items() if table}})


def judge(case: SweepCase) -> None:
    """Read the case of every run, so that all that is wrong is known before anything is run.

    Raises
    ------
    InputErrors
        What is wrong, once for every value that brings it up.
    """
    found: dict[tuple[str, str, str], InputError] = {}
    for run in case.runs:
        for fault in _faults(case, run):
            found.setdefault((fault.place, str(fault.value), fault.problem), _of_run(fault, run))
    if found:
        raise InputErrors(list(found.values()))


def _faults(case: SweepCase, run: SweepRun) -> list[InputError]:
    try:
        case.read(run)
    except InputErrors as errors:
        return errors.errors
    except InputError as error:
        return [error]
    return []


def _of_run(error: InputError, run: SweepRun) -> InputError:
    """An error of a varied key at that key, any other with the run that it is of."""
    if error.place.startswith("vary."):
        return error
    place, problem = f"case, {error.place}", f"{error.problem} (with {run.told})"
    if error.place in run.values:
        place, problem = f"vary.{error.place}", error.problem
    elif any(error.place.startswith((f"{key}.", f"{key}[")) for key in run.values):
        place, problem = f"vary, {error.place}", error.problem
    remedy = error.remedy.replace("at the top of the file", "at the top of the case")
    return InputError(place, problem, remedy, value=error.value)
