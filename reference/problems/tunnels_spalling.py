"""A tunnel in hard rock under anisotropic stress: Kirsch's stresses before it breaks, then where and when it spalls.

Bonded discs of the law `rock`; the far field is brought about, a circle is excavated and its face relaxed in stages.
The outline moves as that of an infinite plate would (Kirsch 1898; Muskhelishvili 1953, section 56a), so that the plate
is infinite in effect. Then the far field grows, all components alike, and bonds break. The strength of the rock is
measured: uniaxial compression of a specimen with the same bonds and grains.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from geodem.breaking.removal import Removal, remove_particles
from geodem.breaking.scene import build_scene, start
from geodem.breaking.shapes import inside_circle
from geodem.builders.fill_body import fill_body
from geodem.builders.section_body import box_body
from geodem.laboratory.axial import compress
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.specimen import make_specimen
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import displace, find_equilibrium
from geodem.preparation.initial_stress import far_field, link_forces

from .rows import Row, relative

Floats = NDArray[np.float64]

RADIUS = 1.0
"""Of the tunnel [m]."""
HALF = 4.0
"""Half the side of the ground, over the radius."""
FIELD = (10e6, 5e6)
"""Pressure along x and along y [Pa] at load 1."""
RINGS = ((1.0, 1.2), (1.15, 1.35), (1.35, 1.65), (1.8, 2.2), (2.8, 3.2))
"""Over the radius, from where to where; the first one is at the wall."""
RAYS = 360
"""Cuts from the middle outwards on which stress is measured."""
GROWTH = 0.03
"""Of the load from one step to the next."""
SEEDS = (1, 2, 3, 4)
"""Of arrangements whose stresses are averaged; the first one is loaded on until it breaks."""
SOME = 20
"""Cracks that are told the place of."""
ROCK = BondedMaterial.rock(
    density=2650.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=20e6, shear_strength=60e6,
    friction_angle=math.radians(30.0), bonding_range=1.2,
)  # fmt: skip


@dataclass(eq=False)
class Tunnel:
    """A run.

    Attributes
    ----------
    simulation : ParticleSimulation
    moduli : (float, float)
        E [Pa] and nu of the plate.
    cracks : list of (float, int)
        Load and number of all cracks.
    angles, distances : lists of float
        Of the first cracks, from the x axis [rad] and over the radius.
    """

    simulation: ParticleSimulation
    moduli: tuple[float, float]
    cracks: list[tuple[float, int]] = field(default_factory=list)
    angles: list[float] = field(default_factory=list)
    distances: list[float] = field(default_factory=list)


def plane_moduli(strain: Floats, stress: Floats) -> tuple[float, float]:
    """E [Pa] and nu of a plate from a state: E exx = sxx - nu syy, E eyy = syy - nu sxx."""
    matrix = np.array([[strain[0, 0], stress[1, 1]], [strain[1, 1], stress[0, 0]]])
    modulus, ratio = np.linalg.solve(matrix, np.array([stress[0, 0], stress[1, 1]]))
    return float(modulus), float(ratio)


def kirsch_motion(places: Floats, pressure: tuple[float, float], moduli: tuple[float, float]) -> Floats:
    """What a hole of `RADIUS` adds to displacements (n, 2) [m] of an infinite plate under pressures along x and y."""
    shear = moduli[0] / (2.0 * (1.0 + moduli[1]))
    kappa = (3.0 - moduli[1]) / (1.0 + moduli[1])
    mean, half = -0.5 * (pressure[0] + pressure[1]), -0.5 * (pressure[0] - pressure[1])
    r, angle = np.hypot(*places.T), np.arctan2(places[:, 1], places[:, 0])
    near, nearer = RADIUS**2 / r, RADIUS**4 / r**3
    out = (mean * near + half * ((kappa + 1.0) * near - nearer) * np.cos(2.0 * angle)) / (2.0 * shear)
    turn = -half * ((kappa - 1.0) * near + nearer) * np.sin(2.0 * angle) / (2.0 * shear)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([out * cos - turn * sin, out * sin + turn * cos], axis=1)


def kirsch_hoop(places: Floats, pressure: tuple[float, float]) -> Floats:
    """Hoop stress (n,) [Pa], pressure positive (Kirsch 1898)."""
    r, angle = np.hypot(*places.T) / RADIUS, np.arctan2(places[:, 1], places[:, 0])
    mean, half = 0.5 * (pressure[0] + pressure[1]), 0.5 * (pressure[0] - pressure[1])
    return np.asarray(mean * (1.0 + r**-2) - half * (1.0 + 3.0 * r**-4) * np.cos(2.0 * angle))


def thrust_stress(s: ParticleSimulation, low: float, high: float) -> Floats:
    """Mean hoop stress (RAYS,) [Pa] between two radii on rays around the tunnel, pressure positive.

    It is the force that contacts carry across a ray, over its length: what a cut bears, whatever the particles are.
    """
    pairs = s.contacts().pairs
    _, _, forces = link_forces(s)
    first, second = s.positions[pairs[:, 0]], s.positions[pairs[:, 1]]
    found = np.empty(RAYS)
    for k, angle in enumerate(rays()):
        along = np.array([math.cos(angle), math.sin(angle)])
        across = np.array([-along[1], along[0]])
        one, other = first @ across, second @ across
        cut = np.flatnonzero(one * other < 0.0)
        share = one[cut] / (one[cut] - other[cut])
        place = (first[cut] + share[:, None] * (second[cut] - first[cut])) @ along
        within = cut[(place >= low * RADIUS) & (place < high * RADIUS)]
        found[k] = (np.sign(one[within]) * (forces[within] @ across)).sum() / ((high - low) * RADIUS)
    return found


def rays() -> Floats:
    """Angles (RAYS,) from the x axis [rad]."""
    return np.asarray(2.0 * math.pi * (np.arange(RAYS) + 0.5) / RAYS)


def mean_hoop(low: float, high: float) -> Floats:
    """Kirsch's mean hoop stress (RAYS,) [Pa] between two radii on the same rays."""
    radii = low + (high - low) * (np.arange(200) + 0.5) / 200
    return np.array(
        [
            kirsch_hoop(radii[:, None] * np.array([math.cos(angle), math.sin(angle)]), FIELD).mean()
            for angle in rays()
        ]
    )


def excavate(particles: int, seed: int = 1) -> tuple[Tunnel, Removal]:
    """Ground under the far field, a circle taken out and its face relaxed in two stages."""
    side = 2.0 * HALF * RADIUS
    body = box_body((side, side), [("rock", 1.0)], origin=(-0.5 * side, -0.5 * side))
    filling = fill_body(body, particles=particles, seed=seed)
    held = dict.fromkeys(("left", "right", "bottom", "top"), "fixed")
    wanted = far_field(-np.diag(FIELD))
    scene = build_scene(body, filling, {"rock": ROCK}, supports=held, initial_stress=wanted)
    s, found = start(scene, applied=True)
    assert found is not None
    motion = s.positions - s.assembly.positions
    middle = np.abs(s.positions).max(axis=1) < 0.6 * HALF * RADIUS
    ends = np.column_stack([s.assembly.positions[middle], np.ones(int(middle.sum()))])
    gradient = np.linalg.lstsq(ends, motion[middle], rcond=None)[0][:2].T
    moduli = plane_moduli(0.5 * (gradient + gradient.T), found.measured[0])
    removal = remove_particles(s, inside_circle(s.positions, (0.0, 0.0), RADIUS))
    s = removal.simulation
    added = kirsch_motion(s.positions, FIELD, moduli)
    for factor in (0.5, 0.0):
        removal.face.set(s, factor)
        displace(s, np.hstack([0.5 * added, np.zeros((len(added), 1))]))
        find_equilibrium(s, breaking=False)
    return Tunnel(s, moduli), removal


def raise_load(tunnel: Tunnel, loads: list[float], enough: int) -> None:
    """Let the far field grow from load to load, all displacements of the outline with it, until so many bonds broke."""
    s = tunnel.simulation
    elastic = s.positions - s.assembly.positions
    now = 1.0
    for load in loads:
        way = (load - now) * elastic
        displace(s, np.hstack([way, np.zeros((len(way), 1))]))
        find_equilibrium(s, tolerance=1e-4, most_steps=20_000)
        now = load
        found = s.broken_bonds()
        tunnel.cracks.append((load, len(found.bond)))
        if len(found.bond) >= enough:
            break
    place = s.broken_bonds().place[:SOME]
    tunnel.angles = np.arctan2(place[:, 1], place[:, 0]).tolist()
    tunnel.distances = (np.hypot(*place.T) / RADIUS).tolist()


def rows_of_rings(tunnels: list[Tunnel], seconds: float) -> list[Row]:
    """Hoop stress at roof and floor, of all rays by their second harmonic, beside Kirsch's; means over tunnels."""
    shapes = np.column_stack([np.ones(RAYS), -np.cos(2.0 * rays())])
    found = []
    for low, high in RINGS:
        own, other = (
            float(np.linalg.lstsq(shapes, values, rcond=None)[0].sum())
            for values in (
                np.mean([thrust_stress(each.simulation, low, high) for each in tunnels], axis=0),
                mean_hoop(low, high),
            )
        )
        wall = (low, high) == RINGS[0]
        found.append(
            relative(
                "hoop stress, wall" if wall else "hoop stress", f"roof and floor, {low:g} to {high:g} radii [Pa]", own,
                other, 0.10 if wall else 0.03, seconds, "Kirsch (1898)",
            )
        )  # fmt: skip
        seconds = 0.0
    return found


def strength() -> tuple[float, float, float]:
    """Uniaxial compressive strength and crack initiation stress [Pa] of the rock, and seconds."""
    begun = time.perf_counter()
    record = compress(make_specimen(2, width=1.0, across=30.0, seed=1), ROCK)
    return record.strength, record.numbers["crack_initiation_stress"], time.perf_counter() - begun


def run(particles: int = 12_000) -> list[Row]:
    """All rows."""
    begun = time.perf_counter()
    tunnels = [excavate(particles, seed)[0] for seed in SEEDS]
    rows = rows_of_rings(tunnels, time.perf_counter() - begun)
    tunnel = tunnels[0]
    s = tunnel.simulation
    most = float(np.where(s.intact()[:, None], s.utilisation[: len(s.assembly.bonds)], 0.0).max())
    first = 1.0 / most
    peak = 3.0 * FIELD[0] - FIELD[1]
    compressive, initiation, spent = strength()
    begun = time.perf_counter()
    loads = [first * (0.999 + GROWTH * k) for k in range(60)]
    raise_load(tunnel, loads, 3 * SOME)
    seconds = time.perf_counter() - begun
    some = next((load for load, count in tunnel.cracks if count >= SOME), math.nan)
    away = np.abs(np.abs(np.array(tunnel.angles)) - 0.5 * math.pi)
    there = (away < math.radians(30.0)) & (np.array(tunnel.distances) < 1.3)
    share = float(there.mean()) if len(there) else 0.0
    kirsch = "Kirsch's 3 p1 - p2 at roof and floor"
    rows += [
        Row(
            "first cracks", f"share of the first {SOME} at roof and floor, within 30 deg and 1.3 radii [-]", share, 1.0,
            1.0 - share, 0.1, seconds, "where Kirsch's hoop stress is largest",
        ),
        relative(
            "onset", f"hoop stress of Kirsch at {SOME} cracks over the compressive strength [-]",
            some * peak / compressive, 1.0, 0.5, spent, f"{kirsch}; strength {compressive / 1e6:.4g} MPa",
        ),
        relative(
            "onset", "hoop stress of Kirsch at the first crack over the crack initiation stress [-]",
            first * peak / initiation, 1.0, 0.5, 0.0, f"{kirsch}; initiation {initiation / 1e6:.4g} MPa",
        ),
    ]  # fmt: skip
    return rows
