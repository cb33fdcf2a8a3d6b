"""Meshes as they are read: materials, sizes and named boundaries of every kind of file."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.mesh_body import MeshBody
from geodem.builders.mesh_reading import read_mesh
from geodem.errors import InputError
from tests.builders.mesh_files import CUBE, FOUR, SQUARE, square, write_msh

# three columns 1, 2 and 3 m wide, 2 m high: areas 2, 4 and 6 m2
COLUMNS = [(x, y) for y in (0.0, 2.0) for x in (0.0, 1.0, 3.0, 6.0)]
QUADS = [(k, k + 1, k + 5, k + 4) for k in range(3)]
NAMES = [(2, 1, "sand"), (2, 2, "clay"), (2, 3, "rock"), (1, 4, "base"), (1, 5, "top")]
LINES = [("line", (k, k + 1), 4) for k in range(3)] + [("line", (k + 5, k + 4), 5) for k in range(3)]


def columns(path):
    halves = [("triangle", t, k + 1) for k, (a, b, c, d) in enumerate(QUADS) for t in ((a, b, c), (a, c, d))]
    return write_msh(path, COLUMNS, [*LINES, *halves], NAMES)


def converted(folder, name):
    """The columns in another file, written by meshio, or by gmsh where meshio does not keep the names."""
    source = columns(folder / "columns.msh")
    path = folder / name
    if path.suffix == ".vtu":
        import meshio

        mesh = meshio.read(source)
        kept = {"material": mesh.cell_data["gmsh:physical"]}
        meshio.write(path, meshio.Mesh(mesh.points, mesh.cells, cell_data=kept))
        return path
    from geodem.builders.mesh_gmsh import gmsh_session

    with gmsh_session(path) as gmsh:
        gmsh.merge(str(source))
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.option.setNumber("Mesh.Binary", float("binary" in name))
        gmsh.write(str(path))
    return path


@pytest.mark.parametrize("name", ["text.msh", "binary.msh", "columns.inp", "columns.vtk", "columns.vtu"])
def test_materials_and_sizes_of_every_kind_of_file(tmp_path, name):
    """What is in the file does not depend on how it is written."""
    vtk = name[-4:] in (".vtk", ".vtu")
    given = {1: "sand", 2: "clay", 3: "rock"} if vtk else None
    mesh = read_mesh(converted(tmp_path, name), names=given)
    assert dict(zip(mesh.materials, mesh.sizes, strict=True)) == pytest.approx(
        {"sand": 2.0, "clay": 4.0, "rock": 6.0}
    )
    assert len(mesh.cells) == 6
    assert len(mesh.nodes) == 8
    if not vtk:
        assert set(mesh.groups) == {"base", "top"}
        surfaces = {surface.name: surface.corners for surface in MeshBody(mesh).surfaces}
        assert surfaces["base"][..., 1].max() == 0.0
        assert surfaces["top"][..., 1].min() == 2.0
        assert len(surfaces["rest"]) == 2


def test_version_two_is_read_alike(tmp_path):
    first, second = read_mesh(columns(tmp_path / "2.msh")), read_mesh(converted(tmp_path, "4.msh"))
    assert (first.nodes == second.nodes).all()
    assert (first.cells == second.cells).all()
    assert first.groups == second.groups


def test_what_was_assumed_is_said(tmp_path):
    assert read_mesh(columns(tmp_path / "c.msh")).remarks == (
        "No length_unit was given, so coordinates are metres: the ground is 6 m by 2 m.",
    )
    assert read_mesh(columns(tmp_path / "c.msh"), length_unit=0.1).remarks == ()


def test_unit_scales_the_coordinates(tmp_path):
    mesh = read_mesh(columns(tmp_path / "c.msh"), length_unit=0.001)
    assert mesh.sizes == pytest.approx([2e-6, 4e-6, 6e-6])


def test_groups_without_names_are_numbered(tmp_path):
    mesh = read_mesh(square(tmp_path / "s.msh", group=7, names=()))
    assert mesh.materials == ("group 7",)
    assert any("'group 7'" in remark for remark in mesh.remarks)
    assert read_mesh(square(tmp_path / "s.msh", group=7, names=()), names={7: "till"}).materials == ("till",)


def test_quadrilaterals_are_split_and_stay_one_element(tmp_path):
    elements = [("quad", corners, k + 1) for k, corners in enumerate(QUADS)]
    mesh = read_mesh(write_msh(tmp_path / "q.msh", COLUMNS, elements, NAMES[:3]))
    assert mesh.sizes == pytest.approx([2.0, 4.0, 6.0])
    assert mesh.cell_element.tolist() == [0, 0, 1, 1, 2, 2]
    assert mesh.unjoined == 0


@pytest.mark.parametrize(
    ("kind", "corners", "volume", "cells"),
    [
        ("tetra", (0, 1, 3, 4), 1 / 6, 1),
        ("hexahedron", tuple(range(8)), 1.0, 6),
        ("wedge", (0, 1, 2, 4, 5, 6), 0.5, 3),
        ("pyramid", (0, 1, 2, 3, 4), 1 / 3, 2),
    ],
)
@pytest.mark.parametrize("seed", range(3))
def test_solid_elements_are_split(tmp_path, kind, corners, volume, cells, seed):
    """Whatever the numbers of the nodes; volumes by hand."""
    new = np.random.default_rng(seed).permutation(8)
    nodes = np.empty((8, 3))
    nodes[new] = CUBE
    element = (kind, new[list(corners)].tolist(), 1)
    mesh = read_mesh(write_msh(tmp_path / "e.msh", nodes.tolist(), [element], [(3, 1, "rock")]))
    assert mesh.sizes == pytest.approx([volume])
    assert (mesh.cell_sizes > 0.0).all()
    assert len(mesh.cells) == cells
    assert not any("inverted" in remark for remark in mesh.remarks)


def test_hexahedra_share_the_sides_of_their_tetrahedra(tmp_path):
    """Two cubes: boundary of 10 squares, none inside."""
    nodes = [(float(x), float(y), float(z)) for x in range(3) for y in (0, 1) for z in (0, 1)]
    number = {node: k for k, node in enumerate(nodes)}
    elements = [
        ("hexahedron", [number[(k + x, y, z)] for x, y, z in CUBE], 1 + k) for k in (0, 1)
    ]  # fmt: skip
    mesh = read_mesh(write_msh(tmp_path / "h.msh", nodes, elements, [(3, 1, "a"), (3, 2, "b")]))
    assert mesh.sizes == pytest.approx([1.0, 1.0])
    assert mesh.unjoined == 0
    corners = mesh.nodes[mesh.facets]
    assert len(corners) == 20
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    assert area.sum() == pytest.approx(10.0)


def test_section_that_stands_upright(tmp_path):
    nodes = [(x, 5.0, z) for x, z in SQUARE]
    mesh = read_mesh(square(tmp_path / "s.msh", nodes=nodes))
    assert mesh.sizes == pytest.approx([4.0])
    assert any("x and z" in remark for remark in mesh.remarks)


def test_nodes_between_corners_are_left_out(tmp_path):
    nodes = [*SQUARE[:3], (1.0, -0.1), (2.0, 1.0), (1.0, 1.0)]
    path = write_msh(tmp_path / "s.msh", nodes, [("triangle6", range(6), 1)], [(2, 1, "clay")])
    mesh = read_mesh(path)
    assert mesh.sizes == pytest.approx([2.0])
    assert len(mesh.nodes) == 3
    assert any("1 elements" in remark and "straight" in remark for remark in mesh.remarks)


def test_flat_stl_is_a_section(tmp_path):
    from tests.builders.mesh_files import write_stl

    corners = np.array([[(*SQUARE[k], 0.0) for k in t] for t in FOUR])
    mesh = read_mesh(write_stl(tmp_path / "plate.stl", corners))
    assert mesh.materials == ("plate",)
    assert mesh.sizes == pytest.approx([4.0])
    assert len(mesh.nodes) == 5


ABAQUS = """*Heading
*Node
1, 0., 0.
2, 1., 0.
3, 1., 1.
4, 0., 1.
5, 2., 0.
6, 2., 1.
*Element, type=CPE4
1, 1, 2, 3, 4
*Element, type=CPE3
2, 2, 5, 6
3, 2, 6, 3
*Elset, elset=left
1
*Elset, elset=right, generate
2, 3, 1
"""


def test_element_sets_name_materials(tmp_path):
    path = tmp_path / "a.inp"
    path.write_text(ABAQUS)
    mesh = read_mesh(path)
    assert mesh.materials == ("left", "right")
    assert mesh.sizes == pytest.approx([1.0, 1.0])


def test_a_block_without_elements_is_passed_over(tmp_path):
    path = tmp_path / "a.inp"
    path.write_text(ABAQUS.replace("*Elset, elset=left", "*Element, type=CPE4\n*Elset, elset=left"))
    assert read_mesh(path).materials == ("left", "right")
    path.write_text(ABAQUS.partition("*Element")[0] + "*Element, type=CPE3\n")
    with pytest.raises(InputError, match=r"no \*ELEMENT in it"):
        read_mesh(path)


def test_sections_name_materials_where_sets_overlap(tmp_path):
    path = tmp_path / "a.inp"
    more = "*Elset, elset=all, generate\n1, 3, 1\n"
    path.write_text(ABAQUS + more + "*Elset, elset=some\n3\n")
    with pytest.raises(InputError, match="do not give each element one material"):
        read_mesh(path)
    path.write_text(ABAQUS + more + "*Solid Section, elset=left, material=Clay\n,\n"
                    "*Solid Section, elset=right, material=Sand\n,\n")  # fmt: skip
    mesh = read_mesh(path)
    assert mesh.materials == ("Clay", "Sand")


def test_first_block_of_an_abaqus_file_without_a_name(tmp_path):
    """The order of *ELEMENT blocks, not of their names, says what is in them."""
    path = tmp_path / "a.inp"
    head = ABAQUS.partition("*Elset")[0].replace("type=CPE3", "type=CPE3, elset=right")
    path.write_text(head + "*Elset, elset=left\n1\n")
    mesh = read_mesh(path)
    assert dict(zip(mesh.materials, mesh.cell_material[[0, 2]], strict=True)) == {"left": 0, "right": 1}
