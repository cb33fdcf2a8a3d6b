"""Other people's codes, run as programs of their own on a scene of `reference.scenes`; none of them is imported.

A backend is a module with

- ``NAME``;
- ``available() -> str | None``: None where the code is found, else how to install it;
- ``run(scene, steps, *, threads=1, warm_up=0, every=0) -> Outcome``;
- ``run_speed(scene, steps, threads) -> Speed``.

A scene that a code's laws cannot stand for is refused; which law was used is told in the answer.
"""

from __future__ import annotations

from types import ModuleType

from . import lammps, liggghts, yade
from .outcome import Outcome, Speed

BACKENDS: dict[str, ModuleType] = {module.NAME: module for module in (yade, liggghts, lammps)}

__all__ = ["BACKENDS", "Outcome", "Speed"]
