"""Regular arrays at failure in a periodic cell: `python -m reference run arrays`.

The stress ratio at which all inclined contacts of an array slide follows from the balance of one particle. The contacts
here are so stiff that the array at failure is still the one of the formula.
"""

from __future__ import annotations

import itertools
import math
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation

from .rows import Row, at_most, relative

Floats = NDArray[np.float64]

DIAMETER = 0.01  # [m]
STIFFNESS = 1e8  # [N/m] (2D: N/m per m)
OVERLAP = 1e-5
"""Over the diameter, before the array is loaded; at failure some are a few times deeper."""
DEEPEST = 1e-4
"""Over the diameter: deeper overlaps would turn the contacts."""
STRAIN_A_STEP = 2e-8
LONGEST = 4e-3
"""Axial strain at which a run ends that has not failed."""
FALLEN = 0.995
"""Share of its peak to which the stress ratio has fallen when a run ends."""
SAMPLE = 500
"""Steps between two looks."""
GAP = 1e-4
"""Over the diameter, between the rows of a plane-strain array along the axis that is held: they carry nothing."""
BOUND = 0.01

ROWE = "Rowe 1962: tan 60 tan(60 + phi_mu)"
AXISYMMETRIC = "Thornton 1979: 2 (1 + f)/(1 - f)"
PLANE = "balance of a sphere that slides on four along (sqrt 2, 0, -1)/sqrt 3"


class Failure(NamedTuple):
    """An array at its peak."""

    stress: Floats  # (d,) normal stresses, tension positive [Pa]
    strain: float  # axial, logarithmic
    deepest: float  # overlap over diameter
    seconds: float


def array(
    dimension: int, friction: float, *, gap: float = 0.0, spin: bool = True, cells: int = 4
) -> ParticleSimulation:
    """Rows of discs (hexagonal) or square layers of spheres (face-centred cubic), rows along x (and y), in a cell.

    Inclined contacts overlap by `OVERLAP`; rows along y are `gap` diameters apart. `spin`: particles may turn.
    """
    row = DIAMETER * (1.0 - OVERLAP)
    if dimension == 2:
        sides = np.array([row, math.sqrt(3.0) * row])
        basis = np.array([(0.0, 0.0), (0.5, 0.5)])
        count: tuple[int, ...] = (cells, cells // 2 + 1)
    else:
        wide = row + (gap + OVERLAP) * DIAMETER if gap else row
        sides = np.array([row, wide, 2.0 * math.sqrt(row**2 * 0.75 - 0.25 * wide**2)])
        basis = np.array([(0.0, 0.0, 0.0), (0.5, 0.5, 0.5)])
        count = (cells, cells, cells // 2 + 1)
    corners = np.array(list(itertools.product(*(range(each) for each in count))), dtype=float)
    places = ((corners[:, None] + basis[None]) * sides).reshape(-1, dimension)
    builder = AssemblyBuilder(dimension)
    contact = {
        "normal_stiffness": STIFFNESS, "shear_stiffness": STIFFNESS, "friction_coefficient": friction,
    }  # fmt: skip
    builder.add_material("grain", density=2500.0, contact=contact)
    builder.set_cell(sides * np.array(count))
    ids = builder.add_particles(places, 0.5 * DIAMETER, "grain")
    if not spin:
        builder.hold(ids, rotation=0.0)
    return ParticleSimulation(builder.build(), local_damping=0.1)


def load(simulation: ParticleSimulation, held: int | None = None) -> Failure:
    """Compress along the last axis at constant stress across, an axis `held` or not, until the ratio falls."""
    started = time.perf_counter()
    s, d = simulation, simulation.dimension
    rate = STRAIN_A_STEP / s.time_step
    pressure = OVERLAP * STIFFNESS / (1.0 if d == 2 else DIAMETER)
    across = np.full(d, -pressure)
    if held is not None:
        across[held] = np.nan
    s.set_target_stress(across, largest_rate=30.0 * rate)
    s.run(4 * SAMPLE)
    axial = np.full(d, np.nan)
    axial[-1] = -rate
    s.set_strain_rate(axial)
    peak, best = 0.0, Failure(np.zeros(d), 0.0, 0.0, 0.0)
    while s.strain()[-1, -1] > -LONGEST:
        s.run(SAMPLE)
        stress = np.diag(s.stress())
        ratio = stress[-1] / stress[0]
        if ratio > peak:
            peak = ratio
            deepest = float(s.contacts().overlap.max()) / DIAMETER
            best = Failure(stress.copy(), float(s.strain()[-1, -1]), deepest, 0.0)
        elif ratio < FALLEN * peak:
            break
    return best._replace(seconds=time.perf_counter() - started)


def discs(friction: float) -> list[Row]:
    """Hexagonal discs."""
    found = load(array(2, friction))
    expected = math.tan(math.pi / 3.0) * math.tan(math.pi / 3.0 + math.atan(friction))
    return _rows("hexagonal discs", friction, found, [("sigma 1 over sigma 3 [-]", 1, expected, ROWE)])


def axisymmetric(friction: float) -> list[Row]:
    """Face-centred cubic spheres, equal stress across."""
    found = load(array(3, friction))
    expected = 2.0 * (1.0 + friction) / (1.0 - friction)
    return _rows(
        "FCC axisymmetric", friction, found, [("sigma 1 over sigma 3 [-]", 2, expected, AXISYMMETRIC)]
    )


def plane_strain(friction: float) -> list[Row]:
    """Face-centred cubic spheres that cannot move along y.

    They are kept from spinning, as the formula has it. When all contacts slide nothing holds them back any more, and
    what rounding begins ends with half of the contacts rolling: at f = 0.3 at 4.60 and 1.80 instead of 4.88 and 1.96.
    """
    found = load(array(3, friction, gap=GAP, spin=False), held=1)
    least = math.sqrt(3.0) - 2.0 * math.sqrt(2.0) * friction
    most = 2.0 * (math.sqrt(3.0) + math.sqrt(2.0) * friction)
    return _rows(
        "FCC plane strain", friction, found,
        [("sigma zz over sigma xx [-]", 2, most / least, PLANE),
         ("sigma yy over sigma xx [-]", 1, math.sqrt(3.0) / least, PLANE)],
    )  # fmt: skip


def _rows(name: str, friction: float, found: Failure, ratios: list[tuple[str, int, float, str]]) -> list[Row]:
    name = f"P23 {name}, friction {friction:g}"
    rows = [
        relative(
            name,
            quantity,
            float(found.stress[axis] / found.stress[0]),
            expected,
            BOUND,
            found.seconds,
            source,
        )
        for quantity, axis, expected, source in ratios
    ]
    rows.append(
        at_most(
            name,
            "deepest overlap over diameter, at most",
            found.deepest,
            DEEPEST,
            found.seconds,
            "stiff contacts",
        )
    )
    return rows


def run() -> list[Row]:
    """Frictions of CASES: those of Rowe's discs, of his steel spheres, and of Itasca's verification."""
    rows = []
    for friction in (0.0, 0.05, 0.2, 0.3):
        rows += discs(friction)
    for friction in (0.05, 0.12278, 0.2, 0.3):
        rows += axisymmetric(friction)
    for friction in (0.05, 0.12278, 0.2, 0.3):
        rows += plane_strain(friction)
    return rows
