"""Reading one TOML table: typed access that collects every error instead of stopping at the first."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from geodem import units
from geodem.errors import InputError

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def join(place: str, key: str) -> str:
    """Dotted key below `place`, quoted where TOML needs quotes."""
    written = key if _BARE_KEY.fullmatch(key) else quoted(key)
    return f"{place}.{written}" if place else written


def quoted(text: str) -> str:
    """A TOML basic string."""
    escapes = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    # TOML forbids bare control characters, and surrogates cannot be written at all
    return '"' + "".join(escapes.get(c) or (c if c.isprintable() else f"\\U{ord(c):08x}") for c in text) + '"'


def nearest(word: str, known: Iterable[str]) -> str:
    """ "Did you mean ...? " with the nearest known word, or nothing."""
    folded = {k.lower().replace("-", "_"): k for k in known}
    near = difflib.get_close_matches(word.lower().replace("-", "_"), folded, n=1, cutoff=0.5)
    return f"Did you mean {quoted(folded[near[0]])}? " if near else ""


def listed(words: Iterable[str]) -> str:
    """Words for a sentence: "a", "b"."""
    return ", ".join(quoted(word) for word in words) or "none"


def places_of(value: object, place: str = "") -> list[str]:
    """Dotted places of everything in a document, in the order of the file."""
    found = [place] if place else []
    if isinstance(value, dict):
        for key, inner in value.items():
            found += places_of(inner, join(place, key))
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            if isinstance(inner, dict | list):
                found += places_of(inner, f"{place}[{index}]")
    return found


class Findings:
    """What reading a case brings up.

    Parameters
    ----------
    document : mapping
        The parsed file; its order is the order of the errors.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.errors: list[InputError] = []
        self.notices: list[str] = []
        self.questions: list[str] = []
        self.allowed: tuple[str, ...] = ()
        self.asked: set[str] = set()
        self._order = {place: index for index, place in enumerate(places_of(dict(document)))}

    def error(self, place: str, problem: str, remedy: str, *, value: object = None) -> None:
        """Keep an error and read on."""
        self.errors.append(InputError(place, problem, remedy, value=units.short(value)))

    def default(self, place: str, shown: str, *, why: str = "") -> None:
        """Note a default that was taken."""
        self.notices.append(f"{place} is not given: {shown} is used{f' ({why})' if why else ''}.")

    def implausible(self, place: str, problem: str, remedy: str, *, value: object = None) -> None:
        """An error unless the case says that the value is meant; then a notice."""
        self.asked.add(place)
        if place in self.allowed:
            shown = "" if value is None else f" = {value}"
            self.notices.append(f"{place}{shown}: {problem}; allowed by allow_implausible.")
        else:
            consent = f"If it is meant, add allow_implausible = [{quoted(place)}] at the top of the file."
            self.error(place, problem, f"{remedy} {consent}", value=value)

    def in_order(self) -> list[InputError]:
        """The errors in the order of the file; what is missing comes with the table that lacks it."""

        def position(error: InputError) -> int:
            place = error.place
            for end in range(len(place), 0, -1):
                if place[:end] in self._order and place[end : end + 1] in {"", ".", "["}:
                    return self._order[place[:end]]
            return -1

        return sorted(self.errors, key=position)


class Table:
    """One table of the file.

    Parameters
    ----------
    findings : Findings
    place : str
        Dotted key of the table, "" for the file itself.
    content : mapping
    known : tuple of str
        The keys it may have; others are reported at once.
    """

    def __init__(
        self, findings: Findings, place: str, content: Mapping[str, Any], known: tuple[str, ...]
    ) -> None:
        self.findings = findings
        self.place = place
        self.content = content
        where = (
            f"in [{place}]" if place and "[" not in place else f"in {place}" if place else "at the top level"
        )
        for key in content:
            if key not in known:
                remedy = f"{nearest(key, known)}Known {where}: {', '.join(known)}."
                findings.error(self.at(key), "unknown key", remedy)

    def __contains__(self, key: str) -> bool:
        return key in self.content

    def at(self, key: str) -> str:
        """Dotted key of an entry."""
        return join(self.place, key)

    def error(self, key: str, problem: str, remedy: str) -> None:
        """Keep an error about an entry."""
        self.findings.error(self.at(key), problem, remedy, value=self.content.get(key))

    def missing(self, key: str, remedy: str) -> None:
        """Keep an error about an entry that must be given."""
        self.findings.error(self.at(key), "missing", remedy)

    def quantity(
        self, key: str, dimension: str, *, check: Callable[[float], tuple[str, str] | None] | None = None
    ) -> float | None:
        """SI value, or None where the key is missing or wrong (which has then been reported).

        `check` gets the value and returns problem and remedy where it cannot be used.
        """
        if key not in self.content:
            return None
        try:
            value = units.parse(self.content[key], dimension, place=self.at(key))
        except InputError as error:
            self.findings.errors.append(error)
            return None
        wrong = check(value) if check else None
        if wrong:
            self.error(key, *wrong)
            return None
        return value

    def integer(self, key: str, *, smallest: int, remedy: str) -> int | None:
        """Whole number from `smallest` to what 63 bits hold, or None."""
        if key not in self.content:
            return None
        value = self.content[key]
        if isinstance(value, bool) or not isinstance(value, int):
            what = (
                units.describe(value)
                if not isinstance(value, float)
                else "a number with a point or an exponent"
            )
            if isinstance(value, float) and math.isfinite(value) and value.is_integer() and abs(value) < 1e15:
                remedy = f"Write {int(value)}."
            self.error(key, f"a whole number is needed here, not {what}", remedy)
            return None
        if not smallest <= value < 2**63:
            bound = f"below {smallest}" if value < smallest else "too large"
            self.error(key, f"this is {bound}", remedy)
            return None
        return value

    def text(self, key: str, *, remedy: str) -> str | None:
        """Text that is not empty, or None."""
        if key not in self.content:
            return None
        value = self.content[key]
        if not isinstance(value, str) or not value.strip():
            what = "empty" if isinstance(value, str) else f"{units.describe(value)}, and text is needed"
            self.error(key, f"this is {what}", remedy)
            return None
        return value

    def choice(self, key: str, options: tuple[str, ...], *, default: str | None = None) -> str | None:
        """One of `options`; the default is noted; None where wrong."""
        if key not in self.content:
            if default is not None:
                self.findings.default(self.at(key), quoted(default))
            return default
        value = self.content[key]
        if isinstance(value, str) and value in options:
            return value
        hint = nearest(value, options) if isinstance(value, str) else ""
        self.error(key, "this is not one of the choices", f"{hint}Write one of {listed(options)}.")
        return None

    def items(self, key: str, *, example: str) -> list[Any]:
        """A list, empty where missing or wrong."""
        value = self.content.get(key, [])
        if not isinstance(value, list):
            self.error(
                key, f"a list is needed here, not {units.describe(value)}", f"Write {key} = {example}."
            )
            return []
        return value

    def sub(self, key: str, known: tuple[str, ...], *, example: str) -> Table | None:
        """A table below this one, or None where missing or wrong."""
        if key not in self.content:
            return None
        value = self.content[key]
        if not isinstance(value, dict):
            self.error(key, f"a table is needed here, not {units.describe(value)}", f"Write {example}.")
            return None
        return Table(self.findings, self.at(key), value, known)

    def rows(self, key: str, known: tuple[str, ...], *, example: str) -> list[Table]:
        """A list of tables; entries that are none are reported and left out."""
        found = []
        for index, value in enumerate(self.items(key, example=f"[{example}]")):
            place = f"{self.at(key)}[{index}]"
            if isinstance(value, dict):
                found.append(Table(self.findings, place, value, known))
            else:
                problem = f"a table is needed here, not {units.describe(value)}"
                self.findings.error(place, problem, f"Write {example}.", value=value)
        return found
