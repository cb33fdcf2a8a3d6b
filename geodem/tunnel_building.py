"""From a tunnel case to its ground and plan."""

from __future__ import annotations

from dataclasses import replace

import shapely

from .builders.filling import TooFewParticlesError
from .builders.ground import STANDARD_GRAVITY, Surcharge
from .building import ground_properties, refinements, section_of, told_at_section
from .case.mesh_section import MeshSection
from .case.tunnel import TunnelCase
from .errors import InputError, InputErrors
from .tunnelling.ground import TunnelGround, make_tunnel_ground
from .tunnelling.plan import Opening, Plan, UniformStress

QUICK_PARTICLES = 1500
QUICK_TOLERANCE = 0.02
QUICK_INCREMENTS = 10


def build_tunnel(case: TunnelCase) -> tuple[TunnelGround, Plan]:
    """Ground and plan of a case.

    Raises
    ------
    InputError, InputErrors
        Openings or bolts that do not lie in the ground, particles that do not fit it.
    """
    section = section_of(case.section)
    plan = case.plan()
    errors = [*_misplaced(plan.openings, section.outline, case.boundary), *_lost_bolts(plan, section.outline)]
    if errors:
        raise InputErrors(errors)
    weightless = isinstance(case.initial, UniformStress)
    with told_at_section():
        ground = make_tunnel_ground(
            section,
            plan.openings,
            {name: ground_properties(material) for name, material in case.materials.items()},
            boundary=dict(case.boundary),
            particles=case.particles,
            spacing=case.spacing,
            wall_spacing=case.wall_spacing,
            seed=case.seed,
            surcharges=[Surcharge(s.start, s.end, s.pressure) for s in case.surcharge],
            refine=refinements(section, case.section),
            gravity=0.0 if weightless else STANDARD_GRAVITY,
        )
    return ground, plan


def quick(case: TunnelCase) -> TunnelCase:
    """A coarser version of a case, for a first look."""
    count = min(case.particles or QUICK_PARTICLES, QUICK_PARTICLES)
    tolerance = max(case.tolerance, QUICK_TOLERANCE)
    increments = min(case.increments, QUICK_INCREMENTS)
    coarse = replace(
        case, particles=count, spacing=None, wall_spacing=None, tolerance=tolerance, increments=increments
    )
    why = ""
    for _ in range(3):
        try:
            build_tunnel(coarse)
            break
        except TooFewParticlesError as error:
            # the spacing on the walls follows from the number, so one more tenth is asked for
            coarse = replace(coarse, particles=int(1.1 * error.needed))
            why = " (about the least that its walls and refined places need)"
        except InputError:
            break  # building will say what is wrong
    notice = (
        f"--quick: {coarse.particles} particles{why}, {increments} increments and a tolerance of {tolerance:g} "
        "instead of the case's own."
    )
    return replace(coarse, notices=(*case.notices, notice))


def unsuited_section(case: TunnelCase) -> list[InputError]:
    """Sections that cannot be dug into."""
    if isinstance(case.section, MeshSection) and case.section.particles_on == "nodes":
        return [
            InputError(
                "section.particles_on",
                "openings are cut into polygons, not into the nodes of a mesh",
                'Write particles_on = "polygons".',
                value="nodes",
            )
        ]
    return []


def _misplaced(
    openings: tuple[Opening, ...], outline: shapely.Geometry, boundary: object
) -> list[InputError]:
    """Openings outside the ground, over a side that is no line of symmetry, or over each other."""
    assert isinstance(boundary, dict)
    left, bottom, right, top = outline.bounds
    sides = {
        "left": shapely.LineString([(left, bottom), (left, top)]),
        "right": shapely.LineString([(right, bottom), (right, top)]),
        "bottom": shapely.LineString([(left, bottom), (right, bottom)]),
        "top": shapely.LineString([(left, top), (right, top)]),
    }
    slack = 1e-6 * max(right - left, top - bottom)
    errors = []
    for number, opening in enumerate(openings):
        place = f"excavation[{number}]"
        polygon = opening.polygon
        outside = shapely.difference(polygon, outline)
        where = f"the ground reaches from ({left:.4g}, {bottom:.4g}) to ({right:.4g}, {top:.4g}) m"
        x, y = opening.centre
        if shapely.intersection(polygon, outline).area <= 1e-9 * polygon.area:
            errors.append(
                InputError(
                    place,
                    f"{opening.name!r} at ({x:.4g}, {y:.4g}) m lies outside the ground: {where}",
                    "Move it into the section, or check section.length_unit.",
                )
            )
        elif outside.area > 1e-9 * polygon.area:
            crossed = [
                side for side, line in sides.items() if shapely.intersects(polygon.buffer(-slack), line)
            ]
            wrong = [side for side in crossed if boundary.get(side) != "roller"]
            if wrong or not crossed:
                named = f"the {wrong[0]} side" if wrong else "the surface of the ground"
                errors.append(
                    InputError(
                        place,
                        f"{opening.name!r} reaches over {named}: {where}",
                        "Move it into the section; only over a line of symmetry, a side that is a roller, may half "
                        "of it stand outside.",
                    )
                )
        for other in openings[:number]:
            if shapely.intersection(polygon, other.polygon).area > 1e-9 * polygon.area:
                errors.append(
                    InputError(
                        place,
                        f"{opening.name!r} overlaps {other.name!r}",
                        "Draw heading and bench as neighbours that share a line.",
                    )
                )
    return errors


def _lost_bolts(plan: Plan, outline: shapely.Geometry) -> list[InputError]:
    """Bolts that do not end in the ground, or do not begin on a wall."""
    left, bottom, right, top = outline.bounds
    slack = 0.005 * max(right - left, top - bottom)
    holes = shapely.union_all([o.polygon for o in plan.openings])
    errors = []
    for number, bolts in enumerate(plan.bolts):
        for bar, (head, tip) in enumerate(bolts.bars):
            place = f"bolt[{number}]"
            end = shapely.Point(tip)
            if not outline.contains(end) or holes.contains(end):
                what = "an opening" if holes.contains(end) else "the outside of the ground"
                errors.append(
                    InputError(
                        place,
                        f"bar {bar} of {bolts.name!r} ends at ({tip[0]:.4g}, {tip[1]:.4g}) m, in {what}",
                        "Make it shorter, turn it, or move it.",
                    )
                )
            elif shapely.Point(head).distance(holes.boundary) > slack:
                errors.append(
                    InputError(
                        place,
                        f"bar {bar} of {bolts.name!r} begins at ({head[0]:.4g}, {head[1]:.4g}) m, not on a wall",
                        "Let it begin on the outline of an excavation.",
                    )
                )
    return errors
