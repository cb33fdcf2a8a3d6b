"""What a particle simulation has to do with its periodic cell, and what stress and packing it has: one mix-in class."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .assembly import Assembly
from .boundaries.cell import PeriodicCell
from .boundaries.wall_pairs import WallPairs
from .boundaries.wall_table import WallTable
from .errors import InputError
from .kernels.adapters import HistoryLayout
from .kernels.particle_kernel import Features
from .kernels.wall_geometry import RIGID
from .measure import fabric
from .measure.contact_forces import law_forces
from .measure.stress import stress_of_contacts
from .neighbors import PairList, wrapped
from .particle_network import wall_branches

if TYPE_CHECKING:
    from .particle_layout import Columns, RowArrays
    from .particle_reading import Contacts

Floats = NDArray[np.float64]


class ParticleCell:
    """Control and reading of the periodic cell; stress, strain and packing.

    Stress and strain are positive in tension and extension. In a cell velocities, kinetic energy and damping are those
    of the fluctuations about the motion of the cell.

    Attributes
    ----------
    cell : PeriodicCell or None
    """

    cell: PeriodicCell | None
    assembly: Assembly
    dimension: int
    columns: Columns
    arrays: RowArrays
    pairs: PairList
    wall_pairs: WallPairs
    wall_parameters: Floats
    walls: WallTable
    features: Features
    layout: HistoryLayout
    time_step: float

    if TYPE_CHECKING:
        # of ParticleReading

        @property
        def now(self) -> Floats: ...

        @property
        def positions(self) -> Floats: ...

        def contacts(self) -> Contacts: ...

        def contact_forces(self) -> tuple[Floats, Floats]: ...

        def _touching_pairs(self) -> NDArray[np.int64]: ...

        # of ParticleSimulation

        def _choose_cell_gain(self) -> None: ...

    def _of_cell(self) -> PeriodicCell:
        if self.cell is None:
            raise InputError("cell", "there is no periodic cell", "Call AssemblyBuilder.set_cell")
        return self.cell

    # ------------------------------------------------------------------ control

    def set_strain_rate(self, rate: ArrayLike) -> None:
        """Let the cell deform at a given rate from now on.

        Parameters
        ----------
        rate : float, (d,) or (d, d) float
            [1/s]; extension positive. A number: the same along all axes; d numbers: along each axis, without shear; a
            matrix: the velocity gradient dv_i/dx_j. 0 holds the cell. Entries that are nan keep the control they have.

        Raises
        ------
        InputError
            No cell, no such tensor, or a cell that is not periodic in every direction.
        """
        self._of_cell().set_strain_rate(rate)

    def set_target_stress(self, stress: ArrayLike, *, largest_rate: float, gain: float | None = None) -> None:
        """Let the cell deform so that its stress reaches a target: rate = gain (target - stress), in every step.

        Parameters
        ----------
        stress : float, (d,) or (d, d) float
            [Pa], tension positive. A number or d numbers: normal stresses; shear keeps the control it has. Entries that
            are nan keep theirs too.
        largest_rate : float
            Bound on the rate of every component [1/s].
        gain : float, optional
            [1/(Pa s)]; where left out it follows from the stiffness of all contacts: one step makes good half of the
            error at most. A stress that must be kept up against a rate of another component lags by rate/gain.

        Raises
        ------
        InputError
            As of `set_strain_rate`; a tensor that is not symmetric; a rate or gain that is not positive.
        """
        self._of_cell().set_target_stress(stress, largest_rate=largest_rate, gain=gain)
        self._choose_cell_gain()

    def set_mean_stress(
        self,
        mean: float,
        *,
        largest_rate: float,
        axial: tuple[int, float] | None = None,
        gain: float | None = None,
    ) -> None:
        """Let the cell shrink or swell alike along its axes so that the mean stress reaches a target.

        Parameters
        ----------
        mean : float
            [Pa], tension positive.
        largest_rate, gain : float
            See `set_target_stress`.
        axial : (axis, rate), optional
            This axis has a given rate [1/s]; the others answer: compression at constant mean stress.

        Raises
        ------
        InputError
            As of `set_target_stress`; no such axis.
        """
        self._of_cell().set_mean_stress(mean, largest_rate=largest_rate, axial=axial, gain=gain)
        self._choose_cell_gain()

    # ------------------------------------------------------------------ reading

    def wrapped_positions(self) -> Floats:
        """Centres (n, d) [m] of the images that lie in the cell; `positions` are those of the particles followed."""
        return wrapped(self.positions, self._of_cell().lattice(), self.dimension)

    def seen_positions(self) -> Floats:
        """Where particles are drawn (n, d) [m]: in the cell, where there is one."""
        return self.positions if self.cell is None else self.wrapped_positions()

    def deformation_gradient(self) -> Floats:
        """Of the cell since the start (d, d) [-]."""
        return self._of_cell().deformation_gradient

    def strain(self) -> Floats:
        """Logarithmic strain ln(F F^T)/2 of the cell since the start (d, d) [-], extension positive."""
        gradient = self._of_cell().deformation_gradient
        values, vectors = np.linalg.eigh(gradient @ gradient.T)
        return np.asarray((vectors * (0.5 * np.log(values))) @ vectors.T)

    def stress(self, volume: float | None = None) -> Floats:
        """Mean stress (d, d) [Pa], tension positive: sum of force times branch over the volume.

        Parameters
        ----------
        volume : float, optional
            In a cell left out: the stress of the last step over the volume of the cell, dashpots included, walls not.
            Else the volume [m3] (2D: area [m2]) of all particles: the stress of their contacts and of those with walls
            as they are now, without dashpots.

        Raises
        ------
        InputError
            Neither a cell nor a volume.
        """
        if volume is None:
            if self.cell is None:
                raise InputError("volume", "there is no cell whose volume it would be", "Give m3 (2D: m2)")
            return self.cell.stress
        normal, shear = self.contact_forces()
        branches = self.contact_branches()
        along = branches / np.sqrt((branches**2).sum(axis=1))[:, None]
        forces, ways = self.wall_contact_forces()
        return stress_of_contacts(
            np.concatenate([shear - normal[:, None] * along, forces]),
            np.concatenate([branches, ways]),
            volume,
        )

    def wall_contact_forces(self) -> tuple[Floats, Floats]:
        """Forces of walls on particles where the particles are, dashpots left out, one row a contact.

        Returns
        -------
        force : (k, d) [N]
            On the particle.
        branch : (k, d) [m]
            From its centre to where it touches.
        """
        w, columns, d = self.wall_pairs, self.columns, self.dimension
        which = np.flatnonzero(w.touching > 0)
        if not len(which):
            return np.zeros((0, d)), np.zeros((0, d))
        branch = wall_branches(self, which)
        distance = np.sqrt((branch**2).sum(axis=1))
        if not hasattr(self.features.laws()[0], "reach"):
            # what has parted since the last forces pulls nothing
            pressed = distance < self.now[w.particle[which], self.columns.radius]
            which, branch, distance = which[pressed], branch[pressed], distance[pressed]
        normal = branch / distance[:, None]
        own = self.now[w.particle[which]]
        radius, mass = own[:, columns.radius], own[:, columns.mass]
        known = {
            "overlap": radius - distance, "radius_a": radius, "radius_b": RIGID * radius, "distance": distance,
            "mass_a": mass, "mass_b": RIGID * mass, "time_step": np.full(len(which), self.time_step),
        }  # fmt: skip
        history = w.history[which]
        known |= {name: history[:, k] for k, name in enumerate(self.layout.contact)}
        row = (
            own[:, columns.material].astype(int) * len(self.walls.bodies)
            + self.walls.body[w.primitive[which]]
        )
        found = law_forces(self.features.laws()[0], d, self.wall_parameters[row], known)
        shear = found[:, 1:]
        if d == 2:
            shear = found[:, 1:2] * np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        return shear - found[:, :1] * normal, branch

    def contact_branches(self) -> Floats:
        """Ways (k, d) [m] from the first to the second particle of `contacts`, or to its image."""
        return self._branches(self._touching_pairs())

    def _branches(self, which: NDArray[np.int64]) -> Floats:
        p, position = self.pairs, self.columns.position
        apart = self.now[p.b[which]][:, position] - self.now[p.a[which]][:, position]
        if self.cell is not None:
            apart = apart + self.cell.shifts(p.image[which])
        return np.asarray(apart)

    def fabric_tensor(self) -> Floats:
        """Mean of n_i n_j (d, d) [-] over the contacts between particles, bonds included."""
        branches = self.contact_branches()
        return fabric.fabric_tensor(branches / np.sqrt((branches**2).sum(axis=1))[:, None])

    def coordination_number(self, *, rattlers: bool = True) -> float:
        """Contacts and bonds a particle [-]; without rattlers see `geodem.measure.fabric.coordination_number`."""
        return fabric.coordination_number(self.contacts().pairs, self.assembly.particles, rattlers=rattlers)

    def solid_fraction(self) -> float:
        """Volume of the particles over that of the cell [-]; what overlaps counts twice. Porosity is 1 less this."""
        return fabric.solid_fraction(self.assembly.radii, self.dimension, self._of_cell().volume)
