"""Checkpoints of discs or spheres in motion: the whole assembly and the whole state, to go on with the same bits.

The file is one of `geodem.io.checkpoint`. What the state is made of is `geodem.particle_state`'s business.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from ..assembly import Anchors, Assembly, Cell, Joints, Servo, Wall
from ..errors import InputError
from ..laws import BOND_LAWS, CONTACT_LAWS, JOINT_LAWS
from ..provenance import sources_digest, versions
from .checkpoint import PARTICLES, Tree, read_checkpoint, write_checkpoint

_WALL_ARRAYS = ("planes", "segments", "triangles", "velocity", "spin", "centre")


def write_particles(path: Path | str, assembly: Assembly, state: Mapping[str, Any]) -> None:
    """Write an assembly and the state of its motion, whole or not at all.

    Raises
    ------
    InputError
        The file cannot be written; the old one is untouched.
    """
    tree = {
        "versions": versions(),
        "sources": sources_digest(),
        "assembly": assembly_tree(assembly),
        "state": dict(state),
    }
    write_checkpoint(path, tree, PARTICLES)


def read_particles(path: Path | str, *, other_version: bool = False) -> tuple[Assembly, Tree]:
    """Assembly and state of a checkpoint; nothing in it is executed.

    Parameters
    ----------
    other_version : bool
        Take one that was written by other sources of geodem, or with other versions of its libraries: what follows
        may then differ in its bits.

    Raises
    ------
    InputError
        No such file, not such a checkpoint, of another version, truncated, changed, or of a law that is not known here.
    """
    tree = read_checkpoint(path, PARTICLES)
    place = str(path)
    try:
        written = tree["versions"]
        if tree["sources"] != sources_digest() and not other_version:
            libraries = ", ".join(f"{name} {version}" for name, version in sorted(written.items()))
            raise InputError(
                place,
                f"it was written by other sources or libraries ({libraries}), whose numbers may differ",
                "Use those, or allow it with other_version=True",
            )
        return assembly_from(tree["assembly"], place), tree["state"]
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise InputError(place, f"the checkpoint lacks a part ({error})", PARTICLES.again) from error


def checkpoint_step(path: Path | str) -> int:
    """Step that a checkpoint holds, of whatever version of geodem; raises InputError where it cannot be read."""
    return int(read_checkpoint(path, PARTICLES)["state"]["plain"]["numbers"]["steps"])


def assembly_tree(assembly: Assembly) -> Tree:
    """An assembly as a checkpoint tree."""
    tree: Tree = {}
    for field in fields(Assembly):
        value = getattr(assembly, field.name)
        if isinstance(value, np.ndarray):
            tree[field.name] = value
    tree["plain"] = {
        "dimension": int(assembly.dimension),
        "material_names": list(assembly.material_names),
        "contact_law": assembly.contact_law,
        "bond_law": assembly.bond_law,
    }
    if assembly.anchors is not None:
        tree["anchors"] = {field.name: getattr(assembly.anchors, field.name) for field in fields(Anchors)}
    if assembly.cell is not None:
        tree["cell"] = {
            "vectors": assembly.cell.vectors,
            "plain": {"periodic": [bool(each) for each in assembly.cell.periodic]},
        }
    if assembly.joints is not None:
        joints = {field.name: getattr(assembly.joints, field.name) for field in fields(Joints)}
        plain = {"laws": list(joints.pop("laws")), "names": list(joints.pop("names"))}
        plain["reach"] = [float(joints.pop("reach"))]
        tree["joints"] = {**joints, "plain": plain}
    tree["walls"] = {str(number): _wall_tree(wall) for number, wall in enumerate(assembly.walls)}
    return tree


def assembly_from(tree: Mapping[str, Any], place: str) -> Assembly:
    """An assembly from a checkpoint tree; `place` is named where its laws are not known."""
    plain = tree["plain"]
    for kind, known in (("contact_law", CONTACT_LAWS), ("bond_law", BOND_LAWS)):
        if plain[kind] is not None and plain[kind] not in known:
            raise InputError(
                place,
                f"its {kind.replace('_', ' ')} {plain[kind]!r} is not known here",
                "Register the law as you did before, then resume",
            )
    arrays = {name: value for name, value in tree.items() if isinstance(value, np.ndarray)}
    law = CONTACT_LAWS[plain["contact_law"]]
    numbers = sorted(tree["walls"], key=int)
    return Assembly(
        **arrays,
        dimension=plain["dimension"],
        material_names=tuple(plain["material_names"]),
        contact_law=plain["contact_law"],
        bond_law=plain["bond_law"],
        anchors=Anchors(**tree["anchors"]) if "anchors" in tree else None,
        walls=tuple(_wall_from(tree["walls"][number], law) for number in numbers),
        cell=Cell(tree["cell"]["vectors"], tuple(tree["cell"]["plain"]["periodic"]))
        if "cell" in tree
        else None,
        joints=_joints_from(tree["joints"], place) if "joints" in tree else None,
    )


def _joints_from(tree: Mapping[str, Any], place: str) -> Joints:
    plain = tree["plain"]
    for law in plain["laws"]:
        if law not in JOINT_LAWS:
            problem = f"its joint law {law!r} is not known here"
            raise InputError(place, problem, "Register the law as you did before, then resume")
    arrays = {name: value for name, value in tree.items() if isinstance(value, np.ndarray)}
    return Joints(tuple(plain["laws"]), tuple(plain["names"]), reach=plain["reach"][0], **arrays)


def _wall_tree(wall: Wall) -> Tree:
    return {
        **{name: getattr(wall, name) for name in _WALL_ARRAYS},
        "plain": {
            "name": wall.name,
            "servo": None if wall.servo is None else _plain_servo(wall.servo),
            "contact": {name: [float(value) for value in wall.contact[name]] for name in wall.contact},
        },
    }


def _plain_servo(servo: Servo) -> dict[str, Any]:
    plain = asdict(servo)
    plain["direction"] = [float(part) for part in servo.direction]
    return {
        name: value if value is None or name == "direction" else float(value) for name, value in plain.items()
    }


def _wall_from(tree: Mapping[str, Any], law: Any) -> Wall:
    plain = tree["plain"]
    servo = plain["servo"]
    return Wall(
        name=plain["name"],
        **{name: tree[name] for name in _WALL_ARRAYS},
        contact={name: law.PARAMETERS(*values) for name, values in plain["contact"].items()},
        servo=None if servo is None else Servo(**{**servo, "direction": tuple(servo["direction"])}),
    )
