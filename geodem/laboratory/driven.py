"""A specimen some of whose particles are driven and others loaded: what splitting, bending and shear have in common.

A drive is a number in metres. Driven particles move by their share of it along the axes that they are held along and
are free along the others. The load is the force that does the work of the drive, so it is the mean of what opposite
grips feel. As in `geodem.laboratory.rig` the motion begins from the solved elastic state, without a shock.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..builders.assembly_builder import AXES, AssemblyBuilder
from ..builders.close_pairs import close_pairs
from ..errors import InputError
from ..integrators.elastic_network import NetworkSolver
from ..integrators.network import build_network
from ..measure.region_stress import stress_in_region
from ..particle_network import touching_links
from ..particle_simulation import ParticleSimulation
from ..particle_statics import displace
from . import pace as paces
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
    firm : (n,) bool, optional
        Particles whose bonds to one another hold, whatever they bear: those of grips.
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
        firm: Mask | None = None,
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
        self._bond(build, firm, seed)
        for axis in range(d):
            if self.driven[:, axis].any():
                build.hold(self.driven[:, axis], **{AXES[axis]: 0.0})
        if load is not None:
            build.apply(np.arange(len(radii)), force=load)
        self.simulation = s = ParticleSimulation(build.build(), local_damping=DAMPING, orientation=False)
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

    def _bond(self, build: AssemblyBuilder, firm: Mask | None, seed: int) -> None:
        material, specimen = self.material, self.specimen
        scale = material.scatter(seed)
        if firm is None:
            build.bond_within(material.bonding_range, scale=scale)
            return
        pairs, _ = close_pairs(
            specimen.positions, specimen.radii, lambda a, b: material.bonding_range * (a + b), None
        )
        factors = np.full(len(pairs), scale) if isinstance(scale, float) else scale.factors(len(pairs))
        factors[firm[pairs].all(axis=1)] = FIRM
        build.bond(pairs, scale=factors)

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
        """
        if not self._solved:
            self.solve()
        s = self.simulation
        if self.load is not None:
            displace(s, self.loaded)
        size = float(self.specimen.size.max())
        found = go_to_first_break(s, self.unit, TRIAL_STRAIN * size, share, farthest=FARTHEST * size)
        self.first_break = found / share
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

FIRM = 1e6
"""Factor on the strength of bonds that hold."""

Reading = Callable[[Driven], float]
"""One more column of the curves."""


class Course:
    """Curves of a drive, look by look.

    Parameters
    ----------
    driven : Driven
    per_force : float
        What the load counts as over its force [Pa/N].
    more : dict of str to Reading
        Further columns by name.
    """

    def __init__(self, driven: Driven, per_force: float, more: dict[str, Reading] | None = None) -> None:
        self.driven = driven
        self.per_force = per_force
        self.more = more or {}
        self.rows: list[tuple[float, ...]] = []
        self.top = -math.inf
        self.look()

    def look(self) -> float:
        """Take down where everything is; the stress."""
        driven = self.driven
        s = driven.simulation
        force = driven.force()
        modes = s.record[: len(s.assembly.bonds), 0]
        self.rows.append(
            (
                s.steps, driven.displacement(), force, self.per_force * force, int((modes == 1).sum()),
                int((modes == 2).sum()), s.unbalanced_ratio(), *(read(driven) for read in self.more.values()),
            )
        )  # fmt: skip
        self.top = max(self.top, force)
        return force

    def until_failure(
        self, *, every: int, fall: float, longest: float, beyond: float = 0.0, watch: Watch | None = None
    ) -> tuple[bool, str]:
        """Move until the load has fallen to `fall` of its peak and the drive is `beyond` [m]; whether it has, and why.

        Parameters
        ----------
        every : int
            Steps between looks.
        longest : float
            Drive at which it ends without failure [m].
        """
        fallen = False
        while True:
            self.driven.simulation.run(every)
            force = self.look()
            way = self.rows[-1][1]
            if watch is not None:
                watch(way, self.per_force * force)
            fallen = fallen or (self.top > 0.0 and force < fall * self.top)
            if fallen and way >= beyond:
                return True, f"the load has fallen to {force / self.top:.0%} of its peak"
            if way > longest:
                return False, f"no failure up to a displacement of {1e3 * longest:.3g} mm"

    def curves(self) -> dict[str, Floats]:
        """By name."""
        names = (
            "steps", "displacement", "force", "axial_stress", "tension_cracks", "shear_cracks", "unbalanced_ratio",
            *self.more,
        )  # fmt: skip
        return dict(zip(names, np.array(self.rows, dtype=float).T, strict=True))


Watch = Callable[[float, float], None]
"""Is told the displacement and the stress now and then."""


@dataclass(frozen=True, eq=False)
class Driving:
    """How a drive is carried out.

    Attributes
    ----------
    per_force : float
        Stress over force [Pa/N].
    high : float
        Particles that a wave passes on its way through the specimen.
    overshoot : float
        Displacement at the peak over that of the first break, at a guess.
    share : float
        Displacement at the peak over that of the fast pilot's.
    fall : float
        Share of the peak at which the test ends.
    beyond : float
        It goes on until the displacement is this many times that at the peak [-].
    """

    per_force: float
    high: float
    overshoot: float
    share: float
    fall: float
    beyond: float = 0.0


@dataclass(frozen=True, eq=False)
class Carried:
    """What came of a drive.

    Attributes
    ----------
    driven : Driven
        At the end.
    curves : dict of str to (k,)
    failed : bool
    reason : str
    steps : int
        Of the pilot too.
    top : int
        Place of the peak in the curves.
    rate : float
        Drive per step [m].
    """

    driven: Driven
    curves: dict[str, Floats]
    failed: bool
    reason: str
    steps: int
    top: int
    rate: float


def carry_out(
    mounted: Callable[[], Driven],
    driving: Driving,
    *,
    pace: float,
    expected: float | None = None,
    more: dict[str, Reading] | None = None,
    watch: Watch | None = None,
) -> Carried:
    """Drive a specimen past its peak.

    Parameters
    ----------
    mounted : callable
        Makes it anew.
    driving : Driving
    pace : float
        See `geodem.laboratory.pace`.
    expected : float, optional
        Displacement at the peak [m]; a fast pilot finds it where it is left out.
    more : dict of str to Reading
        Further columns of the curves.

    Raises
    ------
    InputError
        A pace that is none, or as of `Driven`.
    """
    if not (math.isfinite(pace) and pace > 0.0):
        raise InputError("pace", "these are no steps per particle", f"Give {paces.PACE:g}", value=pace)
    steps = 0
    if not paces.sound(expected):
        driven = mounted()
        driven.solve()
        driven.begin(0.0)
        guess = driving.overshoot * driven.first_break
        pilot, _, _ = _driven_by(mounted, driving, guess, paces.PILOT, None, None)
        steps = pilot.driven.simulation.steps
        curves = pilot.curves()
        expected = driving.share * float(curves["displacement"][np.argmax(curves["force"])])
    assert expected is not None
    course, failed, reason = _driven_by(mounted, driving, expected, pace, more, watch)
    curves = course.curves()
    s = course.driven.simulation
    rate = paces.rate_of(expected, driving.high, pace)
    return Carried(
        course.driven, curves, failed, reason, steps + s.steps, int(np.argmax(curves["force"])), rate
    )


def _driven_by(
    mounted: Callable[[], Driven],
    driving: Driving,
    expected: float,
    pace: float,
    more: dict[str, Reading] | None,
    watch: Watch | None,
) -> tuple[Course, bool, str]:
    driven = mounted()
    rate = paces.rate_of(expected, driving.high, pace)
    driven.begin(rate)
    course = Course(driven, driving.per_force, more)
    failed, reason = course.until_failure(
        every=paces.looks_every(expected, rate), fall=driving.fall, longest=paces.LONGEST * expected,
        beyond=driving.beyond * expected, watch=watch,
    )  # fmt: skip
    return course, failed, reason
