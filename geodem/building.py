"""From a case to its section, particles and model, and what makes two cases the same."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from .builders.filling import TooFewParticlesError
from .builders.ground import GroundProperties, Surcharge, build_ground
from .builders.particles import Particles, fill_section
from .builders.section import Section
from .case import Case, ImageSection, MeshSection, RegionSection, SectionOptions, TerrainSection
from .errors import InputError
from .measure.failing_zone import FailingZone
from .model import Model
from .units import show

QUICK_PARTICLES = 1000
QUICK_TOLERANCE = 0.02


def make_section(case: Case) -> Section:
    """The section of a case, from its polygons, its picture, its mesh or its terrain."""
    return section_of(case.section)


def section_of(spec: SectionOptions) -> Section:
    """Polygons of what a case says of its section."""
    if isinstance(spec, RegionSection):
        return Section.from_polygons(spec.regions)
    if isinstance(spec, MeshSection | TerrainSection):
        return spec.section
    assert isinstance(spec, ImageSection)
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
        Exactly one of the two; neither where the nodes of a mesh are the particles.
    focus : FailingZone, optional
        Where the particles are to lie closer.
    """
    spec = case.section
    if isinstance(spec, MeshSection) and particles is None and spacing is None:
        from .builders.from_mesh import particles_from_mesh

        return particles_from_mesh(spec.mesh)
    with told_at_section():
        return fill_section(
            section,
            particles=particles,
            spacing=spacing,
            packing="hexagonal" if case.packing == "hexagonal" else "random",
            seed=case.seed,
            layers=spec.layers,
            thin="refuse" if spec.thin == "refuse" else "refine",
            refine=refinements(section, spec),
            focus=() if focus is None else [focus],
            points=[point for s in case.loads.surcharge for point in (s.start, s.end)],
        )


@contextmanager
def told_at_section() -> Iterator[None]:
    """Errors of filling a section at the keys of the case that they come from."""
    try:
        yield
    except TooFewParticlesError:
        raise
    except InputError as error:
        place, value = error.place, error.value
        if place.startswith("refine["):
            place, value = f"section.{place}.spacing", show(float(str(value)), "length")
        elif place in ("layers", "thin"):
            place = f"section.{place}"
        raise InputError(place, error.problem, error.remedy, value=value, picture=error.picture) from error


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
    spec = case.section
    if isinstance(spec, MeshSection):
        spec = replace(spec, particles_on="polygons")
    coarse = replace(case, particles=count, spacing=None, tolerance=tolerance, section=spec)
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
    """The case as it is run, its file named without a folder: as it stands in the folder of the results."""
    return replace(case, section=case.section.beside()).as_run_text()


def case_identity(case: Case) -> str:
    """Hash of all that decides the result of a case: its values, and the content of its file.

    Raises
    ------
    InputError
        The file is gone.
    """
    digest = hashlib.sha256(portable_text(case).encode())
    digest.update(source_bytes(case.section) or b"")
    return digest.hexdigest()


def source_bytes(spec: SectionOptions) -> bytes | None:
    """Content of the picture, mesh or terrain that a section was read from; None where it has no file."""
    if spec.file is None:
        return None
    try:
        return spec.file.read_bytes()
    except OSError as error:
        raise InputError(
            f"section.{spec.key}", f"the file cannot be read ({error.strerror})", "Put it back.",
            value=str(spec.file),
        ) from error  # fmt: skip


def refinements(section: Section, spec: SectionOptions) -> list[tuple[Any, float]]:
    """Places of a section where the particles lie closer, and their spacing there [m]."""
    from shapely import box, union_all

    chosen = []
    for refinement in spec.refine:
        if refinement.box is not None:
            where = box(*refinement.box)
        else:
            where = union_all([r.polygon for r in section.regions if r.material == refinement.material])
        chosen.append((where, refinement.spacing))
    return chosen
