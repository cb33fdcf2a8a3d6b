"""A case file to a validated `Case`; every error of the file at once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from geodem import units
from geodem.case.data import (
    METHODS,
    PACKINGS,
    Case,
    Reference,
    SectionOptions,
)
from geodem.case.document import read_text
from geodem.case.head import CaseHead, read_head
from geodem.case.loading import read_boundary, read_loads
from geodem.case.material import check_names, read_materials
from geodem.case.mesh_section import MeshSection
from geodem.case.section import positive, read_section
from geodem.case.source_files import unnamed
from geodem.case.table import Findings, Table, join, listed, nearest
from geodem.case.terrain_section import TerrainSection

KEYS = (
    "workflow",
    "title",
    "particles",
    "spacing",
    "packing",
    "methods",
    "tolerance",
    "seed",
    "allow_implausible",
    "section",
    "boundary",
    "loads",
    "material",
    "reference",
)
DEFAULT_PARTICLES = 5000
DEFAULT_TOLERANCE = 0.01
DEFAULT_SEED = 1
_FEW, _MANY = 100, 10_000_000  # particles: below, no mechanism can form; above, days and tens of gigabytes


def load_case(path: Path | str) -> Case:
    """Read a case.

    Parameters
    ----------
    path : pathlib.Path
        A .toml file, or a folder that holds case.toml.

    Returns
    -------
    Case

    Raises
    ------
    InputError
        The file cannot be found or read, or is no TOML.
    InputErrors
        All that is wrong in the file, in its order.
    """
    text, folder = read_text(path)
    return parse_case(text, folder)


def parse_case(text: str, folder: Path) -> Case:
    """Read a case from its text.

    Parameters
    ----------
    text : str
        TOML.
    folder : pathlib.Path
        What relative paths in it are relative to.

    Returns
    -------
    Case

    Raises
    ------
    InputError
        The text is no TOML.
    InputErrors
        All that is wrong in it, in its order.
    """
    head = read_head(text, folder, "slope", KEYS, example="My slope")
    read = read_slope(head, folder)
    return Case(**head.close(), **read, workflow="slope")


def read_slope(head: CaseHead, folder: Path, methods: tuple[str, ...] | None = None) -> dict[str, Any]:
    """Entries of `Case` but those that every case has; `methods` where they are not the case's to choose.

    What is wrong is told in the head's findings; the entries then are not to be used.
    """
    document, top, findings = head.document, head.top, head.findings
    particles, spacing = _resolution(top)
    nodes = _on_nodes(top)
    packing = top.choice("packing", PACKINGS, default="random") if "packing" in top or not nodes else "random"
    methods = _methods(top) if methods is None else methods
    tolerance = _tolerance(top)
    seed = top.integer("seed", smallest=0, remedy="Write a whole number such as 1.")
    if "seed" not in top:
        seed = DEFAULT_SEED
        if not nodes:
            findings.default("seed", str(seed))
    defined = top.content.get("material")
    names = tuple(defined) if isinstance(defined, dict) else ()
    section, coordinates = read_section(top, folder, names)
    boundary = read_boundary(top)
    loads = read_loads(top, coordinates, section)
    materials = read_materials(top)
    used = used_materials(document)
    if isinstance(section, MeshSection):
        place = "section.mesh"
        findings.errors += [
            unnamed(place, name, section.materials, names) for name in section.materials if name not in names
        ]
        used += [(place, name) for name in section.materials if name in names]
    elif isinstance(section, TerrainSection) and "layers" not in document["section"]:
        used += [("section.terrain", name) for name in section.materials]
    given = document.get("section")
    if section is not None or not {"mesh", "terrain"} & set(given if isinstance(given, dict) else ()):
        check_names(findings, used, names, materials)
    if section is not None and spacing is not None:
        check_spacing(findings, section, spacing)
    reference = _reference(top)
    return {
        "particles": particles,
        "spacing": spacing,
        "packing": packing,
        "methods": methods,
        "tolerance": tolerance,
        "seed": seed,
        "section": section,
        "boundary": boundary,
        "loads": loads,
        "materials": materials,
        "reference": reference,
    }


def _resolution(top: Table) -> tuple[int | None, float | None]:
    findings = top.findings
    if _on_nodes(top):
        for key in ("particles", "spacing"):
            if key in top:
                top.error(
                    key, "the nodes of the mesh are the particles",
                    f'Remove {key}, or write particles_on = "polygons".',
                )  # fmt: skip
        return None, None
    particles = top.integer("particles", smallest=3, remedy="Write a whole number such as 5000.")
    spacing = top.quantity("spacing", "length", check=positive)
    if "particles" in top and "spacing" in top:
        top.error("spacing", "particles and spacing are both given", "Keep one of them; the other follows.")
    elif "particles" not in top and "spacing" not in top:
        particles = DEFAULT_PARTICLES
        findings.default("particles", str(particles))
    if particles is not None and not _FEW <= particles <= _MANY:
        few = particles < _FEW
        problem = (
            "so few particles cannot form a mechanism"
            if few
            else "so many particles take days and tens of gigabytes"
        )
        findings.implausible("particles", problem, "Slopes need 2500 to 20000.", value=particles)
    return particles, spacing


def _on_nodes(top: Table) -> bool:
    """Whether the nodes of a mesh are the particles, so that nothing is placed."""
    section = top.content.get("section")
    return isinstance(section, dict) and section.get("particles_on") == "nodes" and "mesh" in section


def check_spacing(findings: Findings, section: SectionOptions, spacing: float) -> None:
    """Report a spacing that is too coarse for the section, or makes too many particles."""
    left, bottom, right, top = section.bounds
    width, height = right - left, top - bottom
    shown = units.show(spacing, "length")
    if spacing > 0.5 * min(width, height):
        size = f"{units.show(width, 'length')} by {units.show(height, 'length')}"
        problem = f"{shown} between particles is too coarse for a section of {size}"
        remedy = f"Give a smaller spacing, such as {units.show(0.02 * width, 'length')}."
        findings.implausible("spacing", problem, remedy)
    elif width * height / spacing**2 > _MANY:
        problem = f"{shown} between particles makes up to {width * height / spacing**2:.2g} particles"
        findings.implausible(
            "spacing", problem, "Give a larger spacing; slopes need 2500 to 20000 particles."
        )


def _methods(top: Table) -> tuple[str, ...]:
    if "methods" not in top:
        top.findings.default("methods", listed(METHODS))
        return METHODS
    example = f"[{listed(METHODS)}]"
    values = top.items("methods", example=example)
    if values == [] and isinstance(top.content["methods"], list):
        top.error("methods", "the list is empty", f"Write methods = {example}, or one of them.")
    found: list[str] = []
    for index, value in enumerate(values):
        place = f"methods[{index}]"
        if not isinstance(value, str) or value not in METHODS:
            hint = nearest(value, METHODS) if isinstance(value, str) else ""
            top.findings.error(place, "unknown method", f"{hint}Known: {listed(METHODS)}.", value=value)
        elif value in found:
            top.findings.error(place, "this method is named twice", "Name it once.", value=value)
        else:
            found.append(value)
    return tuple(found)


def _tolerance(top: Table) -> float:
    def check(value: float) -> tuple[str, str] | None:
        if 1e-4 <= value <= 0.2:
            return None
        return (
            "the tolerance lies between 0.0001 and 0.2",
            "It is the width of [stable, failed] over the factor; 0.01 is usual.",
        )

    if "tolerance" not in top:
        top.findings.default("tolerance", str(DEFAULT_TOLERANCE))
        return DEFAULT_TOLERANCE
    return top.quantity("tolerance", "dimensionless", check=check) or DEFAULT_TOLERANCE


def used_materials(document: dict[str, Any]) -> list[tuple[str, str]]:
    """Places and names of the materials that the section asks for, whatever else is wrong with it."""
    section = document.get("section")
    if not isinstance(section, dict):
        return []
    used = []
    for key in ("regions", "refine", "layers"):
        rows = section.get(key)
        for index, row in enumerate(rows if isinstance(rows, list) else []):
            if isinstance(row, dict) and isinstance(row.get("material"), str) and row["material"].strip():
                used.append((f"section.{key}[{index}].material", row["material"]))
    legend = section.get("legend")
    if isinstance(legend, dict) and "image" in section:
        used += [
            (join("section.legend", c), m) for c, m in legend.items() if isinstance(m, str) and m.strip()
        ]
    return used


def _reference(top: Table) -> Reference | None:
    example = '[reference] with factor = 1.26 and source = "author, year"'
    table = top.sub("reference", ("factor", "source"), example=example)
    if table is None:
        return None
    factor = table.quantity("factor", "dimensionless", check=positive)
    source = table.text("source", remedy='Write source = "author, year, table".')
    for key in ("factor", "source"):
        if key not in table:
            table.missing(key, f"Write {example}.")
    return None if factor is None or source is None else Reference(factor, source)
