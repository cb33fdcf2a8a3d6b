"""A tunnel case, back to TOML."""

from __future__ import annotations

import math

from geodem.case.bonded import exact
from geodem.case.table import quoted
from geodem.case.tunnel import BoltPattern, Excavation, TunnelCase
from geodem.case.writing import material_lines, section_lines, surcharge_lines
from geodem.tunnelling.plan import DepthStress, Lining, Stage


def tunnel_text(case: TunnelCase) -> str:
    """TOML with every default written out; reading it gives the same numbers to the last bit."""
    lines = [f"workflow = {quoted(case.workflow)}", f"title = {quoted(case.title)}"]
    if case.spacing is not None:
        lines.append(f"spacing = {exact(case.spacing, 'length')}")
    else:
        lines.append(f"particles = {case.particles}")
    if case.wall_spacing is not None:
        lines.append(f"wall_spacing = {exact(case.wall_spacing, 'length')}")
    lines += [f"seed = {case.seed}", f"increments = {case.increments}"]
    lines.append(f"ground_reaction = {str(case.ground_reaction).lower()}")
    if case.allow_implausible:
        allowed = dict.fromkeys(key.replace(".unit_weight", ".density") for key in case.allow_implausible)
        lines.append(f"allow_implausible = [{', '.join(map(quoted, allowed))}]")
    lines += ["", *section_lines(case.section), "", "[boundary]"]
    lines += [f"{side} = {quoted(support)}" for side, support in case.boundary.items()]
    if case.surcharge:
        lines += ["", "[loads]", *surcharge_lines(case.surcharge)]
    lines += ["", "[initial_stress]"]
    if isinstance(case.initial, DepthStress):
        lines.append(f"k0 = {case.initial.k0!r}")
    else:
        for key in ("horizontal", "vertical", "shear"):
            lines.append(f"{key} = {exact(getattr(case.initial, key), 'stress')}")
    for excavation in case.excavations:
        lines += ["", "[[excavation]]", *_excavation(excavation)]
    for lining in case.linings:
        lines += ["", "[[lining]]", *_lining(lining)]
    for pattern in case.bolts:
        lines += ["", "[[bolt]]", *_bolts(pattern)]
    for stage in case.stages:
        lines += ["", "[[stage]]", *_stage(stage)]
    if case.methods:
        lines += ["", "[stability]", f"methods = [{', '.join(map(quoted, case.methods))}]"]
        lines.append(f"tolerance = {case.tolerance!r}")
    for material in case.materials.values():
        lines += ["", *material_lines(material)]
    return "\n".join(lines) + "\n"


def _point(point: tuple[float, float]) -> str:
    return f"[{point[0]!r}, {point[1]!r}]"


def _excavation(excavation: Excavation) -> list[str]:
    lines = [f"name = {quoted(excavation.name)}"]
    sizes = [exact(size, "length") for size in excavation.sizes]
    if excavation.shape == "circle":
        return [*lines, f"circle = {{centre = {_point(excavation.at)}, diameter = {sizes[0]}}}"]
    if excavation.shape == "horseshoe":
        shape = f"floor = {_point(excavation.at)}, width = {sizes[0]}, height = {sizes[1]}"
        return [*lines, f"horseshoe = {{{shape}}}"]
    return [*lines, f"polygon = [{', '.join(map(_point, excavation.corners))}]"]


def _lining(lining: Lining) -> list[str]:
    lines = [
        f"name = {quoted(lining.name)}",
        f"excavation = {quoted(lining.opening)}",
        f"thickness = {exact(lining.thickness, 'length')}",
        f"young_modulus = {exact(lining.young_modulus, 'stress')}",
        f"poisson_ratio = {lining.poisson_ratio!r}",
    ]
    for key in ("compressive_strength", "tensile_strength"):
        if math.isfinite(getattr(lining, key)):
            lines.append(f"{key} = {exact(getattr(lining, key), 'stress')}")
    return lines


def _bolts(pattern: BoltPattern) -> list[str]:
    lines = [f"name = {quoted(pattern.name)}"]
    if pattern.excavation is not None:
        angles = ", ".join(exact(angle, "angle") for angle in pattern.angles)
        lines += [
            f"excavation = {quoted(pattern.excavation)}",
            f"angles = [{angles}]",
            f"length = {exact(pattern.length, 'length')}",
        ]
    else:
        lines.append(f"bars = [{', '.join(f'[{_point(a)}, {_point(b)}]' for a, b in pattern.bars)}]")
    lines += [
        f"kind = {quoted('anchored' if pattern.anchored else 'grouted')}",
        f"diameter = {exact(pattern.diameter, 'length')}",
        f"young_modulus = {exact(pattern.young_modulus, 'stress')}",
        f"yield_force = {exact(pattern.yield_force, 'force')}",
        f"spacing = {exact(pattern.spacing, 'length')}",
    ]
    if not pattern.anchored:
        lines.append(f"grout_stiffness = {exact(pattern.grout_stiffness, 'stress')}")
        if math.isfinite(pattern.grout_strength):
            lines.append(f"grout_strength = {exact(pattern.grout_strength, 'line_load')}")
    return lines


def _stage(stage: Stage) -> list[str]:
    lines = [f"name = {quoted(stage.name)}"]
    for key, names in (("excavate", stage.excavate), ("install", stage.install)):
        if names:
            lines.append(f"{key} = [{', '.join(map(quoted, names))}]")
    if stage.opening is not None:
        lines.append(f"excavation = {quoted(stage.opening)}")
    if stage.relax is not None:
        lines.append(f"relax = {stage.relax!r}")
    if stage.pressure is not None:
        lines.append(f"pressure = {exact(stage.pressure, 'stress')}")
    return lines
