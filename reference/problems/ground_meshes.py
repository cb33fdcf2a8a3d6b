"""Ground from meshes, geometry and closed surfaces: sizes and masses, and the hole of P14 on nodes and filled in."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.body import Body
from geodem.builders.body_filling import add_body
from geodem.builders.fill_body import fill_body
from geodem.builders.from_mesh import body_from_mesh, particles_from_mesh, section_from_mesh
from geodem.builders.mesh_gmsh import gmsh_session
from geodem.builders.mesh_reading import read_mesh
from geodem.builders.packings import volumes
from geodem.builders.particles import Particles, fill_section
from geodem.integrators.direct_solve import solve_elastic

from .ground_elastic import boundary_traction, ground, kirsch_stress, material, polar
from .rows import Row, relative

Floats = NDArray[np.float64]

SIZE_BOUND = 0.005
DENSITY = {"bedrock": 2600.0, "seam": 1800.0, "soil": 1900.0, "rock": 2650.0, "block": 2700.0}
"""[kg/m3]"""
LAYERS = {
    "bedrock": [(0.0, 0.0), (40.0, 0.0), (40.0, 9.0), (0.0, 5.0)],
    "seam": [(0.0, 5.0), (40.0, 9.0), (40.0, 10.0), (0.0, 6.0)],
    "soil": [(0.0, 6.0), (40.0, 10.0), (40.0, 20.0), (25.0, 20.0), (10.0, 10.0), (0.0, 10.0)],
}
"""A slope over an inclined seam of 1 m [m]."""
HALF = 4.0
"""Half the side of the plate around the hole [m]; the hole's radius is 1 m."""


def layers_geo(size: float) -> str:
    """A .geo text of `LAYERS`, with elements of `size` [m]."""
    corners = list(dict.fromkeys(corner for outline in LAYERS.values() for corner in outline))
    lines = [f"Point({k + 1}) = {{{x}, {y}, 0, {size}}};" for k, (x, y) in enumerate(corners)]
    drawn: dict[tuple[int, int], int] = {}
    for number, (name, outline) in enumerate(LAYERS.items(), start=1):
        loop = []
        for first, second in zip(outline, [*outline[1:], outline[0]], strict=True):
            a, b = corners.index(first) + 1, corners.index(second) + 1
            if (b, a) in drawn:
                loop.append(-drawn[b, a])
                continue
            drawn[a, b] = len(drawn) + 1
            lines.append(f"Line({drawn[a, b]}) = {{{a}, {b}}};")
            loop.append(drawn[a, b])
        lines.append(f"Curve Loop({number}) = {{{', '.join(map(str, loop))}}};")
        lines.append(f"Plane Surface({number}) = {{{number}}};")
        lines.append(f'Physical Surface("{name}") = {{{number}}};')
    lines.append('Physical Curve("base") = {1};')
    return "\n".join(lines) + "\n"


def write_layers(path: Path, size: float, version: float) -> Path:
    """A .msh file of `LAYERS`, by gmsh."""
    geo = path.with_suffix(".geo")
    geo.write_text(layers_geo(size))
    with gmsh_session(geo) as gmsh:
        gmsh.merge(str(geo))
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(path))
    return path


def write_tunnel_block(path: Path) -> float:
    """A STEP file of a block of 20 m with a round tunnel of 3 m radius through it; its volume [m3]."""
    with gmsh_session(path) as gmsh:
        occ = gmsh.model.occ
        block = occ.addBox(0.0, 0.0, 0.0, 20.0, 20.0, 20.0)
        tube = occ.addCylinder(10.0, 0.0, 10.0, 0.0, 20.0, 0.0, 3.0)
        occ.cut([(3, block)], [(3, tube)])
        occ.synchronize()
        gmsh.write(str(path))
    return 20.0**3 - math.pi * 3.0**2 * 20.0


def write_stl(path: Path, corners: Floats) -> Path:
    """A binary .stl file of triangles (f, 3, 3) [m]."""
    facets = np.zeros(len(corners), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    facets["corners"] = corners
    path.write_bytes(b" " * 80 + np.uint32(len(corners)).tobytes() + facets.tobytes())
    return path


def egg(count: int) -> tuple[Floats, float]:
    """Triangles (f, 3, 3) [m] of the hull of points on an ellipsoid, 12 m long, and its volume [m3] by qhull."""
    from scipy.spatial import ConvexHull

    # evenly spread: a golden spiral
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, math.pi * (1.0 + math.sqrt(5.0)) * k
    wide = np.sqrt(1.0 - z * z)
    points = np.stack([wide * np.cos(angle), wide * np.sin(angle), z], axis=1) * [6.0, 5.0, 4.0]
    hull = ConvexHull(points.astype(np.float32).astype(np.float64))
    corners = hull.points[hull.simplices]
    outwards = (
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * hull.equations[:, :3]
    ).sum(1)
    return np.where(outwards[:, None, None] > 0.0, corners, corners[:, ::-1]), float(hull.volume)


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


def hole_geo(fine: float, coarse: float) -> str:
    """A .geo text of a plate with a hole of 1 m radius, elements of `fine` at the hole and `coarse` outside [m]."""
    ring = [(1, 0), (0, 1), (-1, 0), (0, -1)]
    rim = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)]
    lines = ["Point(1) = {0, 0, 0};"]
    lines += [f"Point({k + 2}) = {{{x}, {y}, 0, {fine}}};" for k, (x, y) in enumerate(ring)]
    lines += [f"Point({k + 6}) = {{{HALF * x}, {HALF * y}, 0, {coarse}}};" for k, (x, y) in enumerate(rim)]
    lines += [f"Circle({k + 1}) = {{{k + 2}, 1, {(k + 1) % 4 + 2}}};" for k in range(4)]
    lines += [f"Line({k + 5}) = {{{k + 6}, {(k + 1) % 8 + 6}}};" for k in range(8)]
    lines += ["Curve Loop(1) = {1:4};", "Curve Loop(2) = {5:12};", "Plane Surface(1) = {2, 1};"]
    lines += [
        'Physical Surface("rock") = {1};',
        'Physical Curve("tunnel") = {1:4};',
        'Physical Curve("far") = {5:12};',
    ]
    return "\n".join(lines) + "\n"


def hole(folder: Path, *, fine: float = 0.04, coarse: float = 0.25) -> list[Row]:
    """P14 on the nodes of a graded mesh, and with particles that `fill_section` fills in."""
    path = folder / "hole.geo"
    path.write_text(hole_geo(fine, coarse))
    started = time.perf_counter()
    mesh = read_mesh(path)
    on_nodes = particles_from_mesh(mesh)
    seconds = time.perf_counter() - started
    rows = hole_rows("P14 on the nodes of a graded mesh", on_nodes, seconds)
    started = time.perf_counter()
    ground_section = section_from_mesh(mesh)
    ring = shapely.LineString(ground_section.regions[0].polygon.interiors[0])
    filled = fill_section(
        ground_section,
        spacing=0.8 * coarse,
        refine=[(ring, fine)],
        grading=0.12,
        points=[(1, 0), (0, 1), (-1, 0), (0, -1)],
    )
    return rows + hole_rows("P14 filled in", filled, time.perf_counter() - started)


def hole_rows(name: str, filled: Particles, seconds: float) -> list[Row]:
    """Stresses around the hole under 10 MPa horizontally and 30 MPa vertically: Kirsch 1898.

    The outer sides carry the tractions of the exact solution, so that the size of the plate does not matter.
    """
    started = time.perf_counter()
    positions = filled.positions

    def exact(points: Floats) -> Floats:
        return kirsch_stress(points, 1.0, -10e6, -30e6)

    outer: NDArray[np.bool_] = np.asarray((np.abs(positions) > HALF - 1e-9).any(axis=1))
    held = np.zeros((len(positions), 2), dtype=bool)
    # on the axes of symmetry nothing moves across them
    for axis in (0, 1):
        for sign in (-1.0, 1.0):
            end = np.zeros(2)
            end[axis] = sign * HALF
            held[int(np.argmin(np.hypot(*(positions - end).T))), 1 - axis] = True
    model = ground(
        filled, material(young=10e9, poisson=0.25), held=held, load=boundary_traction(filled, outer, exact)
    )
    _, stress = solve_elastic(model, model.load)
    found = model.particle_mean(stress)
    seconds += time.perf_counter() - started
    r = np.hypot(*positions.T)
    rows = []
    for where, spot, axis, value in (("side", (1.0, 0.0), 1, 80e6), ("crown", (0.0, 1.0), 0, 0.0)):
        at = int(np.argmin(np.hypot(*(positions - spot).T)))
        error = (-found[at, axis] - value) / 80e6
        rows.append(
            Row(name, f"sigma_theta at the {where} wall [Pa], error over 80 MPa", -found[at, axis], value, error, 0.1,
                seconds, "Kirsch 1898")
        )  # fmt: skip
    around = (r >= 1.25) & (r <= 0.95 * HALF)
    error = float(np.abs(found[around] - exact(positions[around])).max())
    rows.append(
        Row(name, "worst stress error from 1.25 a on, over 30 MPa", error, 0.0, error / 30e6, 0.03, seconds,
            "Kirsch 1898")
    )  # fmt: skip
    near = around & (r <= 3.0) & (np.abs(positions[:, 1]) < 0.1 * r)
    own, wanted = (
        polar(found[near], positions[near])[:, :2],
        polar(exact(positions[near]), positions[near])[:, :2],
    )
    for column, symbol in enumerate(("sigma_r", "sigma_theta")):
        off = own[:, column] / wanted[:, column] - 1.0
        worst = int(np.argmax(np.abs(off)))
        rows.append(
            relative(name, f"{symbol} along the horizontal axis, 1.25 a to 3 a, the worst [Pa]",
                     -own[worst, column], -wanted[worst, column], 0.03, seconds, "Kirsch 1898")
        )  # fmt: skip
    return rows


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
    """Every source, the hole both ways and the large volume."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return [
            *section(folder),
            *step_volume(folder),
            *stl_body(folder),
            *hole(folder),
            *many_spheres(folder),
        ]
