"""A specimen between two grips: started from the solved elastic state, then moved at a quasi-static rate.

The grips are the particles nearest to the end faces: driven along the axis, free across it, so that the ends are
smooth. They hold in tension as in compression, without platens, glue or bedding errors.

The start is no shock: the elastic state at a share of the load at which the first bond breaks is solved for, and the
motion goes on from there with the velocities of the solution. Masses are of no account in a quasi-static test, so
every particle gets one that makes its own frequency the same (the same total): the step is a third longer.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..builders.assembly_builder import AXES, AssemblyBuilder
from ..errors import InputError
from ..integrators.elastic_network import NetworkSolver
from ..integrators.network import build_network
from ..particle_network import touching_links
from ..particle_simulation import ParticleSimulation
from ..particle_statics import displace
from .confinement import Confinement, joined_to_most
from .material import BondedMaterial
from .pace import LOOKS
from .record import Cracks
from .specimen import Specimen
from .start import go_to_first_break

Floats = NDArray[np.float64]

GRIP = 1.0
"""Thickness of a grip over the mean diameter."""

DAMPING = 0.7
"""Cundall's local damping: energy that breaking bonds set free does not travel far."""

STEP = 0.7
"""Share of the critical time step."""

FIRST_SHARE = 0.8
"""Share of the load of the first break at which the motion begins."""

TRIAL_STRAIN = 1e-6
"""Axial strain at which the bonds are looked at to find the load of the first break."""

FARTHEST = 0.05
"""Axial strain beyond which a specimen is no longer itself: what has not broken before counts as unbreakable."""

GAUGE = 0.7
"""Share of the length and width, in the middle, over which strains are measured."""

REFRESH = 100
"""Steps between looks at what the pressure acts on."""


Prepare = Callable[[AssemblyBuilder], object]
"""What is done to a specimen before it is built."""


class Rig:
    """A specimen ready to be loaded along its axis.

    Parameters
    ----------
    specimen : Specimen
    material : BondedMaterial
    confinement : float
        Pressure on the sides [Pa].
    time_share : float
        Of the critical time step [-].
    seed : int
        Of the scatter of bond strengths.
    prepare : callable, optional
        Is given the builder when everything is bonded and held: to cut joints through the specimen, for instance.

    Raises
    ------
    InputError
        The material's parameters are out of range, the grips meet, or the bonds do not hold the specimen together.
    """

    def __init__(
        self,
        specimen: Specimen,
        material: BondedMaterial,
        *,
        confinement: float = 0.0,
        time_share: float = STEP,
        seed: int = 1,
        prepare: Prepare | None = None,
    ) -> None:
        material.check()
        self.specimen = specimen
        self.material = material
        self.confinement = confinement
        d = self.dimension = specimen.dimension
        positions, radii = specimen.positions, specimen.radii
        along = positions[:, -1]
        thick = GRIP * specimen.diameter
        self.lower = np.flatnonzero(along < thick)
        self.upper = np.flatnonzero(along > specimen.height - thick)
        if 3.0 * thick > specimen.height:
            raise InputError(
                "specimen, height", "the grips meet: the specimen is shorter than three particles",
                "Make it higher, or the particles smaller", value=specimen.height,
            )  # fmt: skip
        build = AssemblyBuilder(d, contact_law=material.contact_law, bond_law=material.bond_law)
        build.add_material(
            material.name, density=material.density, contact=material.contact, bond=material.bond
        )
        heavy = material.density * even_density(radii, d)
        build.add_particles(positions, radii, material.name, density=heavy)
        build.bond_within(material.bonding_range, scale=material.scatter(seed))
        for ids in (self.lower, self.upper):
            build.hold(ids, **{AXES[d - 1]: 0.0})
        if prepare is not None:
            prepare(build)
        self.sides = Confinement(float(along.min()), float(along.max()), float(radii.min()), d)
        if confinement:
            # the place of the forces is looked up again and again
            load = confinement * self.sides.loads(positions, radii, np.ones(len(radii), bool))
            build.apply(np.arange(len(radii)), force=load[:, :d], torque=load[:, d:])
        # whether pressed on the sides or not: both share one kernel, whose compilation takes longer than a test
        self.simulation = s = ParticleSimulation(
            build.build(), local_damping=DAMPING, orientation=False, applied=True
        )
        s.time_step = s.span = time_share * s.critical_time_step
        self.start = s.positions
        self.length = float(along[self.upper].mean() - along[self.lower].mean())
        middle = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
        reach = 0.5 * GAUGE * (positions.max(axis=0) - positions.min(axis=0))
        self.gauge = np.flatnonzero((np.abs(positions - middle) <= reach).all(axis=1))
        self._refuse_loose()
        self._solved = False

    def _refuse_loose(self) -> None:
        joined = joined_to_most(self.simulation)
        loose = int((~joined).sum())
        if not joined[self.lower].any() or not joined[self.upper].any() or loose > 0.05 * len(joined):
            raise InputError(
                "specimen, bonding_range", f"{loose} particles are bonded to nothing that reaches both ends",
                "Bond from farther apart: 1.05 for a dense packing", value=self.material.bonding_range,
            )  # fmt: skip

    # ------------------------------------------------------------------ elastic

    def solve(self) -> None:
        """Solve for the elastic states of a unit strain along the axis and of a unit pressure on the sides."""
        s, d = self.simulation, self.dimension
        ids = s.arrays.ids
        links = touching_links(s)
        network = build_network(np.ascontiguousarray(s.now[:, s.columns.position]), links)
        held = np.array(s.assembly.held[ids])
        joined = joined_to_most(s)
        solver = NetworkSolver(network, held=held | ~joined[ids][:, None] | self._pinned(joined)[ids])
        shape = held.shape
        upper = np.zeros(len(ids), dtype=bool)
        upper[self.upper] = True
        given = np.zeros(shape)
        given[upper[ids], d - 1] = -self.length
        self.squeezed = np.empty(shape)
        self.squeezed[ids] = solver.solve(np.zeros(shape), prescribed=given)
        self.pressed = np.zeros(shape)
        stiffness = solver.matrix

        def resultant(motion: Floats, load: Floats) -> float:
            force = (stiffness @ motion[ids].ravel()).reshape(shape) - load
            return -float(force[upper[ids], d - 1].sum()) / self.specimen.area

        nothing = np.zeros(shape)
        self.modulus = resultant(self.squeezed, nothing)
        if self.confinement:
            load = self.sides.loads(self.start, self.specimen.radii, joined)[ids]
            self.pressed[ids] = solver.solve(load)
            # strain at which the axis is under the pressure of the sides
            self.even = (1.0 - resultant(self.pressed, load)) / self.modulus
        else:
            self.even = 0.0
        self._solved = True

    def _pinned(self, joined: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Freedoms (n, d + s), held for a solve, that keep the specimen in place across the axis.

        Nothing pushes it there and it does not turn: they bear no force, and the solution is unique.
        """
        found = np.zeros_like(self.simulation.assembly.held)
        along = np.where(joined[self.lower], self.start[self.lower, 0], math.nan)
        first, last = self.lower[np.nanargmin(along)], self.lower[np.nanargmax(along)]
        found[first, : self.dimension - 1] = True
        if self.dimension == 3:
            found[last, 1] = True
        return found

    def elastic_constants(self) -> tuple[float, float]:
        """Young's modulus [Pa] and Poisson's ratio of the middle, from the solved state (2D: of a plate)."""
        if not self._solved:
            self.solve()
        strain = self._gradient(self.squeezed[:, : self.dimension])
        axial, lateral = strain[-1, -1], np.diag(strain)[:-1].mean()
        return self.modulus / -axial, -lateral / axial

    def _gradient(self, displacement: Floats) -> Floats:
        """Displacement gradient (d, d), row: component of the displacement; by least squares over the gauge."""
        places = self.start[self.gauge]
        places = np.column_stack([places - places.mean(axis=0), np.ones(len(places))])
        found, *_ = np.linalg.lstsq(places, displacement[self.gauge], rcond=None)
        return np.asarray(found[: self.dimension].T)

    def begin(self, rate: float, *, share: float = FIRST_SHARE) -> None:
        """Go to the elastic state at `share` of the load of the first break and set everything in motion.

        Parameters
        ----------
        rate : float
            Axial strain per step [-]; positive: compression.
        share : float
            Of the strength of the bond that breaks first [-].
        """
        self.approach(math.copysign(1.0, rate), share=share)
        self.set_in_motion(rate)

    def approach(self, sign: float, *, share: float = FIRST_SHARE) -> None:
        """Go to the elastic state at `share` of the load of the first break, in compression (1) or tension (-1)."""
        if not self._solved:
            self.solve()
        s = self.simulation
        p = self.confinement
        if p:
            displace(s, p * (self.pressed + self.even * self.squeezed))
        strain = go_to_first_break(s, sign * self.squeezed, TRIAL_STRAIN, share, farthest=FARTHEST).multiple
        self.first_break = strain / share
        self.strain = sign * strain

    def set_in_motion(self, rate: float) -> None:
        """Give everything the velocities that the solved state changes with at this strain per step."""
        s = self.simulation
        self.drive(rate)
        speed = rate / s.time_step * self.squeezed
        held = s.assembly.held
        motion = np.where(held, np.hstack([s.velocities, s.spins]), speed)[s.arrays.ids]
        for rows in s.rows:
            rows[:, s.columns.velocity] = motion[:, : self.dimension]
            rows[:, s.columns.spin] = motion[:, self.dimension :]

    def drive(self, rate: float) -> None:
        """Move the grips towards each other by a strain per step, half of it each."""
        s = self.simulation
        axis = s.columns.velocity.start + self.dimension - 1
        for ids, sign in ((self.upper, -0.5), (self.lower, 0.5)):
            at = np.isin(s.arrays.ids, ids)
            for rows in s.rows:
                rows[at, axis] = sign * rate * self.length / s.time_step
        self.rate = rate

    # ------------------------------------------------------------------ motion

    def advance(self, steps: int) -> None:
        """Move on, and look where the pressure acts now and then."""
        s = self.simulation
        if not self.confinement:
            s.run(steps)
            return
        while steps > 0:
            self.refresh()
            part = min(REFRESH, steps)
            s.run(part)
            steps -= part

    def refresh(self) -> None:
        """Let the pressure act on what lies outermost now."""
        s = self.simulation
        found = self.sides.loads(s.positions, self.specimen.radii, joined_to_most(s))
        s.arrays.applied[:] = self.confinement * found[s.arrays.ids]

    def axial_stress(self) -> float:
        """Mean of the stresses at both grips [Pa]."""
        force = self.simulation.forces[:, self.dimension - 1]
        return 0.5 * float(force[self.upper].sum() - force[self.lower].sum()) / self.specimen.area

    def axial_strain(self) -> float:
        """Of the distance of the grips."""
        along = self.simulation.positions[:, -1]
        return 1.0 - float(along[self.upper].mean() - along[self.lower].mean()) / self.length

    def gauge_strain(self) -> tuple[float, float]:
        """Axial strain, and mean strain across, in the middle; positive in compression."""
        gradient = self._gradient(self.simulation.positions - self.start)
        return -float(gradient[-1, -1]), -float(np.diag(gradient)[:-1].mean())


def even_density(radii: Floats, dimension: int) -> Floats:
    """Factors (n,) on the density that make every particle's frequency the same; the total mass stays.

    The stiffness of its bonds goes with the radius to the power d - 2, so its mass must too.
    """
    factor = 1.0 / radii**2
    volume = radii**dimension
    return np.asarray(factor * volume.sum() / (factor * volume).sum())


Watch = Callable[[float, float, float], None]
"""Is told the strain, the stress, and the steps over those to the expected peak, now and then."""


class Motion:
    """Curves of a rig in motion, look by look.

    Parameters
    ----------
    rig : Rig
    sign : float
        1 compression, -1 tension: what is recorded is positive either way.
    """

    NAMES = (
        "steps", "axial_strain", "gauge_axial", "gauge_lateral", "axial_stress", "tension_cracks", "shear_cracks",
        "unbalanced_ratio",
    )  # fmt: skip

    def __init__(self, rig: Rig, sign: float) -> None:
        self.rig = rig
        self.sign = sign
        self.rows: list[tuple[float, ...]] = []
        self.top = -math.inf
        self.look()

    def look(self) -> float:
        """Take down where everything is; the stress."""
        rig, sign = self.rig, self.sign
        s = rig.simulation
        stress, strain = sign * rig.axial_stress(), sign * rig.axial_strain()
        axial, lateral = rig.gauge_strain()
        modes = s.record[: len(s.assembly.bonds), 0]
        self.rows.append(
            (
                s.steps, strain, sign * axial, sign * lateral, stress, int((modes == 1).sum()),
                int((modes == 2).sum()), s.unbalanced_ratio(),
            )
        )  # fmt: skip
        self.top = max(self.top, stress)
        return stress

    def until_failure(
        self, *, every: int, fall: float, longest: float, floor: float = 0.0, watch: Watch | None = None
    ) -> tuple[bool, str]:
        """Move until the load has fallen behind a peak; whether it has, and why the test ended.

        Parameters
        ----------
        every : int
            Steps between looks.
        fall : float
            Share of the peak, counted from `floor`, at which the test ends.
        longest : float
            Strain at which it ends without failure.
        floor : float
            Stress that stays whatever breaks: the pressure on the sides [Pa].
        """
        while True:
            self.rig.advance(every)
            stress = self.look()
            strain = self.rows[-1][1]
            if watch is not None:
                watch(strain, stress, (len(self.rows) - 1) / LOOKS)
            if self.top > floor and stress - floor < fall * (self.top - floor):
                return True, f"the load has fallen to {stress / self.top:.0%} of its peak"
            if strain > longest:
                return False, f"no failure up to an axial strain of {longest:.2%}"

    def curves(self) -> dict[str, Floats]:
        """By name."""
        return dict(zip(self.NAMES, np.array(self.rows, dtype=float).T, strict=True))


def seen_cracks(rig: Rig, steps: Floats, stress: Floats) -> Cracks:
    """The rig's cracks with the stress at which each was made."""
    s = rig.simulation
    found = s.broken_bonds()
    pairs = s.assembly.bonds[found.bond]
    apart = rig.start[pairs[:, 1]] - rig.start[pairs[:, 0]]
    size = np.sqrt((apart**2).sum(axis=1, keepdims=True))
    radii = rig.specimen.radii
    at = np.interp(found.step, steps, stress) if len(steps) else np.zeros(len(pairs))
    return Cracks(found.place, found.mode, apart / size, 2.0 * np.minimum(*radii[pairs].T), at)
