"""A user's script that goes on where there is a checkpoint: a bonded block that breaks on a floor, recorded.

``python -m reference.problems.interruptions_particles FOLDER``
"""

from __future__ import annotations

import sys
from pathlib import Path

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.packings import lattice
from geodem.errors import InputError, StoppedError
from geodem.particle_recorder import Recorder
from geodem.particle_simulation import ParticleSimulation

LAST = 3000


def falling_block() -> ParticleSimulation:
    """Thirty discs in bonds, thrown onto a floor."""
    builder = AssemblyBuilder(2, bond_law="two_springs", gravity=(0.0, -9.81))
    contact = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
    strength = {"tensile_strength": 3e3, "cohesion": 3e3, "width_ratio": 0.8}
    builder.add_material("rock", density=2000.0, contact=contact, bond={**contact, **strength})
    places = lattice("hexagonal", 0.1, cells=(6, 5)).positions
    builder.add_particles(places - places.min(axis=0) + 0.11, 0.1, "rock", velocity=(0.0, -0.8))
    builder.bond_within(1.01)
    builder.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0)))
    return ParticleSimulation(builder.build(), local_damping=0.1, energy=True)


def main() -> None:
    """Run, or go on."""
    folder = Path(sys.argv[1])
    checkpoint = folder / "checkpoint.h5"
    simulation = ParticleSimulation.resume(checkpoint) if checkpoint.is_file() else falling_block()
    recorder = Recorder(
        simulation, folder, history_every=20, frame_every=500, checkpoint_seconds=0.02, show=False
    )
    recorder.run_to(LAST)


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    except StoppedError as error:
        print(error, file=sys.stderr)
        sys.exit(3)
