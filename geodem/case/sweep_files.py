"""Files that a case of any kind names: every text in it that is the name of a file or folder which is there."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..errors import InputError

_LONGEST = 200


def named_files(document: Any, folder: Path) -> dict[str, Path]:
    """Names as they stand in the document, and the files or folders that they are of.

    Parameters
    ----------
    document : object
        A case, as TOML has it, or a part of one.
    folder : pathlib.Path
        What the names are relative to. Folders that hold the case itself are left out.
    """
    found = {}
    for name in _texts(document):
        if name in found or not 0 < len(name) <= _LONGEST or "\0" in name:
            continue
        path = folder / name
        try:
            there = path.is_file() or (path.is_dir() and path.resolve() not in _above(folder))
        except OSError:
            continue
        if there:
            found[name] = path
    return found


def digests(document: Any, folder: Path) -> dict[str, Any]:
    """Digests of the files that a case names, by name.

    Raises
    ------
    InputError
        One cannot be read.
    """
    held: dict[str, Any] = {}
    for name, path in named_files(document, folder).items():
        try:
            entries = (
                sorted(entry for entry in path.iterdir() if entry.is_file()) if path.is_dir() else [path]
            )
            held[name] = {entry.name: _digest(entry, entry.stat().st_mtime_ns) for entry in entries}
        except OSError as error:
            raise InputError(
                str(path), f"the file cannot be read ({error.strerror})", "Put it back."
            ) from error
    return held


def mirrored(base_file: Path, names: Mapping[str, Path]) -> tuple[Path, dict[str, Path]]:
    """Where a case and the files that it names go in a folder "source", so that it reads as before.

    Returns
    -------
    Path, dict of str to Path
        Place of the case file, and all that is to be copied: place, and where it comes from. Files that the case names
        by their full path stay where they are.
    """
    relative = [path for name, path in names.items() if not Path(name).is_absolute()]
    whole = [Path(os.path.abspath(path)) for path in (base_file, *relative)]
    root = Path(os.path.commonpath([path.parent for path in whole]))
    copies = {str(Path("source") / path.relative_to(root)): path for path in whole}
    return Path("source") / whole[0].relative_to(root), copies


@lru_cache(maxsize=4096)
def _digest(path: Path, changed: int) -> str:
    """Of a file's content; `changed` is when it was written last, so that a file is read once."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _above(folder: Path) -> set[Path]:
    here = folder.resolve()
    return {here, *here.parents}


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from _texts(inner)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _texts(inner)
