"""The file of a case as text and as TOML, whatever it is a case of; and the values that it says are meant."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geodem import units
from geodem.case.table import Findings, Table, nearest, places_of
from geodem.errors import InputError
from geodem.kinds import KINDS

_DEEPEST = 20  # tables in tables; a case has five
_BEGIN = "`geodem new slope DIR` writes a case to begin with."


def read_text(path: Path | str, *, what: str = "case") -> tuple[str, Path]:
    """Text of a file, and the folder that paths in it are relative to.

    Parameters
    ----------
    path : pathlib.Path
        A .toml file; of a case also the folder that holds case.toml.
    what : str
        What the file is, for the messages.

    Raises
    ------
    InputError
        The file cannot be found or read, or is no UTF-8.
    """
    path = Path(path)
    begin = f" {_BEGIN}" if what == "case" else ""
    try:
        if what == "case" and path.is_dir():
            path = path / "case.toml"
        content = path.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(str(path), f"there is no such {what} file", f"Check the path.{begin}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(
            str(path), f"the {what} file cannot be read ({reason})", "Check the path and its permissions."
        ) from None
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        problem = f"line {line} is not UTF-8 text"
        raise InputError(str(path), problem, "Save the file as UTF-8.") from None
    return text, path.parent


def parse_document(text: str, *, what: str = "case") -> dict[str, Any]:
    """The parsed TOML.

    Raises
    ------
    InputError
        The text is no TOML.
    """
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        # "Cannot overwrite a value (at line 3, column 5)"
        message, _, where = str(error).rstrip(")").partition(" (at ")
        line = _line_of(text, where)
        raise InputError(
            f"{what} file, {where}" if where else f"{what} file", f"this is not TOML: {message}",
            _mend(text, line), value=units.short(line) if line else None,
        ) from None  # fmt: skip
    except (ValueError, RecursionError):
        raise InputError(
            f"{what} file", "a number is too long or lists are nested too deep", "Shorten it."
        ) from None
    level: list[Any] = [document]
    for _ in range(_DEEPEST):
        level = [inner for value in level for inner in (value.values() if isinstance(value, dict) else value)]
        level = [value for value in level if isinstance(value, dict | list)]
    if level:
        raise InputError(
            f"{what} file",
            f"tables are nested more than {_DEEPEST} deep",
            f"A case has five levels. {_BEGIN}",
        )
    return document


def _line_of(text: str, where: str) -> str:
    """The line that "line 3, column 5" means."""
    number = re.match(r"line ([0-9]+)", where)
    lines = text.split("\n")
    return lines[int(number[1]) - 1].strip() if number and int(number[1]) <= len(lines) else ""


def _mend(text: str, line: str) -> str:
    """What to do about a line that is not TOML."""
    if set(line) & set("“”„‟«»‘’"):
        return 'Write straight quotes: "10 kPa".'
    if "\r" in text.replace("\r\n", ""):
        return "Save the file with the line ends of Unix or Windows."
    return "Mend this place; text stands in quotes, a table begins with [name], and each key stands once."


def refuse_other(document: Mapping[str, Any], workflow: str) -> None:
    """Raise InputError where a case is of another kind that there is, and say which command is for it."""
    found = document.get("workflow")
    if isinstance(found, str) and found in KINDS and found != workflow:
        remedy = f"Run it with: {KINDS[found].command} CASE"
        raise InputError("workflow", f'a case of "{workflow}" is needed here', remedy, value=found)


def read_allowed(top: Table) -> None:
    """Take allow_implausible, the keys whose value is meant although it looks mistaken."""
    allowed = []
    for index, value in enumerate(top.items("allow_implausible", example='["material.soil.density"]')):
        if isinstance(value, str):
            allowed.append(value)
        else:
            problem = f"the text of a key is needed here, not {units.describe(value)}"
            remedy = 'Write allow_implausible = ["material.soil.density"].'
            top.findings.error(f"allow_implausible[{index}]", problem, remedy, value=value)
    top.findings.allowed = tuple(dict.fromkeys(allowed))


def check_allowed(findings: Findings, document: dict[str, Any]) -> None:
    """Every key that allow_implausible names is one of this case, and needs it."""
    known = dict.fromkeys([*places_of(document), *findings.asked])
    for place in findings.allowed:
        if place not in known:
            remedy = f'{nearest(place, known)}Write the full key, as in "material.soil.density".'
            findings.error("allow_implausible", "no such key in this case", remedy, value=place)
        elif place not in findings.asked:
            findings.notices.append(f"allow_implausible: {place} is plausible and needs no permission.")
