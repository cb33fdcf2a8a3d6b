"""What is wrong with a mesh: each defect is repaired and told, or refused with its place."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.mesh_gmsh import gmsh_session
from geodem.builders.mesh_reading import read_mesh
from geodem.errors import InputError
from tests.builders.mesh_files import CUBE, FOUR, SQUARE, cube_facets, square, write_msh, write_stl


def told(mesh, words):
    """The one remark that has these words."""
    found = [remark for remark in mesh.remarks if words in remark]
    assert len(found) == 1, mesh.remarks
    return found[0]


def test_inverted_elements_are_turned_over(tmp_path):
    mesh = read_mesh(square(tmp_path / "s.msh", triangles=[FOUR[0], FOUR[1][::-1], FOUR[2], FOUR[3]]))
    assert (mesh.cell_sizes > 0.0).all()
    assert mesh.sizes == pytest.approx([4.0])
    assert told(mesh, "inverted").startswith("1 of 4 elements")


def test_inverted_tetrahedron_is_turned_over(tmp_path):
    path = write_msh(tmp_path / "t.msh", CUBE[:5], [("tetra", (1, 0, 3, 4), 1)], [(3, 1, "rock")])
    mesh = read_mesh(path)
    assert mesh.cell_sizes == pytest.approx([1 / 6])
    assert told(mesh, "inverted").startswith("1 of 1 elements")


def test_folded_element(tmp_path):
    path = write_msh(tmp_path / "q.msh", SQUARE, [("quad", (0, 1, 3, 2), 1)], [(2, 1, "clay")])
    with pytest.raises(InputError, match=r"1 elements are folded.*\(0.6\d*, 1\) m"):
        read_mesh(path)


def test_no_group_is_one_material_named_after_the_file(tmp_path):
    mesh = read_mesh(square(tmp_path / "embankment.msh", group=0, names=()))
    assert mesh.materials == ("embankment",)
    assert "'embankment'" in told(mesh, "No physical group")


def test_elements_left_out_of_the_groups(tmp_path):
    path = tmp_path / "s.msh"
    elements = [("triangle", t, 1 if k else 0) for k, t in enumerate(FOUR)]
    write_msh(path, SQUARE, elements, [(2, 1, "clay")])
    with pytest.raises(InputError, match=r"1 of 4 elements are in no physical group.*\(1, 0.333333\) m"):
        read_mesh(path)


@pytest.mark.parametrize("version", [2.2, 4.1])
def test_several_surfaces_without_groups(tmp_path, version):
    path = tmp_path / "s.msh"
    with gmsh_session(path) as gmsh:
        for x in (0.0, 3.0):
            gmsh.model.occ.addRectangle(x, 0.0, 0.0, 2.0, 1.0)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(path))
    with pytest.raises(InputError, match=r"2 surfaces \(1, 2\) without physical groups"):
        read_mesh(path)
    mesh = read_mesh(path, names={1: "clay", 2: "sand"})
    assert mesh.materials == ("clay", "sand")
    assert mesh.sizes == pytest.approx([2.0, 2.0])


def test_array_that_is_not_known_to_number_materials(tmp_path):
    import meshio

    triangles = [("triangle", np.array(FOUR))]
    points = np.array([(*p, 0.0) for p in SQUARE])
    path = tmp_path / "s.vtu"
    meshio.write(path, meshio.Mesh(points, triangles, cell_data={"zone": [np.array([1, 1, 2, 2])]}))
    with pytest.raises(InputError, match=r"'zone', and none is known.*material_array='zone'"):
        read_mesh(path)
    mesh = read_mesh(path, material_array="zone", names={1: "clay", 2: "sand"})
    assert mesh.sizes == pytest.approx([2.0, 2.0])
    with pytest.raises(InputError, match=r"no array 'zones'.*'zone'"):
        read_mesh(path, material_array="zones")
    meshio.write(path, meshio.Mesh(points, triangles, cell_data={"zone": [np.array([0.5, 1, 2, 2])]}))
    with pytest.raises(InputError, match="does not number materials"):
        read_mesh(path, material_array="zone")


@pytest.mark.parametrize(("factor", "unit"), [(1e4, "mm"), (1e-3, "km")])
def test_span_that_looks_like_another_unit(tmp_path, factor, unit):
    """A section of 20 km, or of 2 mm, is refused, unless the unit is given."""
    path = square(tmp_path / "s.msh", nodes=[(factor * x, factor * y) for x, y in SQUARE])
    with pytest.raises(InputError, match=f'length_unit: the ground would be .* Give length_unit = "{unit}"'):
        read_mesh(path)
    assert read_mesh(path, length_unit=1.0).sizes == pytest.approx([4.0 * factor**2])


def test_unit_that_is_none(tmp_path):
    with pytest.raises(InputError, match="not a positive length"):
        read_mesh(square(tmp_path / "s.msh"), length_unit=-1.0)


def test_triangles_without_area_are_removed(tmp_path):
    nodes = [*SQUARE, (0.5, 0.5)]
    mesh = read_mesh(square(tmp_path / "s.msh", nodes=nodes, triangles=[*FOUR, (0, 5, 4), (1, 1, 4)]))
    assert told(mesh, "without an area").startswith("2 triangles")
    assert "(0.5, 0.5) m" in told(mesh, "without an area")
    assert len(mesh.nodes) == 5
    assert mesh.sizes == pytest.approx([4.0])


def test_nodes_at_one_place_are_merged(tmp_path):
    nodes = [*SQUARE, (1.0, 1.0 + 1e-10)]
    mesh = read_mesh(square(tmp_path / "s.msh", nodes=nodes, triangles=[*FOUR[:3], (3, 0, 5)]))
    assert told(mesh, "merged").startswith("1 nodes")
    assert len(mesh.nodes) == 5
    assert len(mesh.facets) == 4


def test_parts_that_overlap_in_a_section(tmp_path):
    """Two squares of 2 m, moved by 1 m: 2 m2 are there twice, around x = 1.5."""
    moved = [(x + 1.0, y) for x, y in SQUARE]
    elements = [("triangle", t, 1) for t in FOUR]
    elements += [("triangle", tuple(k + 5 for k in t), 2) for t in FOUR]
    path = write_msh(tmp_path / "s.msh", [*SQUARE, *moved], elements, [(2, 1, "clay"), (2, 2, "sand")])
    with pytest.raises(InputError, match=r"'clay' and 'sand' overlap by about .* m2 around \(1\.") as caught:
        read_mesh(path)
    assert float(str(caught.value).split("about ")[1].split()[0]) == pytest.approx(2.0, rel=0.25)


def test_parts_that_overlap_in_a_volume(tmp_path):
    """Two cubes of 1 m, moved by half: 0.5 m3 are there twice."""
    nodes = [*CUBE, *((x + 0.5, y, z) for x, y, z in CUBE)]
    elements = [("hexahedron", range(8), 1), ("hexahedron", range(8, 16), 2)]
    path = write_msh(tmp_path / "h.msh", nodes, elements, [(3, 1, "rock"), (3, 2, "dyke")])
    with pytest.raises(InputError, match=r"'rock' and 'dyke' overlap by about .* m3 around \(0\.") as caught:
        read_mesh(path)
    assert float(str(caught.value).split("about ")[1].split()[0]) == pytest.approx(0.5, rel=0.25)


@pytest.mark.parametrize("dimension", [2, 3])
def test_copies_of_elements(tmp_path, dimension):
    if dimension == 2:
        path = square(tmp_path / "s.msh", triangles=[*FOUR, FOUR[0]])
    else:
        elements = [("tetra", (0, 1, 3, 4), 1)] * 3
        path = write_msh(tmp_path / "t.msh", CUBE, elements, [(3, 1, "rock")])
    with pytest.raises(InputError, match="belong to more than two elements"):
        read_mesh(path)


def test_copy_of_an_element_on_its_own(tmp_path):
    elements = [("tetra", (0, 1, 3, 4), 1), ("tetra", (0, 1, 3, 4), 2)]
    path = write_msh(tmp_path / "t.msh", CUBE, elements, [(3, 1, "rock"), (3, 2, "dyke")])
    with pytest.raises(InputError, match=r"'rock' and 'dyke' overlap by about 0.1667 m3"):
        read_mesh(path)


def test_neighbours_that_share_no_nodes_are_told(tmp_path):
    """A square beside four triangles whose common side has a node more."""
    nodes = [*SQUARE, (2.0, 1.0), (4.0, 0.0), (4.0, 2.0)]
    right = [(1, 6, 5), (6, 7, 5), (7, 2, 5)]
    mesh = read_mesh(square(tmp_path / "s.msh", nodes=nodes, triangles=[*FOUR, *right]))
    assert mesh.unjoined == 3
    assert told(mesh, "without a neighbour").startswith("3 sides")
    assert len(mesh.facets) == 6


def test_named_line_inside_the_ground_is_told(tmp_path):
    path = square(tmp_path / "s.msh", names=((2, 1, "clay"), (1, 2, "crack")), more=[("line", (0, 4), 2)])
    mesh = read_mesh(path)
    assert mesh.groups == ()
    assert told(mesh, "'crack'").startswith("1 of 1 facets")


def test_elements_of_a_kind_that_is_not_known(tmp_path):
    import pyvista

    points = np.array([(0, 0, 0), (1, 0, 0), (1.5, 1, 0), (0.5, 2, 0), (-0.5, 1, 0)], dtype=float)
    grid = pyvista.UnstructuredGrid([5, 0, 1, 2, 3, 4], [pyvista.CellType.POLYGON], points)
    grid.save(tmp_path / "p.vtu")
    with pytest.raises(InputError, match="elements of the kind 'polygon'"):
        read_mesh(tmp_path / "p.vtu")


def test_surface_in_space_is_no_volume(tmp_path):
    with pytest.raises(InputError, match=r"a surface in space \(12 triangles\).*body_from_mesh"):
        read_mesh(write_stl(tmp_path / "cube.stl", cube_facets()))


def test_lines_alone(tmp_path):
    path = write_msh(tmp_path / "l.msh", SQUARE, [("line", (0, 1), 1)], [(1, 1, "base")])
    with pytest.raises(InputError, match="neither surfaces nor volumes"):
        read_mesh(path)


@pytest.mark.parametrize("suffix", [".msh", ".vtk", ".vtu", ".inp", ".stl", ".geo", ".step"])
def test_file_that_is_no_mesh(tmp_path, suffix, capfd):
    path = tmp_path / f"x{suffix}"
    path.write_bytes(b"\x00\x01 this is no mesh\n" * 20)
    with pytest.raises(
        InputError, match=r"x\.\w+: (the file cannot be read|gmsh cannot|it holds|its element)"
    ):
        read_mesh(path)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("suffix", [".msh", ".vtu", ".vtk", ".stl"])
def test_file_that_ends_too_soon(tmp_path, suffix, capfd):
    import meshio

    path = tmp_path / f"s{suffix}"
    points = np.array([(*p, 0.0) for p in SQUARE])
    mesh = meshio.Mesh(
        points, [("triangle", np.array(FOUR))], cell_data={"material": [np.ones(4, dtype=int)]}
    )
    if suffix == ".msh":
        square(path)
    elif suffix == ".stl":
        write_stl(path, points[FOUR])
    else:
        meshio.write(path, mesh)
    capfd.readouterr()
    read_mesh(path)
    path.write_bytes(path.read_bytes()[: int(0.7 * path.stat().st_size)])
    with pytest.raises(InputError, match="cannot be read"):
        read_mesh(path)
    assert capfd.readouterr() == ("", "")


def test_absent_file_and_unknown_ending(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        read_mesh(tmp_path / "none.msh")
    path = tmp_path / "drawing.dwg"
    path.write_text("")
    with pytest.raises(InputError, match=r"files of the kind '.dwg' are not read.*\.msh"):
        read_mesh(path)


def test_size_is_for_geometry(tmp_path):
    with pytest.raises(InputError, match=r"size = 1.0: s.msh is a mesh already"):
        read_mesh(square(tmp_path / "s.msh"), size=1.0)
