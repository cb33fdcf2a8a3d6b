"""What the laws of bonded grains make of the same specimens: `python -m reference run laboratory-laws`.

Strength ratio, friction, brittleness, cracks and cost by law. In 2D random specimens, modulus 30 GPa, stiffness ratio
2.5, tensile strength of a bond 8 MPa. What is held to bounds is what the choice of the law `rock` rests on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from geodem.laboratory.envelope import fit_envelope
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.properties import measure_properties
from geodem.laboratory.specimen import make_specimen

from ..results_file import store_rows
from .laboratory_points import FAST, Mean, in_processes
from .rows import Row, at_most, relative

MODULUS, STRENGTH, KAPPA, RESIDUAL = 30e9, 8e6, 2.5, 0.5
"""Effective modulus and tensile strength of bonds [Pa], kn/ks, friction of broken bonds."""

ACROSS = 20.0
SEEDS = (1, 2, 3)

OURS = "bound ours"


class Law(NamedTuple):
    """A material as the table has it; `ratio` is C/Tb, `angle` phi_b [deg]."""

    label: str
    ratio: float
    angle: float
    material: BondedMaterial


def rock(
    ratio: float, angle: float, beta: float = 0.0, reach: float = 1.05, residual: float = RESIDUAL
) -> Law:
    """Bonds of the law `rock`."""
    label = f"rock, beta {beta:g}, range {reach:g}" + (f", mu {residual:g}" if residual != RESIDUAL else "")
    material = BondedMaterial.rock(
        density=2500.0, effective_modulus=MODULUS, stiffness_ratio=KAPPA, tensile_strength=STRENGTH,
        shear_strength=ratio * STRENGTH, friction_angle=math.radians(angle), moment_contribution=beta,
        residual_friction=residual, bonding_range=reach,
    )  # fmt: skip
    return Law(label, ratio, angle, material)


def of_law(name: str, label: str, base: Law, **values: float) -> Law:
    """The same material with another bond law."""
    bond = dict(base.material.bond)
    del bond["moment_contribution"]
    return base._replace(label=label, material=replace(base.material, bond={**bond, **values}, bond_law=name))


def cement(ratio: float, angle: float) -> Law:
    """The classical parallel bond with all of its moments, beside contacts of the same modulus."""
    return of_law("cement", "cement, beta 1, range 1.05", rock(ratio, angle), radius_factor=1.0)


def flat_joint(ratio: float, angle: float, reach: float) -> Law:
    """Faces of four elements."""
    label = f"flat joint, range {reach:g}"
    base = rock(ratio, angle, reach=reach)
    return of_law("flat_joint", label, base, residual_friction_coefficient=RESIDUAL)


def classical() -> Law:
    """As Potyondy & Cundall (2004) have it: both strengths equal, 157 +- 36 MPa there, no friction."""
    law = cement(1.0, 0.0)
    scattered = replace(law.material, variation=36.0 / 157.0, distribution="normal")
    return law._replace(label="cement, beta 1, range 1.05, scattered", material=scattered)


SANDSTONE, GRANITE = rock(3.0, 30.0), rock(6.0, 45.0, 0.3, 1.3)
SOFT = rock(2.0, 0.0, residual=0.35)
LAWS = (
    classical(),
    cement(3.0, 30.0),
    rock(3.0, 30.0, 1.0),
    rock(3.0, 30.0, 0.3),
    SANDSTONE,
    SOFT,
    rock(6.0, 0.0),
    rock(6.0, 40.0),
    *(rock(4.0, 45.0, reach=reach) for reach in (1.05, 1.2, 1.35, 1.5)),
    GRANITE,
    flat_joint(10.0, 0.0, 1.05),
    flat_joint(10.0, 0.0, 1.25),
)


class Figures(NamedTuple):
    """Of one specimen: E [Pa], nu, tensile and compressive strength [Pa], their ratio, friction [rad], m_i, strain at
    the peak times E over the strength, crack initiation and damage over the strength, shares of bonds that were broken
    by tension and by shear at the peak, run time [s]."""

    young: float
    poisson: float
    tension: float
    compression: float
    ratio: float
    friction: float
    m_i: float
    ductility: float
    initiation: float
    damage: float
    torn: float
    cut: float
    seconds: float


def characterise(asked: tuple[Law, int, float, int]) -> Figures:
    """All of it, of a law on the specimen with a seed, so many particles across, of a dimension."""
    law, seed, across, dimension = asked
    found = measure_properties(make_specimen(dimension, across=across, seed=seed), law.material, pace=FAST)
    _, pressed, confined = found.records
    n = pressed.numbers
    line = fit_envelope([0.0, confined.numbers["confinement"]], [pressed.strength, confined.strength])
    return Figures(
        found.young_modulus, found.poisson_ratio, found.tensile_strength, found.compressive_strength,
        found.compressive_strength / found.tensile_strength, found.friction_angle, line.m_i,
        n["peak_strain"] * found.young_modulus / pressed.strength, n["crack_initiation_stress"] / pressed.strength,
        n["crack_damage_stress"] / pressed.strength, n["tension_cracks_at_peak"] / n["bonds"],
        n["shear_cracks_at_peak"] / n["bonds"], found.seconds,
    )  # fmt: skip


Table = Mapping[str, tuple[Law, Mapping[str, Mean]]]
"""By label with strengths: a law, and every figure's mean over the specimens."""


def key(law: Law) -> str:
    """Of a law in a table."""
    return f"{law.label}, C/Tb {law.ratio:g}, phi_b {law.angle:g}"


def points(across: float = ACROSS, seeds: tuple[int, ...] = SEEDS) -> list[tuple[Law, int, float, int]]:
    """All laws on all specimens in 2D."""
    return [(law, seed, across, 2) for law in LAWS for seed in seeds]


def tabulate(asked: Sequence[tuple[Law, int, float, int]], told: Sequence[Figures]) -> Table:
    """Means over the specimens, law by law."""
    found: dict[str, tuple[Law, list[Figures]]] = {}
    for (law, *_), figures in zip(asked, told, strict=True):
        found.setdefault(key(law), (law, []))[1].append(figures)
    return {
        name: (law, {field: Mean.of(getattr(f, field) for f in all_of) for field in Figures._fields})
        for name, (law, all_of) in found.items()
    }


def stored(table: Table) -> list[dict[str, object]]:
    """Rows of the table, as they are stored: means, and deviations of one specimen."""
    return [
        {
            "law": law.label,
            "C/Tb": law.ratio,
            "phi_b_deg": law.angle,
            "modulus_share": means["young"].value / MODULUS,
            "tension_share": means["tension"].value / STRENGTH,
            **{field: mean.value for field, mean in means.items()},
            **{f"{field}_deviation": mean.deviation for field, mean in means.items()},
            "specimens": means["ratio"].number,
        }
        for law, means in table.values()
    ]


def rows(table: Table) -> list[Row]:
    """What the choice rests on."""
    told = {name: means for name, (_, means) in table.items()}
    spent = {name: means["seconds"].value * means["seconds"].number for name, means in told.items()}
    first = told[key(classical())]["ratio"]
    name = key(classical())
    found = [
        relative(name, "compressive over tensile strength" + scatter(first), first.value, BOOK, 0.25, spent[name],
                 "Potyondy & Cundall 2004: 199.1 over 44.7 MPa in 2D, the latter of Brazilian tests"),
    ]  # fmt: skip
    whole, none = key(rock(3.0, 30.0, 1.0)), key(SANDSTONE)
    share = told[whole]["ratio"].value / told[none]["ratio"].value
    found.append(
        at_most(none, "strength ratio with all of the moments over that with none", share, 0.6,
                spent[whole] + spent[none], OURS)
    )  # fmt: skip
    ours = {name: means for name, means in told.items() if name.startswith("rock")}
    total = sum(spent[name] for name in ours)
    ratios = {name: means["ratio"].value for name, means in ours.items()}
    angles = {name: math.degrees(means["friction"].value) for name, means in ours.items()}
    for quantity, values, low, high in (
        ("compressive over tensile strength", ratios, 5.0, 25.0),
        ("friction angle [deg]", angles, 25.0, 55.0),
    ):
        least, most = min(values, key=values.__getitem__), max(values, key=values.__getitem__)
        found += [
            at_most(least, f"least {quantity} of rock", values[least], low, total, ROCKS),
            at_least(most, f"largest {quantity} of rock", values[most], high, total, ROCKS),
        ]
    for law in (SANDSTONE, GRANITE):
        name = key(law)
        means, took = told[name], spent[name]
        found.append(
            at_most(name, "strain at the peak times E over the strength" + scatter(means["ductility"]),
                    means["ductility"].value, 1.5, took, OURS)
        )  # fmt: skip
        for field, word, low, high in (
            ("initiation", "crack initiation", 0.3, 0.5),
            ("damage", "crack damage", 0.7, 0.9),
        ):
            value = means[field].value
            middle, half = 0.5 * (low + high), 0.5 * (high - low)
            found.append(
                Row(name, f"{word} over the peak, {low:g} to {high:g}" + scatter(means[field]), value, middle,
                    value - middle, half, took, STRESSES)
            )  # fmt: skip
    return found


BOOK = 199.1 / 44.7
ROCKS = "rock: compressive over tensile strength 8 to 25, friction 30 to 57 deg; bound ours"
STRESSES = "rock: cracks begin at 0.3 to 0.5 of the peak, dilation at 0.7 to 0.9 (Martin & Chandler 1994: 0.4 and 0.8)"


def at_least(name: str, quantity: str, value: float, limit: float, spent: float, source: str) -> Row:
    """A row whose error is how far the value lies below a limit, over the limit."""
    return Row(name, quantity, value, limit, min(value / limit - 1.0, 0.0), 1e-9, spent, source)


def scatter(mean: Mean) -> str:
    """The deviation of one specimen, as text."""
    return f"; deviation {mean.deviation:.2g}, {mean.number} specimens"


def run() -> list[Row]:
    """All of them; the whole table is stored as laboratory-laws-table."""
    asked = points()
    table = tabulate(asked, in_processes(characterise, asked))
    store_rows("laboratory-laws-table", stored(table), "python -m reference run laboratory-laws")
    return rows(table)
