"""A case as it is run, back to TOML."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

from geodem import units
from geodem.case.table import join, quoted

if TYPE_CHECKING:
    from geodem.case.data import Case, GroundMaterial, ImageSection, RegionSection


def as_run_text(case: Case) -> str:
    """TOML with every default written out; reading it gives the same numbers to the last bit."""
    lines = [f"workflow = {quoted(case.workflow)}", f"title = {quoted(case.title)}"]
    if case.spacing is not None:
        lines.append(f"spacing = {_exact(case.spacing, 'length')}")
    else:
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
    lines += ["", *_section(case.section), "", "[boundary]"]
    boundary = case.boundary
    for side in ("left", "right", "bottom", "top"):
        lines.append(f"{side} = {quoted(getattr(boundary, side))}")
    lines += [
        "",
        "[loads]",
        f"horizontal_acceleration = {_exact(case.loads.horizontal_acceleration, 'acceleration')}",
    ]
    if case.loads.surcharge:
        rows = [
            f"{{from = {_list(map(repr, s.start))}, to = {_list(map(repr, s.end))}, "
            f"pressure = {_exact(s.pressure, 'stress')}}}"
            for s in case.loads.surcharge
        ]
        lines.append(f"surcharge = {_tall_list(rows)}")
    for material in case.materials.values():
        lines += ["", *_material(material)]
    if case.reference is not None:
        lines += [
            "",
            "[reference]",
            f"factor = {case.reference.factor!r}",
            f"source = {quoted(case.reference.source)}",
        ]
    return "\n".join(lines) + "\n"


def _section(section: RegionSection | ImageSection) -> list[str]:
    from geodem.case.data import RegionSection  # the data's method brings us here, so not at the top

    lines = ["[section]", 'length_unit = "m"']
    if isinstance(section, RegionSection):
        rows = []
        for material, polygon in section.regions:
            corners = _list(_list(map(repr, corner)) for corner in polygon.tolist())
            rows.append(f"{{material = {quoted(material)}, polygon = {corners}}}")
        lines.append(f"regions = {_tall_list(rows)}")
    else:
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
    lines += [f"layers = {section.layers}", f"thin = {quoted(section.thin)}"]
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


def _material(material: GroundMaterial) -> list[str]:
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
