"""A document as TOML text that reads back to the same document."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .table import join, quoted


def toml_text(document: Mapping[str, Any]) -> str:
    """The text: values of a table first, then the tables in it.

    Parameters
    ----------
    document : mapping
        Of texts, numbers, switches, lists and mappings, as `tomllib` reads them.
    """
    lines: list[str] = []
    _write(document, "", lines)
    return "\n".join(lines).lstrip("\n") + "\n"


def toml_value(value: Any) -> str:
    """One value, on one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{join('', key)} = {toml_value(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(inner) for inner in value) + "]"
    return repr(value) if isinstance(value, int | float) else str(value)


def _write(table: Mapping[str, Any], place: str, lines: list[str]) -> None:
    tables = {key: value for key, value in table.items() if isinstance(value, Mapping)}
    plain = {key: value for key, value in table.items() if key not in tables}
    if place and (plain or not tables):
        lines += ["", f"[{place}]"]
    lines += [f"{join('', key)} = {toml_value(value)}" for key, value in plain.items()]
    for key, value in tables.items():
        _write(value, join(place, key), lines)
