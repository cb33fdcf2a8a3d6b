"""A tool through ground that flows, and where its face is slid on: `reference run cutting-clay`.

A bond that breaks leaves friction alone: a chip of such ground comes off at once and the tool then goes free, whatever
the ratio of its strengths. Clay keeps its cohesion as it shears: its grains stick wherever they touch as strongly as
they are bonded, four times as much against pull as against shear, so that it shears before it opens. The tool is
smoother than the ground inside (10 degrees beside a friction coefficient of 0.2 and cohesion), which would else shear
beside the face.

What slides is told from motion alone: contacts that move up the face by more than a twentieth of the tool's speed. Weak
rock is that of workflows/rock_cutting.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from geodem.case.cutting import CuttingCase
from geodem.laboratory.material import BondedMaterial

from .cutting import (
    ANGLE,
    DEPTHS,
    FACE,
    Group,
    Measured,
    case_of,
    changed,
    line_rows,
    mean,
    measured,
    power,
    scatter,
    seconds,
)
from .rows import Row, at_most, relative

MANY = tuple(range(1, 25))
SEEDS = MANY[:6]
FEW = MANY[:3]
ROCK = MANY[:2]
"""Packings of clay at every depth, of clay at another speed or damping, at other rakes, of weak rock. One packing's
mean over the way of a few depths scatters by 44 %: six leave 18 % at every point of the line, more than R2 lets."""
RAKES = (-15.0, 0.0, 15.0, 30.0)
SPEED = 1.0
"""[m/s]: of a wave 300 m/s, and about 15 passages of it through the depth until the force is up."""
SMOOTH = math.radians(10.0)
MODULUS = 200e6
TENSION, SHEAR, FRICTION = 6.7e6, 1.7e6, 0.2
SECTION = 0.9e-3
"""Mean of the bonds' [m]: twice the smaller radius of two grains."""
FLOWS = "Richard, Dagrain, Poyol & Detournay 2012, Eng. Geol. 147:91-100: ductile"


def clay(like: BondedMaterial) -> BondedMaterial:
    """Bonds, and grains that stick as strongly."""
    bond = dict(like.bond) | {
        "effective_modulus": MODULUS, "tensile_strength": TENSION, "shear_strength": SHEAR,
        "friction_coefficient": FRICTION,
    }  # fmt: skip
    stiffness = 0.735 * MODULUS
    contact = {
        "normal_stiffness": stiffness, "shear_stiffness": stiffness, "friction_coefficient": FRICTION,
        "adhesion": TENSION * SECTION, "adhesion_shear": SHEAR * SECTION,
        "normal_viscosity": 0.0, "shear_viscosity": 0.0,
    }  # fmt: skip
    return replace(like, bond=bond, contact=contact, contact_law="cohesive_frictional")


def cut(
    case: CuttingCase, seeds: Sequence[int], *, depth: float = 4.0, rake: float = 15.0, speed: float = SPEED,
    damping: float = 0.3,
) -> list[Measured]:  # fmt: skip
    """Clay at a depth [mm], rake [deg], speed [m/s] and local damping, in every packing."""
    (material,) = case.scene.materials.values()
    assert isinstance(material, BondedMaterial)
    cases = [
        changed(
            case, depth=1e-3 * depth, rake=math.radians(rake), friction=SMOOTH, speed=speed, seed=seed,
            material=clay(material),
        )
        for seed in seeds
    ]  # fmt: skip
    return [measured(replace(one, plan=replace(one.plan, damping=damping))) for one in cases]


def face_rows(name: str, group: Group, expected: float) -> list[Row]:
    """Direction of the force on the face [deg], mean of the packings, of all of it and of what slides up it."""
    share = sum(one.found.slid for one in group) / sum(one.found.pressed for one in group)
    rows = []
    for what, forces, told in (
        ("the force on the face", [one.found.parts["face"] for one in group], ""),
        (
            "the force where the face is slid on",
            [one.found.sliding for one in group],
            f"; {100.0 * share:.0f} % of the pressure on the face slides",
        ),
    ):
        cutting, normal = np.mean(forces, axis=0)
        angle = math.degrees(math.atan2(normal, cutting))
        quantity = f"angle of {what} to the path (difference) [deg]"
        rows.append(
            Row(
                name,
                quantity,
                angle,
                expected,
                angle - expected,
                ANGLE,
                seconds([group]) * (not told),
                FACE + told,
            )
        )
    return rows


def same_rows(name: str, usual: Group, other: Group) -> list[Row]:
    """What another speed or damping changes in the means of all packings."""
    rows = []
    for what, words in (("cutting", "mean cutting force"), ("peaks", "peaks of the cutting force")):
        source = (
            f"{FLOWS}; {len(other)} packings each, which scatter by {100.0 * scatter(usual, what):.0f} % and "
            f"{100.0 * scatter(other, what):.0f} %"
        )
        rows.append(
            relative(name, words, mean(other, what), mean(usual, what), 0.25, seconds([other]), source)
        )
    return rows


def rake_row(cuts: Mapping[float, Group]) -> Row:
    """The force falls with the rake."""
    forces = [mean(group, "cutting") for group in cuts.values()]
    rising = int((np.diff(forces) >= 0.0).sum())
    told = ", ".join(f"{force / 1e3:.3g}" for force in forces)
    source = f"class D: falls with the rake, Merchant 1944; Nishimatsu 1972; here {told} kN/m"
    quantity = "steps from -15 to 30 deg without a fall of the mean cutting force"
    return Row("clay, rake", quantity, rising, 0.0, rising, 0.0, seconds(cuts.values()), source)


def _free(one: Measured) -> float:
    """Share of the looks after entry with less than a fifth of the peaks [-]."""
    c = one.course.columns()
    return float(np.mean(c["cutting"][c["way"] >= one.found.first] < 0.2 * one.peaks))


def run() -> list[Row]:
    """All of them."""
    case = case_of("rock_cutting")
    cuts: dict[float, Group] = {depth: cut(case, MANY, depth=depth) for depth in DEPTHS}
    usual = cuts[4.0][: len(SEEDS)]
    rakes: dict[float, Group] = {rake: usual if rake == 15.0 else cut(case, FEW, rake=rake) for rake in RAKES}
    slow, damped = cut(case, SEEDS, speed=0.5 * SPEED), cut(case, SEEDS, damping=0.8)
    free = [_free(one) for one in usual]
    rows = line_rows("clay", cuts, "cutting", "mean cutting forces")
    rows += line_rows("clay", cuts, "peaks", "peaks")
    found = power(cuts)
    rows.append(
        Row(
            "clay",
            "power of depth in the specific energy (difference)",
            found,
            0.0,
            found,
            0.25,
            0.0,
            f"{FLOWS}: 0",
        )
    )
    rows.append(at_most("clay", "share of looks with a force below a fifth of the peaks", float(np.mean(free)), 0.2,
                        0.0, f"{FLOWS}: the force never falls off"))  # fmt: skip
    rows += same_rows("clay, half the speed", usual, slow)
    rows += same_rows("clay, local damping 0.8 for 0.3", usual, damped)
    rows.append(rake_row(rakes))
    for rake, group in rakes.items():
        rows += face_rows(f"clay, face of 10 deg, rake {rake:g} deg", group, 10.0 - rake)
    rock = {
        rake: [measured(changed(case, rake=math.radians(rake), seed=seed)) for seed in ROCK] for rake in RAKES
    }
    for rake, group in rock.items():
        rows += face_rows(f"weak rock, face of 20 deg, rake {rake:g} deg", group, 20.0 - rake)
    groups = [*cuts.values(), *rakes.values(), slow, damped, *rock.values()]
    worst = max((one.found.imbalance for group in groups for one in group), key=abs)
    rows.append(at_most("all cuts", "imbalance of the energy account", worst, 0.01, 0.0, "energy stays"))
    return rows
