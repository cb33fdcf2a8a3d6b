"""Places in a document: "material.soil.cohesion", "test[1].confinement", "factors[kind=strength-reduction].value"."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ..errors import InputError
from .table import join, nearest, quoted

_KEY = re.compile(r'([A-Za-z0-9_-]+)|"((?:[^"\\]|\\.)*)"')
_STEP = re.compile(r"\[(?:(-?[0-9]{1,9})|([A-Za-z0-9_-]+)=([^\]]+))\]")

Step = str | int | tuple[str, str]
"""A key, an index, or key and value of an entry of a list."""


def steps_of(place: str, *, at: str) -> tuple[Step, ...]:
    """The steps that lead to a place.

    Parameters
    ----------
    place : str
        Keys with points between them, in quotes where they hold others than letters, digits, "_" and "-"; behind one
        that names a list "[0]" for an entry (from 0, "[-1]" for the last one) or "[kind=name]" for the first entry of
        which the key `kind` is `name`.
    at : str
        Where the place is written, for the message.

    Raises
    ------
    InputError
        It cannot be read.
    """
    found: list[Step] = []
    rest = place.strip()
    while rest:
        key = _KEY.match(rest)
        if key is None:
            break
        found.append(key[1] if key[1] is not None else re.sub(r"\\(.)", r"\1", key[2]))
        rest = rest[key.end() :]
        while entry := _STEP.match(rest):
            found.append(int(entry[1]) if entry[1] is not None else (entry[2], entry[3].strip()))
            rest = rest[entry.end() :]
        if not rest.startswith("."):
            break
        rest = rest[1:]
        if not rest:
            rest = "."
            break
    if rest or not found:
        raise InputError(
            at, "this is no key", "Write the keys with points between them, as in material.soil.cohesion.",
            value=place,
        )  # fmt: skip
    return tuple(found)


def written(steps: tuple[Step, ...]) -> str:
    """A place as `steps_of` reads it."""
    place = ""
    for step in steps:
        if isinstance(step, str):
            place = join(place, step)
        else:
            place += f"[{step}]" if isinstance(step, int) else f"[{step[0]}={step[1]}]"
    return place


def value_at(document: Any, steps: tuple[Step, ...]) -> Any:
    """What stands at a place; None where there is nothing."""
    for step in steps:
        if isinstance(step, str):
            document = document.get(step) if isinstance(document, Mapping) else None
        else:
            index = _index(document, step) if isinstance(document, list) else None
            document = None if index is None else document[index]
    return document


def put(document: Any, steps: tuple[Step, ...], value: Any, *, at: str) -> None:
    """Set what stands at a place of which all but the last step is there.

    Raises
    ------
    InputError
        The tables or lists on the way are not there; `at` names the one who wants it.
    """
    inner = document
    for count, step in enumerate(steps[:-1], start=1):
        there = value_at(inner, (step,))
        if not isinstance(there, dict | list):
            raise _absent(inner, steps[:count], written(steps), at)
        inner = there
    last = steps[-1]
    if isinstance(last, str) and isinstance(inner, dict):
        inner[last] = value
    elif isinstance(inner, list) and not isinstance(last, str):
        index = _index(inner, last)
        if index is None:
            raise _absent(inner, steps, written(steps), at)
        inner[index] = value
    else:
        raise _absent(inner, steps, written(steps), at)


def _index(entries: list[Any], step: int | tuple[str, str]) -> int | None:
    if isinstance(step, int):
        return step if -len(entries) <= step < len(entries) else None
    key, wanted = step
    named = (
        k for k, entry in enumerate(entries) if isinstance(entry, Mapping) and str(entry.get(key)) == wanted
    )
    return next(named, None)


def _absent(inner: Any, steps: tuple[Step, ...], place: str, at: str) -> InputError:
    above = written(steps[:-1]) or "its top level"
    if isinstance(inner, list):
        known, hint = f"{len(inner)} entries, the first is [0]", ""
    elif isinstance(inner, dict):
        step = steps[-1]
        hint = nearest(step, inner) if isinstance(step, str) else ""
        known = ", ".join(join("", key) for key in inner) or "nothing"
    else:
        known, hint = "no table", ""
    return InputError(
        at, f"the case has no {written(steps)}",
        f"{hint}There is in {above}: {known}. A table that a run is to have must stand in the case.",
        value=quoted(place),
    )  # fmt: skip
