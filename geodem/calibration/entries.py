"""What result.json tells of a calibration: plain data, SI."""

from __future__ import annotations

from typing import Any

from .fit import GOOD, OF_TARGETS, Calibration

UNITS = {"poisson_ratio": "-", "friction_angle": "rad"}
"""Of the properties; the others are stresses [Pa]."""


_EDGES = {
    "stiffness_ratio": "kn/ks",
    "shear_over_tension": "C/Tb",
    "bond_friction": "tan(phi_b)",
}
"""Micro-parameters whose ends are told; that bonds without friction end the map is no news."""


def calibration_entries(found: Calibration) -> dict[str, Any]:
    """Targets against what was come to, what cannot be had, and every round with its specimens."""
    return {
        "particles": int(found.rounds[0].outcomes[0]["particles"]),
        "reached": not found.missed,
        "narrow": found.good,
        "properties": {name: _property(found, name) for name in OF_TARGETS},
        "missed": [str(miss) for miss in found.missed],
        "texture": found.texture,
        "rounds": [
            {
                "micro": dict(each.fit.micro),
                "effective_modulus_Pa": each.fit.effective_modulus,
                "tensile_strength_Pa": each.fit.tensile_strength,
                "specimens": list(each.outcomes),
            }
            for each in found.rounds
        ],
        "specimens_tested": found.tests,
    }


def statements(found: Calibration) -> list[str]:
    """What cannot be had, and which interval is not as narrow as it should be."""
    said = [str(miss) for miss in found.missed]
    for name, value in found.edges.items():
        if name in _EDGES and value > 0.0:
            said.append(
                f"{_EDGES[name]} = {value:.3g} stands at an end of the map: what was achieved is what was measured "
                "there, and bonds beyond it were not tried"
            )
    if not found.good:
        said.append(
            f"after {found.tests} specimens the intervals are not all as narrow as is wanted; more specimens or "
            "particles across would narrow them"
        )
    return said


def _property(found: Calibration, name: str) -> dict[str, Any]:
    """A target, what was come to, and the interval."""
    wanted, got = getattr(found.targets, name), found.achieved[name]
    share = got.value / wanted - 1.0
    return {
        "unit": UNITS.get(name, "Pa"),
        "target": wanted,
        "achieved": got.value,
        "low": got.low,
        "high": got.high,
        "difference": got.value - wanted,
        "difference_percent": 100.0 * share,
        "reached": bool(abs(share if name not in UNITS else got.value - wanted) <= GOOD[name]),
    }
