"""Checkpoints: a tree of arrays and plain data in one HDF5 file, written whole or not at all, with a checksum."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from .files import write_whole


class CheckpointFormat(NamedTuple):
    """What a checkpoint holds, and what to tell a user who gives another file."""

    name: str
    version: int
    content: str
    missing: str  # remedy where there is no file
    again: str  # remedy where the file is of no use


SEARCH = CheckpointFormat(
    "geodem-checkpoint",
    1,
    "a search for a factor",
    "Give the folder that 'geodem run' wrote to",
    "Run the case again: geodem run CASE --out DIR --overwrite",
)

PARTICLES = CheckpointFormat(
    "geodem-particles",
    1,
    "discs or spheres in motion",
    "Give the file that ParticleSimulation.save wrote",
    "Take an earlier checkpoint, or begin again from the assembly",
)

FORMATS = {form.name: form for form in (SEARCH, PARTICLES)}

Tree = dict[str, Any]
"""Names to arrays, plain data (anything JSON can hold) or further trees."""


def write_checkpoint(path: Path | str, tree: Mapping[str, Any], form: CheckpointFormat = SEARCH) -> None:
    """Write a checkpoint so that its name holds the old or the new one at any moment.

    Raises
    ------
    InputError
        The file cannot be written; the old one is untouched.
    """
    import h5py

    buffer = io.BytesIO()
    with h5py.File(buffer, "w") as file:
        _write_group(file, tree)
        file.attrs["format"] = form.name
        file.attrs["format_version"] = form.version
        file.attrs["checksum"] = checksum(tree)
    write_whole(path, buffer.getbuffer())


def read_checkpoint(path: Path | str, form: CheckpointFormat = SEARCH) -> Tree:
    """Read a checkpoint of this format; nothing in it is executed.

    Raises
    ------
    InputError
        No such file, not a checkpoint, of another format version, truncated or changed.
    """
    import h5py

    path = Path(path)
    place = str(path)
    if not path.is_file():
        raise InputError(place, "there is no checkpoint here", form.missing)
    try:
        with h5py.File(path, "r") as file:
            found = str(file.attrs.get("format"))
            if found != form.name:
                problem = "this is not a checkpoint of geodem"
                if found in FORMATS:
                    problem = f"this is a checkpoint of {FORMATS[found].content}, not of {form.content}"
                raise InputError(place, problem, form.missing)
            version = int(file.attrs["format_version"])
            if version != form.version:
                problem = f"checkpoint format {version}, this geodem reads format {form.version}"
                raise InputError(place, problem, form.again)
            stored = str(file.attrs["checksum"])
            tree = _read_group(file, path.stat().st_size)
    except InputError:
        raise
    # HDF5 raises whatever it comes upon in a damaged file
    except Exception as error:
        raise InputError(place, "the checkpoint is damaged or cut off", form.again) from error
    if checksum(tree) != stored:
        raise InputError(
            place, "the checkpoint was changed after it was written (its checksum differs)", form.again
        )
    return tree


def checksum(tree: Mapping[str, Any]) -> str:
    """SHA-256 over names, types, shapes and bytes of a tree: equal only for equal bits."""
    digest = hashlib.sha256()
    for name, value in _leaves(tree, ""):
        digest.update(name.encode())
        if isinstance(value, np.ndarray):
            digest.update(f"{value.dtype.str}{value.shape}".encode())
            digest.update(np.ascontiguousarray(value).tobytes())
        else:
            digest.update(json.dumps(value, sort_keys=True).encode())
    return digest.hexdigest()


def _leaves(tree: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for name in sorted(tree):
        value = tree[name]
        if _is_tree(value):
            yield from _leaves(value, f"{prefix}/{name}")
        else:
            yield f"{prefix}/{name}", value


def _is_tree(value: object) -> bool:
    """A mapping with an array somewhere below it; others are plain data."""
    return isinstance(value, Mapping) and any(
        isinstance(v, np.ndarray) or _is_tree(v) for v in value.values()
    )


def _write_group(group: Any, tree: Mapping[str, Any]) -> None:
    for name, value in tree.items():
        if isinstance(value, np.ndarray):
            group.create_dataset(name, data=value)
        elif _is_tree(value):
            _write_group(group.create_group(name), value)
        else:
            # a dataset, since attributes are limited to 64 kB
            text = group.create_dataset(name, data=np.frombuffer(json.dumps(value).encode(), dtype=np.uint8))
            text.attrs["json"] = True


def _read_group(group: Any, most: int) -> Tree:
    """A tree of numbers and text that stand in this file itself, none larger than the file: `most` bytes.

    HDF5 can point to other files and places, hold objects, and promise arrays of any size; nothing here writes such.
    """
    import h5py

    tree: Tree = {}
    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise ValueError(f"{name} is a link")
        item = group[name]
        if isinstance(item, h5py.Group):
            tree[name] = _read_group(item, most)
            continue
        own = isinstance(item, h5py.Dataset) and not item.is_virtual and item.external is None
        if not own or item.dtype.kind not in "biuf" or item.nbytes > most:
            raise ValueError(f"{name} is no array of numbers")
        if item.attrs.get("json", False):
            tree[name] = json.loads(item[()].tobytes().decode())
        else:
            tree[name] = item[()]
    return tree
