"""The folder of a run: what already stands in it, and what may be written over."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..errors import InputError
from .files import cannot_write, read_json, remove_unfinished

RESULTS = ("result.json", "checkpoint.h5")
"""Files that tell that a run has written to a folder."""


def claim_folder(
    folder: Path, identity: str, case_text: str, *, overwrite: bool, written: Iterable[str]
) -> bool:
    """Make a folder ready for a run; whether it holds one of the same identity, to be gone on with.

    Parameters
    ----------
    folder : pathlib.Path
    identity : str
        Of the case, as "identity" in result.json.
    case_text : str
        What will be written to case.toml.
    overwrite : bool
        Take away what another run left, or the same one.
    written : iterable of str
        Patterns of the files that a run writes.

    Raises
    ------
    InputError
        It is no folder, it cannot be made, it holds results of another case, or a case file that no run has written.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError("--out", "there is a file of that name", "Choose another folder", value=str(folder))
    ours = any((folder / name).exists() for name in RESULTS)
    case_file = folder / "case.toml"
    if not ours and case_file.exists():
        if case_file.read_text(encoding="utf-8", errors="replace") != case_text:
            raise InputError(
                "--out", "the folder holds a case file, which the results would write over",
                "Choose another folder, such as a new one within it", value=str(folder),
            )  # fmt: skip
    same = ours and (read_json(folder / "result.json") or {}).get("identity") == identity
    if ours and not same and not overwrite:
        raise InputError(
            "--out", "the folder holds results of another case", "Choose another folder, or add --overwrite",
            value=str(folder),
        )  # fmt: skip
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from error
    remove_unfinished(folder)
    if ours and overwrite:
        for pattern in written:
            for path in folder.glob(pattern):
                path.unlink()
        return False
    return same
