"""Ground from meshes, geometry and closed surfaces: sizes and masses, and the hole of P14 on nodes and filled in."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import shapely

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.body import Body
from geodem.builders.body_filling import add_body
from geodem.builders.fill_body import fill_body
from geodem.builders.from_mesh import body_from_mesh
from geodem.builders.mesh_gmsh import gmsh_session
from geodem.builders.packings import volumes

from .ground_meshes_hole import fields
from .ground_meshes_picture import draw
from .ground_meshes_sources import LAYERS, egg, write_layers, write_stl, write_tunnel_block
from .rows import Row, relative

SIZE_BOUND = 0.005
DENSITY = {"bedrock": 2600.0, "seam": 1800.0, "soil": 1900.0, "rock": 2650.0, "block": 2700.0}
"""[kg/m3]"""


def sizes_and_masses(
    name: str, body: Body, expected: dict[str, float], *, particles: int, source: str
) -> list[Row]:
    """Size, represented size and mass of every material against the source, for a body filled at random."""
    started = time.perf_counter()
    filling = fill_body(body, particles=particles)
    seconds = time.perf_counter() - started
    build = AssemblyBuilder(body.dimension)
    for found in body.materials:
        build.add_material(
            found,
            density=DENSITY[found],
            contact={"normal_stiffness": 1e8, "shear_stiffness": 1e8, "friction_coefficient": 0.5},
        )
    added = add_body(build, filling, {found: DENSITY[found] for found in body.materials})
    model = build.build()
    mass = np.asarray(model.mass)[added.ids]
    unit, per = ("m2", "kg/m") if body.dimension == 2 else ("m3", "kg")
    rows = []
    for number, found in enumerate(body.materials):
        share = filling.shares[number]
        rows += [
            relative(name, f"{found}: size of the body [{unit}]", float(body.sizes[number]), expected[found],
                     SIZE_BOUND, seconds, source),
            relative(name, f"{found}: size that its particles stand for [{unit}]", share.represented,
                     expected[found], SIZE_BOUND, seconds, source),
            relative(name, f"{found}: mass of its particles [{per}]", float(mass[filling.material == number].sum()),
                     DENSITY[found] * expected[found], SIZE_BOUND, seconds, source),
        ]  # fmt: skip
    return rows


def section(folder: Path, particles: int = 8000) -> list[Row]:
    """Three materials in .msh 2 and 4: areas of the polygons that were drawn."""
    expected = {name: float(shapely.Polygon(outline).area) for name, outline in LAYERS.items()}
    rows = []
    for version in (2.2, 4.1):
        body = body_from_mesh(write_layers(folder / f"layers-{version:g}.msh", 1.0, version))
        rows += sizes_and_masses(
            f"section, .msh {version:g}", body, expected, particles=particles, source="areas of the polygons"
        )
    return rows


def step_volume(folder: Path, particles: int = 20_000) -> list[Row]:
    """A block with a tunnel from a STEP file in millimetres."""
    path = folder / "rock.step"
    expected = write_tunnel_block(path)
    body = body_from_mesh(path, size=1.2, names={1: "rock"})
    return sizes_and_masses(
        "volume, .step", body, {"rock": expected}, particles=particles, source="20^3 - pi 3^2 20 m3"
    )


def stl_body(folder: Path, particles: int = 20_000) -> list[Row]:
    """What an .stl file encloses."""
    corners, volume = egg(2000)
    body = body_from_mesh(write_stl(folder / "block.stl", corners))
    return sizes_and_masses("body, .stl", body, {"block": volume}, particles=particles, source="qhull")


def many_spheres(folder: Path, particles: int = 200_000) -> list[Row]:
    """A volume of tetrahedra filled with 200,000 spheres; the seconds are those of reading and filling."""
    step, path = folder / "large.step", folder / "large.msh"
    volume = write_tunnel_block(step)
    with gmsh_session(step) as gmsh:
        gmsh.model.occ.importShapes(str(step))
        gmsh.model.occ.synchronize()
        gmsh.model.addPhysicalGroup(3, [tag for _, tag in gmsh.model.getEntities(3)], name="rock")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.9)
        gmsh.model.mesh.generate(3)
        gmsh.write(str(path))
    started = time.perf_counter()
    filling = fill_body(body_from_mesh(path), particles=particles)
    seconds = time.perf_counter() - started
    name = "volume, .msh, many spheres"
    return [
        relative(name, "spheres", filling.particles, particles, 0.01, seconds, "as asked for"),
        relative(name, "volume that they stand for [m3]",
                 float(volumes(filling.radii, 3).sum()) / filling.solid_fraction, volume, SIZE_BOUND, seconds,
                 "20^3 - pi 3^2 20 m3"),
        Row(name, "seconds to read and fill, over 120 s", seconds, 120.0, seconds / 120.0, 1.0, seconds, "wanted"),
    ]  # fmt: skip


def run() -> Sequence[Row]:
    """Every source, the hole both ways and the large volume; draws the hole."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found, around_hole = fields(folder)
        draw(found)
        return [
            *section(folder),
            *step_volume(folder),
            *stl_body(folder),
            *around_hole,
            *many_spheres(folder),
        ]
