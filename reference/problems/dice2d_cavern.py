"""DICE2D's frame on jointed rock, without and with a cavern: `python -m reference run dice2d-cavern`."""

from __future__ import annotations

from .dice2d_ground import cavern
from .rows import Row


def run() -> list[Row]:
    """All of it."""
    return cavern()
