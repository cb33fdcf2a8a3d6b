"""Rowe's octagonal prism of steel spheres in face-centred packing, as TRUBAL and TPM loaded it.

Large and small layers alternate, each a square grid with its corners cut off; a small layer lies in the hollows of
the large ones. Cundall's sample has 7 layers of 37 and 6 of 24 spheres, Rowe's own 13 of 76 and 12 of 57. An ideal
membrane is stretched between the outer spheres of the large layers: it presses on nothing else, and it keeps these
spheres from turning. The platens are the end layers, moved along z, free across.

The stress ratio is R = sigma1/sigma2 = F1/(A sigma2). F1 is the force on a platen, sigma2 the pressure of the membrane;
A, which the text does not define, is taken to be the area inside the membrane, that is of the octagon through the
centres of the outer spheres. With this area a uniform strain of the whole sample gives Rowe's ratio 2 (1 + f)/(1 - f)
whatever the number of spheres, by virtual work. The axial strain is 2 delta/dh, with the way delta of each platen and
the distance dh of the centres of the end layers.

Sources: the thesis on TPM (New Jersey Institute of Technology), chapter 4, after P. A. Cundall and O. D. L. Strack;
P. W. Rowe (1962), The stress-dilatancy relation for static equilibrium of an assembly of particles in contact, Proc. R.
Soc. 269:500-527; C. Thornton (1979), The conditions for failure of a face-centered cubic array of uniform rigid
spheres, Geotechnique 29:441-459.
"""

from __future__ import annotations

import math
import time
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

Floats = NDArray[np.float64]

DENSITY = 2000.0  # [kg/m3]
STIFFNESS = 1.5e9  # kn = ks [N/m]
RADIUS = 20.0  # [m]; Cui and O'Sullivan take 0.02
PRESSURE = 5e4  # of the membrane [Pa]
FRICTION = 0.12278  # of Rowe's steel: 7 degrees
DAMPING = 0.5  # local [-]


class Layers(NamedTuple):
    """How an octagonal prism is made up."""

    large: int  # layers
    across: int  # spheres across a large layer; a small one has one less
    cut: int  # rows that are cut off at every corner

    @property
    def small(self) -> int:
        """Small layers."""
        return self.large - 1


CUNDALL = Layers(large=7, across=7, cut=2)
ROWE = Layers(large=13, across=10, cut=3)


class Sample(NamedTuple):
    """Spheres of a prism and what acts on them; lengths in radii."""

    places: Floats  # (n, 3)
    layer: NDArray[np.int64]  # (n,), even where large
    membrane: NDArray[np.int64]  # outer spheres of large layers
    exposed: Floats  # (m, 2): area of membrane along x and y that each of them bears, with its sign
    area: float  # of the octagon inside the membrane
    height: float  # between the centres of the end layers


def octagon(across: int, cut: int) -> Floats:
    """Centres (k, 2) of a layer in radii: a square grid, `cut` rows cut off at every corner."""
    step = np.arange(across) - 0.5 * (across - 1)
    x, y = (grid.ravel() for grid in np.meshgrid(step, step, indexing="ij"))
    kept = np.abs(x) + np.abs(y) <= across - 1 - cut + 1e-9
    return 2.0 * np.stack([x[kept], y[kept]], axis=1)


def outline(layer: Floats) -> NDArray[np.int64]:
    """Outer spheres of a layer, those along the sides of the octagon too, in counter-clockwise order."""
    reach = np.abs(layer).max()
    diagonal = np.abs(layer).sum(axis=1)
    outer = np.flatnonzero((np.abs(layer).max(axis=1) > reach - 1e-9) | (diagonal > diagonal.max() - 1e-9))
    return outer[np.argsort(np.arctan2(layer[outer, 1], layer[outer, 0]))]


def prism(layers: Layers) -> Sample:
    """The octagonal prism with its membrane.

    Half of each stretch of membrane to a neighbour is borne by a sphere: its exposed lengths Lx and Ly. Lz is the
    distance of large layers, half of it at the ends, where the membrane is fixed to the platens.
    """
    large, small = octagon(layers.across, layers.cut), octagon(layers.across - 1, layers.cut)
    gap = math.sqrt(2.0)
    sheets = [large if k % 2 == 0 else small for k in range(layers.large + layers.small)]
    places = np.concatenate(
        [np.column_stack([sheet, np.full(len(sheet), gap * k)]) for k, sheet in enumerate(sheets)]
    )
    layer = np.repeat(np.arange(len(sheets)), [len(sheet) for sheet in sheets])
    ring = outline(large)
    corners = large[ring]
    along = np.roll(corners, -1, axis=0) - corners
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)  # of the stretch to the next, times its length
    lengths = 0.5 * (inward + np.roll(inward, 1, axis=0))
    first = np.searchsorted(layer, np.arange(0, len(sheets), 2))
    share = np.full(layers.large, 2.0 * gap)
    share[[0, -1]] = gap
    x, y = corners.T
    return Sample(
        places,
        layer,
        (first[:, None] + ring).ravel(),
        (share[:, None, None] * lengths).reshape(-1, 2),
        0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()),
        gap * (len(sheets) - 1),
    )


class Loading(NamedTuple):
    """A stress-strain curve."""

    strain: Floats
    ratio: Floats
    apart: float  # largest difference of the forces on the two platens up to the peak, over their mean
    overlap: float  # largest of all contacts at the end, over the diameter
    seconds: float

    @property
    def peak(self) -> float:
        """Largest stress ratio."""
        return float(self.ratio.max())

    @property
    def peak_strain(self) -> float:
        """Strain at the largest stress ratio."""
        return float(self.strain[self.ratio.argmax()])


def elastic_strain(radius: float) -> float:
    """Strain of the packing under the confining pressure alone: its modulus along z is sqrt(2) kn/r for ks = kn."""
    return PRESSURE * radius / (math.sqrt(2.0) * STIFFNESS)


def simulation_of(
    sample: Sample,
    *,
    friction: float = FRICTION,
    radius: float = RADIUS,
    speed: float = 0.0,
    damping: float = DAMPING,
    fixed_rotation: bool = True,
) -> ParticleSimulation:
    """The prism with both platens approaching the middle at `speed` [m/s], in equilibrium while they are at rest."""
    builder = AssemblyBuilder(3)
    contact = {
        "normal_stiffness": STIFFNESS,
        "shear_stiffness": STIFFNESS,
        "friction_coefficient": friction,
    }
    builder.add_material("steel", density=DENSITY, contact=contact)
    builder.add_particles(radius * sample.places, radius, "steel")
    force = np.zeros((len(sample.membrane), 3))
    force[:, :2] = PRESSURE * radius**2 * sample.exposed
    builder.apply(sample.membrane, force=force)
    if fixed_rotation:
        builder.hold(sample.membrane, rotation=(0.0, 0.0, 0.0))
    top = sample.layer == sample.layer.max()
    builder.hold(sample.layer == 0, z=speed)
    builder.hold(top, z=-speed)
    simulation = ParticleSimulation(builder.build(), local_damping=damping, buffer=0.02 * radius)
    found = find_equilibrium(simulation, tolerance=1e-8)
    if not found.reached:
        raise RuntimeError(f"the prism does not come to rest: {found.reason}")
    return simulation


def platen_forces(simulation: ParticleSimulation, sample: Sample) -> tuple[float, float]:
    """Forces that press on the lower and the upper platen [N]."""
    along = simulation.forces[:, 2]
    return -float(along[sample.layer == 0].sum()), float(along[sample.layer == sample.layer.max()].sum())


def load(
    sample: Sample,
    *,
    to: float,
    steps: int,
    points: int = 400,
    friction: float = FRICTION,
    radius: float = RADIUS,
    damping: float = DAMPING,
    fixed_rotation: bool = True,
) -> Loading:
    """Strain a prism axially by `to` in about `steps` steps and read the stress ratio at `points` strains."""
    started = time.perf_counter()
    posed = partial(
        simulation_of,
        sample,
        friction=friction,
        radius=radius,
        damping=damping,
        fixed_rotation=fixed_rotation,
    )
    time_step = posed().time_step
    height = radius * sample.height
    speed = 0.5 * to * height / (steps * time_step)
    simulation = posed(speed=speed)
    each = max(1, steps // points)
    scale = sample.area * radius**2 * PRESSURE
    strain, forces = [0.0], [platen_forces(simulation, sample)]
    most = 0.0
    for _ in range(points):
        simulation.run(each)
        strain.append(2.0 * speed * simulation.time / height)
        forces.append(platen_forces(simulation, sample))
        most = max(most, sum(forces[-1]))
        if sum(forces[-1]) < 0.5 * most:  # it has fallen apart: forces of the membrane do not follow it
            break
    both = np.array(forces)
    mean = both.mean(axis=1)
    until = int(mean.argmax()) + 1
    return Loading(
        np.array(strain),
        mean / scale,
        float(np.abs(np.diff(both, axis=1)[:until, 0] / mean[:until]).max()),
        float(simulation.contacts().overlap.max(initial=0.0) / (2.0 * radius)),
        time.perf_counter() - started,
    )


def theory(friction: Any) -> Any:
    """Stress ratio at failure of the lattice without bounds, Rowe and Thornton: 2 (1 + f)/(1 - f)."""
    return 2.0 * (1.0 + friction) / (1.0 - friction)


def uniform_strain(strain: Floats, friction: float) -> Floats:
    """Stress ratio at a uniform axial strain, rigid spheres, membrane forces as at the start: 2 tan(beta + phi).

    beta is the elevation of the contacts between layers, 45 degrees at the start: sin(beta) = sin(45) (1 - strain).
    """
    beta = np.arcsin(math.sqrt(0.5) * (1.0 - strain))
    return 2.0 * np.tan(beta + math.atan(friction))
