"""geodem itself on a posed scene."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geodem._jit import compile_seconds
from geodem._version import __version__
from geodem.particle_simulation import ParticleSimulation

from .posed import Floats, PairForces, Posed, State, Trajectory, about_z, sorted_pairs, three


def run_posed(posed: Sequence[Posed]) -> list[Trajectory]:
    """geodem's own runs of posed scenes."""
    return [_run(one) for one in posed]


def handed_over(posed: Posed, state: State) -> Posed:
    """The same scene from the state at which another code stood; its steps are counted from there."""
    a = posed.assembly
    if a.dimension != 3:
        raise ValueError("only states of spheres are handed over")
    assembly = replace(a, positions=state.positions, velocities=state.velocities, spins=state.spins)
    before = posed.first - 1
    return replace(posed, assembly=assembly, steps=posed.steps - before, first=1, memory=state.memory)


def _run(posed: Posed) -> Trajectory:
    a = posed.assembly
    begun = time.perf_counter()
    simulation = ParticleSimulation(
        a,
        time_step=posed.time_step,
        local_damping=posed.local_damping,
        orientation=False,
        convention=posed.convention,
    )
    if posed.memory is not None:
        memory = posed.memory
        if memory.spring is not None and "stiffness_before" in simulation.layout.contact:
            # the force of a spring of 1 N/m
            simulation.hand_over(
                memory.pairs, shear=-memory.spring, stiffness_before=np.ones(len(memory.pairs))
            )
        else:
            simulation.hand_over(memory.pairs, shear=memory.shear)
    wanted = set(posed.frames if posed.pairs_at is None else posed.pairs_at)
    frames: list[tuple[Floats, ...]] = []
    found: list[PairForces] = []
    loop = 0.0
    simulation.kernel(simulation.features)
    for number, step in enumerate(posed.frames):
        start, compiled = time.perf_counter(), compile_seconds()
        simulation.run(step - simulation.steps)
        loop += time.perf_counter() - start if compile_seconds() == compiled else math.nan
        frames.append(_frame(simulation))
        if step in wanted:
            found.append(_pairs(simulation, number))
    positions, velocities, spins, forces, torques, walls = (
        np.array(part) for part in zip(*frames, strict=True)
    )
    broken = simulation.broken_bonds()
    return Trajectory(
        code="geodem", version=__version__, law=f"{a.contact_law}, {a.bond_law}", steps=np.array(posed.frames),
        positions=positions, velocities=velocities, spins=spins, forces=forces, torques=torques,
        wall_forces=walls.reshape(len(frames), len(a.walls), 3),
        pair_forces=_joined(found),
        broken=_broken(posed, broken.bond, broken.step),
        seconds=time.perf_counter() - begun,
        loop_seconds=loop,
    )  # fmt: skip


def _frame(simulation: ParticleSimulation) -> tuple[Floats, ...]:
    """Positions, velocities, spins, forces, torques, forces on walls, in three components."""
    d, forces = simulation.dimension, simulation.forces
    return (
        three(simulation.positions), three(simulation.velocities), about_z(simulation.spins),
        three(forces[:, :d]), about_z(forces[:, d:]),
        three(np.array([simulation.wall_force(w.name) for w in simulation.assembly.walls]).reshape(-1, d)),
    )  # fmt: skip


def _pairs(simulation: ParticleSimulation, number: int) -> PairForces:
    """Shear forces of the last step; normal forces, without dashpots, at the positions of the frame."""
    contacts = simulation.contacts()
    n = len(contacts.pairs)
    shear = np.zeros((n, 3))
    history = contacts.history
    if simulation.dimension == 3 and "shear_x" in history:
        own = np.stack([history[f"shear_{axis}"] for axis in "xyz"], axis=1)
        bond = (
            np.stack([history[f"bond.shear_{axis}"] for axis in "xyz"], axis=1)
            if "bond.shear_x" in history
            else own
        )
        shear = np.where(contacts.bonded[:, None], bond, own)
    positions = three(simulation.positions)
    apart = positions[contacts.pairs[:, 1]] - positions[contacts.pairs[:, 0]]
    along = apart / np.sqrt((apart**2).sum(axis=1))[:, None]
    normal, across = simulation.contact_forces()
    if simulation.dimension == 2:
        shear = three(across)
    return sorted_pairs(np.full(n, number), contacts.pairs, -normal[:, None] * along, shear, along)


def _joined(found: list[PairForces]) -> PairForces | None:
    if not found:
        return None
    return PairForces(
        *(
            np.concatenate([getattr(one, name) for one in found])
            for name in ("frame", "pairs", "normal", "shear", "along")
        )
    )


def _broken(posed: Posed, bond: np.ndarray, step: np.ndarray) -> tuple[tuple[int, int, int], ...]:
    """Pairs, and the step of the first frame that shows the break."""
    frames = np.array(posed.frames)
    rows = []
    for k, at in zip(bond, step, strict=True):
        first, second = sorted(map(int, posed.assembly.bonds[k]))
        rows.append((first, second, int(frames[np.searchsorted(frames, at + 1)])))
    return tuple(sorted(rows, key=lambda row: (row[2], row[0], row[1])))
