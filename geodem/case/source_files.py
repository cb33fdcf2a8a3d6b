"""What cases say of the files that ground is read from: their place, their unit, the names of their groups."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

from geodem import units
from geodem.case.table import Findings, Table, join, listed, nearest, quoted
from geodem.errors import InputError, InputErrors

LENGTH_UNITS = ("m", "mm", "cm", "km", "ft", "in")
MESH_KEYS = ("names", "material_array", "size")
"""Keys of a mesh or geometry beside its file and unit."""

Read = TypeVar("Read")


def find_file(table: Table, key: str, folder: Path, *, folders: bool = False) -> Path | None:
    """Absolute path of the file that `key` names, or None where there is none (which has then been told).

    `folders`: it may be a folder.
    """
    name = table.text(key, remedy=f'Write {key} = "name-of-the-file".')
    return None if name is None else existing(table, key, name, folder, folders=folders)


def existing(table: Table, key: str, name: str, folder: Path, *, folders: bool = False) -> Path | None:
    """As `find_file`, of a name that has been read."""
    path = Path(name)
    try:
        path = (path if path.is_absolute() else folder / path).resolve()
        folder_there = path.is_dir()
        found = path.is_file() or (folders and folder_there)
    except (OSError, ValueError, RuntimeError):  # a name too long, a zero byte, a link that leads to itself
        found = folder_there = False
    if found:
        return path
    if folder_there:
        table.error(key, "this is a folder, and a file is needed", f"Name a file in {name}.")
        return None
    what = "file or folder" if folders else "file"
    hint = nearest(name, [entry.name for entry in folder.iterdir()]) if folder.is_dir() else ""
    remedy = f"{hint}Its place is taken relative to the case file, in {folder}."
    table.error(key, f"there is no such {what}", remedy)
    return None


def metres(symbol: str | None) -> float | None:
    """Metres per unit."""
    return None if symbol is None else units.parse(f"1 {symbol}", "length", place="length_unit")


def read_names(table: Table) -> dict[int, str]:
    """Materials by the number of their group."""
    content = table.content.get("names")
    if content is None:
        return {}
    example = 'names = {1 = "clay", 2 = "sand"}'
    if not isinstance(content, dict):
        table.error("names", f"a table is needed here, not {units.describe(content)}", f"Write {example}.")
        return {}
    inner = Table(table.findings, table.at("names"), content, tuple(content))
    found = {}
    for key in content:
        name = inner.text(key, remedy=f"Name a material, as in {example}.")
        if not key.isdecimal():
            inner.error(key, "the number of a group is needed before the sign", f"Write {example}.")
        elif name is not None:
            found[int(key)] = name
    return found


def read_named_material(table: Table, key: str, example: str) -> str | None:
    """The name of a material, which must be there."""
    if key not in table:
        table.missing(key, f"Write {example}.")
    return table.text(key, remedy=f"Name a material, as in {example}.")


def read_lengths(table: Table, key: str, count: int, *, above_zero: bool = False) -> tuple[float, ...] | None:
    """Lengths with their units; None where they are left out or wrong."""
    if key not in table:
        return None
    places = ", ".join(['"0 m"'] * count)
    example = f"[{places}]" if key == "origin" else '["1 mm", "1 mm", "2 mm"]'
    entries = table.items(key, example=example)
    if len(entries) != count:
        if isinstance(table.content[key], list):
            table.error(key, f"{count} lengths are needed here", f"Write {key} = {example}.")
        return None
    row = Table(
        table.findings,
        table.at(key),
        {str(k): v for k, v in enumerate(entries)},
        tuple(map(str, range(count))),
    )
    values = [row.quantity(str(k), "length", check=_above_zero if above_zero else None) for k in range(count)]
    return tuple(v for v in values if v is not None) if None not in values else None


def _above_zero(value: float) -> tuple[str, str] | None:
    return None if value > 0.0 else ("this must be above zero", "Give a positive value.")


def read_or_tell(
    findings: Findings, place: str, read: Callable[[], Read], *, value: object, keys: Mapping[str, str] = {}
) -> Read | None:
    """What `read` returns; None where it raises an InputError, which is then told at `place`.

    `keys`: words in the places of the errors of what is read that are keys beside it.
    """
    try:
        return read()
    except InputErrors as error:
        findings.errors += error.errors
    except InputError as error:
        findings.errors.append(moved(error, place, value=value, keys=keys))
    return None


def moved(error: InputError, place: str, *, value: object = None, keys: Mapping[str, str] = {}) -> InputError:
    """The same error at a place of the case file."""
    named = error.place
    if named.startswith("/"):  # a file, and what of it
        named = named.rpartition(", ")[2] if ", " in named else ""
    for key, own in keys.items():
        found = re.search(rf"(?:^|[.,\s]){key}(?![\w/])(.*)$", named)
        if found:
            where = join(place.rsplit(".", 1)[0], own) + found[1]
            return InputError(where, error.problem, error.remedy, value=error.value, picture=error.picture)
    return InputError(place, error.problem, error.remedy, value=value, picture=error.picture)


def unnamed(place: str, name: str, found: tuple[str, ...], defined: tuple[str, ...]) -> InputError:
    """The error of a material of a file that has no table; both lists are told."""
    return InputError(
        place, f"the file has the material {quoted(name)}, and no [material.NAME] has this name",
        f"{nearest(name, defined)}Add [{join('material', name)}], or name the groups of the file anew. The file has "
        f"{listed(found)}; the case has {listed(defined)}.",
    )  # fmt: skip
