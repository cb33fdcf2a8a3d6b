"""Joints in bonded particles against closed forms: `python -m reference run ground-joints`."""

from __future__ import annotations

from .ground_jaeger import ANGLES, intact, jaeger
from .ground_priest import priest
from .rows import Row


def run() -> list[Row]:
    """Jaeger's specimens at all angles, Priest's block dry and with water."""
    rock = intact(20.0)
    return [*(jaeger(angle, 20.0, rock) for angle in ANGLES), *priest(wet=False), *priest(wet=True)]
