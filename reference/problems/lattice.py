"""Lattices of bonded discs and spheres, and a bonded beam, against closed forms: `python -m reference run lattice`.

Solved as linear networks here; `lattice_engine` strains one of them with the particle engine.
Moduli of periodic cells follow from the six strains of a cell and the displacements and rotations inside it.
"""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.integrators.elastic_network import solve_network
from geodem.integrators.link_stiffness import law_stiffness
from geodem.integrators.network import (
    build_network,
    imposed_strain,
    link_forces,
    pair_links,
    stiffness_matrix,
)
from geodem.laws.bond import parallel_bond

from . import lattice_engine
from .regular_packings import packing
from .rows import Row, relative

Floats = NDArray[np.float64]

RATIOS = (0.0, 0.25, 0.5, 1.0)
"""ks/kn."""

HCP = {
    0.0: {"C11": 1.7088, "C33": 1.8856, "C12": 0.6482, "C13": 0.4714, "C44": 0.4714},
    0.5: {"C11": 2.2939, "C33": 2.3570, "C12": 0.2988, "C13": 0.2357, "C44": 0.9428},
    1.0: {"C11": 2 * math.sqrt(2), "C33": 2 * math.sqrt(2), "C12": 0.0, "C13": 0.0, "C44": math.sqrt(2)},
}
"""Moduli of the hexagonal close packing for kn = 1 and diameter 1, by ks; given to four places where irrational."""


def moduli(kind: str, ratio: float, cells: int = 2) -> Floats:
    """Elastic moduli (v, v) of a periodic packing for kn = 1, diameter 1; Voigt's order, v = 3 or 6."""
    found = packing(kind, cells)
    network = build_network(found.positions, found.links(1.0, ratio))
    matrix = stiffness_matrix(network)
    dimension = found.positions.shape[1]
    held = np.zeros((len(found.positions), network.freedoms), dtype=bool)
    held[0, :dimension] = True
    order = [(0, 0), (1, 1), (0, 1)] if dimension == 2 else [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    strains, totals = [], []
    for i, j in order:
        strain = np.zeros((dimension, dimension))
        strain[i, j] += 0.5
        strain[j, i] += 0.5
        imposed = imposed_strain(network, found.normal @ strain)
        moved = solve_network(network, np.zeros(held.shape), held=held, imposed=imposed, matrix=matrix)
        strains.append(imposed)
        totals.append(imposed + network.operator @ moved.ravel())
    return np.array(strains) * network.stiffness @ np.array(totals).T / found.volume


def hexagonal(ratio: float) -> list[Row]:
    """Hexagonal discs: E = 2 sqrt3 kn (kn + ks)/(3 kn + ks), nu = (kn - ks)/(3 kn + ks), G = sqrt3/4 (kn + ks)."""
    started = time.perf_counter()
    c = moduli("hexagonal", ratio)
    seconds = time.perf_counter() - started
    name = f"P20 hexagonal, ks/kn {ratio:g}"
    nu = c[0, 1] / c[0, 0]
    found = {"E": c[0, 0] * (1.0 - nu * nu), "nu": nu, "G": c[2, 2]}
    expected = {
        "E": 2.0 * math.sqrt(3.0) * (1.0 + ratio) / (3.0 + ratio),
        "nu": (1.0 - ratio) / (3.0 + ratio),
        "G": math.sqrt(3.0) / 4.0 * (1.0 + ratio),
    }
    return [_row(name, key, found[key], expected[key], 1e-6, seconds) for key in found]


def face_centred(ratio: float) -> list[Row]:
    """FCC along a cube axis: E = 2 sqrt2 kn (kn + 3 ks)/(a (3 kn + ks)), nu = (kn - ks)/(3 kn + ks), C44."""
    started = time.perf_counter()
    c = moduli("FCC", ratio)
    seconds = time.perf_counter() - started
    compliance = np.linalg.inv(c)
    name = f"P20 FCC, ks/kn {ratio:g}"
    found = {"E": 1.0 / compliance[0, 0], "nu": -compliance[0, 1] / compliance[0, 0], "C44": c[3, 3]}
    expected = {
        "E": 2.0 * math.sqrt(2.0) * (1.0 + 3.0 * ratio) / (3.0 + ratio),
        "nu": (1.0 - ratio) / (3.0 + ratio),
        "C44": math.sqrt(0.5) * (1.0 + ratio),
    }
    return [_row(name, key, found[key], expected[key], 1e-6, seconds) for key in found]


def close_packed(ratio: float) -> list[Row]:
    """HCP, whose two layers move against each other: moduli to the four places that are given."""
    started = time.perf_counter()
    c = moduli("HCP", ratio)
    seconds = time.perf_counter() - started
    found = {"C11": c[0, 0], "C33": c[2, 2], "C12": c[0, 1], "C13": c[0, 2], "C44": c[3, 3]}
    name, exact = f"P20 HCP, ks/kn {ratio:g}", ratio == 1.0
    bound = 1e-6 if exact else 5.1e-5
    rows = []
    for key, value in found.items():
        expected = HCP[ratio][key]
        rows.append(Row(name, f"{key}, difference", value, expected, value - expected, bound, seconds))
    return rows


def _row(name: str, quantity: str, value: float, expected: float, bound: float, seconds: float) -> Row:
    """Relative to the expected value, or to 1 (kn over the diameter) where that is 0."""
    size = abs(expected) if expected != 0.0 else 1.0
    return Row(name, quantity, value, expected, (value - expected) / size, bound, seconds)


def sample(ratio: float, wide: int = 30, rows: int = 60) -> list[Row]:
    """Bonded discs between plates that slide freely; stress and strain of the inner third."""
    started = time.perf_counter()
    height = math.sqrt(0.75)
    layer, place = np.divmod(np.arange(wide * rows), wide)
    positions = np.stack([place + 0.5 * (layer % 2), height * layer], axis=1)
    apart = positions[None] - positions[:, None]
    pairs = np.argwhere(np.triu(np.abs((apart**2).sum(axis=2) - 1.0) < 1e-9))
    network = build_network(positions, pair_links(positions, np.full(len(positions), 0.5), pairs, 1.0, ratio))
    held = np.zeros((len(positions), 3), dtype=bool)
    held[(layer == 0) | (layer == rows - 1), 1] = True
    held[0, 0] = True
    prescribed = np.zeros(held.shape)
    prescribed[layer == rows - 1, 1] = -1e-3
    moved = solve_network(network, np.zeros(held.shape), held=held, prescribed=prescribed)
    inner = (layer >= rows // 3) & (layer < 2 * rows // 3) & (place >= wide // 3) & (place < 2 * wide // 3)
    gradient = np.linalg.lstsq(
        np.column_stack([positions[inner], np.ones(inner.sum())]), moved[inner, :2], rcond=None
    )[0]
    forces = link_forces(network, moved)
    # stress of a disc: half of force times branch of all its contacts, over its hexagon
    axial = (
        forces.extension * network.links.normal[:, 1] + forces.slip[:, 0] * network.tangents[:, 0, 1]
    ) * (network.links.normal[:, 1])
    share = sum(np.bincount(network.links[side], 0.5 * axial, minlength=len(positions)) for side in (0, 1))
    stress = float(np.mean(np.asarray(share)[inner])) / height
    vertical, horizontal = gradient[1, 1], gradient[0, 0]
    # what the plates feel, over the width between the outermost centres; the height is one between centres too
    reaction = (stiffness_matrix(network) @ moved.ravel()).reshape(held.shape)[layer == rows - 1, 1].sum()
    plate = reaction / (wide - 0.5) / (-1e-3 / (height * (rows - 1)))
    seconds = time.perf_counter() - started
    name = f"P20 {wide} x {rows} discs, ks/kn {ratio:g}"
    young = 2.0 * math.sqrt(3.0) * (1.0 + ratio) / (3.0 + ratio)
    poisson = (1.0 - ratio) / (3.0 + ratio)
    return [
        relative(name, "E inside", stress / vertical, young, 0.01, seconds),
        _row(name, "nu inside", -horizontal / vertical, poisson, 0.01, seconds),
        relative(name, "E from the plates", plate, young, 0.01, seconds),
    ]


INCH, KIP = 0.0254, 4448.2216152605
LENGTH, RADIUS = 200.0 * INCH, 8.0 * INCH
YOUNG, SHEAR = 1e4 * KIP / INCH**2, 3759.4 * KIP / INCH**2


def cantilever(spheres: int = 10, *, shear: str = "Euler") -> list[Row]:
    """A beam of bonded spheres, clamped in the middle of its first sphere, loaded in that of its last.

    L 200 in, R 8 in, E 10,000 ksi, G 3759.4 ksi; 10 kip across, 100 kip along, 1000 kip in torsion per foot.
    Per bond of the length l: kn = E A/l, bending E I/l, twist G J/l. Slip of the stiffness 12 E I/l^3 makes every bond
    an Euler beam; a parallel bond has ks A instead, here made large, which approaches Euler's beam as 1/spheres^2.
    """
    started = time.perf_counter()
    length = LENGTH / spheres
    area, inertia = math.pi * RADIUS**2, 0.25 * math.pi * RADIUS**4
    polar = 2.0 * inertia
    positions = np.zeros((spheres + 1, 3))
    positions[:, 0] = length * np.arange(spheres + 1)
    pairs = np.stack([np.arange(spheres), np.arange(1, spheres + 1)], axis=1)
    radii = np.full(spheres + 1, 0.5 * length)
    values: Any = (YOUNG * area / length, 12.0 * YOUNG * inertia / length**3, SHEAR * polar / length)
    values = (*values, YOUNG * inertia / length)
    if shear != "Euler":
        # the law gives both ks A and ks J; the torsion is held to its own formula below
        cement = parallel_bond.ParallelBondParameters(
            RADIUS / radii[0], YOUNG / length, 1e4 * YOUNG / length, math.inf, math.inf
        )
        each = np.full(spheres, radii[0])
        values = law_stiffness(
            parallel_bond,
            3,
            np.tile(cement, (spheres, 1)),
            radius_a=each,
            radius_b=each,
            distance=2.0 * each,
            overlap=0.0 * each,
        ).T
    network = build_network(positions, pair_links(positions, radii, pairs, *values))
    matrix = stiffness_matrix(network)
    held = np.zeros((spheres + 1, 6), dtype=bool)
    held[0] = True

    def tip(freedom: int, load: float) -> tuple[Floats, Floats]:
        loads = np.zeros(held.shape)
        loads[-1, freedom] = load
        moved = solve_network(network, loads, held=held, matrix=matrix)
        forces = link_forces(network, moved)
        return moved[-1], np.array([*forces.bend[0], *forces.slip[0]])

    across, along, torque = 10.0 * KIP, 100.0 * KIP, 1000.0 * KIP * 12.0 * INCH
    bent, first = tip(2, -across)
    pulled, _ = tip(0, along)
    turned, _ = tip(3, torque)
    # the moment in the middle of the first bond, and what its shear force adds up to the clamp
    moment = math.hypot(first[0], first[1]) + 0.5 * length * math.hypot(first[4], first[5])
    twist = SHEAR if shear == "Euler" else 1e4 * YOUNG
    seconds = time.perf_counter() - started
    name = f"P22 cantilever, {spheres} bonds, {shear}"
    return [
        relative(
            name,
            "deflection F L^3/3EI [m]",
            -bent[2],
            across * LENGTH**3 / (3 * YOUNG * inertia),
            1e-3,
            seconds,
        ),
        relative(
            name,
            "rotation F L^2/2EI [rad]",
            bent[4],
            across * LENGTH**2 / (2 * YOUNG * inertia),
            1e-3,
            seconds,
        ),
        relative(
            name,
            "fibre stress F L R/I [Pa]",
            moment * RADIUS / inertia,
            across * LENGTH * RADIUS / inertia,
            1e-2,
            seconds,
        ),
        relative(name, "extension P L/EA [m]", pulled[0], along * LENGTH / (YOUNG * area), 1e-3, seconds),
        relative(name, "twist T L/GJ [rad]", turned[3], torque * LENGTH / (twist * polar), 1e-3, seconds),
    ]


def run() -> list[Row]:
    """All of them."""
    rows: list[Row] = []
    for ratio in RATIOS:
        rows += hexagonal(ratio) + face_centred(ratio)
    for ratio in HCP:
        rows += close_packed(ratio)
    for ratio in (0.25, 0.5, 1.0):
        rows += sample(ratio)
    rows += [*cantilever(10), *cantilever(20, shear="parallel bond, ks large")]
    return rows + lattice_engine.run()
