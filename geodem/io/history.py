"""History of a run as comma-separated text: one header with units, one line per record, flushed at once."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from geodem.errors import InputError
from geodem.io.files import cannot_write, write_whole

COLUMNS = ("step [-]", "factor [-]", "unbalanced force ratio [-]", "mean displacement [m]")
"""Columns of a trial's history; a name always ends with its unit in brackets."""


class HistoryWriter:
    """Append records to a history file.

    Parameters
    ----------
    path : path
    columns : sequence of str
        Names with units, such as ``"mean displacement [m]"``.
    append : bool
        Go on with a file that has the same columns (a resumed run); a last line that an interrupted run left
        unfinished is cut off. Without it, or where there is no file, a new one is begun.

    Raises
    ------
    InputError
        The file cannot be written, or has other columns.
    """

    def __init__(self, path: Path | str, columns: Sequence[str] = COLUMNS, *, append: bool = False) -> None:
        self.path = Path(path)
        self.columns = tuple(columns)
        for name in self.columns:
            if not name.endswith("]") or " [" not in name:
                raise ValueError(f"history column without a unit: {name!r}")
        self._stream: TextIO | None = None
        if append and self.path.exists():
            self._mend()
        else:
            write_whole(self.path, _line(self.columns))
        try:
            self._stream = self.path.open("a", encoding="utf-8", newline="")
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def write(self, *values: object) -> None:
        """Append one record, values in the order of the columns; on disk when this returns.

        Numbers are written so that reading them gives the same bits. After `close` this is an error.
        """
        if len(values) != len(self.columns):
            raise ValueError(f"{len(values)} values for {len(self.columns)} columns of {self.path}")
        if self._stream is None:
            raise ValueError(f"{self.path} is closed")
        try:
            self._stream.write(_line([_text(value) for value in values]))
            self._stream.flush()
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def close(self) -> None:
        """Close the file; may be called again."""
        stream, self._stream = self._stream, None
        if stream is None:
            return
        try:
            stream.close()
        except OSError as error:
            raise cannot_write(self.path, error) from error

    def __enter__(self) -> HistoryWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _mend(self) -> None:
        """Check the columns of the file to go on with and cut off a line that was not finished."""
        try:
            content = self.path.read_bytes()
        except OSError as error:
            raise cannot_write(self.path, error) from error
        whole = content[: content.rfind(b"\n") + 1]
        if not whole:
            write_whole(self.path, _line(self.columns))
            return
        header = whole.split(b"\n", 1)[0].decode("utf-8", errors="replace")
        if tuple(next(csv.reader([header]))) != self.columns:
            raise InputError(
                str(self.path),
                f"has the columns '{header}', not '{','.join(self.columns)}'",
                "Move the file away or choose another folder with --out.",
            )
        if len(whole) < len(content):
            write_whole(self.path, whole)


def write_history(path: Path | str, columns: Sequence[str], records: Iterable[Sequence[object]]) -> None:
    """Write a whole history at once, as `HistoryWriter` would line by line.

    Raises
    ------
    InputError
        The file cannot be written; what stood there is untouched.
    """
    lines = [_line(columns), *(_line([_text(value) for value in record]) for record in records)]
    write_whole(path, "".join(lines))


def continued_history(
    path: Path | str, columns: Sequence[str], records: Iterable[Sequence[object]]
) -> HistoryWriter:
    """A history that holds what a run has kept, to be gone on with line by line.

    Raises
    ------
    InputError
        The file cannot be written; what stood there is untouched.
    """
    write_history(path, columns, records)
    return HistoryWriter(path, columns, append=True)


def cut_history(path: Path | str, last: float) -> float:
    """Drop the records whose first value is above `last`; returns that of the last one kept, -inf where there is none.

    Raises
    ------
    InputError
        The file cannot be read or written.
    """
    path = Path(path)
    try:
        header, *records = path.read_bytes().decode("utf-8").splitlines(keepends=True)
        firsts = [float(record.split(",", 1)[0]) for record in records]
    except (OSError, ValueError) as error:
        raise InputError(str(path), f"cannot be read ({error})", "Move the file away.") from error
    kept = [record for record, first in zip(records, firsts, strict=True) if first <= last]
    if len(kept) < len(records):
        write_whole(path, "".join([header, *kept]))
    return max((first for first in firsts if first <= last), default=-math.inf)


def read_history(path: Path | str) -> Mapping[str, NDArray]:
    """Read a history file.

    Parameters
    ----------
    path : path

    Returns
    -------
    dict of str to array
        By column name with unit, in the file's order: float64 where every entry is a number, text otherwise.
        A last line without its end, left by an interrupted run, is not read.

    Raises
    ------
    InputError
        No such file, or a line whose number of values is not that of the header.
    """
    path = Path(path)
    try:
        text = path.read_bytes().decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(str(path), f"cannot be read ({error})", "Give the history.csv of a run.") from error
    rows = list(csv.reader(text[: text.rfind("\n") + 1].splitlines()))
    if not rows:
        raise InputError(str(path), "is empty", "Give the history.csv of a run.")
    header, records = rows[0], rows[1:]
    for number, record in enumerate(records, start=2):
        if len(record) != len(header):
            raise InputError(
                f"{path}, line {number}",
                f"has {len(record)} values where the header names {len(header)}",
                "Remove the line or run the case again.",
            )
    return {name: _column([record[place] for record in records]) for place, name in enumerate(header)}


def _column(entries: list[str]) -> NDArray:
    try:
        return np.array([float(entry) for entry in entries], dtype=np.float64)
    except ValueError:
        return np.array(entries, dtype=str)


def _text(value: object) -> str:
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    return str(value)


def _line(values: Sequence[str]) -> str:
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerow(values)
    return buffer.getvalue()
