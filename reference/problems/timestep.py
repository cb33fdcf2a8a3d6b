"""Critical time step of regular packings, found and put to the test: `python -m reference run timestep`."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import DISC_INERTIA, SPHERE_INERTIA
from geodem.integrators.critical_step import critical_step, gershgorin_frequency, largest_frequency
from geodem.integrators.network import build_network, stiffness_matrix

from . import timestep_engine
from .regular_packings import CELLS, CONTACTS, packing
from .rows import Row, relative

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

Floats = NDArray[np.float64]

RATIOS = (0.0, 0.4, 0.5, 1.0)
"""ks/kn."""

WITHOUT_SPIN = {
    "square": 1.0,
    "hexagonal": math.sqrt(2.0 / 3.0),
    "SC": 1.0,
    "BCC": math.sqrt(0.75),
    "FCC": math.sqrt(0.5),
    "HCP": math.sqrt(0.5),
}
"""Critical step over sqrt(m/kn) for ks = 0."""

NOISE = 1e-6
GROWTH = 20.0
"""What stays below so many times the noise is bounded: at 0.98 of the critical step a mode grows to 5 times at most."""


def expected_step(kind: str, ratio: float) -> float:
    """Critical step over sqrt(m/kn): without friction that of the normal springs, else spin governs."""
    if ratio == 0.0:
        return WITHOUT_SPIN[kind]
    inertia = 2.0 * DISC_INERTIA if len(CELLS[kind][0]) == 2 else 3.0 * SPHERE_INERTIA
    return math.sqrt(inertia / (CONTACTS[kind] * ratio))


def system(kind: str, ratio: float, cells: int = 4, *, periodic: bool = True) -> tuple[csr_matrix, Floats]:
    """Stiffness for kn = 1 and inertia (n, d + s) for m = 1 and diameter 1."""
    found = packing(kind, cells, periodic=periodic)
    network = build_network(found.positions, found.links(1.0, ratio))
    dimension = network.dimension
    mass = np.ones((len(found.positions), network.freedoms))
    mass[:, dimension:] = 0.25 * (DISC_INERTIA if dimension == 2 else SPHERE_INERTIA)
    return stiffness_matrix(network), mass


def noise(freedoms: int) -> Floats:
    """Displacements of up to 1e-6, the same ones every time."""
    return np.random.default_rng(27).uniform(-NOISE, NOISE, freedoms)


def highest_mode(matrix: csr_matrix, mass: Floats) -> Floats:
    """Displacements of up to 1e-6 in the motion of the largest frequency: the one that alternates fastest."""
    motion = noise(mass.size)
    for _ in range(400):
        motion = (matrix @ motion) / mass.ravel()
        motion *= NOISE / np.abs(motion).max()
    return motion


def shake(
    matrix: csr_matrix,
    mass: Floats,
    step: float,
    steps: int,
    *,
    start: Floats | None = None,
    viscous: float = 0.0,
    local: float = 0.0,
) -> Floats:
    """Leap-frog from `start` or noise of 1e-6: the largest displacement after every step, over the noise.

    `viscous` is the factor on K of a stiffness-proportional damping [s], `local` Cundall's coefficient.
    """
    inertia = mass.ravel()
    position = noise(len(inertia)) if start is None else start.copy()
    velocity = np.zeros_like(position)
    sizes = []
    for _ in range(steps):
        force = -(matrix @ (position + viscous * velocity))
        force -= local * np.abs(force) * np.sign(velocity)
        velocity += step * force / inertia
        position = position + step * velocity
        sizes.append(float(np.abs(position).max()) / NOISE)
        if sizes[-1] > 1e30:
            break
    return np.array(sizes)


def found_step(kind: str, ratio: float) -> list[Row]:
    """The step of a periodic packing, of a finite one, and how far below Gershgorin's bound leads."""
    started = time.perf_counter()
    matrix, mass = system(kind, ratio)
    step = critical_step(largest_frequency(matrix, mass, accuracy=1e-8))
    bound = critical_step(gershgorin_frequency(matrix, mass))
    finite_matrix, finite_mass = system(kind, ratio, periodic=False)
    finite = critical_step(largest_frequency(finite_matrix, finite_mass, accuracy=1e-8))
    seconds = time.perf_counter() - started
    name = f"P27 {kind}, ks/kn {ratio:g}"
    expected = expected_step(kind, ratio)
    return [
        relative(name, "critical step [sqrt(m/kn)]", step, expected, 1e-6, seconds),
        Row(
            name,
            "step of a finite packing: not below",
            finite,
            expected,
            min(0.0, finite / expected - 1),
            1e-6,
            seconds,
        ),
        Row(
            name,
            "step by Gershgorin: not above",
            bound,
            expected,
            max(0.0, bound / expected - 1),
            1e-6,
            seconds,
        ),
    ]


def driven(kind: str, ratio: float, steps: int = 2000) -> list[Row]:
    """Bounded at 0.98 of the critical step; at 1.02 the growth per step is 2 arcosh(1.02)."""
    started = time.perf_counter()
    matrix, mass = system(kind, ratio)
    critical = expected_step(kind, ratio)
    stays = float(shake(matrix, mass, 0.98 * critical, steps).max())
    grows = np.log(shake(matrix, mass, 1.02 * critical, 150))
    rate = float(grows[-1] - grows[-51]) / 50.0
    seconds = time.perf_counter() - started
    name = f"P27 {kind}, ks/kn {ratio:g}"
    return [
        _bounded(name, f"0.98: largest over noise in {steps} steps, at most", stays, seconds),
        relative(name, "1.02: growth per step", rate, 2.0 * math.acosh(1.02), 0.01, seconds),
    ]


def damped(kind: str, ratio: float, *, viscous: float = 0.0, local: float = 0.0) -> list[Row]:
    """Bounded at 0.98 of the step that allows for damping; at 1.02 the highest mode grows.

    Local damping is not linear: it may damp noise whose highest mode would grow alone.
    """
    started = time.perf_counter()
    matrix, mass = system(kind, ratio)
    frequency = 2.0 / expected_step(kind, ratio)
    critical = critical_step(frequency, viscous=viscous, local=local)
    factor = 2.0 * viscous / frequency
    stays = float(shake(matrix, mass, 0.98 * critical, 2000, viscous=factor, local=local).max())
    mode = highest_mode(matrix, mass)
    grows = float(shake(matrix, mass, 1.02 * critical, 500, start=mode, viscous=factor, local=local).max())
    seconds = time.perf_counter() - started
    name = f"P27 {kind}, viscous {viscous:g}, local {local:g}"
    return [
        _bounded(name, "0.98: largest over noise, at most", stays, seconds),
        Row(
            name,
            "1.02: growth of the highest mode, at least",
            grows,
            1e6,
            min(0.0, math.log10(grows) / 6.0 - 1.0),
            1e-6,
            seconds,
        ),
    ]


def _bounded(name: str, quantity: str, value: float, seconds: float) -> Row:
    return Row(name, quantity, value, GROWTH, max(0.0, value / GROWTH - 1.0), 1e-6, seconds)


def run() -> list[Row]:
    """Every packing at every ratio."""
    rows: list[Row] = []
    for kind in CELLS:
        for ratio in RATIOS:
            rows += found_step(kind, ratio)
            rows += driven(kind, ratio)
            rows += timestep_engine.by_engine(kind, ratio, expected_step(kind, ratio))
    for kind in ("hexagonal", "FCC"):
        rows += damped(kind, 0.5, local=0.8)
        rows += damped(kind, 0.5, viscous=0.3)
        rows += damped(kind, 0.5, viscous=0.2, local=0.7)
    return rows
