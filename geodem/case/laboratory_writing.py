"""Cases of the laboratory and of a calibration, back to TOML."""

from __future__ import annotations

import math

from geodem.calibration.targets import OPTIONAL, RockTargets
from geodem.case.bonded import exact, material_lines, number
from geodem.case.laboratory import CalibrationCase, LaboratoryCase, SpecimenOptions
from geodem.case.laboratory_reading import KINDS, ROCK_DIMENSIONS
from geodem.case.specimen import CALIBRATION_KEYS, SPECIMEN_KEYS
from geodem.case.table import quoted


def laboratory_text(case: LaboratoryCase) -> str:
    """TOML with every default and the material written out; reading it gives the same numbers to the last bit."""
    lines = [
        *_head(case.workflow, case.title, case.seed, case.allow_implausible),
        f"seeds = {case.seeds}",
        "",
        *_specimen(case.specimen, SPECIMEN_KEYS),
        "",
        "[material]",
        *material_lines(case.material, place="material"),
    ]
    for test in case.tests:
        lines += ["", "[[test]]", f"kind = {quoted(test.kind)}"]
        if KINDS[test.kind]:
            stresses = ", ".join(exact(stress, "stress") for stress in test.stresses)
            lines.append(f"{KINDS[test.kind]} = [{stresses}]")
    return "\n".join(lines) + "\n"


def calibration_text(case: CalibrationCase) -> str:
    """TOML with every default written out; reading it gives the same numbers to the last bit."""
    lines = [
        *_head(case.workflow, case.title, case.seed, case.allow_implausible),
        "",
        *_specimen(case.specimen, CALIBRATION_KEYS),
        "",
        *rock_lines(case.targets),
    ]
    return "\n".join(lines) + "\n"


def rock_lines(targets: RockTargets) -> list[str]:
    """The table [rock]."""
    return [
        "[rock]",
        *(
            f"{key} = {number(getattr(targets, key), kind)}"
            for key, kind in ROCK_DIMENSIONS.items()
            if not (key in OPTIONAL and math.isnan(getattr(targets, key)))
        ),
    ]


def _head(workflow: str, title: str, seed: int, allowed: tuple[str, ...]) -> list[str]:
    lines = [f"workflow = {quoted(workflow)}", f"title = {quoted(title)}", f"seed = {seed}"]
    if allowed:
        lines.append(f"allow_implausible = [{', '.join(map(quoted, allowed))}]")
    return lines


def _specimen(options: SpecimenOptions, keys: tuple[str, ...]) -> list[str]:
    height = 2.0 * options.width if options.height is None else options.height
    written = {
        "dimension": str(options.dimension),
        "packing": quoted(options.packing),
        "shape": quoted(options.shape),
        "width": exact(options.width, "length"),
        "height": exact(height, "length"),
        "across": repr(options.across),
        "size_ratio": repr(options.size_ratio),
    }
    return ["[specimen]", *(f"{key} = {written[key]}" for key in keys)]
