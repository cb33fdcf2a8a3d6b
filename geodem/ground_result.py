"""What result.json says of a body and its particles."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .builders.body_filling import BodyFilling
from .builders.packings import volumes
from .case.ground import GroundCase
from .ground_building import GroundBody
from .ground_cost import Cost
from .io.checkpoint import checksum
from .provenance import versions

NEIGHBOURS = 1.05
"""Particles up to this many times the sum of their radii apart are told as neighbours."""
COST_STEPS = 1000


def assemble(case: GroundCase, made: GroundBody, filling: BodyFilling, price: Cost) -> dict[str, Any]:
    """The content of result.json, but for what the run itself knows."""
    body = made.body
    touching = filling.contacts(NEIGHBOURS)
    return {
        "workflow": case.workflow,
        "title": case.title,
        "status": "done",
        "kind_of_result": "ground: particles of a body, before anything is run",
        "particles": filling.particles,
        "dimension": filling.dimension,
        "source": {"kind": case.source.kind, "files": [path.name for path in case.source.files.values()]},
        "bounds_m": np.asarray(body.bounds).tolist(),
        "materials": _materials(case, filling),
        "contacts": {
            "reach": NEIGHBOURS,
            "pairs": touching.pairs,
            "coordination": touching.coordination,
            "largest_overlap": touching.largest_overlap,
            "loose": touching.loose,
        },
        "arrangement": filling.arrangement,
        "solid_fraction": filling.solid_fraction,
        "smallest_radius_m": float(filling.radii.min()),
        "largest_radius_m": float(filling.radii.max()),
        "grains": len(np.unique(filling.group[filling.group >= 0])),
        "surfaces": [
            {"name": s.name, "facets": len(s.corners), "size": float(_sizes(s.corners).sum())}
            for s in body.surfaces
        ],
        "cost": {
            "memory_bytes": price.memory_bytes,
            "bonds": price.bonds,
            "critical_time_step_s": price.critical_time_step,
            "seconds_per_1000_steps": COST_STEPS * price.step_seconds,
            "why": price.why,
        },
        "steps": 0,
        "compile_time_s": round(price.compile_seconds, 3),
        "seed": case.particles.seed,
        "versions": versions(),
        "notices": [*case.notices, *_thresholds(made)],
        "warnings": [*case.questions, *filling.remarks],
        "digest": checksum(
            {"positions": filling.positions, "radii": filling.radii, "material": filling.material}
        ),
    }


def _materials(case: GroundCase, filling: BodyFilling) -> list[dict[str, Any]]:
    densities = {name: material.density for name, material in case.materials.items()}
    volume = volumes(filling.radii, filling.dimension)
    mass = np.bincount(
        filling.material, volume * filling.density(densities), minlength=len(filling.materials)
    )
    return [
        {
            "name": share.name,
            "particles": share.particles,
            "source_size": share.source,
            "represented_size": share.represented,
            "difference_percent": 100.0 * share.difference,
            "density_kg_m3": densities[share.name],
            "mass": float(mass[k]),
            "mass_difference_percent": 100.0
            * (float(mass[k]) / (share.source * densities[share.name]) - 1.0),
        }
        for k, share in enumerate(filling.shares)
    ]


def _sizes(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Length or area (f,) of facets (f, d, d)."""
    if corners.shape[1] == 2:
        return np.asarray(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(0.5 * np.linalg.norm(normal, axis=1))


def _thresholds(made: GroundBody) -> list[str]:
    if made.segmentation is None:
        return []
    cut = made.segmentation
    return [
        f"source: cut at the brightness {', '.join(f'{value:.3f}' for value in cut.thresholds)} (0 black, 1 white); "
        f"{100.0 * cut.separability:.0f} % of its variance lies between the classes."
    ]
