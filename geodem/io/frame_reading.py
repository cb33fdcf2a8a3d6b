"""Frames of particles, read back: what was written for ParaView is there for a script, too."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Floats = NDArray[np.float64]


class ParticleFrame(NamedTuple):
    """Discs or spheres at a moment.

    Attributes
    ----------
    step : int
    positions : (n, d) [m]
    radii : (n,) [m]
    material : (n,) int32
    velocities : (n, d) [m/s]
    """

    step: int
    positions: Floats
    radii: Floats
    material: NDArray[np.int32]
    velocities: Floats


def frame_paths(folder: Path | str) -> list[Path]:
    """Frames of particles in a folder, in the order of their steps."""
    return sorted(Path(folder).glob("particles-*.vtkhdf"))


def read_frame(path: Path | str, *, dimension: int = 2) -> ParticleFrame:
    """One of the files that `geodem.io.particle_frames.write_frame` writes.

    Raises
    ------
    InputError
        There is no such file, or it is damaged.
    """
    import h5py

    try:
        with h5py.File(path) as file:
            root = file["VTKHDF"]
            data = root["PointData"]
            return ParticleFrame(
                int(Path(path).stem.split("-")[-1]),
                np.asarray(root["Points"], dtype=np.float64)[:, :dimension],
                np.asarray(data["radius [m]"], dtype=np.float64),
                np.asarray(data["material [-]"], dtype=np.int32),
                np.asarray(data["velocity [m per s]"], dtype=np.float64)[:, :dimension],
            )
    except (OSError, KeyError, ValueError) as error:
        raise InputError(
            str(path), f"this is no frame of particles ({error})", "Run the case again."
        ) from error
