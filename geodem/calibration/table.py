"""What was measured on specimens of known bonds: the table that the map from micro to macro is fitted to, and its file.

The file is JSON, all numbers dimensionless or in radians:

    {"format": 1, "dimension": 2, "bond_law": "rock", "contact_law": "effective_modulus",
     "packing": "random", "across": 40, "size_ratio": 1.66, "source": "how it was measured, and when",
     "rows": [{"micro": {"stiffness_ratio": 2.5, "shear_over_tension": 4.0, "bond_friction": 0.577,
                         "residual_friction": 0.5, "bonding_range": 1.05, "moment_contribution": 0.0},
               "macro": {"modulus_ratio": [0.85, 0.84], "poisson_ratio": [0.21, 0.22], "tension_ratio": [0.62, 0.6],
                         "strength_ratio": [10.1, 10.8], "friction_angle": [0.75, 0.78]},
               "seeds": [1, 2]}, ...]}

A row may have a `packing` and an `across` of its own. A value that a seed did not give is null.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..laboratory.confined import CONFINED, LOW

Floats = NDArray[np.float64]

FORMAT = 1

MICRO = {
    "stiffness_ratio": "kappa = kn/ks of bonds and contacts",
    "shear_over_tension": "C/Tb, shear over tensile strength of a bond",
    "bond_friction": "t = tan(phi_b), friction coefficient of an intact bond",
    "residual_friction": "mu, friction coefficient once a bond is broken",
    "bonding_range": "pairs up to this many times the sum of their radii apart are bonded",
    "moment_contribution": "beta, share of the moments' stress that counts at the rim",
    "strength_variation": "coefficient of variation of the strength from bond to bond",
}
"""What is varied, all dimensionless. A name that a row lacks takes the value of `DEFAULTS`."""

DEFAULTS = {
    "residual_friction": 0.5,
    "bonding_range": 1.05,
    "moment_contribution": 0.0,
    "strength_variation": 0.0,
}

MACRO = {
    "modulus_ratio": "E/Ec, Young's modulus over the bonds' effective modulus",
    "poisson_ratio": "nu",
    "tension_ratio": "T/Tb, direct tensile strength over that of a bond",
    "strength_ratio": "R = UCS/T, uniaxial compressive over direct tensile strength",
    "friction_angle": "phi [rad], of the line through strengths between no confinement and half of UCS",
    "low_friction_angle": "the same, of the line up to a tenth of UCS",
    "compression_ratio": "UCS/Tb; follows seed by seed from R and T/Tb where it is not given",
}
"""What is measured."""

LOGARITHMIC = frozenset({"modulus_ratio", "tension_ratio", "strength_ratio", "compression_ratio"})
"""Macro answers that scatter and err by a factor; the others by a difference."""


@dataclass(frozen=True)
class MapRow:
    """One point of the map.

    Attributes
    ----------
    micro : dict of str to float
        Names of `MICRO`.
    macro : dict of str to tuple of float
        Names of `MACRO`; a value for each seed, NaN where a test gave none.
    seeds : tuple of int
        Of the specimens, in the order of the values.
    packing : str
    across : float
        Particles across the specimens.
    """

    micro: Mapping[str, float]
    macro: Mapping[str, tuple[float, ...]]
    seeds: tuple[int, ...]
    packing: str = "random"
    across: float = 40.0


@dataclass(frozen=True)
class MapTable:
    """The measured points of one dimension, law, packing and resolution.

    Attributes
    ----------
    dimension : int
    rows : tuple of MapRow
    bond_law, contact_law : str
    packing : str
    across, size_ratio : float
        Particles across the specimens, largest over smallest radius [-].
    source : str
        How it was measured.
    """

    dimension: int
    rows: tuple[MapRow, ...]
    bond_law: str = "rock"
    contact_law: str = "effective_modulus"
    packing: str = "random"
    across: float = 40.0
    size_ratio: float = 1.66
    source: str = ""
    notes: Mapping[str, Any] = field(default_factory=dict)

    def up_to(self, confinement: float) -> MapTable:
        """The same with friction angles of the line up to a confinement, given over the compressive strength [-].

        Straight in the logarithm of the confinement through the two that were measured, each seed by itself. Rows
        without the lower one stay as they are.
        """
        weight = math.log(CONFINED / confinement) / math.log(CONFINED / LOW)
        return replace(self, rows=tuple(_at_confinement(row, weight) for row in self.rows))

    def micro(self, name: str) -> Floats:
        """A micro-parameter of every row."""
        return np.array([row.micro.get(name, DEFAULTS.get(name, math.nan)) for row in self.rows])

    def macro(self, name: str) -> list[dict[int, float]]:
        """A macro answer of every row: its finite values by seed, in the scale in which they scatter."""
        found = []
        for row in self.rows:
            values = zip(row.seeds, row.macro.get(name, ()), strict=False)
            kept = {seed: value for seed, value in values if math.isfinite(value)}
            found.append({seed: to_scale(name, value) for seed, value in kept.items()})
        return found


def _at_confinement(row: MapRow, weight: float) -> MapRow:
    macro = dict(row.macro)
    low = macro.pop("low_friction_angle", None)
    if low is not None:
        macro["friction_angle"] = tuple(
            (1.0 - weight) * high + weight * other
            for high, other in zip(macro["friction_angle"], low, strict=True)
        )
    return replace(row, macro=macro)


def to_scale(name: str, value: float) -> float:
    """A macro answer in the scale in which it scatters: the logarithm of moduli and strengths."""
    return math.log(value) if name in LOGARITHMIC else value


def from_scale(name: str, value: float) -> float:
    """A macro answer from the scale in which it scatters."""
    return math.exp(value) if name in LOGARITHMIC else value


def load_table(path: Path) -> MapTable:
    """Read a map file.

    Raises
    ------
    InputError
        No file, no JSON, another format, an unknown name, or values that do not fit the seeds.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        remedy = "Measure the map of this dimension first, or check the path"
        raise InputError(str(path), f"the map cannot be read ({error.strerror})", remedy) from None
    except ValueError as error:
        raise InputError(str(path), f"this is no JSON: {error}", "Measure the map again") from None
    return table_of(content, place=str(path))


def table_of(content: Mapping[str, Any], *, place: str = "map") -> MapTable:
    """A table from the content of its file; raises as `load_table` does."""
    if content.get("format") != FORMAT:
        remedy = f"This geodem reads format {FORMAT}"
        raise InputError(f"{place}, format", "another format", remedy, value=content.get("format"))
    named = ("dimension", "bond_law", "contact_law", "packing", "across", "size_ratio", "source")
    head = {key: content[key] for key in named if key in content}
    packing, across = head.get("packing", "random"), head.get("across", 40.0)
    rows = []
    for number, entry in enumerate(content.get("rows", ())):
        where = f"{place}, rows[{number}]"
        for kind, known in (("micro", MICRO), ("macro", MACRO)):
            for name in entry[kind]:
                if name not in known:
                    raise InputError(
                        f"{where}.{kind}", "unknown name", f"Known: {', '.join(known)}", value=name
                    )
        seeds = tuple(int(seed) for seed in entry["seeds"])
        macro = {name: _values(values) for name, values in entry["macro"].items()}
        for name, values in macro.items():
            if len(values) != len(seeds):
                problem = f"{len(values)} values for {len(seeds)} seeds"
                raise InputError(
                    f"{where}.macro.{name}", problem, "Give one for each seed, null where a test failed"
                )
        if "compression_ratio" not in macro and {"strength_ratio", "tension_ratio"} <= macro.keys():
            pairs = zip(macro["strength_ratio"], macro["tension_ratio"], strict=True)
            macro["compression_ratio"] = tuple(ratio * tension for ratio, tension in pairs)
        micro = {name: float(value) for name, value in entry["micro"].items()}
        rows.append(
            MapRow(micro, macro, seeds, entry.get("packing", packing), float(entry.get("across", across)))
        )
    if not rows:
        raise InputError(f"{place}, rows", "there are none", "Measure the map first")
    notes = {key: value for key, value in content.items() if key not in {*named, "format", "rows"}}
    return MapTable(rows=tuple(rows), notes=notes, **head)


def content_of(table: MapTable) -> dict[str, Any]:
    """What `table_of` makes the same table of: a document for JSON."""
    return {
        "format": FORMAT,
        "dimension": table.dimension,
        "bond_law": table.bond_law,
        "contact_law": table.contact_law,
        "packing": table.packing,
        "across": table.across,
        "size_ratio": table.size_ratio,
        "source": table.source,
        **table.notes,
        "rows": [
            {
                "micro": dict(row.micro),
                "macro": {name: [_json(value) for value in values] for name, values in row.macro.items()},
                "seeds": list(row.seeds),
                **({"packing": row.packing} if row.packing != table.packing else {}),
                **({"across": row.across} if row.across != table.across else {}),
            }
            for row in table.rows
        ],
    }


def _values(values: Sequence[float | None]) -> tuple[float, ...]:
    return tuple(math.nan if value is None else float(value) for value in values)


def _json(value: float) -> float | None:
    return value if math.isfinite(value) else None
