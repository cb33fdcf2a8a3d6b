"""A case of any kind, from its file."""

from __future__ import annotations

from pathlib import Path

from ..kinds import AnyCase, Kind, kind_of
from .document import parse_document, read_text


def load_any(path: Path | str) -> AnyCase:
    """Read a case of whatever workflow it names; where it names none, of the one that it looks like.

    Parameters
    ----------
    path : pathlib.Path
        A .toml file, or a folder that holds case.toml.

    Raises
    ------
    InputError
        The file cannot be found or read, or is no TOML.
    InputErrors
        All that is wrong in the file, in its order.
    """
    return parse_any(*read_text(path))


def parse_any(text: str, folder: Path) -> AnyCase:
    """Read a case of any kind from its text; paths in it are relative to `folder`. Errors as of `load_any`."""
    return kind_of(parse_document(text)).parse(text, folder)


def load_kind(kind: Kind, path: Path | str) -> AnyCase:
    """Read a case that must be of one kind; errors as of `load_any`."""
    return kind.parse(*read_text(path))
