"""A material of bonded grains in a case or in a file of its own: its keys, read and written."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from types import ModuleType
from typing import Any

from geodem import units
from geodem.case.section import positive
from geodem.case.table import Table, listed, quoted
from geodem.laboratory.material import DISTRIBUTIONS, BondedMaterial
from geodem.laws import BOND_LAWS, CONTACT_LAWS

FIELDS = {
    "effective_modulus": "stress",
    "stiffness_ratio": "dimensionless",
    "tensile_strength": "stress",
    "shear_strength": "stress",
    "friction_coefficient": "dimensionless",
    "residual_friction_coefficient": "dimensionless",
    "moment_contribution": "dimensionless",
    "radius_factor": "dimensionless",
}
"""Parameters of laws that a material file can hold: those that do not depend on the size of the grains."""

_SPRINGS = {"normal_stiffness": "line_load", "shear_stiffness": "line_load"}
_DASHPOTS = {"normal_viscosity": "time", "shear_viscosity": "time"}
PER_CONTACT = {
    "two_springs": {
        **_SPRINGS, "tensile_strength": "force", "cohesion": "force", "friction_coefficient": "dimensionless",
        "width_ratio": "dimensionless", **_DASHPOTS,
    },
    "linear_frictional": {**_SPRINGS, "friction_coefficient": "dimensionless", **_DASHPOTS},
    "linear_incremental": {**_SPRINGS, "friction_coefficient": "dimensionless", **_DASHPOTS},
    "linear_rolling": {
        **_SPRINGS, "friction_coefficient": "dimensionless", "rolling_friction": "dimensionless",
        "twisting_friction": "dimensionless", **_DASHPOTS,
    },
    "cohesive_frictional": {
        **_SPRINGS, "friction_coefficient": "dimensionless", "adhesion": "force", "adhesion_shear": "force",
        **_DASHPOTS,
    },
}  # fmt: skip
"""Parameters of laws whose numbers are those of one contact and go with the size of its grains; scenes alone take
them, as in tables of DICE2D: per metre of depth in 2D."""

COMMON = ("law", "density", "bonding_range", "strength_variation", "strength_distribution", "contact")

_DENSITY = (1000.0, 5100.0)
_MODULUS = (1e6, 1e13)
_STRENGTH_PER_MODULUS = 0.1
_LARGEST_COEFFICIENT = 5.0
_LARGEST_RANGE = 2.0
_USUAL_FRICTION = 0.5
_UNLIMITED = "unlimited"


def bond_laws(*, per_contact: bool = False) -> tuple[str, ...]:
    """Laws of bonds that a material file can name; with `per_contact` those of `PER_CONTACT` too."""
    return tuple(
        name for name, law in BOND_LAWS.items() if _fits(law) or (per_contact and name in PER_CONTACT)
    )


def contact_laws(*, per_contact: bool = False) -> tuple[str, ...]:
    """Laws of contacts that a material file can name; `per_contact` as of `bond_laws`."""
    return tuple(
        name for name, law in CONTACT_LAWS.items() if _fits(law) or (per_contact and name in PER_CONTACT)
    )


def dimension_of(law: str, name: str) -> str:
    """Dimension of a parameter of a law."""
    return PER_CONTACT[law][name] if law in PER_CONTACT else FIELDS[name]


def material_lines(material: BondedMaterial, *, place: str = "") -> list[str]:
    """The keys of a material, the contact's table last.

    Parameters
    ----------
    place : str
        Dotted key of the table that they stand in, "" for a file of their own.
    """
    contact = f"{place}.contact" if place else "contact"
    return [
        f"law = {quoted(material.bond_law)}",
        f"density = {exact(material.density, 'density')}",
        *law_lines(material.bond_law, material.bond),
        f"bonding_range = {material.bonding_range!r}",
        f"strength_variation = {material.variation!r}",
        f"strength_distribution = {quoted(material.distribution)}",
        "",
        f"[{contact}]",
        f"law = {quoted(material.contact_law)}",
        *law_lines(material.contact_law, material.contact),
    ]


def law_lines(law: str, values: Mapping[str, float]) -> list[str]:
    """One line for each parameter of a law."""
    return [f"{name} = {_written(law, name, value)}" for name, value in values.items()]


def material_keys(content: Mapping[str, Any], *, per_contact: bool = False) -> tuple[str, ...]:
    """Keys of a material: those of every law, and those of the law that it names."""
    return (*COMMON, *_parameters(BOND_LAWS, content.get("law"), bond_laws(per_contact=per_contact)))


def read_material(table: Table, *, name: str, per_contact: bool = False) -> BondedMaterial | None:
    """The material of a table with the keys `material_keys`; None where something is wrong, which has been told.

    `per_contact`: laws of `PER_CONTACT` may be named.
    """
    findings = table.findings
    before = len(findings.errors)
    law = table.choice("law", bond_laws(per_contact=per_contact))
    if "law" not in table:
        table.missing("law", f'Write law = "rock". Known: {listed(bond_laws())}.')
    density = table.quantity("density", "density", check=positive)
    if "density" not in table:
        table.missing("density", 'Write density = "2600 kg/m3".')
    elif density is not None and not _DENSITY[0] <= density <= _DENSITY[1]:
        remedy = "Check the unit: water has 1000 kg/m3."
        findings.implausible(
            table.at("density"), "rocks have 1000 to 5100 kg/m3", remedy, value=table.content["density"]
        )
    bonding_range = table.quantity("bonding_range", "dimensionless", check=_range)
    if "bonding_range" not in table:
        bonding_range = BondedMaterial.bonding_range
        findings.default(table.at("bonding_range"), str(bonding_range))
    variation = table.quantity("strength_variation", "dimensionless", check=_variation)
    if "strength_variation" not in table:
        variation = 0.0
        findings.default(table.at("strength_variation"), "0", why="all bonds alike")
    distribution: str | None = BondedMaterial.distribution
    if "strength_distribution" in table or variation:
        distribution = table.choice("strength_distribution", DISTRIBUTIONS, default=distribution)
    bond = read_law(table, BOND_LAWS[law], {}) if law is not None else None
    contact_law, contact = read_contact(table, bond, per_contact=per_contact)
    if bond is not None:
        _doubt_bond(table, bond)
    if len(findings.errors) > before:
        return None
    assert density is not None
    assert bond is not None
    assert contact is not None
    assert bonding_range is not None
    assert variation is not None
    assert law is not None
    assert distribution is not None
    return BondedMaterial(
        density=density,
        bond=bond,
        contact=contact,
        bond_law=law,
        contact_law=contact_law,
        bonding_range=bonding_range,
        variation=variation,
        distribution=distribution,
        name=name,
    )


def read_contact(
    table: Table, bond: Mapping[str, float] | None, *, per_contact: bool = False
) -> tuple[str, dict[str, float] | None]:
    """The law of contacts: what it shares with the bond is the bond's where it is left out.

    `bond`: None where it is wrong, empty where there is none.
    """
    usual = BondedMaterial.contact_law
    if per_contact and table.content.get("law") in tuple(PER_CONTACT):
        usual = "linear_frictional"
    laws = contact_laws(per_contact=per_contact)
    content = table.content.get("contact", {})
    named = content.get("law", usual) if isinstance(content, dict) else usual
    known = ("law", *_parameters(CONTACT_LAWS, named, laws))
    if "contact" in table:
        inner = table.sub("contact", known, example='[contact] with law = "effective_modulus"')
        if inner is None:
            return usual, None
    else:
        inner = Table(table.findings, table.at("contact"), {}, known)
    law = inner.choice("law", laws, default=usual)
    if law is None:
        return usual, None
    fields = CONTACT_LAWS[law].PARAMETERS._fields
    # where the bond is wrong, what would be taken from it is not missing as well
    shared = bond if bond is not None else dict.fromkeys(fields, math.nan)
    taken = {key: value for key, value in shared.items() if key in fields and "friction" not in key}
    if "friction_coefficient" in fields:
        taken["friction_coefficient"] = _USUAL_FRICTION
    return law, read_law(inner, CONTACT_LAWS[law], taken)


def read_law(table: Table, law: ModuleType, usual: Mapping[str, float]) -> dict[str, float] | None:
    """Parameters of a law; those left out take the value of `usual`, or the law's own default, and that is noted."""
    findings = table.findings
    before = len(findings.errors)
    values: dict[str, float] = {}
    for name in law.PARAMETERS._fields:
        if name in table:
            value = _read_parameter(table, law.NAME, name)
            if value is not None:
                values[name] = value
            continue
        defaults = {**law.PARAMETERS._field_defaults, **usual}
        if name in defaults:
            values[name] = defaults[name]
            if math.isnan(defaults[name]):
                continue
            why = "as the bond's" if name in usual and name != "friction_coefficient" else ""
            findings.default(table.at(name), _written(law.NAME, name, defaults[name]), why=why)
        else:
            table.missing(name, f"Write {name} = {_example(law.NAME, name)}.")
    if len(findings.errors) > before:
        return None
    for fault in law.check(law.PARAMETERS(**values)):
        if math.isnan(values[fault.field]):
            continue
        table.error(fault.field, fault.problem, f"{fault.remedy}.")
    return values


def read_parameters(table: Table, law: ModuleType) -> dict[str, float]:
    """Those parameters of a law that a table has; what is out of range is told."""
    found = {}
    for name in law.PARAMETERS._fields:
        value = _read_parameter(table, law.NAME, name) if name in table else None
        if value is not None:
            found[name] = value
            if value < 0.0:
                table.error(name, "this must not be negative", "Give 0 or more.")
    return found


def _read_parameter(table: Table, law: str, name: str) -> float | None:
    value = table.content[name]
    strength = name.endswith("_strength") or name == "cohesion"
    if strength and isinstance(value, str) and value.strip().lower() == _UNLIMITED:
        return math.inf
    found = table.quantity(name, dimension_of(law, name))
    if found is not None and "friction" in name and found > _LARGEST_COEFFICIENT:
        meant = f"Did you mean {math.tan(math.radians(found)):.3g}, the tangent of {found:g} deg?"
        remedy = meant if found < 89.0 else "It is the tangent of the friction angle."
        problem = "so large a friction coefficient is an angle of more than 78 deg"
        table.findings.implausible(table.at(name), problem, remedy, value=value)
    return found


def _doubt_bond(table: Table, bond: Mapping[str, float]) -> None:
    """Moduli and strengths of which a unit is more often wrong than the material is strange."""
    modulus = bond.get("effective_modulus")
    if modulus is None:
        return
    if not _MODULUS[0] <= modulus <= _MODULUS[1]:
        remedy = "Bonds have about the rock's Young's modulus, 1 to 200 GPa: check the unit."
        problem = "no rock follows from so soft a bond" if modulus < _MODULUS[0] else "no rock is so stiff"
        value = table.content["effective_modulus"]
        table.findings.implausible(table.at("effective_modulus"), problem, remedy, value=value)
        return
    strength = bond.get("tensile_strength", 0.0)
    if math.isfinite(strength) and strength > _STRENGTH_PER_MODULUS * modulus:
        meant = units.show(strength / 1e3, "stress")
        problem = f"so strong a bond breaks at a strain of {100.0 * strength / modulus:.3g} %"
        value = table.content["tensile_strength"]
        remedy = f'Did you mean "{meant}"?'
        table.findings.implausible(table.at("tensile_strength"), problem, remedy, value=value)


def _fits(law: ModuleType) -> bool:
    return set(law.PARAMETERS._fields) <= FIELDS.keys()


def _parameters(laws: Mapping[str, ModuleType], name: object, usable: Iterable[str]) -> tuple[str, ...]:
    """Of the law of that name; of all usable ones where it is none of them."""
    usable = tuple(usable)
    chosen = [name] if isinstance(name, str) and name in usable else usable
    return tuple(dict.fromkeys(key for each in chosen for key in laws[each].PARAMETERS._fields))


def _range(value: float) -> tuple[str, str] | None:
    if 1.0 <= value <= _LARGEST_RANGE:
        return None
    problem = "nothing is bonded" if value < 1.0 else "grains are bonded past their neighbours"
    return problem, "Write 1.05 for neighbours only, up to 1.5 for hard rock."


def _variation(value: float) -> tuple[str, str] | None:
    if 0.0 <= value <= 2.0:
        return None
    return (
        "a coefficient of variation lies between 0 and 2",
        "Write 0.2 for a scatter of a fifth, 0 for none.",
    )


def _written(law: str, name: str, value: float) -> str:
    return quoted(_UNLIMITED) if math.isinf(value) else number(value, dimension_of(law, name))


def _example(law: str, name: str) -> str:
    dimension = dimension_of(law, name)
    if law in PER_CONTACT and dimension != "dimensionless":
        return {"line_load": '"1000 MN/m"', "force": '"100 kN"', "time": '"0 s"'}[dimension]
    return _EXAMPLES[name]


def number(value: float, dimension: str) -> str:
    """A value as a file holds it: to the last bit, with its unit where there is one."""
    return repr(value) if dimension == "dimensionless" else exact(value, dimension)


def exact(value: float, dimension: str) -> str:
    """A value with its unit as text of TOML."""
    return quoted(units.exact(value, dimension))


_EXAMPLES = {
    "effective_modulus": '"60 GPa"',
    "stiffness_ratio": "2.5",
    "tensile_strength": '"12 MPa"',
    "shear_strength": '"60 MPa"',
    "friction_coefficient": "0.6",
    "residual_friction_coefficient": "0.5",
    "moment_contribution": "0.0",
    "radius_factor": "1.0",
    "width_ratio": "0.5",
    "rolling_friction": "0.3",
    "twisting_friction": "0.0",
}
