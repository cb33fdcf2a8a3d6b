"""Cases of the laboratory and of a calibration, from their text; every error of a file at once."""

from __future__ import annotations

from pathlib import Path

from geodem import units
from geodem.calibration.targets import RockTargets, contradictions, doubts
from geodem.case.bonded import material_keys, read_material
from geodem.case.document import read_text
from geodem.case.head import read_head
from geodem.case.laboratory import CalibrationCase, LaboratoryCase, SpecimenOptions, TestOptions
from geodem.case.material_file import Calibrated, load_material
from geodem.case.specimen import ACROSS, ACROSS_CALIBRATION, read_specimen
from geodem.case.specimen import CALIBRATION_KEYS as SPECIMEN_OF_CALIBRATION
from geodem.case.table import Findings, Table, listed
from geodem.errors import InputError, InputErrors
from geodem.laboratory.material import BondedMaterial

_TOP = ("workflow", "title", "seed", "allow_implausible", "specimen")
LABORATORY_KEYS = (*_TOP, "seeds", "material", "test")
CALIBRATION_KEYS = (*_TOP, "rock")
TEST_KEYS = ("kind", "confinement", "normal_stress")
ROCK_DIMENSIONS = {
    "density": "density",
    "young_modulus": "stress",
    "poisson_ratio": "dimensionless",
    "uniaxial_compressive_strength": "stress",
    "tensile_strength": "stress",
    "friction_angle": "angle",
    "friction_confinement": "stress",
}
"""Properties of a rock, and the kind of quantity that each is."""

KINDS = {
    "uniaxial-compression": "",
    "triaxial-compression": "confinement",
    "direct-tension": "",
    "brazilian": "",
    "direct-shear": "normal_stress",
    "three-point-bending": "",
}
"""Tests, and the key of the stress that each needs."""

DEFAULT_SEEDS = 4
MOST_SEEDS = 10_000
DEFAULT_SEED = 1
_LARGEST_STRESS = 1e9


def load_laboratory(path: Path | str) -> LaboratoryCase:
    """Read a case of the laboratory: a file, or a folder that holds case.toml; raises as `parse_laboratory`."""
    return parse_laboratory(*read_text(path))


def load_calibration(path: Path | str) -> CalibrationCase:
    """Read a case of a calibration: a file, or a folder that holds case.toml; raises as `parse_calibration`."""
    return parse_calibration(*read_text(path))


def parse_laboratory(text: str, folder: Path) -> LaboratoryCase:
    """Read a case of the laboratory from its text.

    Parameters
    ----------
    text : str
        TOML.
    folder : pathlib.Path
        What the path of its material file is relative to.

    Raises
    ------
    InputError
        The text is no TOML, or a case of another workflow.
    InputErrors
        All that is wrong in it, in its order; what is wrong in the material file as well.
    """
    head = read_head(text, folder, "laboratory", LABORATORY_KEYS, example="Granite")
    top, findings = head.top, head.findings
    seed = head.seed(DEFAULT_SEED)
    seeds = top.integer("seeds", smallest=1, remedy="Write a whole number such as 4.")
    if seeds is not None and seeds > MOST_SEEDS:
        top.error(
            "seeds", "so many specimens of each test take years", "Write 4; a mean is known well with 30."
        )
    if "seeds" not in top:
        seeds = DEFAULT_SEEDS
        findings.default("seeds", str(seeds))
    specimen = read_specimen(top, ACROSS)
    material, file, calibrated = _material(top, folder)
    tests = _tests(top, calibrated)
    if specimen is not None and material is not None:
        seeds = _seeds_of_lattice(findings, specimen, material, seeds)
        if calibrated is not None:
            _compare(findings, specimen, calibrated)
    common = head.close()
    # every None below has been reported
    assert seeds is not None
    assert specimen is not None
    assert material is not None
    return LaboratoryCase(
        **common,
        seed=seed,
        seeds=seeds,
        specimen=specimen,
        material=material,
        tests=tests,
        material_file=file,
    )


def parse_calibration(text: str, folder: Path) -> CalibrationCase:
    """Read a case of a calibration from its text; parameters and errors as of `parse_laboratory`."""
    head = read_head(text, folder, "calibration", CALIBRATION_KEYS, example="Granite")
    seed = head.seed(DEFAULT_SEED)
    specimen = read_specimen(head.top, ACROSS_CALIBRATION, SPECIMEN_OF_CALIBRATION)
    targets = _targets(head.top)
    common = head.close()
    assert specimen is not None
    return CalibrationCase(**common, seed=seed, specimen=specimen, targets=targets)


def _material(top: Table, folder: Path) -> tuple[BondedMaterial | None, Path | None, Calibrated | None]:
    """The material of a laboratory case: from a file, or from the case itself."""
    findings = top.findings
    content = top.content.get("material")
    example = '[material] with file = "material.toml", or with law = "rock" and its parameters'
    if "material" not in top:
        top.missing("material", f"Write {example}.")
        return None, None, None
    inside = isinstance(content, dict) and "file" not in content
    keys = material_keys(content) if inside and isinstance(content, dict) else ()
    table = top.sub("material", ("file", *keys), example=example)
    if table is None:
        return None, None, None
    if inside:
        return read_material(table, name=str(top.content.get("title") or "rock")), None, None
    name = table.text("file", remedy='Write file = "material.toml".')
    if name is None:
        return None, None, None
    path = Path(name)
    path = path if path.is_absolute() else folder / path
    try:
        material, calibrated = load_material(path)
    except InputErrors as errors:
        for error in errors.errors:
            findings.errors.append(
                InputError(f"{name}, {error.place}", error.problem, error.remedy, value=error.value)
            )
        return None, path, None
    except InputError as error:
        findings.error("material.file", error.problem, error.remedy, value=name)
        return None, path, None
    return material, path, calibrated


def _tests(top: Table, calibrated: Calibrated | None) -> tuple[TestOptions, ...]:
    findings = top.findings
    example = 'a table for each test: [[test]] with kind = "uniaxial-compression"'
    if "test" not in top:
        top.missing("test", f"Write {example}. Known: {listed(KINDS)}.")
        return ()
    rows = top.rows("test", TEST_KEYS, example='{kind = "uniaxial-compression"}')
    if not rows and top.content["test"] == []:
        top.error("test", "there are no tests", f"Write {example}.")
    found: list[TestOptions] = []
    seen: set[tuple[str, float]] = set()
    for row in rows:
        kind = row.choice("kind", tuple(KINDS))
        if "kind" not in row:
            row.missing("kind", f'Write kind = "uniaxial-compression". Known: {listed(KINDS)}.')
        if kind is None:
            continue
        stresses = _stresses(row, kind)
        if stresses is None:
            continue
        for stress in stresses or (0.0,):
            if (kind, stress) in seen:
                shown = f" at {units.show(stress, 'stress')}" if KINDS[kind] else ""
                findings.error(row.place, f"{kind}{shown} is asked for twice", "Take one of the two out.")
            seen.add((kind, stress))
        if calibrated is not None:
            _doubt_confinement(row, kind, stresses, calibrated)
        found.append(TestOptions(kind, stresses))
    return tuple(found)


def _stresses(row: Table, kind: str) -> tuple[float, ...] | None:
    """Confinements or normal stresses of a test, one text or a list of them; None where wrong."""
    wanted = KINDS[kind]
    before = len(row.findings.errors)
    for key in ("confinement", "normal_stress"):
        if key in row and key != wanted:
            remedy = (
                f"Write it with kind = {listed(name for name, stress in KINDS.items() if stress == key)}."
            )
            row.error(key, f"a test of {kind} has none", f"Take it out. {remedy}")
    if not wanted:
        return () if len(row.findings.errors) == before else None
    if wanted not in row:
        row.missing(wanted, f'Write {wanted} = ["5 MPa", "10 MPa"].')
        return None
    content = row.content[wanted]
    values = content if isinstance(content, list) else [content]
    if not values:
        row.error(wanted, "the list is empty", f'Write {wanted} = ["5 MPa", "10 MPa"].')
    found = []
    for index, value in enumerate(values):
        place = f"{row.at(wanted)}[{index}]" if isinstance(content, list) else row.at(wanted)
        stress = _stress(row.findings, place, value)
        if stress is not None:
            found.append(stress)
    return tuple(found) if len(row.findings.errors) == before else None


def _stress(findings: Findings, place: str, value: object) -> float | None:
    try:
        stress = units.parse(value, "stress", place=place)
    except InputError as error:
        findings.errors.append(error)
        return None
    if stress < 0.0:
        findings.error(place, "pressure is positive in compression", "Give it without the sign.", value=value)
        return None
    if stress > _LARGEST_STRESS:
        remedy = f'Did you mean "{units.show(stress / 1e3, "stress")}"?'
        findings.implausible(place, "more pressure than rock bears", remedy, value=value)
    return stress


def _doubt_confinement(row: Table, kind: str, stresses: tuple[float, ...], calibrated: Calibrated) -> None:
    known = calibrated.achieved.get("uniaxial_compressive_strength")
    if kind != "triaxial-compression" or known is None:
        return
    for stress in stresses:
        if stress > known.value:
            problem = (
                f"{units.show(stress, 'stress')} is more than the material's compressive strength, "
                f"{units.show(float(f'{known.value:.3g}'), 'stress')}: bonds may break before it is loaded"
            )
            half = units.show(float(f"{0.5 * known.value:.2g}"), "stress")
            remedy = f"Envelopes are measured up to half of the strength, here {half}."
            row.findings.implausible(row.at("confinement"), problem, remedy, value=row.content["confinement"])
            return


def _seeds_of_lattice(
    findings: Findings, specimen: SpecimenOptions, material: BondedMaterial, seeds: int | None
) -> int | None:
    if specimen.packing != "random" and material.variation == 0.0 and seeds is not None and seeds > 1:
        findings.notices.append(
            f"seeds = {seeds}: a {specimen.packing} packing with bonds all alike is the same for every seed, so one "
            "specimen is tested."
        )
        return 1
    return seeds


def _compare(findings: Findings, specimen: SpecimenOptions, calibrated: Calibrated) -> None:
    """A material holds for the specimens that it was calibrated on."""
    if specimen.dimension != calibrated.dimension:
        findings.questions.append(
            f"specimen.dimension = {specimen.dimension}: the material was calibrated in {calibrated.dimension}D and "
            "has other properties here."
        )
    elif specimen.packing != calibrated.packing:
        findings.questions.append(
            f'specimen.packing = "{specimen.packing}": the material was calibrated on a {calibrated.packing} packing '
            "and has other properties here."
        )
    elif specimen.across < 0.75 * calibrated.across:
        findings.questions.append(
            f"specimen.across = {specimen.across:g}: the material was calibrated with {calibrated.across:g} particles "
            "across."
        )


def _targets(top: Table) -> RockTargets:
    findings = top.findings
    example = "[rock] with density, young_modulus, poisson_ratio, ... each with its unit"
    if "rock" not in top:
        top.missing("rock", f"Write {example}.")
        return RockTargets()
    table = top.sub("rock", tuple(ROCK_DIMENSIONS), example=example)
    if table is None:
        return RockTargets()
    before = len(findings.errors)
    values = {key: table.quantity(key, dimension) for key, dimension in ROCK_DIMENSIONS.items()}
    unread = {error.place for error in findings.errors[before:]}
    targets = RockTargets(**{key: value for key, value in values.items() if value is not None})
    findings.errors += [error for error in contradictions(targets, place="rock") if error.place not in unread]
    for error in doubts(targets, place="rock"):
        key = error.place.rpartition(".")[2]
        findings.implausible(
            error.place, error.problem, _sentence(error.remedy), value=table.content.get(key)
        )
    return targets


def _sentence(text: str) -> str:
    return text if text.endswith((".", "?")) else f"{text}."
