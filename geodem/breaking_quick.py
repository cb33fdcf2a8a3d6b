"""A case of breaking ground with few, large particles and wide brackets, for a first look."""

from __future__ import annotations

from dataclasses import replace

from .breaking.materials import SceneMaterial
from .case.breaking import BreakingCase
from .laboratory.material import BondedMaterial
from .scene_building import make_filling

QUICK_PARTICLES = 2500
QUICK_TOLERANCE = 0.2
LATTICE = "square"
"""Instead of one particle in each pixel."""
PER_CONTACT = {"two_springs": ("tensile_strength", "cohesion")}
"""Laws of discs with forces for each contact: they grow with the grain where the ground is to be as strong."""


def quick(case: BreakingCase) -> BreakingCase:
    """The case with few particles and wide brackets, for a first look.

    Raises
    ------
    InputError
        As of `geodem.scene_building.make_filling`.
    """
    stages = tuple(
        replace(one, values={**one.values, "tolerance": max(one.values["tolerance"], QUICK_TOLERANCE)})
        if "tolerance" in one.values
        else one
        for one in case.stages
    )
    options = case.scene.particles
    wide = replace(case, stages=stages)
    if options.grading is not None:
        notice = f"--quick: the particles are those of the grading; factors to {QUICK_TOLERANCE:.0%}."
        return replace(wide, notices=(*case.notices, notice))
    _, before = make_filling(case.scene, title=case.title, allow_implausible=case.allow_implausible)
    count = min(before.particles, QUICK_PARTICLES)
    arrangement = LATTICE if options.arrangement == "pixel" else options.arrangement
    few = replace(options, arrangement=arrangement, particles=count, radius=None)
    scene = replace(case.scene, particles=few)
    _, after = make_filling(scene, title=case.title, allow_implausible=case.allow_implausible)
    ratio = float(after.radii.mean() / before.radii.mean())
    materials = {name: _of_grains(material, ratio) for name, material in case.scene.materials.items()}
    notice = (
        f"--quick: about {count} particles, {ratio:.2g} times as large as the case's own; "
        f"factors to {QUICK_TOLERANCE:.0%}."
    )
    if materials != dict(case.scene.materials):
        notice += " Strengths that are given for each contact grow with the particles, so that the ground is as strong."
    return replace(wide, scene=replace(scene, materials=materials), notices=(*case.notices, notice))


def _of_grains(material: SceneMaterial, ratio: float) -> SceneMaterial:
    """A material whose bonds' forces, where its law has such, are those of grains `ratio` times as large."""
    if not isinstance(material, BondedMaterial) or material.bond_law not in PER_CONTACT:
        return material
    grown = {key: ratio * material.bond[key] for key in PER_CONTACT[material.bond_law]}
    return replace(material, bond={**material.bond, **grown})
