"""Columns handed over as failed slopes are: `python -m reference run runout-columns`."""

from __future__ import annotations

from .rows import Row
from .runout import column_rows


def run() -> list[Row]:
    """Run-out over the aspect ratio."""
    return column_rows()
