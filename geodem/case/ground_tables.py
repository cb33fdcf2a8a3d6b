"""Tables that every case of particles has: [particles], and what of [material.NAME] is the same for all."""

from __future__ import annotations

import itertools
from pathlib import Path

from geodem import units
from geodem.case.ground import ParticleOptions
from geodem.case.material_file import load_material
from geodem.case.section import positive
from geodem.case.source_files import find_file
from geodem.case.table import Table, join, listed, nearest, quoted
from geodem.errors import InputError, InputErrors
from geodem.laboratory.material import BondedMaterial

PARTICLE_KEYS = ("arrangement", "radius", "particles", "grading", "size_ratio", "solid_fraction", "seed")
ARRANGEMENTS = ("random", "square", "hexagonal", "simple_cubic", "bcc", "fcc", "hcp", "pixel")
DEFAULT_PARTICLES = 10_000
MANY = 10_000_000
"""Particles beyond which a case must say that so many are meant."""
_DENSITY = (500.0, 5100.0)
_GRADING = '[{radius = "5 mm", passing = "0 %"}, {radius = "10 mm", passing = "100 %"}]'


def mismatches(found: tuple[str, ...], defined: tuple[str, ...], what: str) -> list[InputError]:
    """Errors of materials of a source that have no table, and of tables that it has no ground for."""
    errors = [
        InputError(
            join("material", name), f"missing: {what} has the material {quoted(name)}",
            f"{nearest(name, defined)}Add [{join('material', name)}] with its density. {what.capitalize()} has "
            f"{listed(found)}; the case has {listed(defined)}.",
        )
        for name in found
        if name not in defined
    ]  # fmt: skip
    return errors + [
        InputError(
            join("material", name), f"{what} has no such material",
            f"{nearest(name, found)}Remove the table, or give it the name of one of {listed(found)}.",
        )
        for name in defined
        if name not in found
    ]  # fmt: skip


def read_particles(top: Table) -> ParticleOptions | None:
    """The table [particles]; None where something is wrong, which has then been told."""
    findings = top.findings
    before = len(findings.errors)
    if "particles" not in top:
        findings.default("particles", f"about {DEFAULT_PARTICLES} at random")
        return ParticleOptions(particles=DEFAULT_PARTICLES)
    table = top.sub("particles", PARTICLE_KEYS, example="[particles] with particles = 10000")
    if table is None:
        return None
    arrangement = table.choice("arrangement", ARRANGEMENTS, default="random")
    radius = table.quantity("radius", "length", check=positive)
    count = table.integer("particles", smallest=1, remedy="Write a whole number such as 10000.")
    if count is not None and count > MANY:
        findings.implausible(
            table.at("particles"), "so many particles take days and tens of gigabytes",
            "Write 10000 for a first look.", value=count,
        )  # fmt: skip
    findings.asked.add(table.at("radius"))  # whether it fits is seen when the body is there
    grading = _grading(table)
    sizes = [key for key in ("radius", "particles", "grading") if key in table]
    if arrangement == "pixel":
        for key in sizes:
            table.error(key, "one particle in each pixel has its size", f"Remove {key}.")
    elif len(sizes) > 1:
        table.error(sizes[1], f"{' and '.join(sizes)} are given", "Keep one of them; the others follow.")
    elif not sizes:
        count = DEFAULT_PARTICLES
        findings.default(table.at("particles"), str(count))
    size_ratio = table.quantity("size_ratio", "dimensionless", check=_ratio)
    share = table.quantity("solid_fraction", "dimensionless", check=_share)
    seed = table.integer("seed", smallest=0, remedy="Write a whole number such as 1.")
    if arrangement is not None and arrangement != "random":
        for key in ("grading", "size_ratio", "solid_fraction", "seed"):
            if key in table:
                table.error(
                    key, f'this belongs to arrangement = "random", not {quoted(arrangement)}',
                    f"Remove {key}.",
                )  # fmt: skip
    elif "grading" in table and "size_ratio" in table:
        table.error("size_ratio", "the grading has its own sizes", "Keep one of the two.")
    else:
        for key, shown in (("size_ratio", "1.5"), ("seed", "1")):
            if key not in table and not (key == "size_ratio" and grading):
                findings.default(table.at(key), shown)
    if len(findings.errors) > before:
        return None
    return ParticleOptions(
        arrangement=arrangement or "random",
        radius=radius,
        particles=count,
        grading=grading,
        size_ratio=1.5 if size_ratio is None else size_ratio,
        solid_fraction=share,
        seed=1 if seed is None else seed,
    )


def _grading(table: Table) -> tuple[tuple[float, float], ...] | None:
    if "grading" not in table:
        return None
    points = []
    for row in table.rows("grading", ("sieve", "radius", "passing"), example=_GRADING):
        if "sieve" in row and "radius" in row:
            remedy = "Keep one: what passes a sieve has half its opening as radius."
            row.error("sieve", "sieve and radius are both given", remedy)
        opening = row.quantity("sieve", "length", check=positive)
        radius = row.quantity("radius", "length", check=positive) if opening is None else 0.5 * opening
        values = radius, row.quantity("passing", "dimensionless")
        if "sieve" not in row and "radius" not in row:
            row.missing("radius", f"Write grading = {_GRADING}.")
        if "passing" not in row:
            row.missing("passing", f"Write grading = {_GRADING}.")
        if values[0] is not None and values[1] is not None:
            points.append((values[0], values[1]))
    if isinstance(table.content["grading"], list) and len(table.content["grading"]) < 2:
        table.error("grading", "a sieve curve has two points at least", f"Write grading = {_GRADING}.")
    elif points and len(points) == len(table.items("grading", example=_GRADING)):
        ends = points[0][1] == 0.0 and points[-1][1] == 1.0
        grows = all(b[0] >= a[0] and b[1] >= a[1] for a, b in itertools.pairwise(points))
        if not (ends and grows):
            table.error(
                "grading", "radii and shares do not grow from 0 % to 100 %", f"Write grading = {_GRADING}."
            )
    return tuple(points)


def read_density(table: Table) -> float | None:
    """Density of the ground, given so or by its unit weight; None where it is neither, or wrong."""
    if "density" in table and "unit_weight" in table:
        table.error("unit_weight", "density and unit_weight are both given", "Keep one of the two.")
        return None
    key = "unit_weight" if "unit_weight" in table else "density"
    value = table.quantity(key, key, check=positive)
    if value is None:
        return None
    density = value / units.GRAVITY if key == "unit_weight" else value
    if not _DENSITY[0] <= density <= _DENSITY[1]:
        low, high = (
            units.show(bound * (units.GRAVITY if key == "unit_weight" else 1.0), key) for bound in _DENSITY
        )
        table.findings.implausible(
            table.at(key), f"ground has {low} to {high}", "Check the unit: water has 1000 kg/m3, 9.81 kN/m3.",
            value=table.content[key],
        )  # fmt: skip
    return density


def material_of_file(table: Table, folder: Path) -> BondedMaterial | None:
    """The material of the file that the key `file` names; None where it is wrong, which has then been told."""
    path = find_file(table, "file", folder)
    if path is None:
        return None
    name = str(table.content["file"])
    try:
        return load_material(path)[0]
    except InputErrors as errors:
        for error in errors.errors:
            table.findings.errors.append(
                InputError(f"{name}, {error.place}", error.problem, error.remedy, value=error.value)
            )
    except InputError as error:
        table.error("file", error.problem, error.remedy)
    return None


def _ratio(value: float) -> tuple[str, str] | None:
    if 1.0 <= value <= 20.0:
        return None
    return "largest over smallest radius lies between 1 and 20", "Write 1.5; wider ones go with a grading."


def _share(value: float) -> tuple[str, str] | None:
    return None if 0.0 < value < 1.0 else ("a share of the room lies between 0 and 1", "Write 0.6.")
