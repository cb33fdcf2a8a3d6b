"""Laws between materials: each material's own parameters, what a pair overrides, and the tables made of both."""

from __future__ import annotations

import difflib
import inspect
import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Wall
from geodem.errors import InputError

Floats = NDArray[np.float64]
Numbers = Mapping[str, float]


def nearest(word: str, known: list[str]) -> str:
    """A question about the nearest known word, or a list of all."""
    near = difflib.get_close_matches(word, known, n=1, cutoff=0.5)
    return f"Did you mean {near[0]!r}?" if near else f"Known: {', '.join(sorted(known)) or 'none'}."


def named_call(function: Any, menu: Mapping[str, float]) -> Any:
    """Call a function of a law with those of the numbers that its arguments name."""
    return function(**{name: menu[name] for name in inspect.signature(function).parameters})


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


def law_parameters(law: ModuleType, place: str, values: Numbers) -> Any:
    """The law's parameter tuple from numbers by name; `InputError` for one that lacks, one too many, or a bad one."""
    fields = list(law.PARAMETERS._fields)
    refuse_unknown(law, place, values)
    lacking = [name for name in fields if name not in values and name not in law.PARAMETERS._field_defaults]
    if lacking:
        raise InputError(
            place,
            f"the law {law.NAME!r} lacks {', '.join(lacking)}",
            f"Give {', '.join(f'{name}=...' for name in lacking)} in SI units.",
        )
    return checked(law, place, law.PARAMETERS(**{name: number(place, name, values[name]) for name in values}))


def refuse_unknown(law: ModuleType, place: str, values: Numbers) -> None:
    """Raise `InputError` for a parameter that the law does not have."""
    fields = list(law.PARAMETERS._fields)
    for name in values:
        if name not in fields:
            raise InputError(
                f"{place}, {name}",
                f"the law {law.NAME!r} has no such parameter",
                nearest(name, fields),
                value=values[name],
            )


def number(place: str, name: str, value: Any) -> float:
    """The value as a float, or `InputError`."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise InputError(
            f"{place}, {name}", "this is not a number", "Give one number in SI units.", value=value
        ) from None


def checked(law: ModuleType, place: str, parameters: Any) -> Any:
    """The parameters, or `InputError` for the first one that the law cannot work with."""
    for name, value in parameters._asdict().items():
        if math.isnan(value):
            raise InputError(f"{place}, {name}", "this is not a number", "Give a number.", value=value)
    for name, problem, remedy in law.check(parameters):
        raise InputError(f"{place}, {name}", problem, remedy, value=getattr(parameters, name))
    return parameters


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

    def override(self, kind: str, first: str, second: str, values: Numbers) -> None:
        """Parameters that a pair has instead of those that follow from the two materials."""
        law = self.contact_law if kind == "contact" else self.bond_law
        assert law is not None
        place = f"{kind} of {first!r} and {second!r}"
        refuse_unknown(law, place, values)
        table = self.contact_overrides if kind == "contact" else self.bond_overrides
        key = (min(first, second), max(first, second))
        table.setdefault(key, {}).update({name: number(place, name, values[name]) for name in values})

    def refuse_unknown_names(self, walls: list[str]) -> None:
        """Raise `InputError` for an override between names that are neither materials nor walls."""
        for kind, table, others in (
            ("contact", self.contact_overrides, walls),
            ("bond", self.bond_overrides, []),
        ):
            for pair in table:
                place = f"{kind} of {pair[0]!r} and {pair[1]!r}"
                for name in pair:
                    if name not in self.density and name not in others:
                        known = self.names + others
                        raise InputError(
                            place, "this is neither a material nor a wall", nearest(name, known), value=name
                        )
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
            parameters = own[first] if i == j else law.combine(own[first], own[second])
            changed = overrides.get((min(first, second), max(first, second)))
            if changed:
                place = f"{kind} of {first!r} and {second!r}"
                parameters = checked(law, place, parameters._replace(**changed))
            table[i, j] = table[j, i] = parameters
        return table.reshape(len(names) ** 2, -1)

    def against_wall(self, wall: Wall) -> Wall:
        """The wall with the contact law's parameter tuple for every material.

        What `wall.contact` holds goes over what follows from the material: numbers by name for all materials,
        or by material a dictionary of such numbers. Overrides of the pair go over both.
        """
        law = self.contact_law
        place = f"wall {wall.name!r}, contact"
        general = {name: value for name, value in wall.contact.items() if name not in self.density}
        for name, value in general.items():
            if isinstance(value, (Mapping, tuple)):
                raise InputError(place, "there is no such material", nearest(name, self.names), value=name)
        refuse_unknown(law, place, general)
        contact = {}
        for name in self.names:
            changed = dict(general)
            special = wall.contact.get(name, {})
            changed |= special._asdict() if isinstance(special, law.PARAMETERS) else special
            key = (min(name, wall.name), max(name, wall.name))
            changed |= self.contact_overrides.get(key, {})
            here = f"{place} with {name!r}"
            refuse_unknown(law, here, changed)
            numbers = {field: number(here, field, value) for field, value in changed.items()}
            parameters = law.against_rigid(self.contact[name])._replace(**numbers)
            contact[name] = checked(law, here, parameters)
        return replace(wall, contact=contact)
