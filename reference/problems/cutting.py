"""A tool through rock: force on its face, depth, rake, specific energy, DICE2D's cutter: `reference run cutting`.

The rock is that of workflows/rock_cutting: weak, with bonds as the calibration map gives them for a compressive
strength of 15 MPa, a tensile one of 2 MPa and a friction angle of 32 degrees. Brittle rock is Darley Dale sandstone
(80 MPa and 3.85 MPa, 40.6 degrees), from the same map. Broken grains do not roll freely (rolling friction 1): discs
that roll between chip and face bear it like rollers, and the force on the face is then that of a smoother tool.
"""

from __future__ import annotations

import itertools
import math
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from geodem.case.cutting import CuttingCase
from geodem.case.cutting_reading import parse_cutting
from geodem.cutting.course import Course
from geodem.cutting.outcome import Outcome, chip_facts, outcome
from geodem.cutting_building import make_cut
from geodem.laboratory.material import BondedMaterial

from .cutting_formulae import evans, nishimatsu
from .rows import Row, at_most, relative

WORKFLOWS = Path(__file__).resolve().parents[2] / "workflows"
DEPTHS = (2.0, 3.0, 4.0, 5.0, 6.0)
"""[mm], and mean diameters, about."""
BRITTLE_DEPTHS = (2.0, 4.0, 6.0)
SEEDS = (1, 2)
RAKES = (-15.0, 0.0, 30.0)
STRENGTH, TENSION, FRICTION = 15e6, 2e6, math.radians(32.0)
ANGLE = 3.0
"""Largest difference of the force's direction on the face [deg]."""
P19 = "CASES P19: force on the face inclined by the friction angle to its normal"


@dataclass(frozen=True, eq=False)
class Measured:
    """One cut."""

    course: Course
    found: Outcome
    seconds: float

    @property
    def cutting(self) -> float:
        """Mean cutting force [N/m]."""
        return self.found.cutting.mean


def case_of(name: str) -> CuttingCase:
    """The case of a workflow."""
    folder = WORKFLOWS / name
    return parse_cutting((folder / "case.toml").read_text(encoding="utf-8"), folder)


def changed(
    case: CuttingCase,
    *,
    depth: float | None = None,
    rake: float | None = None,
    friction: float | None = None,
    speed: float | None = None,
    seed: int = 1,
    material: BondedMaterial | None = None,
) -> CuttingCase:
    """The same with another depth [m], rake, friction angle of the tool [rad], speed [m/s], packing or rock."""
    plan = case.plan
    tool = replace(
        plan.tool,
        rake=plan.tool.rake if rake is None else rake,
        friction_angle=plan.tool.friction_angle if friction is None else friction,
    )
    plan = replace(plan, tool=tool, depth=plan.depth if depth is None else depth, frames=4)
    plan = replace(plan, speed=plan.speed if speed is None else speed)
    scene = replace(case.scene, particles=replace(case.scene.particles, seed=seed))
    if material is not None:
        scene = replace(scene, materials={name: replace(material, name=name) for name in scene.materials})
    return replace(case, plan=plan, scene=scene)


def measured(case: CuttingCase) -> Measured:
    """Cut to the end."""
    begun = time.perf_counter()
    cut = make_cut(case)
    course = cut.begin()
    while not course.finished:
        course.advance()
    return Measured(course, outcome(course, cut.solid_fraction), time.perf_counter() - begun)


def brittle(case: CuttingCase) -> BondedMaterial:
    """Darley Dale sandstone: bonds of the calibration map, contacts as the weak rock's, as stiff as its bonds allow."""
    weak = next(iter(case.scene.materials.values()))
    modulus = 29.85e9
    share = weak.contact["normal_stiffness"] / 6.78e9
    contact = dict(weak.contact) | {
        "normal_stiffness": share * modulus, "shear_stiffness": share * modulus, "friction_coefficient": 0.5,
    }  # fmt: skip
    bond = {
        "effective_modulus": modulus, "stiffness_ratio": 2.73, "tensile_strength": 7.66e6, "shear_strength": 48.4e6,
        "friction_coefficient": 0.656, "moment_contribution": 0.0,
    }  # fmt: skip
    return BondedMaterial(2250.0, bond, contact, contact_law=weak.contact_law)


def face_row(name: str, one: Measured, case: CuttingCase) -> Row:
    """Direction of the mean force on the face beside friction angle less rake."""
    tool = case.plan.tool
    expected = math.degrees(tool.friction_angle - tool.rake)
    angle = math.degrees(one.found.face_angle)
    what = "angle of the force on the face to the path (difference) [deg]"
    return Row(name, what, angle, expected, angle - expected, ANGLE, one.seconds, P19)


def depth_rows(name: str, cuts: dict[float, list[Measured]]) -> list[Row]:
    """Straight line through the cutting forces, and the power of the specific energy."""
    depth = np.array([key for key, group in cuts.items() for _ in group])
    force = np.array([one.cutting for group in cuts.values() for one in group]) * 1e-3
    mean = np.array([np.mean([one.cutting for one in group]) for group in cuts.values()]) * 1e-3
    each = np.array(list(cuts))
    seconds = sum(one.seconds for group in cuts.values() for one in group)
    slope, intercept = np.polyfit(each, mean, 1)
    missed = float(((mean - slope * each - intercept) ** 2).sum() / ((mean - mean.mean()) ** 2).sum())
    power = float(np.polyfit(np.log(depth), np.log(force / depth), 1)[0])
    source = "CASES P19: cutting force linear in depth where rock is ductile"
    rows = [
        Row(name, "R2 of the line through mean cutting forces (difference)", 1.0 - missed, 1.0, -missed, 0.05,
            seconds, source),
        Row(name, "its intercept over the force at the largest depth (difference)", float(intercept / mean[-1]), 0.0,
            float(intercept / mean[-1]), 0.2, 0.0, "no force without depth"),
        Row(name, "power of depth in the specific energy (difference)", power, 0.0, power, 0.25, 0.0,
            "ductile: 0; Richard, Dagrain, Poyol & Detournay 2012, Eng. Geol. 147:91-100"),
    ]  # fmt: skip
    return rows


def rake_rows(cuts: dict[float, Measured], case: CuttingCase) -> list[Row]:
    """The force falls with the rake, and stands beside the formulae."""
    rakes = sorted(cuts)
    forces = [cuts[rake].cutting for rake in rakes]
    rising = sum(later >= earlier for earlier, later in itertools.pairwise(forces))
    rows = [
        Row("rake", "steps from -15 to 30 deg at which the cutting force does not fall", rising, 0.0, rising, 0.0, 0.0,
            "CASES P19, class D: falling with rake")
    ]  # fmt: skip
    friction = case.plan.tool.friction_angle
    for rake, force in zip(rakes, forces, strict=True):
        own = nishimatsu(STRENGTH, FRICTION, case.plan.depth, math.radians(rake), friction)
        rows.append(
            Row(f"rake {rake:g} deg", "log10 of the cutting force over Nishimatsu's (difference)",
                math.log10(force / own), 0.0, math.log10(force / own), 0.5, cuts[rake].seconds,
                f"class D, factor {force / own:.2f}; Nishimatsu with n = 0 is Merchant's formula: {own / 1e3:.4g} kN/m")
        )  # fmt: skip
    half = math.radians(0.5 * (90.0 - 15.0))
    own = evans(TENSION, case.plan.depth, half + friction)
    force = cuts[15.0].cutting
    rows.append(
        Row("rake 15 deg", "log10 of the cutting force over Evans's (difference)", math.log10(force / own), 0.0,
            math.log10(force / own), 0.7, 0.0,
            f"class D, factor {force / own:.2f}; a symmetric wedge of 75 deg with friction: {own / 1e3:.4g} kN/m")
    )  # fmt: skip
    return rows


def dice2d() -> list[Row]:
    """DICE2D's cutter, table 4.2: a crack ahead of the tool, chips, an account that closes."""
    one = measured(case_of("dice2d_cutter"))
    facts, cracks = chip_facts(one.found), one.found.cracks
    source = "Zhao 2015, section 4.3.2: fractures ahead of the cutter, then chips"
    n = one.course.assembly.particles
    return [
        relative("DICE2D's cutter", "particles", n, 2843, 0.01, one.seconds, "table 4.2"),
        Row("DICE2D's cutter", "cracks more than a particle ahead of the tip, none (1) or some (0)", cracks["ahead"],
            1.0, float(cracks["ahead"] == 0), 0.0, 0.0, source),
        Row("DICE2D's cutter", "chips of more than one particle, none (1) or some (0)", facts["chips"], 1.0,
            float(facts["chips"] == 0), 0.0, 0.0, source),
        at_most("DICE2D's cutter", "imbalance of the energy account", one.found.imbalance, 0.01, 0.0, "energy stays"),
    ]  # fmt: skip


def run() -> list[Row]:
    """All of them."""
    case = case_of("rock_cutting")
    own = round(math.degrees(case.plan.tool.rake), 6)
    cuts = {
        depth: [measured(changed(case, depth=1e-3 * depth, seed=seed)) for seed in SEEDS] for depth in DEPTHS
    }
    usual = cuts[1e3 * case.plan.depth][0]
    smooth = changed(case, friction=0.0)
    plain = measured(smooth)
    rakes = {own: usual} | {rake: measured(changed(case, rake=math.radians(rake))) for rake in RAKES}
    rows = [face_row("smooth face, rake 15 deg", plain, smooth)]
    rows += [
        face_row(f"rough face, rake {rake:g} deg", rakes[rake], changed(case, rake=math.radians(rake)))
        for rake in sorted(rakes)
    ]
    rows += depth_rows("weak rock", cuts)
    rows += rake_rows(rakes, case)
    rock = brittle(case)
    hard = {
        depth: [measured(changed(case, depth=1e-3 * depth, material=rock, speed=2.0 * case.plan.speed))]
        for depth in BRITTLE_DEPTHS
    }
    energy = [group[0].found.specific_energy for group in hard.values()]
    fall = math.log(energy[-1] / energy[0]) / math.log(BRITTLE_DEPTHS[-1] / BRITTLE_DEPTHS[0])
    rows.append(
        Row("sandstone, UCS over tension 21", "power of depth in the specific energy (difference)", fall, -0.5,
            fall + 0.5, 0.5, sum(group[0].seconds for group in hard.values()),
            "brittle: falls, -0.5 where toughness decides")
    )  # fmt: skip
    slow = measured(changed(case, speed=0.5 * case.plan.speed))
    rows.append(
        relative("half the speed", "mean cutting force", slow.cutting, usual.cutting, 0.25, slow.seconds,
                 "slow enough where it does not matter; two packings differ by as much as the line's scatter")
    )  # fmt: skip
    every = [one for group in [*cuts.values(), *hard.values()] for one in group] + [
        plain,
        slow,
        *rakes.values(),
    ]
    worst = max((one.found.imbalance for one in every), key=abs)
    rows.append(at_most("all cuts", "imbalance of the energy account", worst, 0.01, 0.0, "energy stays"))
    return [*rows, *dice2d()]
