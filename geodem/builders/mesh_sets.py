"""Materials from the element sets of an Abaqus file."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geodem.builders.mesh_file import DIMENSION, LoadedMesh
from geodem.errors import InputError

Whole = NDArray[np.int64]


def element_sets(
    path: Path, file: LoadedMesh, blocks: list[tuple[str, Whole]], tops: int, names: dict[int, list[str]]
) -> list[Whole]:
    """Groups from the element sets of an Abaqus file: those of its sections, else those that cover all once."""
    heads = re.findall(r"(?im)^\*(element|solid section)\s*,(.*)$", path.read_text(errors="replace"))
    options = [
        (word.lower(), {k.strip().lower(): v.strip() for k, _, v in (part.partition("=") for part in rest.split(","))})
        for word, rest in heads
    ]  # fmt: skip
    of_block = [found.get("elset") for word, found in options if word == "element"]
    if len(of_block) != len(blocks):
        raise InputError(
            str(path), "its element blocks cannot be told apart", "Write it without *INCLUDE, or as .msh."
        )
    sections = {
        str(found.get("elset")): found.get("material") for word, found in options if word.startswith("solid")
    }
    # the reader's own sets of *ELEMENT blocks are mixed up where some blocks have no name
    members: dict[str, list[Whole]] = {}
    for name, parts in file.sets.items():
        if name in of_block:
            continue
        rows = [np.asarray(part, dtype=np.int64).reshape(-1) for part in parts]
        members[name] = rows + [np.empty(0, dtype=np.int64)] * (len(blocks) - len(rows))
    own: dict[str, list[Whole]] = {}
    for index, head in enumerate(of_block):
        if head is not None:
            own.setdefault(head, [np.empty(0, dtype=np.int64)] * len(blocks))[index] = np.arange(
                len(blocks[index][1])
            )
    groups = [np.full(len(data), -1, dtype=np.int64) for _, data in blocks]
    for dimension in (1, 2, 3):
        mine = [k for k, (kind, _) in enumerate(blocks) if DIMENSION.get(kind) == dimension]
        named: dict[str, str] = {name: name for name in (*members, *own)}
        trials = [members, own, {**own, **members}]
        if dimension == tops and sections:
            named = {key: material or key for key, material in sections.items()}
            trials = [{name: part for name, part in {**own, **members}.items() if name in sections}]
        for sets in trials:
            taken = {name: rows for name, rows in sets.items() if any(len(rows[k]) for k in mine)}
            if taken and _spread(taken, named, groups, mine, names[dimension], dimension == tops):
                break
        else:
            if dimension == tops and any(
                len(rows[k]) for part in trials for rows in part.values() for k in mine
            ):
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
