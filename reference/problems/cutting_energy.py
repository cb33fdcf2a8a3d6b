"""Specific energy and peaks over depth, from ground that flows to rock that chips: `reference run cutting-energy`.

Clay is that of `cutting-clay`, weak rock that of workflows/rock_cutting, sandstone that of `cutting`; marl has bonds
that are weak in shear. Compressive and tensile strength of marl are what `geodem lab` measures, 10 and 5.5 MPa.
Depths of rock are told over the length (toughness/strength)^2, where toughness of bonded grains is about the bonds'
tensile strength times the root of pi and the mean radius: Potyondy & Cundall 2004, Int. J. Rock Mech. Min. Sci.
41:1329-1364. Draws docs/pictures/cutting_energy.png.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geodem.case.cutting import CuttingCase
from geodem.laboratory.material import BondedMaterial

from . import cutting_clay
from .cutting import (
    BRITTLE_DEPTHS,
    DEPTHS,
    STRENGTH,
    Group,
    brittle,
    case_of,
    changed,
    mean,
    measured,
    power,
    scatter,
    seconds,
)
from .cutting_picture import Line, draw
from .rows import Row

SEEDS = (1, 2)
BOUND = 0.25
"""Of powers: of 0 where ground is ductile, of -1/2 where it is brittle."""
DUCTILE = "ductile: 0; Richard, Dagrain, Poyol & Detournay 2012, Eng. Geol. 147:91-100"
BRITTLE = "brittle: -0.5 where toughness decides: Bazant 1984, J. Eng. Mech. 110:518-535"
MARL_DEPTHS = (2.0, 4.0, 6.0)
MARL_STRENGTH, MARL_MODULUS = 10e6, 1.13e9
MARL_BOND = {"tensile_strength": 10e6, "shear_strength": 5e6, "friction_coefficient": 0.0}


class Ground(NamedTuple):
    """Cuts of one ground: its compressive strength and its bonds' tensile strength [Pa], 0 where nothing is scaled."""

    name: str
    strength: float
    tension: float
    cuts: Mapping[float, Group]

    def lengths(self, depth: float) -> float:
        """A depth [mm] over (toughness/strength)^2 [-]; not a number where nothing is scaled."""
        if not self.tension:
            return math.nan
        radius = 0.5 * next(iter(self.cuts.values()))[0].course.placed.diameter
        return 1e-3 * depth * (self.strength / self.tension) ** 2 / (math.pi * radius)

    def line(self) -> Line:
        """What is drawn of it."""
        return Line(
            self.name,
            np.array(list(self.cuts)),
            np.array([np.mean([one.found.specific_energy for one in group]) for group in self.cuts.values()]),
            np.array([self.lengths(depth) for depth in self.cuts]),
            np.array([mean(group, "peaks") / (1e-3 * depth) for depth, group in self.cuts.items()])
            / (self.strength or 1.0),
        )


def marl(like: BondedMaterial) -> BondedMaterial:
    """Bonds that give way in shear, as soft for their strength as the rock of the workflow is at most."""
    stiffness = 0.735 * MARL_MODULUS
    contact = dict(like.contact) | {"normal_stiffness": stiffness, "shear_stiffness": stiffness}
    return replace(
        like, bond=dict(like.bond) | MARL_BOND | {"effective_modulus": MARL_MODULUS}, contact=contact
    )


def grounds(case: CuttingCase) -> list[Ground]:
    """All cuts."""
    (weak,) = case.scene.materials.values()
    assert isinstance(weak, BondedMaterial)

    def cut(material: BondedMaterial | None, depth: float, speed: float) -> Group:
        cases = [
            changed(case, depth=1e-3 * depth, speed=speed, seed=seed, material=material) for seed in SEEDS
        ]
        return [measured(one) for one in cases]

    speed = case.plan.speed
    return [
        Ground("clay", 0.0, 0.0, {depth: cutting_clay.cut(case, SEEDS, depth=depth) for depth in DEPTHS[::2]}),
        Ground("marl", MARL_STRENGTH, MARL_BOND["tensile_strength"],
               {depth: cut(marl(weak), depth, 0.4 * speed) for depth in MARL_DEPTHS}),
        Ground("weak rock", STRENGTH, 3.97e6, {depth: cut(None, depth, speed) for depth in DEPTHS[::2]}),
        Ground("sandstone", 80e6, 7.66e6,
               {depth: cut(brittle(case), depth, 2.0 * speed) for depth in BRITTLE_DEPTHS}),
    ]  # fmt: skip


def _row(name: str, words: str, found: float, expected: float, took: float, source: str) -> Row:
    return Row(
        name,
        f"power of depth in {words} (difference)",
        found,
        expected,
        found - expected,
        BOUND,
        took,
        source,
    )


def run() -> list[Row]:
    """Powers of every ground and of all rocks together."""
    found = grounds(case_of("rock_cutting"))
    rows = []
    for ground in found:
        line = ground.line()
        peaks = float(np.polyfit(np.log(line.depth), np.log(line.peaks), 1)[0])
        between = 100.0 * np.mean([scatter(group, "cutting") for group in ground.cuts.values()])
        expected, source = (0.0, DUCTILE) if ground.name == "clay" else (-0.5, BRITTLE)
        told = f"{source}; {len(SEEDS)} packings a depth, which scatter by {between:.0f} %"
        took = seconds(ground.cuts.values())
        rows.append(_row(ground.name, "the specific energy", power(ground.cuts), expected, took, told))
        rows.append(_row(ground.name, "the peaks over depth", peaks, expected, 0.0, told))
    rocks = [ground.line() for ground in found if ground.strength]
    lengths = np.concatenate([line.lengths for line in rocks])
    all_peaks = np.concatenate([line.peaks for line in rocks])
    through = float(np.polyfit(np.log(lengths), np.log(all_peaks), 1)[0])
    span = f"all rocks, {lengths.min():.2g} to {lengths.max():.3g} lengths deep"
    rows.append(_row(span, "the peaks over depth and strength", through, -0.5, 0.0, BRITTLE))
    draw([ground.line() for ground in found])
    return rows
