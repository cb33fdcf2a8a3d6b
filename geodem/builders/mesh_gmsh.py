"""Geometry that gmsh meshes: its own .geo files, and STEP files by way of OpenCASCADE.

gmsh runs inside this process, without a word, on one thread and with fixed seeds, so that the same file gives the same
mesh. A session that the caller has open keeps its models and options.
"""

from __future__ import annotations

import ctypes
import os
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from geodem.builders.geo_script import refuse_commands
from geodem.builders.gmsh_elements import drawn_size, size_remarks, take_elements
from geodem.builders.mesh_source import MeshSource, ungrouped
from geodem.errors import InputError

STEP = (".step", ".stp")
OPTIONS = {
    "General.Terminal": 0.0,
    "General.NumThreads": 1.0,
    "Mesh.MaxNumThreads1D": 1.0,
    "Mesh.MaxNumThreads2D": 1.0,
    "Mesh.MaxNumThreads3D": 1.0,
    "Mesh.RandomSeed": 1.0,
    "Mesh.RandomFactor": 1e-9,
    "Mesh.RandomFactor3D": 1e-12,
    "Mesh.ElementOrder": 1.0,
    "Mesh.MeshSizeMin": 0.0,
    "Mesh.MeshSizeMax": 1e22,
    "Geometry.OCCImportLabels": 1.0,
}
FIRST_SIZE = 20.0
"""Elements over the span where no size is given for a STEP file."""
SAME = 1e-6
"""Share of a volume that two bodies may have in common by rounding."""
SI = {"": 1.0, "MILLI": 1e-3, "CENTI": 1e-2, "DECI": 1e-1, "KILO": 1e3, "MICRO": 1e-6}


@contextmanager
def gmsh_session(path: Path) -> Iterator[Any]:
    """gmsh with an empty model of its own and our options; everything is as before afterwards.

    Raises
    ------
    InputError
        gmsh is not installed, or cannot be loaded.
    """
    try:
        import gmsh
    # its library needs others of the system
    except (ImportError, OSError) as error:
        raise InputError(
            str(path), f"meshing geometry needs gmsh, which cannot be loaded ({error})",
            "Run: pip install 'geodem[meshes]' (on Debian also: apt install libglu1-mesa libxcursor1 libxft2)",
        ) from None  # fmt: skip
    fresh = not gmsh.isInitialized()
    if fresh:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    before = {name: gmsh.option.getNumber(name) for name in OPTIONS}
    unit = gmsh.option.getString("Geometry.OCCTargetUnit")
    current = None if fresh else gmsh.model.getCurrent()
    try:
        for name, value in OPTIONS.items():
            gmsh.option.setNumber(name, value)
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
        gmsh.model.add("geodem ground")
        yield gmsh
    finally:
        if fresh:
            gmsh.finalize()
        else:
            gmsh.model.remove()
            for name, value in before.items():
                gmsh.option.setNumber(name, value)
            gmsh.option.setString("Geometry.OCCTargetUnit", unit)
            if current in gmsh.model.list():
                gmsh.model.setCurrent(current)


@contextmanager
def silence() -> Iterator[None]:
    """Nothing on the standard output: OpenCASCADE writes there what it makes of a broken file, past gmsh's options."""
    sys.stdout.flush()
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        # what the library holds back would come out later
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def read_with_gmsh(path: Path, size: float | None, names: Mapping[int, str] | None) -> MeshSource:
    """Mesh a .geo or STEP file.

    Parameters
    ----------
    path : Path
    size : float, optional
        Largest side of an element, in the unit of the file. A .geo file has its own sizes besides; a STEP file is
        meshed with a twentieth of its span where it is left out.
    names : dict, optional
        Materials by the number of a surface or volume.

    Raises
    ------
    InputError
        gmsh is missing or cannot read or mesh the file, bodies overlap, or it is open what is of which material.
    """
    step = path.suffix.lower() in STEP
    if not step:
        refuse_commands(path)
    with gmsh_session(path) as gmsh:
        try:
            if step:
                with silence():
                    gmsh.model.occ.importShapes(str(path), highestDimOnly=True)
                gmsh.model.occ.synchronize()
            else:
                try:
                    _merge_geo(gmsh, path)
                except Exception:
                    # a broken file leaves gmsh's parser in its midst, where the next one, however good, fails
                    gmsh.model.remove()
                    gmsh.model.add("geodem ground")
                    _merge_geo(gmsh, path)
        except Exception as error:
            raise InputError(
                str(path), f"gmsh cannot read the file ({_said(gmsh, error)})",
                "Is it complete? Open it in gmsh to see what is wrong.",
            ) from None  # fmt: skip
        top = int(gmsh.model.getDimension())
        if top < 2:
            raise InputError(
                str(path), "it holds neither a surface nor a volume", "Make the outline a surface or volume."
            )
        source = MeshSource(np.empty((0, 3)), [])
        if step:
            source.unit = 1.0
            _part_bodies(gmsh, path, top)
            low, high = np.reshape(gmsh.model.getBoundingBox(-1, -1), (2, 3))
            if size is None:
                size = float((high - low).max()) / FIRST_SIZE
                source.remarks.append(f"No size was given: meshed with sides of {size:.3g} m.")
        groups = _groups(gmsh, path, top, names, source)
        if size is not None:
            gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        used = _used(gmsh, top, groups, source)
        drawn = drawn_size(gmsh, top, used)
        try:
            gmsh.model.mesh.generate(top)
        except Exception as error:
            raise InputError(
                str(path), f"gmsh cannot mesh it ({_said(gmsh, error)})",
                "Mesh it in gmsh to see where, or give another size.",
            ) from None  # fmt: skip
        take_elements(gmsh, path, top, used, groups, source)
        source.remarks += size_remarks(source, top, drawn)
        return source


def _merge_geo(gmsh: Any, path: Path) -> None:
    """Read a .geo file into the model; gmsh skips a last line without a break."""
    text = path.read_bytes()
    if text.endswith(b"\n"):
        # not `open`, which would begin another model
        gmsh.merge(str(path))
        return
    if re.search(rb"\b(Include|Merge|ShapeFromFile)\b", text):
        raise ValueError("its last line has no break, so that it would be skipped")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        copy.write_bytes(text + b"\n")
        gmsh.merge(str(copy))


def _said(gmsh: Any, error: Exception) -> str:
    return str(error).strip() or gmsh.logger.getLastError() or type(error).__name__


def _part_bodies(gmsh: Any, path: Path, top: int) -> None:
    """Let bodies that touch share their common faces; refuse those that overlap."""
    bodies = gmsh.model.getEntities(top)
    if len(bodies) < 2:
        return
    labels = [gmsh.model.getEntityName(*body) for body in bodies]
    _, parts = gmsh.model.occ.fragment(bodies, [])
    owners: dict[tuple[int, int], list[int]] = {}
    for index, pieces in enumerate(parts):
        for piece in pieces:
            owners.setdefault(piece, []).append(index)
    gmsh.model.occ.synchronize()
    for piece, owner in owners.items():
        if len(owner) > 1:
            both = float(gmsh.model.occ.getMass(*piece))
            x, y, z = gmsh.model.occ.getCenterOfMass(*piece)
            first, second = (
                f"{bodies[k][1]} ({labels[k]})" if labels[k] else str(bodies[k][1]) for k in owner[:2]
            )
            raise InputError(
                str(path), f"bodies {first} and {second} overlap by {both:.4g} {'m2' if top == 2 else 'm3'} around "
                f"({x:.4g}, {y:.4g}, {z:.4g}) m", "Cut one out of the other in the program that drew them.",
            )  # fmt: skip
        gmsh.model.setEntityName(*piece, labels[owner[0]])


def _groups(
    gmsh: Any, path: Path, top: int, names: Mapping[int, str] | None, source: MeshSource
) -> dict[int, dict[int, str]]:
    """Names of the surfaces or volumes, and of the lines or faces around them, by dimension and number."""
    groups: dict[int, dict[int, str]] = {top - 1: {}, top: {}}
    for dimension, tag in gmsh.model.getPhysicalGroups():
        if dimension < top - 1:
            continue
        name = gmsh.model.getPhysicalName(dimension, tag)
        if not name:
            name = f"group {tag}"
            source.nameless.append(name)
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag).tolist():
            other = groups[dimension].setdefault(entity, name)
            if other != name and dimension == top:
                raise InputError(
                    str(path), f"{'surface' if top == 2 else 'volume'} {entity} is in two physical groups, {other!r} "
                    f"and {name!r}", "Leave one, which names the material.",
                )  # fmt: skip
    tags = [tag for _, tag in gmsh.model.getEntities(top)]
    for tag in set(names or ()) - set(tags):
        raise InputError(
            str(path), f"it has no {'surface' if top == 2 else 'volume'} {tag}",
            f"Name one of {', '.join(map(str, tags))}.", value=names,
        )  # fmt: skip
    if not groups[top]:
        labels = {tag: gmsh.model.getEntityName(top, tag).rsplit("/", 1)[-1].strip() for tag in tags}
        # what OpenCASCADE writes where the program that drew the body gave no name
        groups[top] = {
            t: name for t, name in labels.items() if name and not name.startswith("Open CASCADE STEP")
        }
    groups[top].update({tag: name for tag, name in (names or {}).items() if tag in tags})
    if not groups[top] and len(tags) > 1:
        raise ungrouped(path, "surfaces" if top == 2 else "volumes", tags)
    return groups


def _used(gmsh: Any, top: int, groups: dict[int, dict[int, str]], source: MeshSource) -> list[int]:
    """Surfaces or volumes that are ground: those in a physical group, as where gmsh writes a mesh, else all."""
    tags = [int(tag) for _, tag in gmsh.model.getEntities(top)]
    if not gmsh.model.getPhysicalGroups(top):
        return tags
    left = [tag for tag in tags if tag not in groups[top]]
    if left:
        what = "surfaces" if top == 2 else "volumes"
        source.remarks.append(
            f"{len(left)} {what} in no physical group were left out: {', '.join(map(str, left[:10]))}."
        )
    return [tag for tag in tags if tag in groups[top]]


def step_unit(path: Path) -> float | None:
    """Metres that a STEP file says its unit of length has; None where it says nothing that is understood."""
    text = path.read_text(errors="replace")
    found = re.search(r"SI_UNIT\s*\(\s*(?:\.(\w+)\.|\$)\s*,\s*\.METRE\.\s*\)", text)
    if re.search(r"CONVERSION_BASED_UNIT\s*\(\s*'(?!DEGREE)", text, flags=re.I) or found is None:
        return None
    return SI.get(found.group(1) or "")
