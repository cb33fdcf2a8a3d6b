"""What a preparation ends with: the sample, how dense and how well connected it is, and whether that was wanted."""

from __future__ import annotations

import io
import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..assembly import Assembly
from ..builders.packings import volumes
from ..errors import InputError
from ..io.files import write_whole
from ..particle_simulation import ParticleSimulation
from .grains import Grains

Floats = NDArray[np.float64]

FORMAT = "geodem-sample"
VERSION = 1

_ARRAYS = ("positions", "radii", "cell", "container", "stress", "pairs")
_NUMBERS = ("porosity", "coordination", "mechanical_coordination", "unbalanced_ratio", "largest_overlap")


@dataclass(frozen=True)
class PreparedSample:
    """Discs or spheres at rest, or as near to it as the preparation came.

    Attributes
    ----------
    positions : (n, d) [m]
    radii : (n,) [m]
    grains : Grains
        With the friction of the preparation.
    cell : (d, d) [m]
        Rows: vectors of the periodic cell; no rows where there is none.
    container : (2, d) [m]
        Corners of the part whose porosity is told: the box, or its middle for a heap; no rows in a cell.
    porosity : float
        Share of pores [-]; what overlaps counts twice. nan where the volume is not known.
    coordination : float
        Contacts of a particle, mean of all particles; contacts with walls count [-].
    mechanical_coordination : float
        The same without particles that hold nothing: again and again those with fewer than d + 1 contacts (2 where
        there is friction) are left out.
    stress : (d, d) [Pa]
        Tension positive; of a heap in a box the mean of the whole, whose porosity is taken to be that of its middle.
        nan where the volume is not known.
    unbalanced_ratio : float
        See `ParticleSimulation.unbalanced_ratio` [-].
    largest_overlap : float
        Over the smaller radius of two particles [-].
    wall_forces : dict of str to (d,)
        Force of the particles on every wall [N].
    pairs : (k, 2) int64
        Particles that touch.
    history : dict of str to (k,) or (k, 3)
        What the contact law remembers of them, for `ParticleSimulation.hand_over`.
    method : str
    target, wanted, got : str, float, float
        What was asked for, how much of it, and what was reached. A sample at rest asks for an unbalanced ratio.
    reached : bool
    reason : str
        Why it ended.
    steps : int
        Steps of motion and of relaxation.
    seconds : float
    seed : int or None
        Of the first positions.
    simulation : ParticleSimulation or None
        Where it ended, to go on with; it is not saved.
    """

    positions: Floats
    radii: Floats
    grains: Grains
    cell: Floats
    container: Floats
    porosity: float
    coordination: float
    mechanical_coordination: float
    stress: Floats
    unbalanced_ratio: float
    largest_overlap: float
    wall_forces: dict[str, Floats]
    pairs: NDArray[np.int64]
    history: dict[str, Floats]
    method: str
    target: str
    wanted: float
    got: float
    reached: bool
    reason: str
    steps: int
    seconds: float
    seed: int | None
    simulation: ParticleSimulation | None = field(default=None, repr=False, compare=False)

    @property
    def dimension(self) -> int:
        """2 for discs, 3 for spheres."""
        return int(self.positions.shape[1])

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self.radii)

    @property
    def solid_fraction(self) -> float:
        """Share of the particles in the volume [-]."""
        return 1.0 - self.porosity

    @property
    def pressure(self) -> float:
        """Mean stress, pressing where positive [Pa]."""
        return 0.0 - float(np.trace(self.stress)) / self.dimension

    def assembly(self, grains: Grains | None = None) -> Assembly:
        """The particles in their cell, at rest, of these grains or others; walls are left to `AssemblyBuilder`.

        Nothing is remembered at the contacts: where there is friction go on with `simulation`, or hand `history` over.
        """
        return (grains or self.grains).assembly(
            self.positions, self.radii, cell=self.cell if len(self.cell) else None
        )

    def summary(self) -> str:
        """One line: what there is, and whether it is what was wanted."""
        what = "discs" if self.dimension == 2 else "spheres"
        verdict = "reached" if self.reached else f"NOT reached ({self.reason})"
        return (
            f"{self.particles:,} {what}, porosity {self.porosity:.4f}, coordination {self.coordination:.3f}, pressure "
            f"{self.pressure:.4g} Pa, unbalanced ratio {self.unbalanced_ratio:.2g}; {self.target} {self.wanted:.6g}: "
            f"{verdict}"
        )

    def save(self, path: Path | str) -> None:
        """Write the sample to an NPZ file, whole or not at all; raises InputError where it cannot be written.

        To go on with the same bits save `simulation` too.
        """
        arrays: dict[str, Any] = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {f"history.{name}": values for name, values in self.history.items()}
        arrays |= {f"wall.{name}": values for name, values in self.wall_forces.items()}
        grains = self.grains
        meta = {
            "format": FORMAT,
            "version": VERSION,
            **{name: getattr(self, name) for name in _NUMBERS},
            **{name: getattr(self, name) for name in ("method", "target", "wanted", "got", "reached", "reason")},
            **{name: getattr(self, name) for name in ("steps", "seconds", "seed")},
            "grains": {
                "density": grains.density, "contact": dict(grains.contact), "contact_law": grains.contact_law,
                "name": grains.name,
            },
        }  # fmt: skip
        arrays["meta"] = np.frombuffer(json.dumps(meta).encode(), dtype=np.uint8)
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **arrays)
        write_whole(path, buffer.getbuffer())

    @classmethod
    def load(cls, path: Path | str) -> PreparedSample:
        """Read what `save` wrote; nothing in the file is executed.

        Raises
        ------
        InputError
            No such file, cut off, or no sample.
        """
        place, remedy = str(path), "Give the file that PreparedSample.save wrote, or prepare the sample again"
        if not Path(path).is_file():
            raise InputError(place, "there is no sample here", remedy)
        try:
            with np.load(path, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            meta = json.loads(arrays.pop("meta").tobytes().decode())
            if meta.pop("format") != FORMAT:
                raise InputError(place, "this is no sample", remedy)
            if meta.pop("version") != VERSION:
                raise InputError(place, "this sample is of another version of geodem", remedy)
            parts: dict[str, dict[str, Floats]] = {"history": {}, "wall": {}}
            for name in [name for name in arrays if "." in name]:
                group, own = name.split(".", 1)
                parts[group][own] = arrays.pop(name)
            grains = Grains(**meta.pop("grains"))
            return cls(**arrays, **meta, grains=grains, history=parts["history"], wall_forces=parts["wall"])
        except InputError:
            raise
        except Exception as error:
            # numpy, zipfile and json each have errors of their own for a damaged file
            raise InputError(place, f"the sample is damaged or cut off ({error})", remedy) from error


def measure_sample(
    simulation: ParticleSimulation,
    grains: Grains,
    *,
    porosity: float,
    container: Floats | None = None,
    **told: Any,
) -> PreparedSample:
    """What can be read off a simulation, as a sample; `told` is what it cannot know."""
    s = simulation
    d = s.dimension
    found = s.contacts()
    pressed = found.overlap > 0.0
    pairs = found.pairs[pressed]
    rows = s.wall_pairs.particle[s.wall_pairs.touching > 0].astype(np.int64)
    on_walls = s.arrays.ids[rows].astype(np.int64)
    radii = np.asarray(s.assembly.radii)
    depth = found.overlap[pressed] / np.minimum(*radii[pairs].T) if len(pairs) else np.zeros(0)
    return PreparedSample(
        positions=s.positions,
        radii=radii.copy(),
        grains=grains,
        cell=np.empty((0, d)) if s.cell is None else np.array(s.cell.vectors),
        container=np.empty((0, d)) if container is None else container,
        porosity=porosity,
        coordination=(2 * len(pairs) + len(on_walls)) / len(radii),
        mechanical_coordination=mechanical_coordination(
            pairs, on_walls, len(radii), d + 1 if grains.friction == 0.0 else 2
        ),
        stress=_stress(s, porosity),
        unbalanced_ratio=s.unbalanced_ratio(),
        largest_overlap=float(depth.max(initial=0.0)),
        wall_forces={wall.name: s.wall_force(wall.name) for wall in s.assembly.walls},
        pairs=pairs,
        history=_history(s, {name: values[pressed] for name, values in found.history.items()}),
        simulation=s,
        **told,
    )


def _history(simulation: ParticleSimulation, columns: dict[str, Floats]) -> dict[str, Floats]:
    """Columns of history by the law's own names, components side by side: as `hand_over` takes them."""
    law, _ = simulation.features.laws()
    found = {}
    for name in (*law.TANGENTIAL, *law.SCALAR, *law.AXIAL):
        parts = [columns[word] for word in (name, *(f"{name}_{axis}" for axis in "xyz")) if word in columns]
        if parts:
            found[name] = parts[0] if len(parts) == 1 else np.stack(parts, axis=1)
    return found


def _stress(simulation: ParticleSimulation, porosity: float) -> Floats:
    """Mean stress (d, d) [Pa] of the cell, or of the volume that the particles have at this porosity."""
    s = simulation
    if s.cell is not None:
        return s.stress()
    if not math.isfinite(porosity):
        return np.full((s.dimension, s.dimension), math.nan)
    solid = float(volumes(np.asarray(s.assembly.radii), s.dimension).sum())
    return s.stress(solid / (1.0 - porosity))


def mechanical_coordination(
    pairs: NDArray[np.int64], on_walls: NDArray[np.int64], particles: int, least: int
) -> float:
    """Mean number of contacts of the particles that remain when those with fewer than `least` are left out [-].

    Leaving one out takes contacts from others, so it is repeated until none is left out; 0 where none remain.
    """
    walls = np.bincount(on_walls, minlength=particles)
    remain = np.ones(particles, dtype=bool)
    while True:
        kept = pairs[remain[pairs].all(axis=1)]
        contacts = np.bincount(kept.ravel(), minlength=particles) + np.where(remain, walls, 0)
        fewer = remain & (contacts < least)
        if not fewer.any():
            return float(contacts[remain].mean()) if remain.any() else 0.0
        remain &= ~fewer
