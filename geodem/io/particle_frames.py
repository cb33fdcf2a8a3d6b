"""Frames of discs or spheres for ParaView and PyVista: particles, contacts, cracks and walls, one VTKHDF file each.

Every kind of file is one animation: its frames have the number of their step in their names, and NAME.vtkhdf.series
beside them lists them with their times. In ParaView, draw the particles as "Point Gaussian" or with the filter "Glyph"
scaled by "radius [m]" (sphere of radius 1).
"""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .files import remove
from .vtkhdf import write_series, write_vtkhdf

if TYPE_CHECKING:
    from geodem.particle_reading import ParticleReading

CONTACT, BONDED, DEBONDED = 0, 1, 2
"""States of a pair: never bonded, bonded, touching after its bond broke."""

KINDS = ("particles", "contacts", "cracks", "walls")


def write_frame(folder: Path | str, simulation: ParticleReading) -> list[Path]:
    """Write a simulation as it is now into a folder; returns the files.

    particles : every particle a point with its radius, number, material, velocity, spin, resultant force and torque,
        orientation where it is kept, and how many of its bonds broke and which share of them.
    contacts : every pair that touches or is bonded a line with its normal force (pressing where positive), shear
        force and state (see `CONTACT`, `BONDED`, `DEBONDED`).
    cracks : every break a point with its mode (1 tension, 2 shear), time and energy; where there are bonds.
    walls : triangles or segments; infinite planes are left out. Where there are such walls.

    In a periodic cell particles are drawn where they lie in it, with its edges, and contacts from their first particle
    on, beyond the face where they lead through one.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    folder, s = Path(folder), simulation
    number = f"{s.steps:09d}"
    writers = {
        "particles": _write_particles, "contacts": _write_contacts, "cracks": _write_cracks, "walls": _write_walls,
    }  # fmt: skip
    found = [writers[kind](folder / f"{kind}-{number}.vtkhdf", s) for kind in _kinds_of(s)]
    for path in found:
        _list_frame(path, s.time)
    return found


def last_whole_frame(folder: Path | str, simulation: ParticleReading) -> int:
    """Step of the last frame of which all files are there and listed; -1 where there is none."""
    steps = [
        {_step(name) for name, _ in _listed(Path(folder) / f"{kind}.vtkhdf.series")}
        for kind in _kinds_of(simulation)
    ]
    return max(set.intersection(*steps), default=-1)


def _kinds_of(s: ParticleReading) -> list[str]:
    """Kinds of files that a frame of a simulation has, in the order in which they are written and then listed."""
    has_faces = any(len(wall.segments) or len(wall.triangles) for wall in s.assembly.walls)
    present = {"particles": True, "contacts": True, "cracks": len(s.assembly.bonds) > 0, "walls": has_faces}
    return [kind for kind in KINDS if present[kind]]


def remove_later_frames(folder: Path | str, step: int) -> None:
    """Take away the frames of later steps, which a resumed run will write again."""
    folder = Path(folder)
    for kind in KINDS:
        series = folder / f"{kind}.vtkhdf.series"
        frames = _listed(series)
        kept = [(name, time) for name, time in frames if _step(name) <= step and (folder / name).is_file()]
        if kept != frames:
            write_series(series, kept)
        for path in folder.glob(f"{kind}-*.vtkhdf"):
            if _step(path.name) > step:
                remove(path)


def damage(simulation: ParticleReading) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Broken bonds (n,) of every particle, and their share of its bonds [-]; 0 where it has none."""
    a = simulation.assembly
    ends = a.bonds.ravel()
    broken = np.bincount(ends, np.repeat(~simulation.intact(), 2), minlength=a.particles).astype(np.int64)
    bonds = np.bincount(ends, minlength=a.particles)
    return broken, broken / np.maximum(bonds, 1)


def _write_particles(path: Path, s: ParticleReading) -> Path:
    a, d = s.assembly, s.dimension
    force = s.forces
    broken, share = damage(s)
    deep = "" if d == 3 else "/m"
    data: dict[str, ArrayLike] = {
        "radius [m]": a.radii,
        "id [-]": np.arange(a.particles),
        "material [-]": a.material,
        "velocity [m/s]": s.velocities,
        "spin [rad/s]": _scalar(s.spins),
        f"force [N{deep}]": force[:, :d],
        f"torque [N m{deep}]": _scalar(force[:, d:]),
        "broken bonds [-]": broken,
        "damage [-]": share,
    }
    if s.features.orientation:
        data["angle [rad]" if d == 2 else "quaternion w, x, y, z [-]"] = _scalar(s.orientations)
    names = ", ".join(a.material_names)
    fields: dict[str, ArrayLike | str] = {"step [-]": np.array([s.steps]), "materials": names}
    places = s.positions
    if s.cell is not None:
        places = s.wrapped_positions()
        fields["cell edges [m]"] = s.cell.vectors
    write_vtkhdf(path, places, point_data=data, field_data=fields, time=s.time)
    return path


def _write_contacts(path: Path, s: ParticleReading) -> Path:
    found = s.contacts()
    normal, shear = s.contact_forces()
    deep = "" if s.dimension == 3 else "/m"
    state = np.where(found.bonded, BONDED, CONTACT)
    n = s.assembly.particles
    first, second = s.assembly.bonds.astype(np.int64).T
    once = np.isin(found.pairs[:, 0] * n + found.pairs[:, 1], first * n + second)
    state[once & ~found.bonded] = DEBONDED
    places, ends = s.positions, found.pairs.reshape(-1, 2)
    if s.cell is not None:
        # points of their own for every line: its second end is an image
        first = s.wrapped_positions()[ends[:, 0]]
        places = np.stack([first, first + s.contact_branches()], axis=1).reshape(-1, s.dimension)
        ends = np.arange(len(places)).reshape(-1, 2)
    write_vtkhdf(
        path,
        places,
        ends,
        cell_data={
            f"normal force [N{deep}]": normal,
            f"shear force [N{deep}]": shear,
            "overlap [m]": found.overlap,
            "state [-]": state.astype(np.uint8),
        },
        time=s.time,
    )
    return path


def _write_cracks(path: Path, s: ParticleReading) -> Path:
    found = s.broken_bonds()
    data: dict[str, ArrayLike] = {
        "mode [-]": found.mode.astype(np.uint8),
        "time [s]": found.time,
        "bond [-]": found.bond,
    }
    if s.features.energy:
        data["energy [J]" if s.dimension == 3 else "energy [J/m]"] = found.energy
    write_vtkhdf(path, found.place, point_data=data, time=s.time)
    return path


def _write_walls(path: Path, s: ParticleReading) -> Path:
    bounded = s.walls.kind > 0
    corners = s.walls.corners_now()[bounded]
    count = 2 if s.dimension == 2 else 3
    points = corners[:, :count].reshape(-1, 3)
    cells = np.arange(len(points)).reshape(-1, count)
    forces = s.walls.forces()[s.walls.body[bounded]]
    deep = "" if s.dimension == 3 else "/m"
    write_vtkhdf(
        path, points, cells, time=s.time, field_data={"walls": ", ".join(s.walls.names)},
        cell_data={"wall [-]": s.walls.body[bounded], f"force on the whole wall [N{deep}]": forces},
    )  # fmt: skip
    return path


def _scalar(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values[:, 0] if values.shape[1] == 1 else values


def _list_frame(path: Path, time: float) -> None:
    series = path.with_name(f"{path.name.split('-')[0]}.vtkhdf.series")
    frames = dict(_listed(series)) | {path.name: time}
    write_series(series, sorted(frames.items(), key=lambda frame: _step(frame[0])))


def _listed(series: Path) -> list[tuple[str, float]]:
    """Frames of a series file; none where it is missing or no such file."""
    try:
        files = json.loads(series.read_text(encoding="utf-8"))["files"]
        return [(str(file["name"]), float(file["time"])) for file in files]
    except (OSError, ValueError, KeyError, TypeError):
        return []


def _step(name: str) -> int:
    found = re.search(r"-(\d+)\.vtkhdf$", name)
    return int(found[1]) if found else -1
