"""A case of ground, back to TOML."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from geodem.case.bonded import exact, material_lines
from geodem.case.ground import GroundCase, GroundGrains, GroundSource, ParticleOptions
from geodem.case.ground_source import DRAWN, NOTHING, SOURCES
from geodem.case.table import join, quoted

_DIMENSIONS = {"scale": "pixel_scale", "base": "length", "size": "length"}
_LENGTHS = ("origin", "voxel")


def ground_text(case: GroundCase) -> str:
    """TOML with every default written out; reading it gives the same numbers to the last bit."""
    lines = [f"workflow = {quoted(case.workflow)}", f"title = {quoted(case.title)}"]
    if case.allow_implausible:
        allowed = dict.fromkeys(key.replace(".unit_weight", ".density") for key in case.allow_implausible)
        lines.append(f"allow_implausible = [{', '.join(map(quoted, allowed))}]")
    if case.scene is not None:
        # the writer of scenes takes the tables of this file
        from geodem.case.scene_reading import scene_head, scene_lines

        scene = replace(case.scene, source=case.source, particles=case.particles)
        return "\n".join([*lines, *scene_head(scene), *scene_lines(scene)]) + "\n"
    lines += ["", *source_lines(case.source), "", *particle_lines(case.particles)]
    for material in case.materials.values():
        lines += ["", *_material(material)]
    return "\n".join(lines) + "\n"


def source_lines(source: GroundSource) -> list[str]:
    """The table [source]."""
    lines = ["[source]"]
    if source.kind in DRAWN:
        lines.append(f"{source.kind} = {_drawn(source.kind, source.options[source.kind])}")
    elif source.kind == "solids":
        named = ", ".join(f"{_key(name)} = {quoted(str(path))}" for name, path in source.files.items())
        lines.append(f"solids = {{{named}}}")
    else:
        lines.append(f"{source.kind} = {quoted(str(source.file))}")
    thick = "thickness" if source.kind == "box" else "depth"
    for key in SOURCES[source.kind]:
        if key in source.options:
            lines.append(f"{key} = {_written(key, source.options[key], thick)}")
    return lines


def _drawn(kind: str, value: Any) -> str:
    if kind == "box":
        return f"[{', '.join(exact(side, 'length') for side in value)}]"
    rows = [
        f"{{material = {quoted(name)}, polygon = [{', '.join(f'[{x!r}, {y!r}]' for x, y in corners)}]}}"
        for name, corners in value
    ]
    return "[\n" + "".join(f"  {row},\n" for row in rows) + "]"


def _written(key: str, value: Any, thick: str) -> str:
    if key in _DIMENSIONS:
        return exact(value, _DIMENSIONS[key])
    if key in _LENGTHS:
        return f"[{', '.join(exact(entry, 'length') for entry in value)}]"
    if key == "layers":
        rows = [
            f"{{material = {quoted(name)}"
            + ("" if math.isinf(depth) else f", {thick} = {exact(depth, 'length')}")
            + "}"
            for name, depth in value
        ]
        return "[\n" + "".join(f"  {row},\n" for row in rows) + "]"
    return _plain(NOTHING if value is None else value)


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, tuple):
        return f"[{', '.join(_plain(NOTHING if entry is None else entry) for entry in value)}]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(str(key))} = {_plain(entry)}" for key, entry in value.items()) + "}"
    return repr(value)


def _key(name: str) -> str:
    return join("", name)


def particle_lines(options: ParticleOptions) -> list[str]:
    """The table [particles]."""
    lines = ["[particles]", f"arrangement = {quoted(options.arrangement)}"]
    if options.radius is not None:
        lines.append(f"radius = {exact(options.radius, 'length')}")
    if options.particles is not None:
        lines.append(f"particles = {options.particles}")
    if options.arrangement != "random":
        return lines
    if options.grading is not None:
        rows = [
            f"{{radius = {exact(radius, 'length')}, passing = {share!r}}}"
            for radius, share in options.grading
        ]
        lines.append("grading = [\n" + "".join(f"  {row},\n" for row in rows) + "]")
    else:
        lines.append(f"size_ratio = {options.size_ratio!r}")
    if options.solid_fraction is not None:
        lines.append(f"solid_fraction = {options.solid_fraction!r}")
    return [*lines, f"seed = {options.seed}"]


def _material(material: GroundGrains) -> list[str]:
    place = join("material", material.name)
    if material.bonded is None:
        return [f"[{place}]", f"density = {exact(material.density, 'density')}"]
    return [f"[{place}]", *material_lines(material.bonded, place=place)]
