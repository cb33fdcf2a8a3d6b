"""A tool through rock: force on its face, depth, rake, specific energy, DICE2D's cutter: `reference run cutting`.

The rock is that of workflows/rock_cutting: weak, with bonds as the calibration map gives them for a compressive
strength of 15 MPa, a tensile one of 2 MPa and a friction angle of 32 degrees. Brittle rock is Darley Dale sandstone
(80 MPa and 3.85 MPa, 40.6 degrees), from the same map. Broken grains do not roll freely (rolling friction 1): discs
that roll between chip and face bear it like rollers, and the force on the face is then that of a smoother tool.
Means of several packings: one alone gives a force of a few chips.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

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
BRITTLE_DEPTHS = (1.25, 2.5, 5.0, 8.0)
"""[mm]. Toughness is about the bonds' tensile strength times the root of pi and the mean radius (Potyondy & Cundall
2004, Int. J. Rock Mech. Min. Sci. 41:1329-1364), 0.3 MPa m^0.5; over the strength and squared it is 0.014 mm (weak
rock: 0.11 mm), so that all depths that grains of 1 mm can show should lie on the brittle side."""
SEEDS = (1, 2, 3)
FEW = (1, 2)
RAKES = (-15.0, 0.0, 30.0)
STRENGTH, TENSION, FRICTION = 15e6, 2e6, math.radians(32.0)
ANGLE = 3.0
"""Largest difference of the force's direction on the face [deg]."""
FACE = "Merchant 1944, J. Appl. Phys. 16:267-275: friction angle of the face less its rake"
LINEAR = "linear in depth: Evans & Pomeroy 1966; Merchant 1944; Nishimatsu 1972"


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

    @property
    def peaks(self) -> float:
        """Mean of the peaks of every stretch as long as the depth [N/m]."""
        return self.found.cutting.peaks


Group = Sequence[Measured]


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


def seconds(groups: Iterable[Group]) -> float:
    """Of all their cuts [s]."""
    return sum(one.seconds for group in groups for one in group)


def mean(group: Group, what: str) -> float:
    """Of the packings, of `what` (`cutting` or `peaks`) [N/m]."""
    return float(np.mean([getattr(one, what) for one in group]))


def scatter(group: Group, what: str) -> float:
    """Standard deviation between packings over their mean [-]."""
    return float(np.std([getattr(one, what) for one in group], ddof=1)) / mean(group, what)


def face_row(name: str, group: Group, case: CuttingCase) -> Row:
    """Direction of the mean force of all packings on the face beside friction angle less rake."""
    tool = case.plan.tool
    expected = math.degrees(tool.friction_angle - tool.rake)
    cutting, normal = np.mean([one.found.parts["face"] for one in group], axis=0)
    angle = math.degrees(math.atan2(normal, cutting))
    what = "angle of the force on the face to the path (difference) [deg]"
    return Row(name, what, angle, expected, angle - expected, ANGLE, seconds([group]), FACE)


def line_rows(name: str, cuts: Mapping[float, Group], what: str, words: str) -> list[Row]:
    """Straight line through the means of all packings."""
    depth = np.array(list(cuts))
    force = np.array([mean(group, what) for group in cuts.values()])
    slope, intercept = np.polyfit(depth, force, 1)
    missed = float(((force - slope * depth - intercept) ** 2).sum() / ((force - force.mean()) ** 2).sum())
    between = float(np.mean([scatter(group, what) for group in cuts.values()]))
    told = f"{LINEAR}; {len(next(iter(cuts.values())))} packings a depth, which scatter by {100.0 * between:.0f} %"
    over = float(intercept / force[-1])
    return [
        Row(name, f"R2 of the line through {words} (difference)", 1.0 - missed, 1.0, -missed, 0.05,
            seconds(cuts.values()), told),
        Row(name, f"intercept of the line through {words} over its value at the largest depth (difference)", over, 0.0,
            over, 0.2, 0.0, "no force without depth"),
    ]  # fmt: skip


def power(cuts: Mapping[float, Group]) -> float:
    """Of depth in the specific energy, by the means of all packings [-]."""
    energy = [np.mean([one.found.specific_energy for one in group]) for group in cuts.values()]
    return float(np.polyfit(np.log(list(cuts)), np.log(energy), 1)[0])


def formula_row(
    name: str, group: Group, what: str, words: str, expected: float, bound: float, source: str
) -> Row:
    """log10 of a force over that of a formula."""
    ratio = mean(group, what) / expected
    return Row(name, f"log10 of {words} over {source.split(' ')[0]}'s (difference)", math.log10(ratio), 0.0,
               math.log10(ratio), bound, 0.0,
               f"class D, factor {ratio:.2f} of {expected / 1e3:.4g} kN/m: {source}")  # fmt: skip


def rake_rows(cuts: Mapping[float, Group], case: CuttingCase) -> list[Row]:
    """The force falls with the rake, and stands beside the formulae."""
    rakes = sorted(cuts)
    rows = []
    for what, words in (("cutting", "the mean cutting force"), ("peaks", "the peaks of the cutting force")):
        forces = [mean(cuts[rake], what) for rake in rakes]
        rising = sum(later >= earlier for earlier, later in itertools.pairwise(forces))
        rows.append(
            Row("rake", f"steps from -15 to 30 deg without a fall of {words}", rising, 0.0, rising, 0.0,
                seconds(cuts.values()), "class D: falls with the rake, Merchant 1944; Nishimatsu 1972")
        )  # fmt: skip
        friction = case.plan.tool.friction_angle
        for rake in rakes:
            own = nishimatsu(STRENGTH, FRICTION, case.plan.depth, math.radians(rake), friction)
            rows.append(
                formula_row(f"rake {rake:g} deg", cuts[rake], what, words, own, 0.5,
                             "Nishimatsu 1972, for the force that breaks a chip, with n = 0: Merchant's formula")
            )  # fmt: skip
        half = math.radians(0.5 * (90.0 - 15.0))
        own = evans(TENSION, case.plan.depth, half + friction)
        rows.append(
            formula_row("rake 15 deg", cuts[15.0], what, words, own, 0.7,
                         "Evans & Pomeroy 1966, for the force that breaks a chip: wedge of 75 deg with friction")
        )  # fmt: skip
    return rows


def speed_rows(usual: Group, slow: Group) -> list[Row]:
    """What half the speed changes in the means of all packings."""
    rows = []
    for what, words in (("cutting", "mean cutting force"), ("peaks", "peaks of the cutting force")):
        source = (
            f"slow enough where it does not matter; {len(slow)} packings each, which scatter by "
            f"{100.0 * scatter(usual, what):.0f} % and {100.0 * scatter(slow, what):.0f} %"
        )
        rows.append(
            relative(
                "half the speed", words, mean(slow, what), mean(usual, what), 0.25, seconds([slow]), source
            )
        )
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


def each(case: CuttingCase, seeds: Sequence[int], **changes: Any) -> list[Measured]:
    """A cut in every packing."""
    return [measured(changed(case, seed=seed, **changes)) for seed in seeds]


def run() -> list[Row]:
    """All of them."""
    case = case_of("rock_cutting")
    own = round(math.degrees(case.plan.tool.rake), 6)
    cuts = {depth: each(case, SEEDS, depth=1e-3 * depth) for depth in DEPTHS}
    usual = cuts[round(1e3 * case.plan.depth, 6)]
    smooth = each(case, (1,), friction=0.0)
    rakes = {own: usual} | {rake: each(case, FEW, rake=math.radians(rake)) for rake in RAKES}
    rows = [face_row("smooth face, rake 15 deg", smooth, changed(case, friction=0.0))]
    rows += [
        face_row(f"rough face, rake {rake:g} deg", rakes[rake], changed(case, rake=math.radians(rake)))
        for rake in sorted(rakes)
    ]
    rows += line_rows("weak rock", cuts, "cutting", "mean cutting forces")
    rows += line_rows("weak rock", cuts, "peaks", "peaks")
    ductile = power(cuts)
    rows.append(
        Row("weak rock", "power of depth in the specific energy (difference)", ductile, 0.0, ductile, 0.25, 0.0,
            "ductile: 0; Richard, Dagrain, Poyol & Detournay 2012, Eng. Geol. 147:91-100")
    )  # fmt: skip
    rows += rake_rows(rakes, case)
    # as far below its wave speed
    rock, fast = brittle(case), 2.0 * case.plan.speed
    hard = {depth: each(case, FEW, depth=1e-3 * depth, material=rock, speed=fast) for depth in BRITTLE_DEPTHS}
    fall = power(hard)
    rows.append(
        Row("sandstone, UCS over tension 21", "power of depth in the specific energy (difference)", fall, -0.5,
            fall + 0.5, 0.5, seconds(hard.values()),
            "brittle: falls, -0.5 where toughness decides: Bazant 1984, J. Eng. Mech. 110:518-535")
    )  # fmt: skip
    slow = each(case, SEEDS, speed=0.5 * case.plan.speed)
    rows += speed_rows(usual, slow)
    groups = [*cuts.values(), *hard.values(), *rakes.values(), smooth, slow]
    worst = max((one.found.imbalance for group in groups for one in group), key=abs)
    rows.append(at_most("all cuts", "imbalance of the energy account", worst, 0.01, 0.0, "energy stays"))
    return [*rows, *dice2d()]
