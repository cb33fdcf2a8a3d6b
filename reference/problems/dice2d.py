"""The twelve benchmark examples of DICE2D (Zhao 2015, section 1.5): `python -m reference run dice2d`."""

from __future__ import annotations

from . import dice2d_contacts, dice2d_motion, dice2d_scenes
from .rows import Row


def run() -> list[Row]:
    """All twelve."""
    return [*dice2d_motion.run(), *dice2d_contacts.run(), *dice2d_scenes.run()]
