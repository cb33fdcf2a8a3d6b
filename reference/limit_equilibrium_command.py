"""The command ``limit-equilibrium``: Bishop's and Spencer's factors for a case file."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from reference.ground import Ground, NotASlopeError, Soil, Surcharge
from reference.limit_equilibrium import search
from reference.noncircular import search_blocks
from reference.slice_methods import Answer

if TYPE_CHECKING:
    from geodem.builders.section import Section
    from geodem.case import Case, GroundMaterial, Loads

# Both methods see the same circles and agree within a few per cent where both can judge them. A larger factor
# by Spencer's comes from a circle that is not critical, for want of a solution on the one that is.
SPENCER_OVER_BISHOP = 1.05
HELP = "Factor of safety of a section by the methods of Bishop (simplified) and Spencer"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the command."""
    parser.add_argument("case", help="case file, or a folder that holds case.toml")
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def main(arguments: argparse.Namespace) -> int:
    """Print the factors; 0 done (also where the method does not apply, with the reason), 2 bad input."""
    from geodem.case import load_case
    from geodem.errors import InputError

    start = time.perf_counter()
    try:
        case = load_case(arguments.case)
        section = section_of(case)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    result = factors(section, case.materials, case.loads)
    result["seconds"] = round(time.perf_counter() - start, 3)
    print(json.dumps(result) if arguments.json else as_text(result))
    return 0


def section_of(case: Case) -> Section:
    """The section of a case, from its polygons or its picture.

    Raises
    ------
    InputError
        As `Section.from_polygons` and `section_from_image`.
    """
    from geodem.building import make_section

    return make_section(case)


def ground_from_section(
    section: Section, materials: Mapping[str, GroundMaterial], loads: Loads | None = None
) -> Ground:
    """The section as limit equilibrium sees it.

    Parameters
    ----------
    section : Section
    materials : mapping of str to GroundMaterial
        Density, cohesion and friction angle are used; tensile strength is not (full Mohr-Coulomb cone).
    loads : Loads, optional

    Raises
    ------
    NotASlopeError
        The section is in pieces, or has an opening or an overhang.
    """
    from geodem.units import GRAVITY

    soils = {
        name: Soil(
            materials[name].density * GRAVITY, materials[name].cohesion, materials[name].friction_angle
        )
        for name in section.materials
    }
    regions = [
        (region.material, [ring.coords for ring in (region.polygon.exterior, *region.polygon.interiors)])
        for region in section.regions
    ]
    if loads is None:
        return Ground(regions, soils)
    surcharges = [Surcharge(load.start, load.end, load.pressure) for load in loads.surcharge]
    return Ground(regions, soils, loads.horizontal_acceleration / GRAVITY, surcharges)


def factors(
    section: Section, materials: Mapping[str, GroundMaterial], loads: Loads | None = None
) -> dict[str, Any]:
    """Factors of safety of a section, ready for JSON.

    Returns
    -------
    dict
        ``methods``: Bishop simplified and Spencer on their critical circles (Spencer is left out, with a
        note, where it finds no equilibrium there) and, where it is lower, Spencer on a block along a layer,
        each with ``method``, ``factor``, ``centre`` and ``radius`` (None for a block), ``surface`` [m] and
        ``notes``. Where limit equilibrium does not apply, ``methods`` is empty and ``why`` says so.
    """
    try:
        ground = ground_from_section(section, materials, loads)
        answers = [search(ground, "bishop")]
    except NotASlopeError as error:
        return {"methods": [], "why": f"limit equilibrium does not apply: {error}"}
    try:
        spencer = search(ground, "spencer")
    except NotASlopeError:
        spencer = None
    if spencer is not None and spencer.factor <= SPENCER_OVER_BISHOP * answers[0].factor:
        answers.append(spencer)
    else:
        note = "Spencer's method finds no equilibrium on the critical circle and is left out."
        answers[0] = replace(answers[0], notes=(*answers[0].notes, note))
    block = search_blocks(ground)
    if block is not None and block.factor < answers[-1].factor:
        answers.append(block)
    elif block is not None:
        note = f"The best block along a layer is no lower: {block.factor:.3f}."
        answers[-1] = replace(answers[-1], notes=(*answers[-1].notes, note))
    cut_off = [
        name for name in section.materials if materials[name].tensile_strength < _apex(materials[name])
    ]
    note = f"The tensile strength of {', '.join(cut_off)} is not used: full Mohr-Coulomb cone."
    return {"methods": [_entry(answer, (note,) if cut_off else ()) for answer in answers]}


def _apex(material: GroundMaterial) -> float:
    """Tension at the apex of the Mohr-Coulomb cone [Pa]."""
    slope = math.tan(material.friction_angle)
    return material.cohesion / slope if slope > 0.0 else math.inf


def _entry(answer: Answer, notes: tuple[str, ...]) -> dict[str, Any]:
    return {
        "method": answer.method,
        "factor": answer.factor,
        "centre": None if answer.centre is None else list(answer.centre),
        "radius": answer.radius,
        "surface": answer.surface.tolist(),
        "notes": [*answer.notes, *notes],
    }


def as_text(result: Mapping[str, Any]) -> str:
    """The result as a table with its notes."""
    lines = [result["why"]] if "why" in result else []
    for entry in result["methods"]:
        where = (
            "" if entry["centre"] is None else "  circle about ({:.2f}, {:.2f}) m".format(*entry["centre"])
        )
        size = "" if entry["radius"] is None else f" of radius {entry['radius']:.2f} m"
        lines.append(f"{entry['method']:<24} {entry['factor']:.3f}{where}{size}")
        lines += [f"    {note}" for note in entry["notes"]]
    return "\n".join([*lines, f"{result['seconds']:.2f} s"])
