"""Residual friction of discs against the angle asked for: `python -m reference run disc-friction`."""

from __future__ import annotations

from .rows import Row
from .runout import friction_rows


def run() -> list[Row]:
    """Fresh packings in biaxial compression."""
    return friction_rows()
