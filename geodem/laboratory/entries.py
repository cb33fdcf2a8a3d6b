"""What result.json tells of tests: plain data, SI, the unit at the end of a name."""

from __future__ import annotations

from typing import Any

from .material import BondedMaterial
from .orders import KINDS
from .summary import EnvelopeSummary, Property, Spread, TestGroup

NUMBERS = {
    "young_modulus": "young_modulus_Pa",
    "poisson_ratio": "poisson_ratio",
    "peak_strain": "peak_strain",
    "residual_stress": "residual_stress_Pa",
    "crack_initiation_stress": "crack_initiation_stress_Pa",
    "crack_damage_stress": "crack_damage_stress_Pa",
    "failure_angle": "failure_angle_rad",
    "localisation": "localisation",
    "shear_stiffness": "shear_stiffness_Pa_per_m",
    "dilation_angle": "dilation_angle_rad",
    "crushing": "crushing",
}
"""Numbers of the records that result.json tells, and their names in it."""


def spread_entry(spread: Spread) -> dict[str, Any]:
    """A mean with its scatter."""
    return {"mean": spread.mean, "standard_deviation": spread.deviation, "specimens": spread.specimens}


def property_entry(found: Property) -> dict[str, Any]:
    """A property in words and numbers."""
    return {"name": found.name, **spread_entry(found.spread), "from": found.source}


def group_entry(group: TestGroup) -> dict[str, Any]:
    """The same test on several specimens."""
    records = [test.record for test in group.tests]
    kind = KINDS[group.kind]
    entry: dict[str, Any] = {"kind": group.kind}
    if kind.stress:
        entry[f"{kind.stress.replace(' ', '_')}_Pa"] = group.stress
    entry |= {
        "seeds": [test.order.seed for test in group.tests],
        "strength_Pa": spread_entry(group.strength) | {"values": [record.strength for record in records]},
        "failed": [record.failed for record in records],
        "ended": [record.reason for record in records],
        "cracks": {
            mode: Spread.of(float(getattr(record.cracks, mode)) for record in records).mean
            for mode in ("tension", "shear")
        },
        "steps": sum(record.steps for record in records),
        "seconds": round(sum(test.seconds for test in group.tests), 3),
    }
    for name, key in NUMBERS.items():
        spread = group.number(name)
        if spread.specimens:
            entry[key] = spread_entry(spread)
    return entry


def envelope_entry(envelope: EnvelopeSummary) -> dict[str, Any]:
    """The envelope through all strengths, and how those of single specimens scatter."""
    whole = envelope.whole
    return {
        "confinement_Pa": envelope.confinement,
        "strength_Pa": envelope.strength,
        "friction_angle_rad": whole.friction_angle,
        "cohesion_Pa": whole.cohesion,
        "intercept_Pa": whole.intercept,
        "misfit": whole.misfit,
        "m_i": whole.m_i,
        "over_specimens": {
            "friction_angle_rad": spread_entry(envelope.friction_angle),
            "cohesion_Pa": spread_entry(envelope.cohesion),
            "m_i": spread_entry(envelope.m_i),
        },
    }


def material_entry(material: BondedMaterial) -> dict[str, Any]:
    """Laws and parameters, SI."""
    names = ("bond_law", "contact_law", "density", "bonding_range", "variation", "distribution")
    own = {name: getattr(material, name) for name in names}
    return own | {"bond": dict(material.bond), "contact": dict(material.contact)}
