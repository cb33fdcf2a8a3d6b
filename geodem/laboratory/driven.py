"""A specimen some of whose particles are driven and others loaded: what splitting, bending and shear have in common.

A drive is a number in metres. Driven particles move by their share of it along the axes that they are held along and
are free along the others. The load is the force that does the work of the drive, so it is the mean of what opposite
grips feel. As in `geodem.laboratory.rig` the motion begins from the solved elastic state, without a shock.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..builders.assembly_builder import AXES, AssemblyBuilder
from ..errors import InputError
from ..integrators.elastic_network import NetworkSolver
from ..integrators.network import build_network
from ..measure.region_stress import stress_in_region
from ..particle_network import touching_links
from ..particle_simulation import ParticleSimulation
from ..particle_statics import displace
from .confinement import joined_to_most
from .material import BondedMaterial
from .record import Cracks
from .rig import DAMPING, FIRST_SHARE, STEP, TRIAL_STRAIN, even_density
from .specimen import Specimen
from .start import go_to_first_break

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]


FARTHEST = 0.05
"""Longest drive of the solved state over the size of the specimen: beyond, it is no longer linear."""


class Driven:
    """A specimen ready to be loaded.

    Parameters
    ----------
    specimen : Specimen
    material : BondedMaterial
    motion : (n, d)
        Way of every driven particle over the drive [-]; nan where it is free.
    load : (n, d), optional
        Constant forces [N].
    time_share : float
        Of the critical time step.
    seed : int
        Of the scatter of bond strengths.

    Raises
    ------
    InputError
        The material's parameters are out of range, nothing is driven, or the bonds do not hold the specimen together.
    """

    def __init__(
        self,
        specimen: Specimen,
        material: BondedMaterial,
        motion: Floats,
        *,
        load: Floats | None = None,
        time_share: float = STEP,
        seed: int = 1,
    ) -> None:
        material.check()
        self.specimen = specimen
        self.material = material
        self.driven = np.isfinite(motion)
        self.motion = np.where(self.driven, motion, 0.0)
        self.load = load
        d = self.dimension = specimen.dimension
        if not self.motion.any():
            raise InputError(
                "specimen", "no particle lies where the load is to act", "Make the particles smaller"
            )
        build = AssemblyBuilder(d, contact_law=material.contact_law, bond_law=material.bond_law)
        build.add_material(
            material.name, density=material.density, contact=material.contact, bond=material.bond
        )
        positions, radii = specimen.positions, specimen.radii
        build.add_particles(
            positions, radii, material.name, density=material.density * even_density(radii, d)
        )
        build.bond_within(material.bonding_range, scale=material.scatter(seed))
        for axis in range(d):
            if self.driven[:, axis].any():
                build.hold(self.driven[:, axis], **{AXES[axis]: 0.0})
        if load is not None:
            build.apply(np.arange(len(radii)), force=load)
        # every test asks for applied forces, so that all share one kernel: its compilation takes longer than a test
        self.simulation = s = ParticleSimulation(
            build.build(), local_damping=DAMPING, orientation=False, applied=True
        )
        s.time_step = s.span = time_share * s.critical_time_step
        self.start = s.positions
        joined = joined_to_most(s)
        grips = self.driven.any(axis=1)
        if (~joined).sum() > 0.05 * len(joined) or not joined[grips].any():
            raise InputError(
                "specimen, bonding_range", f"{int((~joined).sum())} particles are bonded to nothing that is loaded",
                "Bond from farther apart: 1.05 for a dense packing", value=material.bonding_range,
            )  # fmt: skip
        self._solved = False

    # ------------------------------------------------------------------ elastic

    def solve(self) -> None:
        """Solve for the elastic states of a drive of one metre and of the loads."""
        s, d = self.simulation, self.dimension
        ids = s.arrays.ids
        links = touching_links(s)
        network = build_network(np.ascontiguousarray(s.now[:, s.columns.position]), links)
        held = np.array(s.assembly.held[ids])
        linked = np.zeros(len(ids), dtype=bool)
        linked[links.first] = linked[links.second] = True
        shape = held.shape
        solver = NetworkSolver(network, held=held | ~linked[:, None] | self._floating()[ids])
        given = np.zeros(shape)
        given[:, :d] = self.motion[ids]
        self.unit = np.empty(shape)
        self.unit[ids] = solver.solve(np.zeros(shape), prescribed=given)
        force = (solver.matrix @ self.unit[ids].ravel()).reshape(shape)[:, :d]
        self.stiffness = float((self.motion[ids] * force).sum())
        self.loaded = np.zeros(shape)
        if self.load is not None:
            applied = np.zeros(shape)
            applied[:, :d] = np.where(held[:, :d] | ~linked[:, None], 0.0, self.load[ids])
            self.loaded[ids] = solver.solve(applied)
        self._solved = True

    def _floating(self) -> Mask:
        """Freedoms (n, d + s) of one particle that keep the whole from floating where no grip holds it."""
        d = self.dimension
        found = np.zeros(self.simulation.assembly.held.shape, dtype=bool)
        driven = self.driven.any(axis=0)
        away = ((self.start - self.start.mean(axis=0)) ** 2).sum(axis=1)
        middle = int(np.argmin(away))
        found[middle, :d] = ~driven
        if d == 3 and driven.sum() == 1:
            # it would turn about the axis of the drive
            found[middle, d:] = driven
        return found

    def begin(self, rate: float, *, share: float = FIRST_SHARE) -> None:
        """Go to the elastic state at `share` of the load of the first break and set everything in motion.

        Parameters
        ----------
        rate : float
            Drive per step [m].

        `first_break` is then the drive at which the first bond breaks, and `scale` the one at which it would without
        loads, and what the loads take [m].
        """
        if not self._solved:
            self.solve()
        s = self.simulation
        if self.load is not None:
            displace(s, self.loaded)
        size = float(self.specimen.size.max())
        start = go_to_first_break(s, self.unit, TRIAL_STRAIN * size, share, farthest=FARTHEST * size)
        self.first_break = start.multiple / share
        # of the drive alone, whatever the loads have used up; what they add to the strength is of their own size
        weight = 0.0 if self.load is None else float(np.abs(self.load).sum())
        self.scale = 1.0 / max(start.steepest, 1.0 / (FARTHEST * size)) + weight / self.stiffness
        held = s.assembly.held
        moving = np.where(held, np.hstack([s.velocities, s.spins]), rate / s.time_step * self.unit)
        moving[:, : self.dimension][self.driven] = rate / s.time_step * self.motion[self.driven]
        moving = moving[s.arrays.ids]
        for rows in s.rows:
            rows[:, s.columns.velocity] = moving[:, : self.dimension]
            rows[:, s.columns.spin] = moving[:, self.dimension :]

    # ------------------------------------------------------------------ readings

    def force(self) -> float:
        """What the drive works against [N] (2D: N per m)."""
        return -float((self.motion * self.simulation.forces[:, : self.dimension]).sum())

    def displacement(self) -> float:
        """The drive so far [m]."""
        moved = self.simulation.positions - self.start
        return float((self.motion * moved).sum() / (self.motion**2).sum())

    def stress_in(self, centre: Floats, radius: float) -> Floats:
        """Mean stress (d, d) [Pa] in a circle or sphere, positive in compression."""
        s = self.simulation
        normal, shear = s.contact_forces()
        pairs, places = s.contacts().pairs, s.positions
        starts = places[pairs[:, 0]]
        branches = places[pairs[:, 1]] - starts
        along = branches / np.sqrt((branches**2).sum(axis=1, keepdims=True))
        return -stress_in_region(shear - normal[:, None] * along, starts, branches, centre, radius)

    def cracks(self, steps: Floats, load: Floats) -> Cracks:
        """With the load at which each was made."""
        s = self.simulation
        found = s.broken_bonds()
        pairs = s.assembly.bonds[found.bond]
        apart = self.start[pairs[:, 1]] - self.start[pairs[:, 0]]
        size = np.sqrt((apart**2).sum(axis=1, keepdims=True))
        at = np.interp(found.step, steps, load) if len(steps) else np.zeros(len(pairs))
        radii = self.specimen.radii
        return Cracks(found.place, found.mode, apart / size, 2.0 * np.minimum(*radii[pairs].T), at)


def outermost(
    positions: Floats, radii: Floats, axis: int, sign: float, low: Floats, high: Floats
) -> tuple[NDArray[np.int64], Floats]:
    """Particles that rays along an axis meet first, ascending, and the share of the rays that meet each.

    Parameters
    ----------
    positions : (n, d) [m]
    radii : (n,) [m]
    axis : int
    sign : float
        1: rays come from where the coordinate is high; -1: from where it is low.
    low, high : (d - 1,) [m]
        Where the rays are, along the other axes.
    """
    across = [k for k in range(positions.shape[1]) if k != axis]
    spacing = float(radii.min()) / RAYS
    away = np.abs(positions[:, across] - 0.5 * (low + high))
    near = (away <= 0.5 * (high - low) + radii[:, None]).all(axis=1)
    along = sign * positions[:, axis]
    # the outermost layers are no thicker than this
    near &= along > along[near].max(initial=-math.inf) - LAYERS * 2.0 * float(radii.max())
    ids = np.flatnonzero(near)
    hits = np.zeros(len(ids))
    lines = []
    for first, last in zip(low, high, strict=True):
        count = max(1, math.ceil((last - first) / spacing))
        lines.append(first + (np.arange(count) + 0.5) / count * (last - first))
    for ray in np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, len(across)):
        reach = radii[ids] ** 2 - ((positions[ids][:, across] - ray) ** 2).sum(axis=1)
        met = np.flatnonzero(reach > 0.0)
        if len(met):
            hits[met[np.argmax(along[ids[met]] + np.sqrt(reach[met]))]] += 1.0
    found = np.flatnonzero(hits)
    return ids[found], hits[found] / max(hits.sum(), 1.0)


RAYS = 3.0
"""Per smallest radius."""

LAYERS = 4.0
"""Largest diameters in which the outermost particles of a flat or a slightly curved face are found."""
