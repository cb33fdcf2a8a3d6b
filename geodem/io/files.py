"""Writing a file whole or not at all, with errors that say what to do."""

from __future__ import annotations

import errno
import json
import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geodem.errors import InputError

_REMEDIES = {
    errno.ENOSPC: ("the disk is full", "Free some space or choose another folder with --out"),
    errno.EDQUOT: ("the disk quota is used up", "Free some space or choose another folder with --out"),
    errno.EFBIG: ("the file is larger than is allowed here", "Choose another folder with --out"),
    errno.EACCES: ("writing is not permitted", "Choose a folder that you may write to, with --out"),
    errno.EPERM: ("writing is not permitted", "Choose a folder that you may write to, with --out"),
    errno.EROFS: ("the folder is read-only", "Choose a folder that you may write to, with --out"),
    errno.ENOTDIR: ("a part of the path is a file, not a folder", "Choose another folder with --out"),
    errno.EEXIST: ("a part of the path is a file, not a folder", "Choose another folder with --out"),
    errno.EISDIR: ("a folder has the name of the file", "Move that folder away or choose another with --out"),
}


def write_whole(path: Path | str, data: bytes | memoryview | str) -> None:
    """Write a file so that at any moment its name holds the old content or the new, never a part.

    Parameters
    ----------
    path : path
        Folders on the way are made.
    data : bytes, memoryview of bytes, or str (written as UTF-8)

    Raises
    ------
    InputError
        The file cannot be written (read-only folder, full disk, ...); what stood there is untouched.
    """
    path = Path(path)
    content = data.encode() if isinstance(data, str) else data
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with part.open("wb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(part, path)
        except BaseException:
            _remove(part)
            raise
    except OSError as error:
        raise cannot_write(path, error) from error


def write_json(path: Path | str, content: Mapping[str, Any]) -> dict[str, Any]:
    """Write a JSON file, whole or not at all; returns what it holds: null for what is no finite number.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    held = dict(_finite(content))
    write_whole(path, json.dumps(held, indent=1, ensure_ascii=False) + "\n")
    return held


def remove(path: Path | str) -> None:
    """Take a file away where there is one.

    Raises
    ------
    InputError
        It cannot be taken away.
    """
    try:
        Path(path).unlink(missing_ok=True)
    except OSError as error:
        raise cannot_write(path, error) from error


def read_json(path: Path | str) -> dict[str, Any] | None:
    """What a JSON file holds; None where there is none that can be read."""
    try:
        return dict(json.loads(Path(path).read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, RecursionError):
        return None


def _finite(value: Any) -> Any:
    """JSON knows neither NaN nor infinity: both become null."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(entry) for entry in value]
    return value


def cannot_write(path: Path | str, error: OSError) -> InputError:
    """The error of the system, as one that tells the user what is wrong with the place and what to do."""
    problem, remedy = _REMEDIES.get(
        error.errno or 0,
        (f"cannot be written ({error.strerror or error})", "Choose another folder with --out"),
    )
    return InputError(str(path), problem, remedy + ".")


def _remove(part: Path) -> None:
    """Take the unfinished file away where that is still possible."""
    try:
        part.unlink(missing_ok=True)
    except OSError:
        return  # the first error is the one to report


def remove_unfinished(folder: Path) -> None:
    """Take away the parts of files that a process which no longer runs left unfinished, in folders below as well."""
    for part in folder.rglob(".*.part"):
        owner = part.name.split(".")[-2]
        if owner.isdigit() and not _runs(int(owner)):
            _remove(part)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True  # another user's
    return True
