"""Physical laws, one file each, and the registry that finds them by the name used in a case file.

A new law is a new file and one line here. A law of the ground offers ``NAME``, a parameter tuple,
``parameters(...)`` from engineering constants, ``reduced(parameters, factor)``, the scalar functions
``update_stress`` and ``elastic_energy``, and ``features(tuples)``: which of its branches a scene needs.
"""

from __future__ import annotations

from types import ModuleType

from .ground import mohr_coulomb

GROUND_LAWS: dict[str, ModuleType] = {module.NAME: module for module in (mohr_coulomb,)}
"""Laws of stress-carrying particles by name."""
