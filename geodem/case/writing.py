"""A case as it is run, back to TOML."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

from geodem import units
from geodem.case.table import join, quoted

if TYPE_CHECKING:
    from geodem.case.data import Case, GroundMaterial, SectionOptions, Surcharge
    from geodem.case.mesh_section import MeshSection
    from geodem.case.terrain_section import TerrainSection


def as_run_text(case: Case) -> str:
    """TOML with every default written out; reading it gives the same numbers to the last bit."""
    lines = [f"workflow = {quoted(case.workflow)}", f"title = {quoted(case.title)}"]
    if case.spacing is not None:
        lines.append(f"spacing = {_exact(case.spacing, 'length')}")
    elif case.particles is not None:
        lines.append(f"particles = {case.particles}")
    lines += [
        f"packing = {quoted(case.packing)}",
        f"methods = {_list(map(quoted, case.methods))}",
        f"tolerance = {case.tolerance!r}",
        f"seed = {case.seed}",
    ]
    if case.allow_implausible:
        # the unit weight is written as a density below
        allowed = dict.fromkeys(re.sub(r"\.unit_weight$", ".density", key) for key in case.allow_implausible)
        lines.append(f"allow_implausible = {_list(map(quoted, allowed))}")
    lines += ["", *section_lines(case.section), "", "[boundary]"]
    boundary = case.boundary
    for side in ("left", "right", "bottom", "top"):
        lines.append(f"{side} = {quoted(getattr(boundary, side))}")
    lines += [
        "",
        "[loads]",
        f"horizontal_acceleration = {_exact(case.loads.horizontal_acceleration, 'acceleration')}",
    ]
    if case.loads.surcharge:
        lines += surcharge_lines(case.loads.surcharge)
    for material in case.materials.values():
        lines += ["", *material_lines(material)]
    if case.reference is not None:
        lines += [
            "",
            "[reference]",
            f"factor = {case.reference.factor!r}",
            f"source = {quoted(case.reference.source)}",
        ]
    return "\n".join(lines) + "\n"


def surcharge_lines(surcharges: Iterable[Surcharge]) -> list[str]:
    """The key surcharge."""
    rows = [
        f"{{from = {_list(map(repr, s.start))}, to = {_list(map(repr, s.end))}, "
        f"pressure = {_exact(s.pressure, 'stress')}}}"
        for s in surcharges
    ]
    return [f"surcharge = {_tall_list(rows)}"]


def section_lines(section: SectionOptions) -> list[str]:
    """The table of a section."""
    # the data's method brings us here, so not at the top
    from geodem.case.data import ImageSection, RegionSection
    from geodem.case.mesh_section import MeshSection
    from geodem.case.terrain_section import TerrainSection

    lines = ["[section]", 'length_unit = "m"']
    if isinstance(section, RegionSection):
        rows = []
        for material, polygon in section.regions:
            corners = _list(_list(map(repr, corner)) for corner in polygon.tolist())
            rows.append(f"{{material = {quoted(material)}, polygon = {corners}}}")
        lines.append(f"regions = {_tall_list(rows)}")
    elif isinstance(section, ImageSection):
        legend = ", ".join(
            f"{quoted(colour)} = {quoted(material)}" for colour, material in section.legend.items()
        )
        lines += [
            f"image = {quoted(str(section.image))}",
            f"scale = {_exact(section.scale, 'pixel_scale')}",
            f"legend = {{{legend}}}",
            f"background = {_list(map(quoted, section.background))}",
            f"y_axis = {quoted(section.y_axis)}",
            f"origin = {_list(map(repr, section.origin))}",
        ]
    elif isinstance(section, MeshSection):
        # without a unit the file's own one counts, and coordinates are metres
        lines = ["[section]", *([] if section.unit is None else ['length_unit = "m"']), *_mesh(section)]
        if section.particles_on == "nodes":
            return lines
    elif isinstance(section, TerrainSection):
        lines += _terrain(section)
    lines += [
        *([] if section.key == "terrain" else [f"layers = {section.layers}"]),
        f"thin = {quoted(section.thin)}",
    ]
    if section.refine:
        rows = []
        for entry in section.refine:
            if entry.box is not None:
                left, bottom, right, top = entry.box
                where = f"box = [[{left!r}, {bottom!r}], [{right!r}, {top!r}]]"
            else:
                where = f"material = {quoted(entry.material or '')}"
            rows.append(f"{{{where}, spacing = {_exact(entry.spacing, 'length')}}}")
        lines.append(f"refine = {_tall_list(rows)}")
    return lines


def _mesh(section: MeshSection) -> list[str]:
    lines = [f"mesh = {quoted(str(section.path))}", f"particles_on = {quoted(section.particles_on)}"]
    if section.unit is not None:
        lines.append(f"mesh_unit = {quoted(section.unit)}")
    if section.names:
        named = ", ".join(f"{number} = {quoted(name)}" for number, name in section.names.items())
        lines.append(f"names = {{{named}}}")
    if section.material_array is not None:
        lines.append(f"material_array = {quoted(section.material_array)}")
    if section.size is not None:
        lines.append(f"size = {_exact(section.size, 'length')}")
    return lines


def _terrain(section: TerrainSection) -> list[str]:
    lines = [
        f"terrain = {quoted(str(section.path))}",
        f"line = {_list(_list(map(repr, place)) for place in section.line)}",
        f"base = {_exact(section.base, 'length')}",
        f"layers = {_tall_list([_layer(*layer) for layer in section.strata])}",
        f"holes = {quoted(section.holes)}",
    ]
    if section.degrees is not None:
        lines.append(f"degrees = {str(section.degrees).lower()}")
    if section.step is not None:
        lines.append(f"step = {_exact(section.step, 'length')}")
    return lines


def _layer(material: str, depth: float) -> str:
    reach = "" if math.isinf(depth) else f", depth = {_exact(depth, 'length')}"
    return f"{{material = {quoted(material)}{reach}}}"


def material_lines(material: GroundMaterial) -> list[str]:
    """The table of a material."""
    weight = units.show(material.density * units.GRAVITY, "unit_weight")
    dilation = f"dilation_angle = {_exact(material.dilation_angle, 'angle')}"
    tension = material.tensile_strength
    return [
        f"[{join('material', material.name)}]",
        f"law = {quoted(material.law)}",
        f"density = {_exact(material.density, 'density')}  # {weight} at g = {units.GRAVITY} m/s2",
        f"cohesion = {_exact(material.cohesion, 'stress')}",
        f"friction_angle = {_exact(material.friction_angle, 'angle')}",
        # a run reports differently where the angle was left out, so it stays out
        dilation if material.dilation_given else f"# {dilation} (left out: equal to the friction angle)",
        f"young_modulus = {_exact(material.young_modulus, 'stress')}",
        f"poisson_ratio = {material.poisson_ratio!r}",
        f"tensile_strength = {quoted('none') if math.isinf(tension) else _exact(tension, 'stress')}",
    ]


def _exact(value: float, dimension: str) -> str:
    return quoted(units.exact(value, dimension))


def _list(entries: Iterable[str]) -> str:
    return f"[{', '.join(entries)}]"


def _tall_list(rows: list[str]) -> str:
    return "[\n" + "".join(f"  {row},\n" for row in rows) + "]"
