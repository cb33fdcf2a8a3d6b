"""From meshes to particles on nodes, particles in elements, sections and walls."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from geodem.boundaries import walls
from geodem.builders.fill_body import fill_body
from geodem.builders.from_mesh import (
    element_particles,
    particles_from_mesh,
    section_from_mesh,
    walls_from_body,
)
from geodem.builders.ground import held_freedoms
from geodem.builders.mesh_body import MeshBody
from geodem.builders.mesh_reading import read_mesh
from geodem.builders.particles import fill_section
from geodem.errors import InputError
from geodem.integrators.direct_solve import solve_elastic
from reference.problems.ground_elastic import boundary_traction
from tests import meshes
from tests.builders.mesh_files import CUBE, FOUR, SQUARE, square, write_msh

GRADED = """
Point(1) = {0, 0, 0, 0.5}; Point(2) = {4, 0, 0, 0.5}; Point(3) = {4, 3, 0, 0.5}; Point(4) = {0, 3, 0, 0.5};
Point(5) = {1, 1, 0, 0.1}; Point(6) = {2, 1, 0, 0.1}; Point(7) = {2, 2, 0, 0.1}; Point(8) = {1, 2, 0, 0.1};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 8}; Line(8) = {8, 5};
Curve Loop(1) = {1:4}; Curve Loop(2) = {5:8}; Plane Surface(1) = {1, 2}; Plane Surface(2) = {2};
Physical Surface("clay") = {1}; Physical Surface("pillar") = {2}; Physical Curve("top") = {3};
"""


@pytest.fixture(scope="module")
def graded(tmp_path_factory):
    path = tmp_path_factory.mktemp("graded") / "g.geo"
    path.write_text(GRADED)
    return read_mesh(path)


def test_particles_stand_on_the_nodes(graded):
    particles = particles_from_mesh(graded)
    assert sorted(map(tuple, particles.positions)) == sorted(map(tuple, graded.nodes))
    assert particles.materials == ("clay", "pillar")
    corners = particles.positions[particles.triangles]
    area = 0.5 * np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    assert np.bincount(particles.triangle_material, area) == pytest.approx([11.0, 1.0])
    start, end = (particles.positions[particles.boundary_edges[:, k]] for k in (0, 1))
    # shoelace formula: the ground on the left of its boundary
    assert 0.5 * (start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]).sum() == pytest.approx(12.0)
    assert 0.3 < particles.spacing < 0.6
    assert particles.messages == ()


def test_uniform_stress_passes_through_a_graded_mesh(graded):
    """Patch test: a uniform stress on the sides is met by the same stress in every particle."""
    particles = particles_from_mesh(graded)
    stress = np.array([-2e6, -5e6, 0.0])
    held = held_freedoms(particles, {"left": "roller", "bottom": "roller"})
    high = particles.positions.max(axis=0) - 1e-9
    outer = (particles.positions > high).any(axis=1)
    load = boundary_traction(particles, outer, lambda points: np.tile(stress, (len(points), 1)))
    stiff = meshes.soil(c=1e12, young=1e9)
    model = meshes.model(
        particles.positions, particles.triangles, [stiff, stiff], material=particles.triangle_material,
        load=load, held=held, unit_weight=0.0,
    )  # fmt: skip
    _, found = solve_elastic(model, model.load)
    assert model.particle_mean(found) == pytest.approx(np.tile(stress, (model.particles, 1)), abs=1e-3)


def test_sharp_triangles_are_told(tmp_path):
    nodes = [*SQUARE[:4], (1.0, 0.05)]
    particles = particles_from_mesh(read_mesh(square(tmp_path / "s.msh", nodes=nodes)))
    assert len(particles.messages) == 1
    assert particles.messages[0].startswith("1 triangles have an angle below 10 deg")


@pytest.mark.parametrize("make", [particles_from_mesh, section_from_mesh])
def test_parts_meshed_apart_and_volumes_are_refused(tmp_path, make):
    nodes = [*SQUARE, (2.0, 1.0), (4.0, 0.0), (4.0, 2.0)]
    mesh = read_mesh(
        square(tmp_path / "s.msh", nodes=nodes, triangles=[*FOUR, (1, 6, 5), (6, 7, 5), (7, 2, 5)])
    )
    with pytest.raises(InputError, match="Mesh all surfaces at once"):
        make(mesh)
    path = write_msh(tmp_path / "h.msh", CUBE, [("hexahedron", range(8), 1)], [(3, 1, "rock")])
    with pytest.raises(InputError, match="this is a volume"):
        make(read_mesh(path))


def test_section_has_the_outlines_of_the_materials(graded):
    section = section_from_mesh(graded)
    assert section.materials == ("clay", "pillar")
    clay, pillar = (region.polygon for region in section.regions)
    pillar_wanted = shapely.box(1, 1, 2, 2)
    assert pillar.symmetric_difference(pillar_wanted).area == pytest.approx(0.0, abs=1e-12)
    assert clay.symmetric_difference(shapely.box(0, 0, 4, 3) - pillar_wanted).area == pytest.approx(
        0.0, abs=1e-12
    )
    assert len(pillar.exterior.coords) == 5
    filled = fill_section(section, particles=300)
    corners = filled.positions[filled.triangles]
    area = 0.5 * np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    assert np.bincount(filled.triangle_material, area) == pytest.approx([11.0, 1.0])


def test_thin_layer_is_told_in_the_filling(tmp_path):
    """A seam of 0.1 m with discs every 0.1 m: half of it may be lost, and that is said."""
    levels = [0.0, 1.0, 1.1, 2.0]
    nodes = [(x, y) for y in levels for x in (0.0, 4.0)]
    elements = [("quad", (2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2), 1 + k) for k in range(3)]
    names = [(2, 1, "rock"), (2, 2, "seam"), (2, 3, "soil")]
    body = MeshBody(read_mesh(write_msh(tmp_path / "s.msh", nodes, elements, names)))
    filling = fill_body(body, arrangement="hexagonal", radius=0.06)
    said = " ".join(filling.remarks)
    assert "seam is about" in said
    assert "particles across" in said
    off = filling.shares[1].difference
    assert abs(off) > 0.005
    assert f"seam stand for {100.0 * off:+.2f} % of its size" in said
    assert f"{100.0 * off:+.3f}" in filling.summary()


@pytest.mark.parametrize("ratio", [1.0, 0.8])
def test_one_disc_in_each_element(graded, ratio):
    filling = element_particles(graded, radius_ratio=ratio)
    assert filling.particles == len(graded.cells)
    assert filling.positions == pytest.approx(graded.nodes[graded.cells].mean(axis=1))
    mass = filling.density({"clay": 1800.0, "pillar": 2400.0}) * np.pi * filling.radii**2
    assert np.bincount(filling.material, mass) == pytest.approx([1800.0 * 11.0, 2400.0 * 1.0])
    assert mass == pytest.approx(graded.cell_sizes * np.array([1800.0, 2400.0])[graded.cell_material])
    assert [share.represented for share in filling.shares] == pytest.approx([11.0, 1.0])


def test_one_sphere_in_a_hexahedron(tmp_path):
    path = write_msh(tmp_path / "h.msh", CUBE, [("hexahedron", range(8), 1)], [(3, 1, "rock")])
    filling = element_particles(read_mesh(path))
    assert filling.positions == pytest.approx(np.full((1, 3), 0.5))
    assert 4.0 / 3.0 * np.pi * filling.radii**3 == pytest.approx([1.0])
    with pytest.raises(InputError, match="not a positive number"):
        element_particles(read_mesh(path), radius_ratio=0.0)


def test_named_parts_of_the_boundary_are_walls(graded):
    body = MeshBody(graded)
    top, rest = walls_from_body(body)
    assert (top.name, rest.name) == ("top", "rest")
    assert (top.segments[..., 1] == 3.0).all()
    length = np.linalg.norm(np.diff(np.concatenate([top.segments, rest.segments]), axis=1), axis=2).sum()
    assert length == pytest.approx(14.0)
    (lid,) = walls_from_body(body, ["top"], velocity=(0.0, -0.1), contact={"friction_coefficient": 0.0})
    assert lid.velocity.tolist() == [0.0, -0.1]
    assert lid.contact == {"friction_coefficient": 0.0}
    with pytest.raises(InputError, match=r"no surface 'lid'.*'top', 'rest'"):
        walls_from_body(body, ["lid"])


def test_facets_in_any_order():
    ends = np.array([[(0.0, 0.0), (1.0, 0.0)], [(3.0, 0.0), (4.0, 1.0)]])
    assert walls.facets("two", ends).segments.tolist() == ends.tolist()
    corner = np.array([[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]])
    assert walls.facets("one", corner).triangles.tolist() == corner.tolist()
    with pytest.raises(InputError, match="are no triangles"):
        walls.facets("bad", np.zeros((2, 3)))
