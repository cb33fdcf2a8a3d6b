"""Laws between materials: each material's own parameters, what a pair overrides, and the tables made of both."""

from __future__ import annotations

import difflib
import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Wall
from geodem.errors import InputError
from geodem.laws.protocol import argument_names, in_dimension, make_parameters

Floats = NDArray[np.float64]
Numbers = Mapping[str, float]


def nearest(word: str, known: list[str]) -> str:
    """A question about the nearest known word, or a list of all."""
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"Did you mean {near[0]!r}?" if near else f"Known: {', '.join(sorted(known)) or 'none'}."


def law_numbers(law: ModuleType, function: str, dimension: int, menu: Numbers) -> tuple[float, ...]:
    """Answer of a law's function to those of the numbers in `menu` that its arguments name."""
    called = getattr(law, function)
    answer = in_dimension(called, dimension)(**{name: menu[name] for name in argument_names(called)})
    return tuple(answer)


def find_law(kind: str, name: str, laws: Mapping[str, ModuleType], dimension: int) -> ModuleType:
    """The law of that name, or `InputError` where there is none or it is made for another dimension."""
    place = f"{kind} law"
    if name not in laws:
        raise InputError(place, "there is no such law", nearest(name, list(laws)), value=name)
    law = laws[name]
    if dimension not in law.DIMENSIONS:
        fit = sorted(other for other, module in laws.items() if dimension in module.DIMENSIONS)
        raise InputError(
            place, f"the law is not made for {dimension}D", f"Take one of: {', '.join(fit)}.", value=name
        )
    return law


@dataclass
class Materials:
    """Materials with the laws between them.

    Attributes
    ----------
    contact_law, bond_law : module
    density : dict
        [kg/m3] by material, in the order of their numbers.
    contact, bond : dict
        Own parameters by material; a material that cannot be bonded has no entry in `bond`.
    contact_overrides, bond_overrides : dict
        By the two names, sorted; a name may be a wall's for contacts.
    """

    contact_law: ModuleType
    bond_law: ModuleType | None
    density: dict[str, float] = field(default_factory=dict)
    contact: dict[str, Any] = field(default_factory=dict)
    bond: dict[str, Any] = field(default_factory=dict)
    contact_overrides: dict[tuple[str, str], dict[str, float]] = field(default_factory=dict)
    bond_overrides: dict[tuple[str, str], dict[str, float]] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        """Names of the materials in the order of their numbers."""
        return list(self.density)

    def index(self, name: str, place: str) -> int:
        """Number of a material, or `InputError`."""
        if name not in self.density:
            raise InputError(place, "there is no such material", nearest(name, self.names), value=name)
        return self.names.index(name)

    def refuse_unknown_names(self, walls: list[str]) -> None:
        """Raise `InputError` for an override between names that are neither materials nor walls."""
        for kind, table, others in (
            ("contact", self.contact_overrides, walls),
            ("bond", self.bond_overrides, []),
        ):
            for pair in table:
                place = f"{kind} of {pair[0]!r} and {pair[1]!r}"
                known = self.names + others
                for name in pair:
                    if name not in known:
                        problem = f"there is no material{' or wall' if kind == 'contact' else ''} {name!r}"
                        raise InputError(place, problem, nearest(name, known))
                if not any(name in self.density for name in pair):
                    raise InputError(
                        place, "walls do not touch each other", "Name one material and one wall."
                    )

    def contact_table(self) -> Floats:
        """Parameters of the contact law, (m * m, k); row first * m + second."""
        return self._table("contact", self.contact_law, self.contact, self.contact_overrides)

    def bond_table(self) -> Floats:
        """Parameters of the bond law, (m * m, k); NaN between materials that cannot be bonded."""
        if self.bond_law is None:
            return np.empty((len(self.density) ** 2, 0))
        return self._table("bond", self.bond_law, self.bond, self.bond_overrides)

    def _table(
        self,
        kind: str,
        law: ModuleType,
        own: dict[str, Any],
        overrides: dict[tuple[str, str], dict[str, float]],
    ) -> Floats:
        names = self.names
        table = np.full((len(names), len(names), len(law.PARAMETERS._fields)), np.nan)
        for i, j in itertools.combinations_with_replacement(range(len(names)), 2):
            first, second = names[i], names[j]
            if first not in own or second not in own:
                continue
            parameters = law.combine(own[first], own[second])
            changed = overrides.get(pair_of(first, second))
            if changed:
                place = f"{kind} of {first!r} and {second!r}"
                parameters = make_parameters(law, parameters._asdict() | changed, place)
            table[i, j] = parameters
            # a law that knows which of the two is which
            turned = getattr(law, "reversed_pair", None)
            table[j, i] = parameters if turned is None else turned(parameters)
        return table.reshape(len(names) ** 2, -1)

    def against_wall(self, wall: Wall) -> Wall:
        """The wall with the contact law's parameter tuple for every material.

        What `wall.contact` holds goes over what follows from the material: numbers by name for all materials,
        or by material a dictionary of such numbers. Overrides of the pair go over both.
        """
        law = self.contact_law
        general = {name: value for name, value in wall.contact.items() if name not in self.density}
        for name, value in general.items():
            if isinstance(value, (Mapping, tuple)):
                place = f"wall {wall.name!r}, contact"
                raise InputError(place, "there is no such material", nearest(name, self.names), value=name)
        contact = {}
        for name in self.names:
            special = wall.contact.get(name, {})
            changed = general | dict(special if isinstance(special, Mapping) else special._asdict())
            changed |= self.contact_overrides.get(pair_of(name, wall.name), {})
            own = law.against_rigid(self.contact[name])._asdict()
            contact[name] = make_parameters(law, own | changed, f"contact of {name!r} and wall {wall.name!r}")
        return replace(wall, contact=contact)


def pair_of(first: str, second: str) -> tuple[str, str]:
    """Key of an override: the same whichever of the two names comes first."""
    return min(first, second), max(first, second)
