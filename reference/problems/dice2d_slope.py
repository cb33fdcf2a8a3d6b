"""DICE2D's slope with a weak layer, without and with bolts: `python -m reference run dice2d-slope`."""

from __future__ import annotations

from .dice2d_ground import slope
from .rows import Row


def run() -> list[Row]:
    """All of it."""
    return slope()
