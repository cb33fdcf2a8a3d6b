"""What a .geo file may do: draw geometry. As a script of gmsh it could start programs and write files, too."""

from __future__ import annotations

import re
from pathlib import Path

from geodem.errors import InputError

FORBIDDEN = (
    "SystemCall", "System", "NonBlockingSystemCall", "NonBlockingSystem", "OnelabRun", "Parse", "Plugin", "Exit",
    "Abort", "Save", "Print", "CreateDir", "Sleep",
)  # fmt: skip
"""Commands of gmsh's language that start programs, write files, or end or stop the program that reads them."""

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_TEXT = re.compile(r'"[^"\n]*"')
_OTHERS = re.compile(r'\b(Include|Merge|ShapeFromFile)\b\s*\(?\s*(?:"([^"\n]*)")?')
_TO_A_FILE = re.compile(r"\bPrintf\s*\([^;]*\)\s*>")
_DEEPEST = 10


def refuse_commands(path: Path, *, depth: int = 0) -> None:
    """Look through a .geo file and those that it names before gmsh reads it.

    Raises
    ------
    InputError
        It has a command that does more than draw, or takes in a file whose name cannot be told beforehand.
    """
    text = _COMMENT.sub(" ", path.read_text(encoding="utf-8", errors="replace"))
    bare = _TEXT.sub('""', text)
    found = re.search(rf"\b({'|'.join(FORBIDDEN)})\b", bare) or _TO_A_FILE.search(bare)
    if found:
        word = found[0].split("(")[0].strip()
        raise InputError(
            str(path), f"its command {word} does more than draw: such commands are not carried out",
            "Take it out, or run the file in gmsh yourself and give the mesh that it makes.",
        )  # fmt: skip
    for command, name in _OTHERS.findall(text):
        if not name or depth == _DEEPEST:
            raise InputError(
                str(path), f"it takes in files with {command}, and which cannot be told before gmsh carries it out",
                "Write the name of the file there, or put all into one file.",
            )  # fmt: skip
        other = path.parent / name
        if other.is_file() and other.suffix.lower() in ("", ".geo", ".geo_unrolled", ".pro", ".opt", ".txt"):
            refuse_commands(other, depth=depth + 1)
