"""What result.json says of a scene: bonds, sides, joints, bolts, linings, initial stress."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..preparation.initial_stress import WantedStress
from .scene import BondedScene


def scene_facts(scene: BondedScene) -> dict[str, Any]:
    """Numbers with units in their names; lists in the order of the case."""
    a = scene.assembly
    length = "m" if scene.dimension == 2 else "m2"
    return {
        "bond_law": a.bond_law,
        "contact_law": a.contact_law,
        "bonds": [
            {"between": list(pair), "bonds": found.bonds, "touching": found.contacts}
            for pair, found in scene.bonds.items()
        ],
        "bonds_in_all": len(a.bonds),
        "without_bond": len(scene.loose),
        "supports": [
            {"side": side, "support": kind, "held": len(scene.held.get(side, ()))}
            for side, kind in scene.supports.items()
        ],
        "gravity_m_s2": a.gravity.tolist(),
        "joints": [
            {
                "name": name, "joints": facts.joints, f"size_{length}": facts.size, "pairs": facts.pairs,
                "bonded": facts.bonded,
            }
            for name, facts in scene.structures.joints.items()
        ],
        "bolts": [
            {
                "name": name, "length_m": float(bolt.along[-1]), "pieces": len(bolt.pieces),
                "grouted_to": len(np.unique(bolt.grouted[:, 1])), "plate": len(bolt.plate) > 0,
            }
            for name, bolt in scene.structures.bolts.items()
        ],
        "linings": [
            {
                "name": name, "particles": len(ids), "thickness_m": 2.0 * float(a.radii[ids[0]]),
                "length_m": _length(a.positions[ids]),
            }
            for name, ids in scene.structures.linings.items()
        ],
        "initial_stress": None if scene.initial_stress is None else _stress(scene.initial_stress, scene),
    }  # fmt: skip


def _length(points: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _stress(wanted: WantedStress, scene: BondedScene) -> dict[str, Any]:
    """Pressures at the top and the bottom of the ground, positive."""
    low, high = float(scene.box[0, -1]), float(scene.box[1, -1])
    return {
        "top_m": high,
        "pressure_at_top_Pa": (-wanted.at(high)).tolist(),
        "bottom_m": low,
        "pressure_at_bottom_Pa": (-wanted.at(low)).tolist(),
    }
