"""How codes of discrete elements turn the motion of two particles into what a contact law asks for.

The same law gives slightly different motions in different codes: where the slip is measured, how a force that is
remembered turns with the contact, which velocities are those at the start, at which velocity local damping looks. Most
of these differences vanish with the time step; two do not: YADE's arms differ by the overlap over the distance, and
LIGGGHTS does not turn a remembered force about the normal. geodem has its own convention; those of other codes are here
so that one and the same scene can be computed in theirs, and compared to the last digits.

A convention offers ``NAME``, the constants

- ``VELOCITIES_BEFORE``: velocities at the start are those half a step before it, and the first slip is theirs; else the
  first forces act on them for half a step;
- ``AT_MIDDLE``: local damping looks at the velocity in the middle of the step;

and the scalar functions ``branches``, ``wall_branches``, ``parting_velocity``, ``relative_motion``, ``half_turn``,
``spin_about`` and ``transported``.
"""

from __future__ import annotations

from types import ModuleType

from . import geodem, liggghts, yade, yade_plain

CONVENTIONS: dict[str, ModuleType] = {module.NAME: module for module in (geodem, yade, yade_plain, liggghts)}
"""By name; all but geodem's own are for spheres."""

FUNCTIONS = (
    "branches",
    "wall_branches",
    "parting_velocity",
    "relative_motion",
    "half_turn",
    "spin_about",
    "transported",
)
"""Functions that the loops call; they call nothing but math."""
