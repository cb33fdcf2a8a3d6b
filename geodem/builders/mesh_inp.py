"""Read what geodem needs of an Abaqus or CalculiX input file: nodes, elements, element sets and sections."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.builders.mesh_file import DIMENSION, LoadedMesh
from geodem.errors import InputError

Whole = NDArray[np.int64]

PLANE = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}
SOLID = {4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron", 10: "tetra10", 13: "pyramid13", 15: "wedge15",
         20: "hexahedron20", 27: "hexahedron27"}  # fmt: skip
LINE = {2: "line", 3: "line3"}
FAMILIES = (
    (r"(?:CPEG|CPE|CPS|CAX|STRI|S|M3D|SFM3D|R3D|DC2D|AC2D|DCAX|ACAX)(\d+)", PLANE),
    (r"(?:C3D|DC3D|AC3D)(\d+)", SOLID),
    (r"(?:T2D|T3D|R2D|RAX|DC1D)(\d+)", LINE),
)
"""Beginnings of Abaqus's names of elements, with the number of nodes, and what they are."""


def load_inp(path: Path) -> LoadedMesh:
    """Nodes, blocks of elements, and sets as `Sets`.

    Raises
    ------
    ValueError
        What stands there cannot be right.
    """
    node_ids: list[int] = []
    nodes: list[list[float]] = []
    blocks: list[tuple[str, list[list[int]]]] = []
    place_of: dict[int, tuple[int, int]] = {}
    own: dict[str, list[int]] = {}
    members: dict[str, list[int]] = {}
    sections: dict[str, str] = {}
    for keyword, options, lines in _keywords(path.read_text(errors="replace")):
        if keyword == "NODE":
            for line in lines:
                values = line.split(",")
                node_ids.append(int(values[0]))
                nodes.append([float(value or 0.0) for value in (*values[1:], "0", "0")[:3]])
        elif keyword == "ELEMENT":
            kind, width = _kind(options.get("TYPE", ""))
            numbers = [int(value) for line in lines for value in line.split(",") if value.strip()]
            if len(numbers) % (width + 1):
                raise ValueError(f"elements of type {options['TYPE']} with too few nodes")
            rows = [numbers[k : k + width + 1] for k in range(0, len(numbers), width + 1)]
            for k, row in enumerate(rows):
                if row[0] in place_of:
                    raise ValueError(f"there are two elements {row[0]}; is it one part only?")
                place_of[row[0]] = (len(blocks), k)
            if rows:
                blocks.append((kind, [row[1:] for row in rows]))
            if "ELSET" in options:
                own.setdefault(options["ELSET"], []).extend(row[0] for row in rows)
        elif keyword == "ELSET":
            members.setdefault(options["ELSET"], []).extend(
                _members(lines, "GENERATE" in options, members, own)
            )
        elif keyword == "SOLID SECTION":
            sections[options.get("ELSET", "")] = options.get("MATERIAL", "") or options.get("ELSET", "")
        elif keyword == "INCLUDE":
            raise ValueError("it includes another file")
        elif keyword == "INSTANCE" and lines:
            raise ValueError("it moves a part to its place; write it as one part")
    if not blocks:
        raise ValueError("no *ELEMENT in it")
    number = {name: k for k, name in enumerate(node_ids)}
    try:
        found = [(kind, np.array([[number[n] for n in row] for row in rows])) for kind, rows in blocks]
        sets = [
            {name: _by_block([place_of[i] for i in ids], len(blocks)) for name, ids in some.items()}
            for some in (members, own)
        ]
    except KeyError as error:
        raise ValueError(f"node or element {error} is not there") from None
    return LoadedMesh(
        np.array(nodes), found, {}, {"sections": sections}, {"sets": sets[0], "blocks": sets[1]}
    )


def _keywords(text: str) -> list[tuple[str, dict[str, str], list[str]]]:
    """Keyword, options and lines of data, one after the other."""
    found: list[tuple[str, dict[str, str], list[str]]] = []
    for line in text.splitlines():
        line = line.strip()
        if line.startswith("**") or not line:
            continue
        if line.startswith("*"):
            word, *rest = (part.strip() for part in line[1:].split(","))
            pairs = (part.partition("=") for part in rest)
            found.append((word.upper(), {key.strip().upper(): value.strip() for key, _, value in pairs}, []))
        elif found:
            found[-1][2].append(line)
    return found


def _kind(name: str) -> tuple[str, int]:
    for pattern, kinds in FAMILIES:
        match = re.match(pattern, name.upper())
        if match and int(match.group(1)) in kinds:
            return kinds[int(match.group(1))], int(match.group(1))
    raise ValueError(f"elements of type {name!r} cannot be used")


def _members(
    lines: list[str], generate: bool, members: Mapping[str, list[int]], own: Mapping[str, list[int]]
) -> list[int]:
    ids: list[int] = []
    for line in lines:
        values = [value.strip() for value in line.split(",") if value.strip()]
        if generate:
            first, last, *step = (int(value) for value in values)
            ids += range(first, last + 1, *step)
            continue
        for value in values:
            known = members.get(value, own.get(value))
            ids += known if known is not None else [int(value)]
    return ids


def _by_block(places: list[tuple[int, int]], blocks: int) -> list[Whole]:
    """Numbers of the elements in each block."""
    rows: list[list[int]] = [[] for _ in range(blocks)]
    for block, row in places:
        rows[block].append(row)
    return [np.unique(np.array(some, dtype=np.int64)) for some in rows]


def element_sets(
    path: Path, file: LoadedMesh, blocks: list[tuple[str, Whole]], tops: int, names: dict[int, list[str]]
) -> list[Whole]:
    """Groups of all elements: by the sets that have a section, else those that hold every element once.

    Parameters
    ----------
    path : Path
    file : LoadedMesh
        Of `load_inp`.
    blocks : list of (kind, corners)
    tops : int
        Dimension of the elements that fill the ground.
    names : dict
        Names by dimension, to which those that are found are added.

    Raises
    ------
    InputError
        An element in no set or in several.
    """
    members, own, sections = file.sets["sets"], file.sets["blocks"], file.named["sections"]
    every = {**own, **members}
    groups = [np.full(len(data), -1, dtype=np.int64) for _, data in blocks]
    for dimension in (1, 2, 3):
        mine = [k for k, (kind, _) in enumerate(blocks) if DIMENSION.get(kind) == dimension]
        trials, named = [members, own, every], {name: name for name in every}
        if dimension == tops and sections:
            trials, named = [{name: every[name] for name in every if name in sections}], sections
        given = [
            {name: rows for name, rows in sets.items() if any(len(rows[k]) for k in mine)} for sets in trials
        ]
        whole = dimension == tops
        spread = any(_spread(sets, named, groups, mine, names[dimension], whole) for sets in given if sets)
        if whole and not spread and any(given):
            raise InputError(
                str(path), "its element sets do not give each element one material",
                "Leave one set for each material, or give a *SOLID SECTION for each.",
            )  # fmt: skip
    return groups


def _spread(
    sets: Mapping[str, list[Whole]],
    named: Mapping[str, str],
    groups: list[Whole],
    mine: list[int],
    known: list[str],
    every: bool,
) -> bool:
    """Write the sets into the groups if they hold no element twice, and `every` one; whether they do."""
    times = [np.zeros(len(groups[k]), dtype=int) for k in mine]
    for rows in sets.values():
        for count, k in zip(times, mine, strict=True):
            count[rows[k]] += 1
    if any((count > 1).any() or (every and (count < 1).any()) for count in times):
        return False
    for name, rows in sets.items():
        if named[name] not in known:
            known.append(named[name])
        for k in mine:
            groups[k][rows[k]] = known.index(named[name])
    return True
