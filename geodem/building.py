"""From a case to its section, particles and model, and what makes two cases the same."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import Any

from .builders.filling import TooFewParticlesError
from .builders.ground import GroundProperties, Surcharge, build_ground
from .builders.particles import Particles, fill_section
from .builders.section import Section
from .case import Case, ImageSection, RegionSection
from .errors import InputError
from .measure.failing_zone import FailingZone
from .model import Model

QUICK_PARTICLES = 1000
QUICK_TOLERANCE = 0.02


def make_section(case: Case) -> Section:
    """The section of a case, from its polygons or its picture."""
    spec = case.section
    if isinstance(spec, RegionSection):
        return Section.from_polygons(spec.regions)
    from .builders.from_image import section_from_image

    return section_from_image(
        spec.image,
        scale=spec.scale,
        legend=spec.legend,
        background=spec.background,
        y_axis="down" if spec.y_axis == "down" else "up",
        origin=spec.origin,
    )


def make_particles(
    case: Case,
    section: Section,
    *,
    particles: int | None,
    spacing: float | None = None,
    focus: FailingZone | None = None,
) -> Particles:
    """Particles of a case's section, with its packing, refinements and load edges.

    Parameters
    ----------
    case : Case
    section : Section
        `make_section(case)`.
    particles : int or None
    spacing : float or None [m]
        Exactly one of the two.
    focus : FailingZone, optional
        Where the particles are to lie closer.
    """
    spec = case.section
    return fill_section(
        section,
        particles=particles,
        spacing=spacing,
        packing="hexagonal" if case.packing == "hexagonal" else "random",
        seed=case.seed,
        layers=spec.layers,
        thin="refuse" if spec.thin == "refuse" else "refine",
        refine=_refinements(section, spec),
        focus=() if focus is None else [focus],
        points=[point for s in case.loads.surcharge for point in (s.start, s.end)],
    )


def make_model(case: Case, particles: Particles) -> Model:
    """The model of a case on given particles."""
    return build_ground(
        particles,
        {name: ground_properties(material) for name, material in case.materials.items()},
        boundary={side: getattr(case.boundary, side) for side in ("left", "right", "bottom", "top")},
        horizontal_acceleration=case.loads.horizontal_acceleration,
        surcharges=[Surcharge(s.start, s.end, s.pressure) for s in case.loads.surcharge],
    )


def ground_properties(material: Any) -> GroundProperties:
    """Density and law parameters of a material of the case file."""
    return GroundProperties.of(
        material.density,
        material.law,
        young_modulus=material.young_modulus,
        poisson_ratio=material.poisson_ratio,
        cohesion=material.cohesion,
        friction_angle=material.friction_angle,
        dilation_angle=material.dilation_angle,
        tensile_strength=material.tensile_strength,
    )


def quick(case: Case) -> Case:
    """A coarser version of a case, for a first look: about 1,000 particles, more where a thin seam needs them."""
    count = min(case.particles or QUICK_PARTICLES, QUICK_PARTICLES)
    tolerance = max(case.tolerance, QUICK_TOLERANCE)
    coarse = replace(case, particles=count, spacing=None, tolerance=tolerance)
    section = make_section(coarse)
    why = ""
    for _ in range(3):
        try:
            make_particles(coarse, section, particles=count)
            break
        except TooFewParticlesError as error:
            count, why = error.needed, " (the least that its thin or refined places need)"
        except InputError:
            break  # building will say what is wrong
    notice = f"--quick: {count} particles{why} and a tolerance of {tolerance:g} instead of the case's own."
    return replace(coarse, particles=count, notices=(*case.notices, notice))


def portable_text(case: Case) -> str:
    """The case as it is run, its picture named without a folder: as it stands in the folder of the results."""
    spec = case.section
    if isinstance(spec, ImageSection):
        case = replace(case, section=replace(spec, image=Path(spec.image.name)))
    return case.as_run_text()


def case_identity(case: Case) -> str:
    """Hash of all that decides the result of a case: its values, and the content of its picture.

    Raises
    ------
    InputError
        The picture is gone.
    """
    digest = hashlib.sha256(portable_text(case).encode())
    if isinstance(case.section, ImageSection):
        digest.update(picture_bytes(case.section))
    return digest.hexdigest()


def picture_bytes(spec: ImageSection) -> bytes:
    """Content of the picture that a section was read from."""
    try:
        return spec.image.read_bytes()
    except OSError as error:
        raise InputError(
            "section.image",
            f"the picture cannot be read ({error.strerror})",
            "Put it back.",
            value=str(spec.image),
        ) from error


def _refinements(section: Section, spec: RegionSection | ImageSection) -> list[tuple[Any, float]]:
    from shapely import box, union_all

    chosen = []
    for refinement in spec.refine:
        if refinement.box is not None:
            where = box(*refinement.box)
        else:
            where = union_all([r.polygon for r in section.regions if r.material == refinement.material])
        chosen.append((where, refinement.spacing))
    return chosen
