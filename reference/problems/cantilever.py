"""A beam of bonded spheres in equilibrium, by the engine itself: `python -m reference run cantilever`.

L 200 in, circular section R 8 in, E 10,000 ksi, G 3759.4 ksi: a verification problem of Itasca's, with the formulae of
beams. Spheres of the diameter l = L/n are joined by parallel bonds of the radius R, clamped at the centre of the first
and loaded at that of the last. A bond of the normal stiffness E/l is a beam of the length l whose bending sits in its
middle; that makes the deflection 1/(4 n^2) too small. Shear of the stiffness 12 E I/(A l^3) gives this back and makes
every bond an Euler beam. Torsion, which shares the bond's shear stiffness, is held to G/l in a beam of its own.

`lattice.cantilever` solves the same beams without the engine.
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from .rows import Row, relative

Floats = NDArray[np.float64]

INCH, KIP = 0.0254, 4448.2216152605
LENGTH, RADIUS = 200.0 * INCH, 8.0 * INCH
YOUNG, SHEAR = 1e4 * KIP / INCH**2, 3759.4 * KIP / INCH**2
AREA, INERTIA = math.pi * RADIUS**2, 0.25 * math.pi * RADIUS**4

ACROSS, ALONG, TORQUE = 10.0 * KIP, 100.0 * KIP, 1000.0 * KIP * INCH
SOURCE = "Itasca verification problem; beam theory"

DEFLECTION, STRESS = 1e-3, 1e-2
"""Bounds."""


class Bent:
    """A beam in equilibrium under a force and a torque at its end.

    Attributes
    ----------
    tip : (6,)
        Displacement [m] and rotation [rad] of the last sphere.
    force, moment : (3,)
        Of the first bond on the clamped sphere, moment about its centre [N, N m].
    bond : dict of str to float
        What the first bond remembers: shear force [N], bending and twisting moment [N m].
    """

    def __init__(self, bonds: int, shear_stiffness: float, force: Floats, torque: Floats) -> None:
        length = LENGTH / bonds
        radius = 0.5 * length
        builder = AssemblyBuilder(3, bond_law="parallel_bond")
        # the contact, which acts beside the bond where it is pressed, is next to nothing
        weak = {"normal_stiffness": 1e-3, "shear_stiffness": 1e-3, "friction_coefficient": 0.0}
        bond = {
            "radius_factor": RADIUS / radius,
            "normal_stiffness": YOUNG / length,
            "shear_stiffness": shear_stiffness,
            "tensile_strength": math.inf,
            "shear_strength": math.inf,
        }
        builder.add_material("beam", density=2700.0, contact=weak, bond=bond)
        places = np.zeros((bonds + 1, 3))
        places[:, 0] = length * np.arange(bonds + 1)
        builder.add_particles(places, radius, "beam")
        builder.bond(np.stack([np.arange(bonds), np.arange(1, bonds + 1)], axis=1))
        builder.hold([0], x=0.0, y=0.0, z=0.0, rotation=0.0)
        builder.apply([bonds], force=force, torque=torque)
        simulation = ParticleSimulation(builder.build(), orientation=True)
        self.found = find_equilibrium(simulation, tolerance=1e-9)
        moved = simulation.positions[-1] - places[-1]
        w, *vector = simulation.orientations[-1]
        turned = 2.0 * math.copysign(1.0, w) * np.array(vector)
        self.tip = np.concatenate([moved, turned])
        reaction = simulation.forces[0]
        self.force, self.moment = reaction[:3], reaction[3:]
        contacts = simulation.contacts()
        first = int(np.flatnonzero((contacts.pairs == (0, 1)).all(axis=1))[0])
        self.bond = {
            name[5:]: float(values[first]) for name, values in contacts.history.items() if "bond." in name
        }


def beam(bonds: int = 10) -> list[Row]:
    """10 kip across: deflection, rotation, fibre stress; 100 kip along: extension and stress."""
    started = time.perf_counter()
    length = LENGTH / bonds
    euler = 12.0 * YOUNG * INERTIA / (AREA * length**3)
    none = np.zeros(3)
    bent = Bent(bonds, euler, np.array([0.0, -ACROSS, 0.0]), none)
    pulled = Bent(bonds, euler, np.array([ALONG, 0.0, 0.0]), none)
    seconds = time.perf_counter() - started
    # the moment sits in the middle of the bond; to its end the shear force adds half a length of arm
    middle = math.hypot(bent.bond["bending_y"], bent.bond["bending_z"])
    shear = math.hypot(bent.bond["shear_y"], bent.bond["shear_z"])
    clamped = float(np.linalg.norm(bent.moment))
    name = f"P22 cantilever, {bonds} bonds"
    return [
        relative(
            name, "deflection F L^3/3EI [m]", -bent.tip[1], ACROSS * LENGTH**3 / (3 * YOUNG * INERTIA),
            DEFLECTION, seconds, SOURCE,
        ),
        relative(
            name, "rotation F L^2/2EI [rad]", -bent.tip[5], ACROSS * LENGTH**2 / (2 * YOUNG * INERTIA),
            DEFLECTION, seconds, SOURCE,
        ),
        relative(
            name, "fibre stress F L R/I, from the clamp's moment [Pa]", clamped * RADIUS / INERTIA,
            ACROSS * LENGTH * RADIUS / INERTIA, STRESS, seconds, SOURCE,
        ),
        relative(
            name, "fibre stress, from the bond's moment and shear force [Pa]",
            (middle + 0.5 * length * shear) * RADIUS / INERTIA, ACROSS * LENGTH * RADIUS / INERTIA,
            STRESS, seconds, SOURCE,
        ),
        relative(name, "shear force of the first bond [N]", shear, ACROSS, DEFLECTION, seconds, "equilibrium"),
        relative(
            name, "extension P L/EA [m]", pulled.tip[0], ALONG * LENGTH / (YOUNG * AREA), DEFLECTION, seconds, SOURCE
        ),
        relative(
            name, "axial stress P/A, from the clamp [Pa]", abs(pulled.force[0]) / AREA, ALONG / AREA, STRESS, seconds,
            SOURCE,
        ),
    ]  # fmt: skip


def elastic(bonds: int = 20) -> list[Row]:
    """Bond shear of E and nu, G/l: twist under 1000 kip in, and the deflection of Timoshenko's beam without kappa."""
    started = time.perf_counter()
    length = LENGTH / bonds
    none = np.zeros(3)
    turned = Bent(bonds, SHEAR / length, none, np.array([TORQUE, 0.0, 0.0]))
    bent = Bent(bonds, SHEAR / length, np.array([0.0, -ACROSS, 0.0]), none)
    seconds = time.perf_counter() - started
    name = f"P22 cantilever, {bonds} bonds with shear G/l"
    timoshenko = ACROSS * LENGTH**3 / (3 * YOUNG * INERTIA) + ACROSS * LENGTH / (SHEAR * AREA)
    polar = 2.0 * INERTIA
    return [
        relative(
            name, "twist T L/GJ [rad]", turned.tip[3], TORQUE * LENGTH / (SHEAR * polar), DEFLECTION, seconds, SOURCE
        ),
        relative(
            name, "shear stress T R/J, from the bond [Pa]", abs(turned.bond["twisting"]) * RADIUS / polar,
            TORQUE * RADIUS / polar, STRESS, seconds, SOURCE,
        ),
        relative(
            name, "deflection F L^3/3EI + F L/GA [m]", -bent.tip[1], timoshenko, DEFLECTION, seconds,
            "beam theory with the shear force spread evenly",
        ),
    ]  # fmt: skip


def run() -> list[Row]:
    """Both beams, the first with more bonds too."""
    return [*beam(10), *beam(20), *elastic()]
