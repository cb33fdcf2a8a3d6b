"""Points of a case in the plane or in space: bare numbers in one unit, or text with units of their own."""

from __future__ import annotations

import math
from dataclasses import dataclass

from geodem import units
from geodem.case.scene import Place
from geodem.case.table import Table
from geodem.errors import InputError


@dataclass(frozen=True)
class Places:
    """Reads points.

    Attributes
    ----------
    unit : str
        Of bare coordinates.
    dimension : int or None
        2 or 3; None where the file of the source tells.
    """

    unit: str
    dimension: int | None

    def point(self, table: Table, key: str) -> Place | None:
        """The point [m] of a key; None where it is missing or wrong, which has then been told."""
        return self.read(table, table.at(key), table.content[key]) if key in table else None

    def points(self, table: Table, key: str, *, fewest: int = 2) -> tuple[Place, ...]:
        """The points of a key, empty where something is wrong or missing."""
        if key not in table:
            return ()
        before = len(table.findings.errors)
        entries = table.items(key, example="[[0, 0], [10, 5]]")
        found = [self.read(table, f"{table.at(key)}[{k}]", entry) for k, entry in enumerate(entries)]
        if len(found) < fewest and len(table.findings.errors) == before:
            table.error(key, f"{fewest} points at least are needed here", f"Write {key} = [[0, 0], [10, 5]].")
        if len(table.findings.errors) > before:
            return ()
        return tuple(point for point in found if point is not None)

    def read(self, table: Table, place: str, value: object) -> Place | None:
        """A point at a place of the file."""
        findings = table.findings
        example = (
            "[x, y]" if self.dimension == 2 else "[x, y, z]" if self.dimension == 3 else "[x, y] or [x, y, z]"
        )
        sizes = (2, 3) if self.dimension is None else (self.dimension,)
        if not isinstance(value, list) or len(value) not in sizes:
            what = f"{len(value)} entries" if isinstance(value, list) else units.describe(value)
            findings.error(place, f"a point is needed here, not {what}", f"Write {example}.", value=value)
            return None
        found = [self._coordinate(table, f"{place}[{k}]", entry) for k, entry in enumerate(value)]
        return None if any(x is None for x in found) else tuple(x for x in found if x is not None)

    def _coordinate(self, table: Table, place: str, entry: object) -> float | None:
        if isinstance(entry, int | float) and not isinstance(entry, bool):
            value = float(entry) if abs(entry) < 1e12 else math.inf
            if math.isinf(value) or math.isnan(value):
                table.findings.error(place, "this is beyond all ground", f"Write a number in {self.unit}.")
                return None
            entry = f"{value!r} {self.unit}"
        try:
            return units.parse(entry, "length", place=place)
        except InputError as error:
            table.findings.errors.append(error)
            return None
