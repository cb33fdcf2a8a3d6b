"""What a scene is made of: bonded materials, loose ones, and what holds where two of them meet."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ..errors import InputError
from ..laboratory.material import BondedMaterial
from ..laws import CONTACT_LAWS
from ..laws.protocol import make_parameters


@dataclass(frozen=True)
class LooseMaterial:
    """Grains that touch and are not bonded.

    Attributes
    ----------
    density : float
        Of the ground, voids between the grains included [kg/m3].
    contact : dict of str to float
        Parameters of the law, SI.
    contact_law : str
        Name in `geodem.laws.CONTACT_LAWS`.
    name : str
    """

    density: float
    contact: Mapping[str, float]
    contact_law: str = "effective_modulus"
    name: str = "grains"

    def check(self) -> None:
        """Raise InputError where the law is not known, or a parameter is missing or out of range."""
        if self.contact_law not in CONTACT_LAWS:
            remedy = f"Choose one of: {', '.join(CONTACT_LAWS)}"
            raise InputError("material, contact law", "there is no such law", remedy, value=self.contact_law)
        make_parameters(CONTACT_LAWS[self.contact_law], self.contact, "material, contact")


SceneMaterial = BondedMaterial | LooseMaterial


@dataclass(frozen=True)
class Interface:
    """What holds between two materials instead of what follows from both.

    Where there is none, the laws' own rule holds: stiffnesses in series, the lower strength and friction. Pairs up to
    the smaller of the two bonding ranges are bonded, with the larger of the two scatters. Nothing bonds to a loose
    material.

    Attributes
    ----------
    first, second : str
        Materials; the same name twice: within it.
    bonded : bool
    strength : float
        Factor on the strength of its bonds [-].
    bond, contact : dict of str to float
        Parameters of the laws that replace those of the rule, SI.
    """

    first: str
    second: str
    bonded: bool = True
    strength: float = 1.0
    bond: Mapping[str, float] = field(default_factory=dict)
    contact: Mapping[str, float] = field(default_factory=dict)

    @property
    def pair(self) -> tuple[str, str]:
        """The two names, sorted."""
        return min(self.first, self.second), max(self.first, self.second)


def laws_of(materials: Mapping[str, SceneMaterial]) -> tuple[str, str | None]:
    """Laws of contacts and of bonds of a scene; None where nothing is bonded.

    Raises
    ------
    InputError
        No material, or materials with different laws: a scene has one of each.
    """
    if not materials:
        raise InputError("materials", "there is none", "Give one for each material of the ground")
    contacts = {name: material.contact_law for name, material in materials.items()}
    bonds = {name: m.bond_law for name, m in materials.items() if isinstance(m, BondedMaterial)}
    for kind, laws in (("contact", contacts), ("bond", bonds)):
        named = list(laws.items())
        other = next((each for each in named if each[1] != named[0][1]), None)
        if other is not None:
            raise InputError(
                f"material {other[0]!r}, {kind} law",
                f"{named[0][0]!r} has the {kind} law {named[0][1]!r}, and a scene has one for all",
                "Give all materials the same law, with parameters of their own", value=other[1],
            )  # fmt: skip
    return next(iter(contacts.values())), next(iter(bonds.values()), None)


def pair_range(first: SceneMaterial, second: SceneMaterial) -> float:
    """Up to how many times the sum of their radii apart particles of the two are bonded [-]; 0: not at all."""
    if isinstance(first, LooseMaterial) or isinstance(second, LooseMaterial):
        return 0.0
    return min(first.bonding_range, second.bonding_range)


def pair_scatter(first: BondedMaterial, second: BondedMaterial) -> BondedMaterial:
    """Which of the two says how the strength of their bonds scatters: the one with the larger variation."""
    return second if second.variation > first.variation else first


def check_interfaces(interfaces: Sequence[Interface], materials: Mapping[str, SceneMaterial]) -> None:
    """Raise InputError for an interface of materials that are not there, twice the same, or that cannot bond."""
    seen: set[tuple[str, str]] = set()
    for one in interfaces:
        place = f"interface of {one.first!r} and {one.second!r}"
        for name in (one.first, one.second):
            if name not in materials:
                raise InputError(
                    place, "there is no such material", f"Known: {', '.join(materials)}", value=name
                )
        if one.pair in seen:
            raise InputError(place, "it is given twice", "Keep one of the two")
        seen.add(one.pair)
        loose = [name for name in one.pair if isinstance(materials[name], LooseMaterial)]
        if loose and (one.bond or one.strength != 1.0):
            raise InputError(
                place, f"{loose[0]!r} has no bonds", "Give the contact alone, or give the material bonds"
            )
        if not (0.0 < one.strength < float("inf")):
            raise InputError(
                f"{place}, strength",
                "this is no factor",
                "Give more than 0, or bonded=False",
                value=one.strength,
            )
