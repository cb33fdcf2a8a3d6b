"""Particles and boundaries of a body that nothing has moved yet, for ParaView and PyVista."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .builders.body import Surface
from .builders.body_filling import BodyFilling
from .errors import InputError
from .io.vtkhdf import write_vtkhdf

NAMES = "surfaces"
"""Field of the names, one a line."""


def write_particles(path: Path, filling: BodyFilling, density: NDArray[np.float64]) -> None:
    """Every particle a point with its radius, material, density [kg/m3] and grain.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    write_vtkhdf(
        path,
        filling.positions,
        point_data={
            "radius [m]": filling.radii,
            "material [-]": filling.material,
            "density [kg per m3]": density,
            "grain [-]": filling.group,
        },
        field_data={"materials": ", ".join(filling.materials)},
        time=0.0,
    )


def write_surfaces(path: Path, surfaces: Sequence[Surface]) -> None:
    """Every facet a line or a triangle with the number of its boundary; raises as `write_particles`."""
    corners = np.concatenate([surface.corners for surface in surfaces])
    d = corners.shape[1]
    write_vtkhdf(
        path,
        corners.reshape(-1, d),
        np.arange(len(corners) * d).reshape(-1, d),
        cell_data={"boundary [-]": np.repeat(np.arange(len(surfaces)), [len(s.corners) for s in surfaces])},
        field_data={NAMES: "\n".join(surface.name for surface in surfaces)},
        time=0.0,
    )


def read_surfaces(path: Path) -> tuple[Surface, ...]:
    """What `write_surfaces` wrote.

    Raises
    ------
    InputError
        The file is damaged.
    """
    import h5py

    try:
        with h5py.File(path) as file:
            root = file["VTKHDF"]
            points = np.asarray(root["Points"], dtype=np.float64)
            owner = np.asarray(root["CellData"]["boundary [-]"])
            names = bytes(root["FieldData"][NAMES][0]).decode().split("\n")
    except (OSError, KeyError) as error:
        raise InputError(
            str(path), f"the file is damaged ({error})", "Make it again: geodem run CASE --overwrite."
        ) from error
    d = len(points) // len(owner)
    corners = points[:, :d].reshape(-1, d, d)
    return tuple(Surface(name, corners[owner == k]) for k, name in enumerate(names))
