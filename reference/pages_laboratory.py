"""What the virtual laboratory is held to: groups of results on docs/verification.md."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from reference.pages_particles import Group, group_sections
from reference.pages_tables import Row, number, table

GROUPS = (
    Group(
        "laboratory-elastic",
        "Specimens and beams of DICE2D's laboratory: modulus and Poisson's ratio",
        "Elastic states of the specimens of Zhao (2015), section 2.5, solved as networks, and of a face-centred block. "
        "Poisson's ratio of irregular specimens passes 1/3 where a disc has few bonds.\n\n"
        "![Poisson's ratio against ks/kn](pictures/laboratory_poisson.png)\n\n"
        "Three statements of the text cannot be those of its own model. Its modulus of the triangular packing without "
        "shear springs, kn/sqrt3 (57 MPa, equation 2.6), is half of what the lattice has; the 40 MPa that it finds "
        "from its beam lie below both. 800 steps of its table 2.7 are a fifth of the beam's period, so that nothing is "
        "at rest after them. With bonds as wide as the discs (WRT 1) it finds no elastic line: here that beam is as "
        "elastic as the others, solved or brought to rest by the engine, and merely stiffer. The height that a beam of "
        "n rows counts with is (n (n^2 - 1))^(1/3) rows without shear springs, neither H nor H - D; with one height "
        "for all ks/kn the modulus rises less than that of the lattice.",
    ),
    Group(
        "laboratory-dice2d",
        "Strengths of DICE2D's laboratory: tension, splitting, compression",
        "The tests of Zhao (2015), section 3.3, begun from the elastic state and driven slowly. Strengths are in Ft "
        "over the diameter D of 20 m that the text's 400 m x 695.5 m and its number of discs ask for. Its 3 MPa for "
        "the triangular specimen are 1.5 Ft over 10 m: twice what all bonds of a section bear together.\n\n"
        "![Tension by four parameters](pictures/laboratory_dice2d_tension.png)\n\n"
        "A triangular specimen breaks at the load at which its most loaded bond does, cohesion and friction cut that "
        "off as the closed form has it, and ks/kn counts for a third, not for a tenth. The text's coefficients of "
        "irregular specimens are what the bonds of a straight section bear if all of them reach Ft at once. They do "
        "not here: one of the first breaks is the last, at less than half of that. Specimens of half the width, discs "
        "all alike, bonds of any width or a rate thirty times higher, tried on a few seeds, change it by 15 % at most. "
        "The ratios of splitting and compression to this tension are higher than the text's. Splitting is between "
        "plane walls, as in the text, at 20 discs across.\n\n"
        "![Splitting, compression, envelopes](pictures/laboratory_dice2d_strength.png)",
    ),
    Group(
        "laboratory-convergence",
        "What a strength is worth: rate, time step, resolution",
        "Two rocks in 2D. The peak of one specimen scatters from seed to seed, and by rounding alone, since which "
        "bond breaks first decides about the next ones: what is compared are means, rates and steps specimen by "
        "specimen. Each figure stands with the deviation of one specimen and the standard error of the mean.\n\n"
        "![Strengths against rate and resolution](pictures/laboratory_convergence.png)",
    ),
    Group(
        "laboratory-step",
        "Hard rock at half the time step",
        "Ten specimens of granite leave an error of the mean larger than the 2 % that are asked for; these are forty.",
    ),
    Group(
        "laboratory-tests",
        "Splitting, bending, direct shear",
        "Discs between jaws that bear on 10 degrees of the rim, beams, blocks in a split box; one rock. Figures of the "
        "middle of a disc are means over a circle, brought to the middle by the closed form.\n\n"
        "The envelope of direct shear is steeper than that of triaxial tests, with a smaller cohesion: at low normal "
        "stress the block tears between the halves of the box, piece by piece, before it shears, and falls short of "
        "Mohr and Coulomb's line; the higher the normal stress, the less. "
        "Beams are 20 discs high: how much more bending gives than tension depends on the height, and 1.5 to 3 is "
        "recalled from textbooks, not looked up.",
    ),
    Group(
        "laboratory-laws",
        "Laws of bonded grains on the same specimens",
        "Compression, tension and confined compression of the same random specimens in 2D, law by law: what the choice "
        "of the law rests on. The figures of all laws follow.",
    ),
)


def laboratory_sections(read: Callable[[str], Any], header: Callable[[Any], str], not_run: str) -> list[str]:
    """Texts of all groups; `read` gives what is stored under a name, `header` its origin."""
    # pictures are drawn when the problems are run
    groups = [group if read(group.name).rows else _without_pictures(group) for group in GROUPS]
    parts = ["## Laboratory\n", *group_sections(groups, read, header, not_run)]
    stored = read("laboratory-laws-table")
    return [*parts, laws_table(stored.rows)] if stored.rows else parts


def _without_pictures(group: Group) -> Group:
    kept = [part for part in group.text.split("\n\n") if not part.startswith("![")]
    return group._replace(text="\n\n".join(kept))


def laws_table(rows: Sequence[Row]) -> str:
    """A line a law: means over the specimens; strains and stresses over those at the peak."""
    head = [
        "law", "C/Tb", "phi_b [deg]", "E/Ec", "nu", "T/Tb", "UCS/T", "friction [deg]", "m_i", "peak strain E/UCS",
        "initiation", "damage", "torn [%]", "cut [%]", "specimens",
    ]  # fmt: skip
    return table(head, [_law(row) for row in rows])


def _law(row: Row) -> list[str]:
    deviation = f" +- {number(row['ratio_deviation'], 2)}"
    return [
        str(row["law"]), number(row["C/Tb"]), number(row["phi_b_deg"]), number(row["modulus_share"], 3),
        number(row["poisson"], 2), number(row["tension_share"], 2), number(row["ratio"], 3) + deviation,
        number(math.degrees(row["friction"]), 2), number(row["m_i"], 2), number(row["ductility"], 3),
        number(row["initiation"], 2), number(row["damage"], 2), number(100.0 * row["torn"], 2),
        number(100.0 * row["cut"], 2), str(row["specimens"]),
    ]  # fmt: skip
