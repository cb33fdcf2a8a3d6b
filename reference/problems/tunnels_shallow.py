"""A round tunnel in uniform clay below a surcharge: collapse by the load, by strength reduction and by relaxation.

Half of the ground around a tunnel of diameter D = 1 m, its left side the line of symmetry. The answers are lower and
upper bounds by finite-element limit analysis of the same sections; they agree with S. Wilson, A. Abbo, S. Sloan & A.
Lyamin (2011), Undrained stability of a circular tunnel where the shear strength increases linearly with depth, Canadian
Geotechnical Journal 48:1328. Errors are against the middle of the two bounds.
"""

from __future__ import annotations

import math
import time

from geodem.builders.ground import STANDARD_GRAVITY, GroundProperties, Surcharge
from geodem.builders.section import Section
from geodem.tunnelling.collapse import make_search
from geodem.tunnelling.digging import Digging
from geodem.tunnelling.ground import make_tunnel_ground
from geodem.tunnelling.plan import DepthStress, Opening, Plan, Stage

from .rows import Row, relative
from .tunnels_deep import circle

COLLAPSE = {
    (1.0, 0.0): (2.427, 2.444),
    (2.0, 0.0): (3.436, 3.468),
    (3.0, 0.0): (4.100, 4.141),
    (1.0, 1.0): (1.244, 1.261),
    (2.0, 1.0): (1.163, 1.190),
}
"""Cover over diameter and gamma D / c_u: sigma_s / c_u at collapse, lower and upper bound."""
SOURCE = "finite-element limit analysis, middle of both bounds"
TOLERANCE = 0.004
FIRST_SURCHARGE = 1.0
BOUND = 0.015


def half(cover: float, weight: float, surcharge: float, particles: int, strength: float = 1.0) -> Digging:
    """The ground before it is dug; c_u = `strength`, gamma D = `weight`."""
    clay = GroundProperties.of(
        weight / STANDARD_GRAVITY, young_modulus=500.0, poisson_ratio=0.3, cohesion=strength, friction_angle=0.0,
        dilation_angle=0.0, tensile_strength=math.inf,
    )  # fmt: skip
    wide, top = cover + 3.0, cover + 0.5
    section = Section.from_polygons([("clay", [[0.0, -2.0], [wide, -2.0], [wide, top], [0.0, top]])])
    opening = Opening("tunnel", circle(0.5), (0.0, 0.0))
    ground = make_tunnel_ground(
        section, [opening], {"clay": clay}, boundary={"left": "roller", "right": "roller", "bottom": "fixed"},
        particles=particles, surcharges=[Surcharge((0.0, top), (wide, top), surcharge)],
    )  # fmt: skip
    plan = Plan((opening,), DepthStress(1.0), (Stage("dig", excavate=("tunnel",), relax=1.0),))
    return Digging(ground, plan)


def middle(cover: float, weight: float) -> float:
    """Middle of the bounds."""
    return 0.5 * sum(COLLAPSE[cover, weight])


def shallow_surcharge(cover: float, weight: float, particles: int) -> Row:
    """The surcharge at collapse: a given one times its load factor, sought from far below."""
    begun = time.perf_counter()
    digging = half(cover, weight, FIRST_SURCHARGE, particles)
    digging.run()
    found = make_search(digging, "load-increase", tolerance=TOLERANCE).run().value or math.nan
    return relative(
        _name(cover, weight), "sigma_s/c_u at collapse, by the load", found * FIRST_SURCHARGE, middle(cover, weight),
        BOUND, time.perf_counter() - begun, SOURCE,
    )  # fmt: skip


def shallow_strength(cover: float, weight: float, particles: int, strength: float = 1.3) -> Row:
    """The same collapse from above: clay 1.3 times as strong as it needs to be has that factor of safety."""
    begun = time.perf_counter()
    digging = half(cover, weight, middle(cover, weight), particles, strength)
    digging.run()
    found = make_search(digging, "strength-reduction", tolerance=TOLERANCE).run().value or math.nan
    return relative(
        _name(cover, weight), "factor by strength reduction, c_u 1.3 times that at collapse", found, strength, BOUND,
        time.perf_counter() - begun, SOURCE,
    )  # fmt: skip


def collapse_pressure(cover: float, weight: float, particles: int) -> list[Row]:
    """A surcharge above that of collapse: (sigma_s - pressure on the wall) / c_u where relaxation finds no rest.

    Undrained, without weight, only the difference of surcharge and pressure on the wall counts.
    """
    begun = time.perf_counter()
    surcharge = middle(cover, weight) + 1.0
    digging = half(cover, weight, surcharge, particles)
    collapse = digging.run().collapse
    pressure = math.nan
    if collapse is not None:
        pressure = 0.5 * (collapse.pressure_stable + collapse.pressure_failed)
    return [
        relative(
            _name(cover, weight), "(sigma_s - p)/c_u where the reaction curve ends", surcharge - pressure,
            middle(cover, weight), BOUND, time.perf_counter() - begun, SOURCE,
        )
    ]  # fmt: skip


def _name(cover: float, weight: float) -> str:
    return f"P17 tunnel, C/D {cover:g}, gamma D/c_u {weight:g}"
