"""Stress that bonded ground is under before anything is done to it: a tensor everywhere, or weight and K0 with depth.

What holds the ground (particles that are held, on the outline but for free surfaces) is moved so that the ground
inside gets the strain that goes with the wanted stress; what is free follows by an elastic solve, its weight included.
Strains that are constant, or grow with depth, belong to displacements that a body can have, so nothing has to give. The
stiffness of the ground is measured on the way, and what is still amiss is corrected the same way. No bond breaks.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..integrators.elastic_network import NetworkSolver
from ..integrators.network import RIGID, Links, build_network
from ..measure.region_stress import stress_in_box
from ..particle_network import current_springs, touching_links
from ..particle_simulation import ParticleSimulation
from ..particle_statics import displace, find_equilibrium

Floats = NDArray[np.float64]

TRIAL = 1e-7
"""Strain at which the stiffness is measured."""

ROUNDS = 6
"""Corrections at most."""

BALANCED = 1e-4
"""Unbalanced ratio of the state in the end."""

FARTHEST = 1e5
"""Trials that a correction is at most: beyond, the ground does not answer to it."""

GAUGE = 0.6
"""Share of the body's size, in the middle, over which stress is measured."""

LEVELS = 3
"""Boxes one over the other in which a stress that grows with depth is measured; two where they would be thin."""

THINNEST = 4.0
"""Height of such a box over the mean diameter: thinner ones have a stress of their own."""


@dataclass(frozen=True, eq=False)
class WantedStress:
    """A stress field that is constant or grows with depth; tension is positive.

    Attributes
    ----------
    at_top : (d, d) [Pa]
        Where the last coordinate is `top`.
    per_depth : (d, d) [Pa/m]
        What it grows by on the way down.
    top : float
        [m]
    """

    at_top: Floats
    per_depth: Floats
    top: float = 0.0

    def at(self, height: float) -> Floats:
        """The tensor [Pa] where the last coordinate is `height` [m]."""
        return np.asarray(self.at_top + (self.top - height) * self.per_depth)


@dataclass(frozen=True, eq=False)
class InitialStress:
    """What came of it.

    Attributes
    ----------
    reached : bool
        Every component is within the tolerance, over the largest wanted one there, and no bond is overstressed.
    heights : (k,) [m]
        Middles of the boxes in which stress was measured.
    wanted, measured : (k, d, d) [Pa]
    error : float
        Largest deviation of a component over the largest wanted one [-].
    most_utilised : float
        Of the strength of a bond [-]: above 1 it breaks as soon as it may.
    unbalanced_ratio : float
    """

    reached: bool
    heights: Floats
    wanted: Floats
    measured: Floats
    error: float
    most_utilised: float
    unbalanced_ratio: float


def far_field(tensor: ArrayLike) -> WantedStress:
    """The same stress everywhere: a symmetric tensor (d, d) [Pa], tension positive.

    Raises
    ------
    InputError
        A tensor that is not symmetric, or not of 2D or 3D.
    """
    found = np.array(tensor, dtype=float)
    if found.shape not in ((2, 2), (3, 3)) or not np.isfinite(found).all():
        raise InputError(
            "stress", "this is no tensor in 2D or 3D", "Give 2 x 2 or 3 x 3 numbers in Pa", value=tensor
        )
    if not np.allclose(found, found.T, rtol=0.0, atol=1e-9 * float(np.abs(found).max())):
        raise InputError("stress", "the tensor is not symmetric", "Give equal shear stresses", value=tensor)
    return WantedStress(found, np.zeros_like(found))


def ground_stress(
    dimension: int, *, unit_weight: float, k0: float | tuple[float, float], top: float
) -> WantedStress:
    """Weight of the ground above, and K0 times that to the sides.

    Parameters
    ----------
    dimension : int
    unit_weight : float
        Of the ground with its voids [N/m3]; `bulk_unit_weight` tells that of an assembly.
    k0 : float, or two of them in 3D
        Horizontal over vertical stress [-].
    top : float
        Where the surface is, in the last coordinate [m].
    """
    sides = np.broadcast_to(np.asarray(k0, dtype=float), (dimension - 1,))
    for value in (unit_weight, *sides):
        if not (math.isfinite(value) and value >= 0.0):
            raise InputError(
                "stress, unit weight or K0", "this is out of range", "Give 0 or more", value=value
            )
    growth = -unit_weight * np.diag([*sides, 1.0])
    return WantedStress(np.zeros_like(growth), growth, float(top))


def bulk_unit_weight(simulation: ParticleSimulation) -> float:
    """Weight over volume [N/m3] of the middle of an assembly, voids included, under its own gravity."""
    s = simulation
    low, high = _gauge(s)
    from_middle = np.abs(s.positions - 0.5 * (low + high)) / (0.5 * (high - low))
    inside = (from_middle <= 1.0).all(axis=1)
    # particles that the faces of the box cut count by half on average
    volume = float(np.prod(high - low))
    return float(s.assembly.mass[inside].sum() * np.abs(s.assembly.gravity[-1]) / volume)


def set_initial_stress(
    simulation: ParticleSimulation, wanted: WantedStress, *, tolerance: float = 0.01
) -> InitialStress:
    """Bring bonded ground to rest under a wanted stress; its time stands still and no bond breaks.

    Parameters
    ----------
    simulation : ParticleSimulation
        Particles on the outline held, but for free surfaces and for freedoms on which no stress acts. They stay held
        where they have been moved to.
    wanted : WantedStress
        By `far_field` or `ground_stress`.
    tolerance : float
        Of the stress in the middle, over the largest component [-].

    Raises
    ------
    InputError
        Nothing is held, or the bonds do not hold the ground together.
    """
    s = simulation
    d = s.dimension
    if wanted.at_top.shape != (d, d):
        problem = f"this is none in {d}D"
        raise InputError("stress", problem, f"Give {d} x {d} numbers", value=wanted.at_top.tolist())
    held = s.assembly.held
    if not held[:, :d].any():
        raise InputError(
            "assembly", "nothing is held that could press on it", "Hold the particles of its outline"
        )
    steps = _Steps(s)
    low, high = _gauge(s)
    graded = bool(np.abs(wanted.per_depth).any())
    thin = high[-1] - low[-1] < LEVELS * THINNEST * 2.0 * float(s.assembly.radii.mean())
    boxes = _boxes(low, high, (2 if thin else LEVELS) if graded else 1)
    heights = np.array([0.5 * (box[0][-1] + box[1][-1]) for box in boxes])
    target = np.array([wanted.at(float(height)) for height in heights])
    scale = np.abs(target).max(axis=(1, 2))
    # a first solve with the weight alone, so that what is measured next is the response to strains alone
    steps.settle()
    compliance = steps.compliance(low, high)
    middle = 0.5 * (low + high)
    away = heights - middle[-1]

    def correct() -> float:
        """Strain by what is amiss until that is little, or does not get less; what is still amiss."""
        best = math.inf
        for _ in range(ROUNDS):
            amiss = target - _measured(s, boxes)
            error = float((np.abs(amiss).max(axis=(1, 2)) / scale).max())
            if error <= 0.1 * tolerance or error >= 0.9 * best:
                return error
            best = error
            slope, mean = _line(away, amiss)
            steps.strain(_strained(compliance, mean), _strained(compliance, slope), middle)
        return best

    if correct() > 0.5 * tolerance and graded:
        steps.lean(boxes, away, target, middle)
        correct()
    state = find_equilibrium(s, tolerance=BALANCED, breaking=False)
    measured = _measured(s, boxes)
    error = float((np.abs(target - measured).max(axis=(1, 2)) / scale).max())
    most = float(np.where(s.intact()[:, None], s.utilisation[: len(s.assembly.bonds)], 0.0).max(initial=0.0))
    return InitialStress(
        error <= tolerance and most < 1.0 and state.reached, heights, target, measured, error, most,
        state.unbalanced_ratio,
    )  # fmt: skip


class _Steps:
    """Moves of a simulation: what is held by a field of displacements, what is free as the elastic solve says."""

    def __init__(self, simulation: ParticleSimulation) -> None:
        self.simulation = s = simulation
        ids = s.arrays.ids
        self.links = touching_links(s)
        network = build_network(
            np.ascontiguousarray(s.now[:, s.columns.position]), self.links, current_springs(s)
        )
        self.held = np.array(s.assembly.held[ids])
        free = self.held | _loose(self.links, len(ids))[:, None]
        self.solver = NetworkSolver(network, held=free)
        self.start = s.positions

    def _follow(self, given: Floats, load: Floats) -> Floats:
        """Motion (n, d + s), in the order of the assembly, of what is given (n, d + s) and what follows from it."""
        ids = self.simulation.arrays.ids
        motion = np.empty_like(given)
        motion[ids] = self.solver.solve(np.where(self.held, 0.0, load), prescribed=given[ids])
        return motion

    def settle(self) -> None:
        """Go to where loads and weight are borne."""
        s = self.simulation
        d = s.dimension
        load = s.assembly.applied.copy()
        load[:, :d] += s.assembly.mass[:, None] * s.assembly.gravity
        if load.any():
            displace(s, self._follow(np.zeros_like(load), load[s.arrays.ids]))
        else:
            displace(s, np.zeros_like(load))

    def field(self, strain: Floats, growth: Floats, middle: Floats) -> Floats:
        """Displacements (n, d + s) of held freedoms for a strain that is `strain` in the middle and grows upwards.

        u = E x + z G x - (x G x) e_z / 2 with the coordinates from the middle: its strain is E + z G, where G has no
        component with z but zz.
        """
        s = self.simulation
        d = s.dimension
        away = self.start - middle
        up = away[:, -1]
        flat = growth.copy()
        flat[-1, :] = flat[:, -1] = 0.0
        given = np.zeros(s.assembly.held.shape)
        given[:, :d] = away @ strain + up[:, None] * (away @ flat)
        given[:, d - 1] += 0.5 * growth[-1, -1] * up * up - 0.5 * ((away @ flat) * away).sum(axis=1)
        return np.where(s.assembly.held, given, 0.0)

    def strain(self, strain: Floats, growth: Floats, middle: Floats) -> None:
        """Strain the ground by moving what is held."""
        given = self.field(strain, growth, middle)
        displace(self.simulation, self._follow(given, np.zeros_like(given)))

    def lean(self, boxes: list[tuple[Floats, Floats]], away: Floats, target: Floats, middle: Floats) -> None:
        """Take away shear stresses on level planes that grow upwards, which no strain of `field` does.

        Held freedoms move by g z^2 along each horizontal axis; how far follows from how the shear stress answers.
        """
        s = self.simulation
        d = s.dimension
        up = self.start[:, -1] - middle[-1]
        for axis in range(d - 1):
            given = np.zeros(s.assembly.held.shape)
            given[:, axis] = np.where(s.assembly.held[:, axis], TRIAL * up * up / float(np.ptp(up)), 0.0)
            motion = self._follow(given, np.zeros_like(given))
            before = _measured(s, boxes)
            displace(s, motion)
            answer = _line(away, _measured(s, boxes) - before)[0][axis, -1]
            wanted = _line(away, target - before)[0][axis, -1]
            # back where nothing answers, else on to where it is wanted
            displace(s, (wanted / answer - 1.0 if abs(wanted) < FARTHEST * abs(answer) else -1.0) * motion)

    def compliance(self, low: Floats, high: Floats) -> Floats:
        """Strain over stress [1/Pa] of the box, by components: (c, c), c = 3 or 6, shear strains doubled."""
        s = self.simulation
        d = s.dimension
        first, second = _components(d)
        middle, nothing = 0.5 * (low + high), np.zeros((d, d))
        before = _measured(s, [(low, high)])[0]
        stiffness = np.empty((len(first), len(first)))
        for k, (i, j) in enumerate(zip(first, second, strict=True)):
            unit = np.zeros((d, d))
            unit[i, j] = unit[j, i] = -TRIAL if i == j else 0.5 * TRIAL
            given = self.field(unit, nothing, middle)
            motion = self._follow(given, np.zeros_like(given))
            displace(s, motion)
            after = _measured(s, [(low, high)])[0]
            displace(s, -motion)
            stiffness[:, k] = (after - before)[first, second] / (-TRIAL if i == j else TRIAL)
        return np.asarray(np.linalg.inv(stiffness))


def _loose(links: Links, particles: int) -> NDArray[np.bool_]:
    linked = np.zeros(particles, dtype=bool)
    linked[links.first] = True
    linked[links.second[links.second != RIGID]] = True
    return ~linked


def _components(dimension: int) -> tuple[list[int], list[int]]:
    return ([0, 1, 0], [0, 1, 1]) if dimension == 2 else ([0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1])


def _strained(compliance: Floats, stress: Floats) -> Floats:
    """Strain tensor of a stress tensor."""
    d = len(stress)
    first, second = _components(d)
    values = compliance @ stress[first, second]
    found = np.zeros((d, d))
    for value, i, j in zip(values, first, second, strict=True):
        found[i, j] = found[j, i] = value if i == j else 0.5 * value
    return found


def _line(heights: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Slope and value at height 0 of the straight line through values (k, d, d)."""
    if len(heights) == 1:
        return np.zeros_like(values[0]), values[0]
    mean = heights.mean()
    away = heights - mean
    slope = np.tensordot(away, values, axes=1) / float(away @ away)
    return slope, values.mean(axis=0) - mean * slope


def _gauge(s: ParticleSimulation) -> tuple[Floats, Floats]:
    """Corners (d,) [m] of the middle of the body."""
    low, high = s.positions.min(axis=0), s.positions.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * GAUGE * (high - low)
    return middle - half, middle + half


def _boxes(low: Floats, high: Floats, levels: int) -> list[tuple[Floats, Floats]]:
    edges = np.linspace(low[-1], high[-1], levels + 1)
    return [
        (np.append(low[:-1], below), np.append(high[:-1], above))
        for below, above in itertools.pairwise(edges)
    ]


def _measured(s: ParticleSimulation, boxes: list[tuple[Floats, Floats]]) -> Floats:
    """Mean stress (k, d, d) [Pa] in boxes; of each the symmetric part, which is all of it in balance."""
    branches, starts, forces = link_forces(s)
    found = [stress_in_box(forces, starts, branches, low, high) for low, high in boxes]
    return np.array([0.5 * (stress + stress.T) for stress in found])


def link_forces(s: ParticleSimulation) -> tuple[Floats, Floats, Floats]:
    """Branches (k, d) [m], centres of the first particles (k, d) [m] and forces on them (k, d) [N], of all contacts."""
    pairs = s.contacts().pairs
    normal, shear = s.contact_forces()
    positions = s.positions
    branches = positions[pairs[:, 1]] - positions[pairs[:, 0]]
    along = branches / np.sqrt((branches**2).sum(axis=1))[:, None]
    return branches, positions[pairs[:, 0]], shear - normal[:, None] * along
