"""From a case of cutting to a cut ready to begin: ground, tool in its place, what it frees, initial stress."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from .assembly import Assembly
from .breaking.materials import LooseMaterial
from .breaking.scene import BondedScene, start
from .case.cutting import CuttingCase
from .case.cutting_reading import at_key
from .cutting.course import Course
from .cutting.pace import Pace
from .cutting.plan import FASTEST, SHALLOW, CuttingPlan, Placed, let_go, place_tool
from .errors import InputError, InputErrors
from .ground_building import GroundBody
from .laboratory.material import BondedMaterial
from .particle_simulation import ParticleSimulation
from .particle_statics import find_equilibrium
from .scene_building import make_filling, quick_particles, scene_of

Floats = NDArray[np.float64]
Made = TypeVar("Made")

SETTLED = 1e-3
"""Unbalanced ratio at which loose ground is at rest."""

QUICK_PARTICLES = 900
"""Of a cut for a first look."""

STRESSES = ("rock", "parallel_bond", "flat_joint")
"""Laws of bonds whose shear strength is a stress."""

WAVE = 3.0
"""Speed of compression waves over mean diameter and critical time step, about: that is the step's of the stiffest
contact, the wave's that of the whole."""


@dataclass(frozen=True, eq=False)
class Cut:
    """A cut ready to begin.

    Attributes
    ----------
    case : CuttingCase
    made : GroundBody
    scene : BondedScene
    assembly : Assembly
        Of the scene, without supports in the tool's way.
    placed : Placed
    freed : int
        Particles of the left side that are not held, because the tool comes in there.
    warnings : tuple of str
    """

    case: CuttingCase
    made: GroundBody
    scene: BondedScene
    assembly: Assembly
    placed: Placed
    freed: int
    warnings: tuple[str, ...]

    @property
    def plan(self) -> CuttingPlan:
        """How the tool is to cut."""
        return self.case.plan

    @property
    def solid_fraction(self) -> float:
        """Share of the ground's area that its particles fill [-]."""
        return self.scene.filling.solid_fraction

    @property
    def strength(self) -> float:
        """Smallest shear strength of bonds [Pa], at about which a chip breaks; nan where a law has no such stress."""
        known = [material.bond.get("shear_strength", math.nan) if isinstance(material, BondedMaterial)
                 and material.bond_law in STRESSES else math.nan
                 for material in self.case.scene.materials.values()]  # fmt: skip
        return min(known, default=math.nan)

    def begin(self) -> Course:
        """The cut at its beginning: at its initial stress where the case wants one, else loose ground at rest."""
        scene = replace(self.scene, assembly=self.assembly)
        simulation, _ = start(scene, local_damping=self.plan.damping, energy=True, orientation=False)
        loose = any(isinstance(each, LooseMaterial) for each in self.case.scene.materials.values())
        if loose and scene.initial_stress is None and self.assembly.gravity.any():
            find_equilibrium(simulation, tolerance=SETTLED, breaking=False)
        return Course(self.assembly, self.plan, self.placed, simulation=simulation)

    def resume(self, tree: object) -> Course:
        """The cut as a tree of `Course.tree` has it."""
        assert isinstance(tree, dict)
        return Course.resumed(self.assembly, self.plan, self.placed, tree)


def make_cut(case: CuttingCase) -> Cut:
    """Ground, tool and what holds them.

    Raises
    ------
    InputError, InputErrors
        As of `geodem.scene_building.make_scene`; a tool that cannot cut this ground, at its key of the case.
    """
    made, filling = make_filling(case.scene, title=case.title, allow_implausible=case.allow_implausible)
    body = made.body
    if body.dimension != 2:
        raise InputError("source", "a cut is a section, 2D", "Give a section of the ground")
    box = np.asarray(body.bounds, dtype=np.float64)
    placed = _told(lambda: place_tool(case.plan, filling.positions, filling.radii, box))
    scene = scene_of(case.scene, body, filling, walls=[case.plan.tool.wall(placed.place, _clean(case))])
    left = np.zeros(scene.assembly.particles, dtype=bool)
    left[scene.held.get("left", np.empty(0, dtype=np.int64))] = True
    assembly, freed = let_go(scene.assembly, placed, left)
    return Cut(case, made, scene, assembly, placed, freed, tuple(_warnings(case, scene, placed, freed)))


def _clean(case: CuttingCase) -> dict[str, float]:
    """Nothing sticks to the tool, whatever grains stick to each other with."""
    contacts = [material.contact for material in case.scene.materials.values()]
    return {key: 0.0 for key in ("adhesion", "adhesion_shear") if any(key in contact for contact in contacts)}


def _told(make: Callable[[], Made]) -> Made:
    """What `make` gives; its errors at the keys of the case."""
    try:
        return make()
    except InputErrors as errors:
        raise InputErrors([at_key(error) for error in errors.errors]) from None
    except InputError as error:
        raise at_key(error) from None


def _warnings(case: CuttingCase, scene: BondedScene, placed: Placed, freed: int) -> list[str]:
    found = list(scene.warnings)
    plan = case.plan
    across = plan.depth / placed.diameter
    if across < SHALLOW:
        found.append(
            f"The depth is {across:.1f} mean diameters: below {SHALLOW:g}, the roughness of the surface decides. "
            "Smaller particles or a deeper cut tell more."
        )
    if freed:
        found.append(
            f"{freed} particles of the left side are not held: the tool comes in there, and what is held is below its "
            "path."
        )
    low, _ = scene.box
    below = (placed.place[1] - low[1]) / plan.depth
    if below < 2.0:
        found.append(
            f"Below the path the ground is {below:.1f} depths thick: cracks may run to its bottom. From "
            "3 depths on the bottom hardly matters."
        )
    return found


def pace_of(cut: Cut, simulation: ParticleSimulation) -> Pace:
    """How fast the tool of a cut is for its ground."""
    low, high = cut.scene.box
    density = float(cut.assembly.mass.sum()) / float(np.prod(np.asarray(high) - np.asarray(low)))
    wave = cut.placed.diameter / (WAVE * simulation.critical_time_step)
    return Pace(cut.plan.speed, wave, density)


def speed_warning(pace: Pace) -> list[str]:
    """Words where inertia decides."""
    share = pace.speed / pace.wave
    if share <= FASTEST:
        return []
    return [
        f"The tool moves at {100.0 * share:.1f} % of the speed of compression waves ({pace.wave:.4g} m/s): inertia "
        f"adds to its forces. Below {100.0 * FASTEST:g} % it hardly does."
    ]


def quick(case: CuttingCase) -> CuttingCase:
    """The case with few particles and half the way, for a first look."""
    plan = case.plan
    entry = plan.entry if plan.entry is not None else 2.0 * plan.depth
    short = replace(plan, distance=0.5 * plan.distance, entry=0.5 * entry, frames=min(plan.frames, 4))
    scene = quick_particles(case.scene, QUICK_PARTICLES)
    if case.scene.particles.particles is not None and case.scene.particles.particles <= QUICK_PARTICLES:
        scene = case.scene
    notice = f"--quick: about {QUICK_PARTICLES} particles at most, and half the way."
    return replace(case, scene=scene, plan=short, notices=(*case.notices, notice))
