"""A case of ground, from its text; every error of the file at once."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from geodem import units
from geodem.case.bonded import material_keys, read_material
from geodem.case.document import read_text
from geodem.case.ground import GroundCase, GroundGrains
from geodem.case.ground_source import read_source
from geodem.case.ground_tables import material_of_file, mismatches, read_density, read_particles
from geodem.case.head import CaseHead, read_head
from geodem.case.scene_reading import STRUCTURE_KEYS, read_scene
from geodem.case.table import Table
from geodem.laboratory.material import BondedMaterial

SCENIC = ("boundary", "loads", "interface", "grain_bonds", *STRUCTURE_KEYS, "initial_stress")
"""Keys that make ground to be bonded, held, cut and reinforced."""
KEYS = ("workflow", "title", "allow_implausible", "source", "particles", "material", *SCENIC)
MATERIAL_KEYS = ("density", "unit_weight", "file")


def load_ground(path: Path | str) -> GroundCase:
    """Read a case of ground: a file, or a folder that holds case.toml; raises as `parse_ground`."""
    return parse_ground(*read_text(path))


def parse_ground(text: str, folder: Path) -> GroundCase:
    """Read a case of ground from its text.

    Parameters
    ----------
    text : str
        TOML.
    folder : pathlib.Path
        What relative paths in it are relative to.

    Raises
    ------
    InputError
        The text is no TOML, or a case of another workflow.
    InputErrors
        All that is wrong in it, in its order. What is wrong in a file that the body is made from is found when it is
        made.
    """
    head = read_head(text, folder, "ground", KEYS, example="Ballast")
    top, findings = head.top, head.findings
    if any(key in top for key in SCENIC):
        return _scenic(head, folder)
    defined = top.content.get("material")
    names = tuple(defined) if isinstance(defined, dict) else ()
    source = read_source(top, folder, names)
    particles = read_particles(top)
    materials = _materials(top, folder, names)
    if source is not None and source.materials is not None:
        findings.errors += mismatches(source.materials, names, "the source")
    common = head.close()
    # every None below has been reported
    assert source is not None
    assert particles is not None
    return GroundCase(**common, source=source, particles=particles, materials=materials)


def _scenic(head: CaseHead, folder: Path) -> GroundCase:
    """A case that says what holds, cuts and reinforces the ground: its materials must be whole."""
    scene = read_scene(head.top, folder)
    common = head.close()
    assert scene is not None  # or an error would have been told
    materials = {
        name: GroundGrains(name, each.density, each if isinstance(each, BondedMaterial) else None)
        for name, each in scene.materials.items()
    }
    return GroundCase(
        **common, source=scene.source, particles=scene.particles, materials=materials, scene=scene
    )


def _materials(top: Table, folder: Path, names: tuple[str, ...]) -> dict[str, GroundGrains]:
    table = top.sub("material", names, example='[material.soil] with density = "1900 kg/m3"')
    if not names:
        if table is not None or "material" not in top:
            top.missing(
                "material", 'Add a table for each material: [material.soil] with density = "1900 kg/m3".'
            )
        return {}
    assert table is not None  # it has names
    found = {}
    for name in names:
        content = table.content[name]
        bonded = {key for key in material_keys({}) if key not in ("density",)}
        given = set(content) & bonded if isinstance(content, dict) else set()
        keys = (*MATERIAL_KEYS, *(material_keys(content) if given else material_keys({})))
        inner = table.sub(
            name, tuple(dict.fromkeys(keys)), example=f'[{table.at(name)}] with density = "1900 kg/m3"'
        )
        material = None if inner is None else _material(name, inner, folder, bool(given))
        if material is not None:
            found[name] = material
    return found


def _material(name: str, table: Table, folder: Path, given: bool) -> GroundGrains | None:
    findings = table.findings
    before = len(findings.errors)
    density = read_density(table)
    bonded: BondedMaterial | None = None
    if "file" in table:
        if given:
            others = [key for key in table.content if key not in MATERIAL_KEYS]
            table.error(
                others[0], "the file of the material has it, too", f"Remove {others[0]}, or remove file."
            )
        bonded = material_of_file(table, folder)
    elif given:
        inner = {key: value for key, value in table.content.items() if key not in MATERIAL_KEYS}
        if density is not None:
            inner["density"] = units.exact(density, "density")
        elif len(findings.errors) > before:
            inner["density"] = "2000 kg/m3"  # what is wrong with the density has been told
        own = Table(findings, table.place, inner, tuple(inner))
        bonded = read_material(own, name=name)
    if density is None and bonded is not None:
        density = bonded.density
        findings.default(table.at("density"), units.show(density, "density"), why="as the file has it")
    if density is None and not given and len(findings.errors) == before:
        table.missing("density", 'Write density = "1900 kg/m3", of the ground with its voids.')
    if density is None or len(findings.errors) > before:
        return None
    return GroundGrains(
        name, density, None if bonded is None else replace(bonded, density=density, name=name)
    )
