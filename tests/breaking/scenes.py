"""Small bonded ground that several tests use; laws and features are shared, so that one kernel serves them."""

from __future__ import annotations

from typing import Any

from geodem.breaking.scene import BondedScene, build_scene
from geodem.builders.body_filling import BodyFilling
from geodem.builders.fill_body import fill_body
from geodem.builders.section_body import BoxBody, box_body
from geodem.laboratory.material import BondedMaterial

ROCK = BondedMaterial.rock(
    density=2600.0, effective_modulus=1e9, stiffness_ratio=2.0, tensile_strength=2e7, shear_strength=2e7,
    friction_angle=0.5, bonding_range=1.08,
)  # fmt: skip


def lattice(
    across: int = 8, up: int = 6, layers: list[tuple[str, float]] | None = None
) -> tuple[BoxBody, BodyFilling]:
    """A square lattice of discs of 1 m, across by up."""
    body = box_body((float(across), float(up)), layers or [("rock", 1.0)])
    return body, fill_body(body, arrangement="square", radius=0.5)


def random_ground(particles: int = 400, **options: Any) -> BondedScene:
    """A block of 10 m by 8 m of bonded discs at random."""
    body = box_body((10.0, 8.0), [("rock", 1.0)])
    sides = {"left": "roller", "right": "roller", "bottom": "fixed", "top": "roller"}
    given: dict[str, Any] = {"supports": sides} | options
    return build_scene(body, fill_body(body, particles=particles), {"rock": ROCK}, **given)
