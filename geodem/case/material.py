"""The materials of a case: macroscopic properties, each held against what ground can be."""

from __future__ import annotations

import math

from geodem import units
from geodem.case.data import LAWS, GroundMaterial
from geodem.case.section import positive
from geodem.case.table import Findings, Table, listed, nearest

KEYS = (
    "law",
    "unit_weight",
    "density",
    "cohesion",
    "friction_angle",
    "dilation_angle",
    "young_modulus",
    "poisson_ratio",
    "tensile_strength",
)

# What ground can be, from peat to massive ore and from soft clay to intact rock, with a margin. Outside, the
# unit is more often wrong than the ground is strange.
_UNIT_WEIGHT = (5e3, 50e3)  # [N/m3]
_DENSITY = (
    500.0,
    5100.0,
)  # [kg/m3]; holds the range of unit weights, so that a case may be written either way
_YOUNG_MODULUS = (1e5, 3e11)  # [Pa]
_LARGEST_COHESION = 1e8  # [Pa]
_LARGEST_POISSON_RATIO = 0.499  # beyond, trials are undecided when their steps run out
_COHESION_PER_MODULUS = 0.05  # soils and rocks lie between 1/2000 and 1/50
_ANGLE_LIKE_RADIANS = math.radians(1.6)  # pi/2 typed as degrees is 1.57
_STEEP_FRICTION = math.radians(60.0)
_FLOW_GAP = math.radians(15.0)  # phi - psi beyond which the answer depends on the mesh


def read_materials(top: Table) -> dict[str, GroundMaterial]:
    """Every material that could be read, in the order of the file."""
    findings = top.findings
    names = tuple(top.content["material"]) if isinstance(top.content.get("material"), dict) else ()
    table = top.sub("material", names, example='[material.soil] with law = "mohr_coulomb"')
    if not names:
        if table is not None or "material" not in top:
            top.missing(
                "material", 'Add a table for each material: [material.soil] with law = "mohr_coulomb".'
            )
        return {}
    assert table is not None  # it has names
    materials = {}
    for name in names:
        if not name.strip():
            findings.error(table.at(name), "a material needs a name", "Write [material.soil].")
            continue
        inner = table.sub(
            name, KEYS, example=f'[{table.at(name)}] with law = "mohr_coulomb" and its properties'
        )
        material = _read_material(name, inner) if inner is not None else None
        if material is not None:
            materials[name] = material
    return materials


def check_names(
    findings: Findings,
    used: list[tuple[str, str]],
    defined: tuple[str, ...],
    complete: dict[str, GroundMaterial],
) -> None:
    """Every (place, material) that is used is defined; what is defined and not used is noted."""
    for place, name in used:
        if name not in defined:
            remedy = f"{nearest(name, defined)}Add [material.{name}], or use one of {listed(defined)}."
            findings.error(place, "no material has this name", remedy, value=name)
    for name in complete:
        if name not in {u for _, u in used}:
            findings.notices.append(f"material {name!r} is not used by the section.")


def _read_material(name: str, table: Table) -> GroundMaterial | None:
    before = len(table.findings.errors)
    law = table.choice("law", LAWS)
    if "law" not in table:
        table.missing("law", 'Write law = "mohr_coulomb".')
    density = _density(table)
    cohesion = table.quantity("cohesion", "stress", check=_not_negative)
    friction = table.quantity("friction_angle", "angle", check=_friction)
    modulus = table.quantity("young_modulus", "stress", check=positive)
    ratio = table.quantity("poisson_ratio", "dimensionless", check=_poisson)
    for key, remedy in (
        ("cohesion", 'Write cohesion = "25 kPa" ("0 kPa" for sand).'),
        ("friction_angle", 'Write friction_angle = "30 deg" ("0 deg" for undrained clay).'),
        ("young_modulus", f'{_ANY_VALUE} Soils have 10 to 100 MPa: young_modulus = "50 MPa".'),
        ("poisson_ratio", f"{_ANY_VALUE} Most ground has 0.2 to 0.4: poisson_ratio = 0.3."),
    ):
        if key not in table:
            table.missing(key, remedy)
    dilation = table.quantity("dilation_angle", "angle", check=_dilation)
    tension = _tensile_strength(table)
    # what can be judged by itself is, so that one pass shows all; the pairs need both of them
    if friction is not None:
        _doubt_friction(table, friction)
    if modulus is not None:
        _doubt_modulus(table, modulus)
    if cohesion is not None:
        _doubt_cohesion(table, cohesion, friction, modulus)
    if friction is not None and dilation is not None:
        _doubt_dilation(table, friction, dilation)
    if len(table.findings.errors) > before:
        return None
    assert law is not None
    assert density is not None
    assert cohesion is not None
    assert friction is not None
    assert modulus is not None
    assert ratio is not None
    assert tension is not None
    _note_tension(table, cohesion, friction, tension)
    given = "dilation_angle" in table
    if not given:
        shown = units.show(friction, "angle")
        table.findings.default(
            table.at("dilation_angle"), shown, why="equal to the friction angle: associated flow"
        )
    return GroundMaterial(
        name=name,
        law=law,
        density=density,
        cohesion=cohesion,
        friction_angle=friction,
        dilation_angle=dilation if dilation is not None else friction,
        young_modulus=modulus,
        poisson_ratio=ratio,
        tensile_strength=tension,
        dilation_given=given,
    )


_ANY_VALUE = "Any plausible value will do: the factor of safety does not depend on it."


def _not_negative(value: float) -> tuple[str, str] | None:
    return None if value >= 0.0 else ("this must not be negative", "Give zero or a positive value.")


def _friction(value: float) -> tuple[str, str] | None:
    if value >= math.pi / 2.0 - 1e-9:
        return (
            "a friction angle is below 90 deg",
            "Soils have 0 to 45 deg, rock joints and broken rock up to 60.",
        )
    return _not_negative(value)


def _dilation(value: float) -> tuple[str, str] | None:
    if value < 0.0:
        return (
            "ground that contracts under shear is not modelled",
            'Write "0 deg" for flow at constant volume.',
        )
    return _friction(value)


def _poisson(value: float) -> tuple[str, str] | None:
    if 0.0 <= value <= _LARGEST_POISSON_RATIO:
        return None
    if 0.0 <= value / 100.0 < 0.5 and value >= 1.0:
        return "Poisson's ratio lies between 0 and 0.5", f"Did you mean {value / 100.0:g}?"
    if _LARGEST_POISSON_RATIO < value <= 0.5:
        problem = "so near 0.5 the ground hardly changes its volume, and relaxes ever more slowly"
        return problem, "Write 0.49 for ground that keeps its volume."
    return "Poisson's ratio lies between 0 and 0.5 (0.5 itself excluded)", "Most ground has 0.2 to 0.4."


def _density(table: Table) -> float | None:
    if ("unit_weight" in table) == ("density" in table):
        both = "density" in table
        problem = (
            "unit_weight and density are both given" if both else "neither unit_weight nor density is given"
        )
        table.findings.error(
            table.place, problem, 'Give exactly one: unit_weight = "20 kN/m3" or density = "2000 kg/m3".'
        )
        return None
    if "density" in table:
        density = table.quantity("density", "density", check=positive)
        if density is not None and not _DENSITY[0] <= density <= _DENSITY[1]:
            _doubt(table, "density", "ground has 500 to 5100 kg/m3", _density_hint(density))
        return density
    weight = table.quantity("unit_weight", "unit_weight", check=positive)
    if weight is None:
        return None
    if not _UNIT_WEIGHT[0] <= weight <= _UNIT_WEIGHT[1]:
        _doubt(table, "unit_weight", "ground has 5 to 50 kN/m3", _weight_hint(weight))
    return weight / units.GRAVITY


def _density_hint(density: float) -> str:
    for factor in (1e3, 1e-3):
        if _DENSITY[0] <= density * factor <= _DENSITY[1]:
            meant = density * factor
            return f'Did you mean "{meant:g} kg/m3" ({meant / 1000.0:g} t/m3)?'
    return "Check the unit."


def _weight_hint(weight: float) -> str:
    if _DENSITY[0] <= weight / 1e3 <= _DENSITY[1]:
        return f'Did you mean density = "{weight / 1e3:g} kg/m3"?'
    if _DENSITY[0] <= weight <= _DENSITY[1]:
        return f'Did you mean density = "{weight / 1e3:g} t/m3", or "{weight / 100.0:g} kN/m3"?'
    for factor in (1e3, 1e-3, 0.1):
        if _UNIT_WEIGHT[0] <= weight * factor <= _UNIT_WEIGHT[1]:
            return f'Did you mean "{units.show(weight * factor, "unit_weight")}"?'
    return "Check the unit."


def _tensile_strength(table: Table) -> float | None:
    if "tensile_strength" not in table:
        why = "no tension cut-off: the full Mohr-Coulomb cone"
        table.findings.default(table.at("tensile_strength"), '"none"', why=why)
        return math.inf
    value = table.content["tensile_strength"]
    if isinstance(value, str) and value.strip().lower() == "none":
        return math.inf
    before = len(table.findings.errors)
    strength = table.quantity("tensile_strength", "stress", check=_not_negative)
    for error in table.findings.errors[before:]:
        error.remedy += ' "none" is the full Mohr-Coulomb cone.'
    return strength


def _doubt(table: Table, key: str, problem: str, remedy: str) -> None:
    table.findings.implausible(table.at(key), problem, remedy, value=table.content.get(key))


def _doubt_friction(table: Table, friction: float) -> None:
    if 0.0 < friction < _ANGLE_LIKE_RADIANS:
        degrees = math.degrees(friction)
        problem = "so small an angle looks like radians"
        _doubt(
            table,
            "friction_angle",
            problem,
            f'Did you mean "{degrees:.6g} rad" ({degrees * 180.0 / math.pi:.3g} deg)?',
        )
    elif friction >= _STEEP_FRICTION:
        _doubt(
            table,
            "friction_angle",
            "this is more than any ground has",
            "Soils have 0 to 45 deg, broken rock up to 60.",
        )


def _doubt_modulus(table: Table, modulus: float) -> None:
    smallest, largest = _YOUNG_MODULUS
    if smallest <= modulus <= largest:
        return
    hint = "Check the unit."
    for factor in (1e3, 1e6, 1e-3, 1e-6):
        # the unit mistaken most often is a step of a thousand; ground itself lies between 1 MPa and 100 GPa
        if 1e6 <= modulus * factor <= 1e11:
            hint = f'Did you mean "{units.show(modulus * factor, "stress")}"?'
            break
    _doubt(table, "young_modulus", "ground has 0.1 MPa (soft clay) to 300 GPa (hard rock)", hint)


def _doubt_cohesion(table: Table, cohesion: float, friction: float | None, modulus: float | None) -> None:
    if cohesion == 0.0 and friction == 0.0:
        _doubt(
            table,
            "cohesion",
            "cohesion and friction angle are both zero: a liquid",
            "Give the ground some strength.",
        )
    limit = min(_LARGEST_COHESION, _COHESION_PER_MODULUS * modulus if modulus else math.inf)
    if cohesion > limit:
        meant = units.show(cohesion / 1e3, "stress")
        against = f" for a Young's modulus of {units.show(modulus, 'stress')}" if modulus else ""
        _doubt(table, "cohesion", f"this is more than ground has{against}", f'Did you mean "{meant}"?')


def _doubt_dilation(table: Table, friction: float, dilation: float) -> None:
    shown = f"{units.show(dilation, 'angle')} of dilation with {units.show(friction, 'angle')} of friction"
    if dilation > friction * (1.0 + 1e-12):
        _doubt(
            table,
            "dilation_angle",
            f"{shown} would make energy from nothing",
            "Give at most the friction angle.",
        )
    elif friction - dilation > _FLOW_GAP:
        table.findings.questions.append(
            f"{table.at('dilation_angle')}: {shown}: so far from associated flow the factor "
            "of safety depends on the mesh."
        )


def _note_tension(table: Table, cohesion: float, friction: float, tension: float) -> None:
    if friction == 0.0 or math.isinf(tension):
        return
    apex = cohesion / math.tan(friction)
    if tension >= apex:
        table.findings.notices.append(
            f"{table.at('tensile_strength')} = {units.show(tension, 'stress')} has no effect: the "
            f"Mohr-Coulomb cone ends at c/tan(phi) = {units.show(apex, 'stress')}."
        )
