"""Bonded ground of a case: its tables read into a `SceneCase`, and written again."""

from __future__ import annotations

from pathlib import Path

from geodem.case.bonded import exact
from geodem.case.ground_source import read_source
from geodem.case.ground_tables import mismatches, read_particles
from geodem.case.ground_writing import particle_lines, source_lines
from geodem.case.places import Places
from geodem.case.scene import SceneCase
from geodem.case.scene_joints import (
    fault_lines,
    joint_lines,
    read_faults,
    read_joint_sets,
    read_joints,
    set_lines,
)
from geodem.case.scene_material import (
    interface_lines,
    read_interfaces,
    read_scene_materials,
    scene_material_lines,
)
from geodem.case.scene_supports import (
    bolt_lines,
    lining_lines,
    read_bolts,
    read_gravity,
    read_linings,
    read_sides,
    read_stress,
    stress_lines,
)
from geodem.case.table import Table, quoted

STRUCTURE_KEYS = ("joint", "joint_set", "fault", "bolt", "lining")
"""Tables of what is in the ground."""

SCENE_KEYS = (
    "source", "particles", "material", "interface", "grain_bonds", "boundary", "loads", *STRUCTURE_KEYS,
    "initial_stress",
)  # fmt: skip
"""Keys of a case that `read_scene` reads."""


def read_scene(top: Table, folder: Path, *, seed: int = 1) -> SceneCase | None:
    """The ground of a case; None where something in it is wrong, which has then been told in `top.findings`.

    Parameters
    ----------
    top : Table
        The file, which knows `SCENE_KEYS`.
    folder : pathlib.Path
        What relative paths are relative to.
    seed : int
        Of the scatter of strength.
    """
    findings = top.findings
    before = len(findings.errors)
    defined = top.content.get("material")
    names = tuple(defined) if isinstance(defined, dict) else ()
    source = read_source(top, folder, names)
    particles = read_particles(top)
    materials = read_scene_materials(top, folder)
    dimension = None if source is None else source.dimension
    unit = "m" if source is None else source.options.get("unit", "m")
    places = Places(unit, dimension)
    faults = read_faults(top, places)
    if source is not None and source.materials is not None:
        found = tuple(dict.fromkeys((*source.materials, *(fault.material for fault in faults))))
        findings.errors += mismatches(found, names, "the source")
    interfaces = read_interfaces(top, materials)
    sides = read_sides(top, dimension)
    gravity = read_gravity(top, places)
    grain_bonds = top.quantity("grain_bonds", "dimensionless", check=_not_negative)
    joints, sets = read_joints(top, places), read_joint_sets(top, places)
    bolts, linings = read_bolts(top, places), read_linings(top, places)
    stress = read_stress(top, dimension)
    _unique(top, [("joint", joints), ("joint_set", sets), ("bolt", bolts), ("lining", linings)])
    if len(findings.errors) > before or source is None or particles is None:
        return None
    return SceneCase(
        source=source, particles=particles, materials=materials, boundary=sides, gravity=gravity,
        grain_bonds=1.0 if grain_bonds is None else grain_bonds, seed=seed,
        interfaces=interfaces, joints=joints, joint_sets=sets, faults=faults, bolts=bolts, linings=linings,
        initial_stress=stress,
    )  # fmt: skip


def scene_lines(scene: SceneCase) -> list[str]:
    """Lines of TOML with every default written out, for the end of a file.

    `scene_head` gives those for its top; the kind of case writes its seed itself.
    """
    lines = ["", *source_lines(scene.source), "", *particle_lines(scene.particles), "", "[boundary]"]
    lines += [f"{side} = {quoted(kind)}" for side, kind in scene.boundary.items()]
    lines += ["", "[loads]", f"gravity = {_gravity(scene.gravity)}"]
    if scene.initial_stress is not None:
        lines += ["", *stress_lines(scene.initial_stress)]
    for name, material in scene.materials.items():
        lines += ["", *scene_material_lines(name, material)]
    tables = [interface_lines(one, dict(scene.materials)) for one in scene.interfaces]
    tables += [joint_lines(one) for one in scene.joints] + [set_lines(one) for one in scene.joint_sets]
    tables += [fault_lines(one) for one in scene.faults] + [bolt_lines(one) for one in scene.bolts]
    tables += [lining_lines(one) for one in scene.linings]
    for table in tables:
        lines += ["", *table]
    return lines


def scene_head(scene: SceneCase) -> list[str]:
    """Lines of TOML for the top of a file, before any table."""
    return [f"grain_bonds = {scene.grain_bonds!r}"]


def _gravity(value: tuple[float, ...] | float) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(exact(each, 'acceleration') for each in value)}]"
    return exact(value, "acceleration")


def _unique(top: Table, kinds: list[tuple[str, tuple]]) -> None:
    """Joints, bolts and linings have names of their own, and none of a material."""
    defined = top.content.get("material")
    names = tuple(defined) if isinstance(defined, dict) else ()
    taken = {name: f"[material.{name}]" for name in names}
    for kind, entries in kinds:
        for number, one in enumerate(entries):
            place = f"{kind}[{number}].name"
            if one.name in taken:
                top.findings.error(
                    place, f"{taken[one.name]} has this name already", "Give it another one.", value=one.name
                )
            taken.setdefault(one.name, place)


def _not_negative(value: float) -> tuple[str, str] | None:
    return None if value >= 0.0 else ("this must not be negative", "Give 0 (not bonded) to 1.")
