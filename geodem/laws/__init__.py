"""Physical laws, one file each, and the registry that finds them by the name used in a case file.

A new law is a new file and one line here. A law of the ground offers ``NAME``, a parameter tuple,
``parameters(...)`` from engineering constants, ``reduced(parameters, factor)``, the scalar functions
``update_stress`` and ``elastic_energy``, and ``features(tuples)``: which of its branches a scene needs.

A law of contacts or bonds offers ``NAME``, ``PARAMETERS`` (its parameter tuple), ``DIMENSIONS``, the names of its
history ``SCALAR``, ``TANGENTIAL`` and ``AXIAL``, ``MOMENT``, ``VISCOUS``, the scalar functions ``force``, ``energy``
and ``stiffness`` (and ``viscous`` where it says so), and ``combine``, ``against_rigid`` and ``check`` on its
parameters. The names of the scalar functions' arguments say what they need. A contact law may offer ``reach``; a
bond law offers ``REPLACES_CONTACT`` and ``bonded``. A law of joints offers the same as a bond's but for what mixes
materials, and ``starts_bonded`` and ``LASTING``. `geodem.laws.protocol` reads and checks all this.
"""

from __future__ import annotations

from types import ModuleType

from .bond import (
    cement,
    cohesive_moments,
    flat_joint,
    jointed_cohesive,
    parallel_bond,
    rock,
    rotational_bond,
    two_springs,
)
from .contact import (
    cohesive_frictional,
    effective_modulus,
    elastic_frictional,
    hertz,
    hertz_dmt,
    hertz_history,
    hertz_mindlin,
    hertz_mindlin_rolling,
    hooke,
    hooke_stiffness,
    linear_frictional,
    linear_incremental,
    linear_rolling,
)
from .ground import mohr_coulomb
from .joint import bolt, smooth_joint

GROUND_LAWS: dict[str, ModuleType] = {module.NAME: module for module in (mohr_coulomb,)}
"""Laws of stress-carrying particles by name."""

CONTACT_LAWS: dict[str, ModuleType] = {
    module.NAME: module
    for module in (
        linear_frictional,
        linear_incremental,
        cohesive_frictional,
        linear_rolling,
        effective_modulus,
        hertz,
        hertz_mindlin,
        hertz_mindlin_rolling,
        hertz_dmt,
        elastic_frictional,
        hooke_stiffness,
        hooke,
        hertz_history,
    )
}
"""Laws of particles that touch by name."""

BOND_LAWS: dict[str, ModuleType] = {
    module.NAME: module
    for module in (
        two_springs,
        parallel_bond,
        cement,
        rotational_bond,
        rock,
        flat_joint,
        cohesive_moments,
        jointed_cohesive,
    )
}
"""Laws of bonded particles by name."""

JOINT_LAWS: dict[str, ModuleType] = {module.NAME: module for module in (smooth_joint, bolt)}
"""Laws of pairs that have a direction of their own, across joints and along bolts, by name."""
