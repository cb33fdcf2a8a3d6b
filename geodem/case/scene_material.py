"""Materials of ground that breaks, and what holds between two of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from geodem import units
from geodem.breaking.materials import Interface, LooseMaterial, SceneMaterial
from geodem.case.bonded import (
    exact,
    law_lines,
    material_keys,
    material_lines,
    read_contact,
    read_material,
    read_parameters,
)
from geodem.case.ground_tables import material_of_file, read_density
from geodem.case.section import positive
from geodem.case.table import Table, join, listed, quoted
from geodem.laboratory.material import BondedMaterial
from geodem.laws import BOND_LAWS, CONTACT_LAWS

OWN = ("unit_weight", "file", "bonds")
BONDS = ("bonded", "none")
_EXAMPLE = 'density = "2600 kg/m3", law = "rock" and its strengths'
_INTERFACE = 'between = ["rock", "seam"] and strength = 0.5'


def read_scene_materials(top: Table, folder: Path) -> dict[str, SceneMaterial]:
    """The tables [material.NAME]; those that are wrong are left out, and have been told."""
    content = top.content.get("material")
    names = tuple(content) if isinstance(content, dict) else ()
    table = top.sub("material", names, example=f"[material.rock] with {_EXAMPLE}")
    if table is None or not names:
        if table is not None or "material" not in top:
            top.missing("material", f"Add a table for each material: [material.rock] with {_EXAMPLE}.")
        return {}
    found: dict[str, SceneMaterial] = {}
    for name in names:
        inner = table.content[name]
        keys = material_keys(inner if isinstance(inner, dict) else {}, per_contact=True)
        own = table.sub(
            name, tuple(dict.fromkeys((*OWN, *keys))), example=f"[{table.at(name)}] with {_EXAMPLE}"
        )
        material = None if own is None else _material(name, own, folder)
        if material is not None:
            found[name] = material
    _one_law(table, found)
    return found


def _material(name: str, table: Table, folder: Path) -> SceneMaterial | None:
    findings = table.findings
    before = len(findings.errors)
    bonds = table.choice("bonds", BONDS) if "bonds" in table else "bonded"
    density = read_density(table)
    if "file" in table:
        for key in table.content:
            if key not in ("file", "density", "unit_weight"):
                table.error(key, "the file of the material has it, too", f"Remove {key}, or remove file.")
        made = material_of_file(table, folder)
        if made is None or len(findings.errors) > before:
            return None
        if density is None:
            findings.default(
                table.at("density"), units.show(made.density, "density"), why="as the file has it"
            )
        return replace(made, density=density or made.density, name=name)
    if bonds == "none":
        return _loose(name, table, density)
    inner = {key: value for key, value in table.content.items() if key not in OWN}
    if density is not None:
        inner["density"] = units.exact(density, "density")
    elif "unit_weight" in table or len(findings.errors) > before:
        inner["density"] = "2000 kg/m3"  # what is wrong with it has been told
    return read_material(Table(findings, table.place, inner, tuple(inner)), name=name, per_contact=True)


def _loose(name: str, table: Table, density: float | None) -> LooseMaterial | None:
    findings = table.findings
    before = len(findings.errors)
    if density is None and "density" not in table and "unit_weight" not in table:
        table.missing("density", 'Write density = "1900 kg/m3", of the ground with its voids.')
    for key in table.content:
        if key not in (*OWN, "density", "contact"):
            table.error(key, 'this belongs to bonds, and bonds = "none"', f"Remove {key}, or remove bonds.")
    law, contact = read_contact(table, {}, per_contact=True)
    if density is None or contact is None or len(findings.errors) > before:
        return None
    return LooseMaterial(density, contact, law, name)


def _one_law(table: Table, materials: dict[str, SceneMaterial]) -> None:
    """A scene has one law of bonds and one of contacts."""
    bonds = {name: m.bond_law for name, m in materials.items() if isinstance(m, BondedMaterial)}
    contacts = {name: m.contact_law for name, m in materials.items()}
    for laws, key in ((bonds, "law"), (contacts, "contact.law")):
        first = next(iter(laws.items()), None)
        for name, law in laws.items():
            if first is not None and law != first[1]:
                table.findings.error(
                    f"{table.at(name)}.{key}", f"{first[0]} has {quoted(first[1])}, and a scene has one law for all",
                    f"Give all materials the law {quoted(first[1])}, with numbers of their own.", value=law,
                )  # fmt: skip


def read_interfaces(top: Table, materials: dict[str, SceneMaterial]) -> tuple[Interface, ...]:
    """The tables [[interface]]."""
    bonded = next((m for m in materials.values() if isinstance(m, BondedMaterial)), None)
    law = None if bonded is None else bonded.bond_law
    fields = () if law is None else BOND_LAWS[law].PARAMETERS._fields
    tables = top.content.get("material")
    defined = tuple(tables) if isinstance(tables, dict) else ()
    found: list[Interface] = []
    for row in top.rows(
        "interface", ("between", "bonds", "strength", "contact", *fields), example=_INTERFACE
    ):
        names = row.items("between", example='["rock", "seam"]')
        if "between" not in row or len(names) != 2 or not all(isinstance(name, str) for name in names):
            row.error("between", "two names of materials are needed here", f"Write {_INTERFACE}.")
            continue
        for name in names:
            if name not in defined:
                row.error("between", f"there is no [material.{name}]", f"Known: {listed(materials)}.")
        pair = {*names}
        if any({one.first, one.second} == pair for one in found):
            row.error("between", "these two have an interface already", "Keep one of them.")
        bonds = row.choice("bonds", BONDS) if "bonds" in row else "bonded"
        strength = row.quantity("strength", "dimensionless", check=positive)
        bond = {} if law is None else read_parameters(row, BOND_LAWS[law])
        contact: dict[str, float] = {}
        if "contact" in row and materials:
            module = CONTACT_LAWS[next(iter(materials.values())).contact_law]
            inner = row.sub(
                "contact", module.PARAMETERS._fields, example="contact = {friction_coefficient = 0.3}"
            )
            contact = {} if inner is None else read_parameters(inner, module)
        loose = [name for name in names if isinstance(materials.get(name), LooseMaterial)]
        if loose and (bond or "strength" in row):
            key = next(iter(bond), "strength")
            row.error(key, f"{loose[0]} has no bonds", "Remove it; contact = {...} holds for its contacts.")
        if bonds == "none" and (bond or "strength" in row):
            row.error(next(iter(bond), "strength"), 'bonds = "none"', "Remove one of the two.")
        found.append(
            Interface(
                names[0], names[1], bonds != "none", 1.0 if strength is None else strength, bond, contact
            )
        )
    return tuple(found)


def scene_material_lines(name: str, material: SceneMaterial) -> list[str]:
    """The table of a material."""
    place = join("material", name)
    if isinstance(material, BondedMaterial):
        return [f"[{place}]", *material_lines(material, place=place)]
    return [
        f"[{place}]", f"density = {exact(material.density, 'density')}", 'bonds = "none"', "", f"[{place}.contact]",
        f"law = {quoted(material.contact_law)}", *law_lines(material.contact_law, material.contact),
    ]  # fmt: skip


def interface_lines(one: Interface, materials: dict[str, Any]) -> list[str]:
    """The table of an interface."""
    lines = ["[[interface]]", f"between = [{quoted(one.first)}, {quoted(one.second)}]"]
    if not one.bonded:
        lines.append('bonds = "none"')
    elif not any(isinstance(materials[name], LooseMaterial) for name in one.pair):
        lines.append(f"strength = {one.strength!r}")
    law = next((m.bond_law for m in materials.values() if isinstance(m, BondedMaterial)), None)
    if one.bond and law is not None:
        lines += law_lines(law, one.bond)
    if one.contact:
        contact = next(iter(materials.values())).contact_law
        lines.append(f"contact = {{{', '.join(law_lines(contact, one.contact))}}}")
    return lines
