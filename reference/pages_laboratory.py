"""What the virtual laboratory is held to: groups of results on docs/verification.md."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from reference.pages_particles import Group, group_sections

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
)


def laboratory_sections(read: Callable[[str], Any], header: Callable[[Any], str], not_run: str) -> list[str]:
    """Texts of all groups; `read` gives what is stored under a name, `header` its origin."""
    return ["## Laboratory\n", *group_sections(GROUPS, read, header, not_run)]
