"""Two particles that are led along a path: the smallest driver of a law of contacts or bonds, and its table.

The normal stands still, so a path is a row of increments of overlap, slip, twist and bend. What the loops add
(moving frames, balance of momentum) is tested with them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geodem.laws import BOND_LAWS, CONTACT_LAWS
from geodem.laws.protocol import argument_names, history_arguments, in_dimension, make_parameters

RADIUS_A, RADIUS_B = 0.011, 0.008
SIZE = 1e-5
"""Overlap and slip of the paths [m]."""

LAWS = {
    "linear_frictional": {
        "normal_stiffness": 2e7,
        "shear_stiffness": 8e6,
        "friction_coefficient": 0.4,
        "normal_viscosity": 1e-5,
        "shear_viscosity": 2e-5,
    },
    "linear_incremental": {
        "normal_stiffness": 2e7,
        "shear_stiffness": 8e6,
        "friction_coefficient": 0.4,
        "normal_viscosity": 1e-5,
        "shear_viscosity": 2e-5,
    },
    "cohesive_frictional": {
        "normal_stiffness": 2e7,
        "shear_stiffness": 8e6,
        "friction_coefficient": 0.4,
        "adhesion": 100.0,
        "adhesion_shear": 60.0,
        "normal_viscosity": 1e-5,
        "shear_viscosity": 2e-5,
    },
    "linear_rolling": {
        "normal_stiffness": 2e7,
        "shear_stiffness": 8e6,
        "friction_coefficient": 0.4,
        "rolling_friction": 0.3,
        "twisting_friction": 0.2,
        "normal_viscosity": 1e-5,
        "shear_viscosity": 2e-5,
    },
    "effective_modulus": {"effective_modulus": 2e9, "stiffness_ratio": 2.5, "friction_coefficient": 0.4},
    "hertz": {"young_modulus": 5e10, "poisson_ratio": 0.2},
    "hertz_mindlin": {
        "young_modulus": 5e10,
        "poisson_ratio": 0.2,
        "friction_coefficient": 0.4,
        "restitution": 0.3,
    },
    "hertz_mindlin_rolling": {
        "young_modulus": 5e10,
        "poisson_ratio": 0.2,
        "friction_coefficient": 0.4,
        "rolling_friction": 0.3,
        "twisting_friction": 0.2,
        "restitution": 0.3,
    },
    "hertz_dmt": {
        "young_modulus": 5e10,
        "poisson_ratio": 0.2,
        "friction_coefficient": 0.4,
        "work_of_adhesion": 100.0,
        "restitution": 0.3,
    },
    "two_springs": {
        "normal_stiffness": 2e7,
        "shear_stiffness": 8e6,
        "tensile_strength": 150.0,
        "cohesion": 250.0,
        "friction_coefficient": 0.5,
        "width_ratio": 0.8,
        "normal_viscosity": 1e-5,
        "shear_viscosity": 2e-5,
    },
    "parallel_bond": {
        "radius_factor": 0.9,
        "normal_stiffness": 1e11,
        "shear_stiffness": 4e10,
        "tensile_strength": 6e5,
        "shear_strength": 9e5,
        "friction_coefficient": 0.3,
        "moment_contribution": 0.7,
    },
    "cement": {
        "radius_factor": 0.9,
        "effective_modulus": 2e9,
        "stiffness_ratio": 2.5,
        "tensile_strength": 6e5,
        "shear_strength": 9e5,
        "friction_coefficient": 0.3,
        "moment_contribution": 0.7,
    },
    "rock": {
        "effective_modulus": 2e9,
        "stiffness_ratio": 2.5,
        "tensile_strength": 6e5,
        "shear_strength": 9e5,
        "friction_coefficient": 0.3,
        "moment_contribution": 0.7,
    },
    "flat_joint": {
        "effective_modulus": 2e9,
        "stiffness_ratio": 2.5,
        "tensile_strength": 6e5,
        "shear_strength": 9e5,
        "friction_coefficient": 0.3,
        "residual_friction_coefficient": 0.4,
    },
    "rotational_bond": {
        "normal_stiffness": 2e7,
        "shear_stiffness": 8e6,
        "twisting_stiffness": 200.0,
        "bending_stiffness": 300.0,
        "tensile_strength": 400.0,
        "shear_strength": 300.0,
        "twisting_strength": 1.2,
        "bending_strength": 1.5,
        "normal_viscosity": 1e-5,
        "shear_viscosity": 2e-5,
    },
}
"""Parameters of every law that let the paths slide and break, and every one of them matter."""

ELASTIC = {
    "friction_coefficient": 1e9,
    "rolling_friction": 1e9,
    "twisting_friction": 1e9,
    "tensile_strength": np.inf,
    "cohesion": np.inf,
    "shear_strength": np.inf,
    "twisting_strength": np.inf,
    "bending_strength": np.inf,
}
"""Strengths that no path reaches."""

OF_OTHER_CODES = {
    "elastic_frictional",
    "cohesive_moments",
    "jointed_cohesive",
    "hooke_stiffness",
    "hooke",
    "hertz_history",
}
"""Laws in the conventions of YADE and LIGGGHTS: `test_laws_of_other_codes` says what they promise."""

OF_ITS_LENGTH = {"effective_modulus"}
"""Stiffness of a beam over its length, which is shorter at a wall: no parameter says that."""
PIECEWISE = {"flat_joint"}
"""Bonds of elements that break one by one, which lie in directions of their own: see `test_flat_joint`."""
NOT_LINEAR = {"hertz"}
SHEAR_FOLLOWS_LOAD = {"hertz_mindlin", "hertz_mindlin_rolling", "hertz_dmt"}
"""The shear spring is stiffer the more the two are pressed, and loses some of its energy as that changes."""
JUMPS = {"hertz_dmt"}
"""The force begins and ends with a jump."""
LOSSLESS = {"hertz"}
"""Neither friction nor anything that breaks."""

REGISTERED = {**CONTACT_LAWS, **BOND_LAWS}
CASES = [(REGISTERED[name], dimension) for name in LAWS for dimension in REGISTERED[name].DIMENSIONS]


def parameters_of(law, **changed):
    return make_parameters(law, {**LAWS[law.NAME], **changed}, "test")


def elastic_parameters(law):
    return parameters_of(law, **{k: v for k, v in ELASTIC.items() if k in law.PARAMETERS._fields})


class Motion(NamedTuple):
    """Increments of one step; vectors (3,), in 2D only the first component."""

    approach: float  # [m]
    slip: np.ndarray  # [m]
    twist: float  # [rad]
    bend: np.ndarray  # [rad]


def no_motion(**some):
    return Motion(**{"approach": 0.0, "slip": np.zeros(3), "twist": 0.0, "bend": np.zeros(3), **some})


class Answer(NamedTuple):
    """Forces and moments on a, and the utilisations of a bond (0, 0 of a contact)."""

    normal: float
    shear: np.ndarray
    twist_moment: float
    bend_moment: np.ndarray
    utilisation: tuple[float, float]

    def vector(self):
        return np.array([self.normal, *self.shear, self.twist_moment, *self.bend_moment])


class Pair:
    """Two particles, their law and what it remembers.

    A contact lives while overlap > 0, and once touched while overlap > -reach; a bond lives from the start until
    it is overstressed. What does not live has no force and no energy.
    """

    def __init__(
        self, law, parameters, dimension, *, scale=1.0, radii=(RADIUS_A, RADIUS_B), normal=(0.0, 0.0, 1.0)
    ):
        self.law = law
        self.is_bond = law.NAME in BOND_LAWS
        self.alive = self.is_bond
        self.broken = False
        self.overlap = 0.0
        self._dimension = dimension
        self._values = {
            **parameters._asdict(), "scale": scale, "radius_a": radii[0], "radius_b": radii[1],
            "mass_a": 3.0, "mass_b": 2.0, "time_step": 1e-6, "breaking": 1.0,
            **{f"normal_{axis}": value for axis, value in zip("xyz", normal, strict=True)},
        }  # fmt: skip
        start = self._call(law.bonded) if self.is_bond else [0.0] * len(history_arguments(law))
        self.history = np.array(start)
        self.answer = Answer(0.0, np.zeros(3), 0.0, np.zeros(3), (0.0, 0.0))

    def _call(self, function, **more):
        values = {**self._values, **more}
        plain = in_dimension(function, self._dimension)
        return plain(**{name: values[name] for name in argument_names(function)})

    def _state(self):
        distance = self._values["radius_a"] + self._values["radius_b"] - self.overlap
        names = history_arguments(self.law)
        return {"overlap": self.overlap, "distance": distance, **dict(zip(names, self.history, strict=True))}

    def step(self, motion):
        """Move, ask the law, keep its history; the answer is also `self.answer`."""
        if self._dimension == 3 and "normal_x" in argument_names(self.law.force):
            # told the normal, the law may take it that nothing slips or bends along it
            normal = np.array([self._values[f"normal_{axis}"] for axis in "xyz"])
            slip, bend = (part - (part @ normal) * normal for part in (motion.slip, motion.bend))
            motion = motion._replace(slip=slip, bend=bend)
        self.overlap += motion.approach
        approach = motion.approach
        if not self.is_bond:
            reach = self._call(self.law.reach) if hasattr(self.law, "reach") else 0.0
            if not self.alive and self.overlap > 0.0:
                self.alive, approach = True, self.overlap
            elif self.overlap <= (-reach if self.alive else 0.0):
                self.alive = False
        if not self.alive:
            self.history[:] = 0.0
            self.answer = Answer(0.0, np.zeros(3), 0.0, np.zeros(3), (0.0, 0.0))
            return self.answer
        increments = {
            "approach": approach, "twist": motion.twist,
            **{f"slip_{axis}": value for axis, value in zip("xyz", motion.slip, strict=True)},
            **{f"bend_{axis}": value for axis, value in zip("xyz", motion.bend, strict=True)},
        }  # fmt: skip
        given = np.array(self._call(self.law.force, **self._state(), **increments))
        forces = 8 if self.law.MOMENT else 4
        names = history_arguments(self.law)
        self.history = given[forces : forces + len(names)].copy()
        moments = given[4:8] if self.law.MOMENT else np.zeros(4)
        utilisation = tuple(given[forces + len(names) :]) if self.is_bond else (0.0, 0.0)
        self.answer = Answer(given[0], given[1:4], moments[0], moments[1:], utilisation)
        if self.is_bond and max(utilisation) >= self._values["breaking"]:
            self.alive, self.broken = False, True
            return self.step(no_motion())
        return self.answer

    def viscous(self, motion):
        increments = {
            "approach": motion.approach,
            **{f"slip_{axis}": value for axis, value in zip("xyz", motion.slip, strict=True)},
        }
        return np.array(self._call(self.law.viscous, **self._state(), **increments))

    def energy(self):
        return self._call(self.law.energy, **self._state()) if self.alive else 0.0

    def stiffness(self):
        return self._call(self.law.stiffness, **self._state())


def work(before, after, motion):
    """Work done on the pair in a step, by the mean of the forces at its two ends [J]."""
    mean = 0.5 * (before.vector() + after.vector())
    return float(mean @ [motion.approach, *motion.slip, motion.twist, *motion.bend])


def random_motion(rng, dimension, size=SIZE):
    """Increments as large as `size` (rotations: over the radius), in the law's dimension."""
    slip, bend = rng.normal(size=3) * size, rng.normal(size=3) * size / RADIUS_B
    twist = rng.normal() * size / RADIUS_B
    if dimension == 2:
        slip[1:], bend[1:], twist = 0.0, 0.0, 0.0
    return Motion(rng.normal() * size, slip, twist, bend)


def scaled(motion, factor):
    return Motion(*(factor * np.asarray(part) for part in motion))


def closed_path(rng, dimension, *, corners=5, steps=400, size=SIZE):
    """A polygon that ends where it begins, each side in equal steps."""
    sides = [random_motion(rng, dimension, size) for _ in range(corners)]
    back = Motion(*(-sum(np.asarray(part) for part in parts) for parts in zip(*sides, strict=True)))
    return [scaled(side, 1.0 / steps) for side in (*sides, back) for _ in range(steps)]
