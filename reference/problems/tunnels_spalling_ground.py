"""Bonded ground around a tunnel: what is excavated, what its contacts carry, how it is loaded until it breaks."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from geodem.breaking.removal import Removal, remove_particles
from geodem.breaking.scene import build_scene, start
from geodem.breaking.shapes import inside_circle
from geodem.builders.fill_body import fill_body
from geodem.builders.section_body import box_body
from geodem.laboratory.material import BondedMaterial
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import displace, find_equilibrium
from geodem.preparation.initial_stress import far_field, link_forces

from .tunnels_spalling_kirsch import RADIUS, kirsch_hoop, kirsch_motion, plane_moduli

Floats = NDArray[np.float64]

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
SIZE_RATIO = 1.5
"""Of the grains."""
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
    filling = fill_body(body, particles=particles, size_ratio=SIZE_RATIO, seed=seed)
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
