"""Geometry that gmsh meshes: STEP and .geo files, quietly and the same every time."""

from __future__ import annotations

import math
import re
import sys

import numpy as np
import pytest

from geodem.builders.mesh_gmsh import gmsh_session
from geodem.builders.mesh_reading import read_mesh
from geodem.errors import InputError

GEO = """
Point(1) = {0, 0, 0, 1}; Point(2) = {4, 0, 0, 1}; Point(3) = {4, 2, 0, 0.2}; Point(4) = {0, 2, 0, 0.2};
Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1:4}; Plane Surface(1) = {1};
Physical Surface("clay") = {1}; Physical Curve("crest") = {3};
"""


def geo(path, text=GEO):
    path.write_text(text)
    return path


def step(path, *boxes, names=()):
    """A STEP file of boxes, given by corner and sides in metres; OpenCASCADE writes millimetres."""
    with gmsh_session(path) as gmsh:
        for box in boxes:
            gmsh.model.occ.addBox(*box)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    text = path.read_text()
    # bodies are called as products, the first of which is the whole
    made = re.findall(r"PRODUCT\('([^']*)'", text.replace("\n", ""))
    for name, old in zip(names, made[1:], strict=bool(names)):
        text = text.replace(f"'{old}'", f"'{name}'")
    path.write_text(text)
    return path


def test_geometry_with_sizes_of_its_own(tmp_path):
    mesh = read_mesh(geo(tmp_path / "g.geo"))
    assert mesh.materials == ("clay",)
    assert mesh.sizes == pytest.approx([8.0])
    assert mesh.groups == ("crest",)
    corners = mesh.nodes[mesh.cells]
    side = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
    high = corners[..., 1].mean(axis=1)
    assert side[high < 0.5].mean() > 2.0 * side[high > 1.5].mean()


def test_size_limits_the_sides(tmp_path):
    coarse, fine = (read_mesh(geo(tmp_path / "g.geo"), size=size) for size in (1.0, 0.1))
    assert len(fine.cells) > 800 > len(coarse.cells)
    in_decimetres = read_mesh(geo(tmp_path / "g.geo"), length_unit=0.1, size=0.01)
    assert len(in_decimetres.cells) == len(fine.cells)


def test_the_same_bits_every_time_and_not_a_word(tmp_path, capfd):
    first, second = (read_mesh(geo(tmp_path / "g.geo")) for _ in range(2))
    assert first.nodes.tobytes() == second.nodes.tobytes()
    assert first.cells.tobytes() == second.cells.tobytes()
    assert capfd.readouterr() == ("", "")


def test_session_of_the_caller_is_left_as_it_was(tmp_path):
    import gmsh

    alone = read_mesh(geo(tmp_path / "g.geo"))
    assert not gmsh.isInitialized()
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.05)
        gmsh.model.add("mine")
        gmsh.model.geo.addPoint(1.0, 2.0, 3.0)
        gmsh.model.geo.synchronize()
        mesh = read_mesh(geo(tmp_path / "g.geo"))
        with pytest.raises(InputError):
            read_mesh(geo(tmp_path / "bad.geo", "Plane Surface(1) = {7};"))
        assert gmsh.model.getCurrent() == "mine"
        assert gmsh.model.getEntities(0) == [(0, 1)]
        assert gmsh.option.getNumber("Mesh.MeshSizeMax") == 0.05
    finally:
        gmsh.finalize()
    assert (mesh.nodes == alone.nodes).all()


def test_without_gmsh(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "gmsh", None)
    with pytest.raises(InputError, match=r"needs gmsh.*pip install 'geodem\[meshes\]'"):
        read_mesh(geo(tmp_path / "g.geo"))


def test_without_meshio(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "meshio", None)
    (tmp_path / "m.msh").write_text("")
    with pytest.raises(InputError, match=r"needs meshio.*pip install 'geodem\[meshes\]'"):
        read_mesh(tmp_path / "m.msh")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Point(1) = {0, 0, 0", "gmsh cannot read"),
        ("Point(1) = {0, 0, 0};", "neither a surface nor a volume"),
        (GEO.replace("{1:4}; Plane", "{1:3}; Plane"), "gmsh cannot"),
        (GEO + 'Physical Surface("sand") = {1};', "surface 1 is in two physical groups, 'clay' and 'sand'"),
        (
            GEO.partition("Physical")[0] + "Point(5) = {9, 9, 0, 1}; Point(6) = {8, 9, 0, 1}; Point(7) = {8, 8, 0, 1};"
            "Line(5) = {5, 6}; Line(6) = {6, 7}; Line(7) = {7, 5}; Curve Loop(2) = {5:7}; Plane Surface(2) = {2};",
            r"2 surfaces \(1, 2\) without physical groups",
        ),
    ],
)  # fmt: skip
def test_geometry_that_cannot_be_used(tmp_path, text, words, capfd):
    with pytest.raises(InputError, match=words):
        read_mesh(geo(tmp_path / "g.geo", text))
    assert capfd.readouterr() == ("", "")


def test_surface_in_no_group_is_left_out(tmp_path):
    """As gmsh does where it writes a mesh."""
    more = (
        "Point(5) = {9, 9, 0, 1}; Point(6) = {8, 9, 0, 1}; Point(7) = {8, 8, 0, 1}; Line(5) = {5, 6}; "
        "Line(6) = {6, 7}; Line(7) = {7, 5}; Curve Loop(2) = {5:7}; Plane Surface(2) = {2};\n"
    )
    mesh = read_mesh(geo(tmp_path / "g.geo", GEO + more))
    assert mesh.sizes == pytest.approx([8.0])
    assert "1 surfaces in no physical group were left out: 2." in mesh.remarks


def test_last_line_without_a_break(tmp_path):
    """gmsh alone would skip it."""
    mesh = read_mesh(geo(tmp_path / "g.geo", GEO + 'Physical Curve("base") = {1};'))
    assert set(mesh.groups) == {"crest", "base"}
    with pytest.raises(InputError, match="its last line has no break"):
        read_mesh(geo(tmp_path / "g.geo", 'Include "other.geo";'))


def test_bodies_of_a_step_file(tmp_path):
    """Two boxes side by side, in millimetres: names of the file, common nodes, volumes by hand."""
    path = step(tmp_path / "two.step", (0, 0, 0, 2, 1, 1), (2, 0, 0, 3, 1, 1), names=("rock", "dyke"))
    assert "SI_UNIT(.MILLI.,.METRE.)" in path.read_text()
    mesh = read_mesh(path, size=0.5)
    assert mesh.materials == ("rock", "dyke")
    assert mesh.sizes == pytest.approx([2.0, 3.0])
    assert mesh.unjoined == 0
    assert any("its own unit" in remark and "5 m by 1 m by 1 m" in remark for remark in mesh.remarks)


def test_bodies_without_names(tmp_path):
    path = step(tmp_path / "two.step", (0, 0, 0, 2, 1, 1), (2, 0, 0, 3, 1, 1))
    with pytest.raises(InputError, match=r"2 volumes \(1, 2\) without physical groups"):
        read_mesh(path)
    mesh = read_mesh(path, names={1: "rock", 2: "dyke"}, size=0.5)
    assert mesh.sizes == pytest.approx([2.0, 3.0])
    with pytest.raises(InputError, match="it has no volume 3"):
        read_mesh(path, names={3: "rock"})


def test_body_without_a_name_or_size(tmp_path):
    mesh = read_mesh(step(tmp_path / "pillar.stp", (0, 0, 0, 2, 1, 1)))
    assert mesh.materials == ("pillar",)
    assert any("sides of 0.1 m" in remark for remark in mesh.remarks)


def test_bodies_that_overlap(tmp_path):
    """1 m of 2 and 3 m is there twice: exactly 1 m3 around (1.5, 0.5, 0.5)."""
    path = step(tmp_path / "two.step", (0, 0, 0, 2, 1, 1), (1, 0, 0, 3, 1, 1), names=("rock", "dyke"))
    with pytest.raises(InputError, match=r"rock.*dyke.* overlap by 1 m3 around \(1.5, 0.5, 0.5\) m"):
        read_mesh(path, size=0.5)


def test_unit_given_replaces_that_of_a_step_file(tmp_path):
    """Its numbers are 2000, 1000, 1000; taken for centimetres they are 20 m by 10 m by 10 m."""
    mesh = read_mesh(step(tmp_path / "b.step", (0, 0, 0, 2, 1, 1)), length_unit=0.01, size=5.0)
    assert mesh.sizes == pytest.approx([2000.0])


def test_step_file_in_another_unit_than_meant(tmp_path):
    path = step(tmp_path / "b.step", (0, 0, 0, 2e-3, 1e-3, 1e-3))
    with pytest.raises(InputError, match=r"0.002 m by 0.001 m by 0.001 m.*length_unit = \"m\""):
        read_mesh(path)
    assert read_mesh(path, length_unit=1.0, size=0.5).sizes == pytest.approx([2.0])


def test_what_flat_sides_leave_out_is_told(tmp_path):
    path = tmp_path / "c.step"
    with gmsh_session(path) as gmsh:
        gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 2, 1)
        gmsh.model.occ.synchronize()
        gmsh.write(str(path))
    mesh = read_mesh(path, size=0.5)
    lost = [remark for remark in mesh.remarks if "of the volume as drawn" in remark]
    assert len(lost) == 1
    share = float(re.search(r"([+-][\d.]+) %", lost[0]).group(1))
    assert share == pytest.approx(100.0 * (mesh.sizes[0] / (2.0 * math.pi) - 1.0), abs=0.01)
    assert share < -0.5


@pytest.mark.parametrize(
    "line",
    [
        'SystemCall "touch {place}";', 'NonBlockingSystemCall "touch {place}";', 'System "touch {place}";',
        'Printf("x") > "{place}";', 'Save "{place}";', 'CreateDir "{place}";', "Exit;", "Abort;", "Sleep 100;",
        'OnelabRun("a", "touch {place}");', 'Merge Sprintf("{place}");',
    ],
)  # fmt: skip
def test_a_script_that_does_more_than_draw_is_refused(line, tmp_path):
    """A .geo file is a program in gmsh's language, which can start others and write files."""
    place = tmp_path / "written"
    path = geo(tmp_path / "g.geo", GEO + line.replace("{place}", str(place)) + "\n")
    with pytest.raises(InputError, match=r"does more than draw|cannot be told before"):
        read_mesh(path)
    assert not place.exists()
    # nor in a file that it takes in
    outer = geo(tmp_path / "outer.geo", 'Include "g.geo";\n')
    with pytest.raises(InputError, match=r"g\.geo: .*(does more than draw|cannot be told before)"):
        read_mesh(outer)


def test_words_of_commands_in_names_and_comments_are_no_commands(tmp_path):
    text = GEO.replace('"clay"', '"System"') + "// Exit; Save it later\n/* Sleep 3; */\n"
    assert read_mesh(geo(tmp_path / "g.geo", text)).materials == ("System",)
