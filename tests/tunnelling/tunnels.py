"""Small tunnels that several tests share; the closed forms are those of reference/problems/tunnels_deep.py."""

from __future__ import annotations

from geodem.builders.ground import GroundProperties
from geodem.builders.section import Section
from geodem.tunnelling.ground import make_tunnel_ground
from geodem.tunnelling.plan import DepthStress, Opening, Plan, Stage
from reference.problems.tunnels_deep import circle

CLAY = {
    "young_modulus": 50e6, "poisson_ratio": 0.3, "cohesion": 60e3, "friction_angle": 0.35, "dilation_angle": 0.35,
    "tensile_strength": float("inf"),
}  # fmt: skip


def level_ground(particles=600, k0=0.7, cohesion=60e3, **options):
    """A full tunnel of 4 m, 10 m below level ground, and its plan; unit weight 20 kN/m3."""
    section = Section.from_polygons([("clay", [[-15, -10], [15, -10], [15, 12], [-15, 12]])])
    opening = Opening("tunnel", circle(2.0), (0.0, 0.0))
    material = GroundProperties.of(20e3 / 9.81, **{**CLAY, "cohesion": cohesion})
    ground = make_tunnel_ground(
        section, [opening], {"clay": material}, boundary={"left": "roller", "right": "roller", "bottom": "fixed"},
        particles=particles, wall_spacing=0.5, grading=0.25, **options,
    )  # fmt: skip
    plan = Plan((opening,), DepthStress(k0), (Stage("dig", excavate=("tunnel",), relax=0.5),))
    return ground, plan
