"""Results on disk: rows with the command, date, versions and machine that made them."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from geodem.provenance import versions

FOLDER = Path(__file__).parent / "results"

Row = dict[str, Any]


def machine() -> dict[str, Any]:
    """Processor and cores of this machine."""
    model = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        model = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {"processor": model, "cores": os.cpu_count(), "system": platform.system()}


def load_rows(name: str) -> list[Row]:
    """Rows stored under a name; none where there is no file."""
    path = FOLDER / f"{name}.json"
    if not path.is_file():
        return []
    return list(json.loads(path.read_text())["rows"])


def store_rows(name: str, rows: Sequence[Row], command: str) -> Path:
    """Write rows, one a line, with their origin; the file holds the old rows or the new ones at any moment."""
    head = {
        "command": command,
        "date": time.strftime("%Y-%m-%d"),
        "versions": versions(),
        "machine": machine(),
    }
    lines = ",\n  ".join(json.dumps(row, default=_plain) for row in rows)
    text = f'{{\n "header": {json.dumps(head)},\n "rows": [\n  {lines}\n ]\n}}\n'
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / f"{name}.json"
    part = path.with_suffix(".part")
    part.write_text(text)
    os.replace(part, path)
    return path


def _plain(value: Any) -> Any:
    """numpy's scalars as Python's."""
    return value.item()
