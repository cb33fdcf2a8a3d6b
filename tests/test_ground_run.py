"""A case of ground in its folder: sizes and masses of closed forms, all that a run leaves, what it refuses."""

from __future__ import annotations

import json
import math
import re
import struct

import h5py
import numpy as np
import pytest
from PIL import Image, ImageDraw

from geodem import resume_case, run_case
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.body_filling_file import load_filling
from geodem.case import load_ground, parse_ground
from geodem.errors import InputError, StoppedError
from geodem.ground_building import fill, make_body
from geodem.ground_cost import cost
from geodem.ground_files import read_surfaces
from geodem.ground_run import make_ground, portable, redraw_ground
from geodem.particle_simulation import ParticleSimulation
from geodem.plotting import ground_pictures
from geodem.plotting.theme import new_figure
from tests.ground_files import BONDED, GROUND, ground_case, write_asc, write_msh

# of bank.png: 12 m by 6 m without the sky of 6 m by 3 m and without the seam of 12 m by 1 m
SIZES = {"soil": 72.0 - 18.0 - 12.0, "seam": 12.0}
DENSITIES = {"soil": 1900.0, "seam": 2100.0}


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """A folder that a run wrote."""
    place = tmp_path_factory.mktemp("ground")
    ground_case(place / "case")
    run_case(place / "case", place / "out", command="geodem run case")
    return place / "out"


@pytest.fixture(scope="module")
def result(out):
    return json.loads((out / "result.json").read_text())


def test_sizes_and_masses_are_those_of_the_drawing(result):
    assert result["workflow"] == "ground"
    assert result["status"] == "done"
    assert result["dimension"] == 2
    assert "before anything is run" in result["kind_of_result"]
    for row in result["materials"]:
        assert row["source_size"] == pytest.approx(SIZES[row["name"]], rel=1e-9)
        assert abs(row["difference_percent"]) < 0.5
        assert row["mass"] == pytest.approx(SIZES[row["name"]] * DENSITIES[row["name"]], rel=1e-9)
        assert abs(row["mass_difference_percent"]) < 1e-6
    assert sum(row["particles"] for row in result["materials"]) == result["particles"]
    assert result["particles"] == pytest.approx(1200, rel=0.03)
    assert result["seed"] == 4
    assert {"geodem", "numpy", "python"} <= set(result["versions"])
    assert result["wall_time_s"] > 0.0
    assert result["bounds_m"] == [[0.0, 0.0], [12.0, 6.0]]


def test_contacts_are_those_of_the_filling(out, result):
    """Neighbours counted pair by pair, as the definition says it."""
    filling = load_filling(out / "filling.npz")
    found = result["contacts"]
    x, r = filling.positions, filling.radii
    apart = np.linalg.norm(x[:, None] - x, axis=2)
    reach = found["reach"] * (r[:, None] + r)
    near = (apart <= reach) & ~np.eye(len(r), dtype=bool)
    assert found["pairs"] == near.sum() // 2
    assert found["coordination"] == pytest.approx(near.sum(axis=1).mean())
    assert found["loose"] == (near.sum(axis=1) == 0).sum()


def test_frames_hold_the_particles(out, result):
    filling = load_filling(out / "filling.npz")
    with h5py.File(out / "particles-000000.vtkhdf") as file:
        root = file["VTKHDF"]
        assert np.array_equal(root["Points"][:, :2], filling.positions)
        assert np.array_equal(root["PointData"]["radius [m]"][()], filling.radii)
        assert np.array_equal(root["PointData"]["material [-]"][()], filling.material)
        mass = root["PointData"]["density [kg per m3]"][()] * math.pi * filling.radii**2
        assert mass.sum() == pytest.approx(sum(SIZES[n] * DENSITIES[n] for n in SIZES), rel=1e-9)
        assert root["FieldData"]["materials"][0] == b"soil, seam"
    assert not (out / "surfaces-000000.vtkhdf").exists(), "a picture names no boundary"


def test_the_report_needs_nothing_else(out, result):
    page = (out / "report.html").read_text()
    assert page.rstrip().endswith("</html>")
    assert re.findall(r"""(?:src|href)\s*=\s*["'](?!data:|#)([^"']*)""", page) == []
    assert page.count("data:image/png;base64,") == 1
    text = re.sub(r"<[^>]*>", " ", re.sub(r"<(style|script).*?</\1>", " ", page, flags=re.DOTALL))
    for words in (
        "discs of 2 materials",
        "mass difference",
        "Nothing has moved yet",
        "no stiffness is given for soil, seam",
    ):
        assert words in text, words
    assert f"{result['particles']:,}" in text
    assert str(out.parent) not in text, "no folder of the machine it was made on"
    with Image.open(out / "figures" / "particles.png") as picture:
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 20


def test_the_folder_is_a_case_that_runs_to_the_same_bits(out, result, tmp_path):
    assert (out / "source" / "bank.png").is_file()
    case = load_ground(out)
    again = run_case(case, tmp_path / "again", threads=1)
    assert again["digest"] == result["digest"]
    assert portable(case)[0].as_run_text() == (out / "case.toml").read_text()


def test_done_is_not_done_again(out, result):
    before = (out / "report.html").stat().st_mtime_ns
    assert resume_case(out)["digest"] == result["digest"]
    assert (out / "report.html").stat().st_mtime_ns == before


def test_drawn_again(out):
    (out / "report.html").unlink()
    path = redraw_ground(out, load_ground(out))
    assert path.is_file()
    assert (out / "figures" / "particles.png").is_file()


def test_another_case_is_not_written_over(out, tmp_path):
    other = ground_case(tmp_path / "case", GROUND.replace("seed = 4", "seed = 5"))
    before = {path: path.read_bytes() for path in out.glob("*.*")}
    with pytest.raises(InputError, match="results of another case"):
        run_case(other, out)
    assert {path: path.read_bytes() for path in out.glob("*.*")} == before
    copy = tmp_path / "copy"
    run_case(other, copy)
    changed = run_case(ground_case(tmp_path / "case", GROUND.replace("1200", "600")), copy, overwrite=True)
    assert changed["particles"] < 700
    assert load_filling(copy / "filling.npz").particles == changed["particles"]


def test_a_stop_leaves_nothing(tmp_path):
    asked = []

    def stop() -> bool:
        asked.append(1)
        return len(asked) > 2

    with pytest.raises(StoppedError):
        run_case(ground_case(tmp_path / "case"), tmp_path / "out", stop_asked=stop)
    assert not (tmp_path / "out").exists()


def test_a_quick_look_is_coarse(tmp_path):
    text = GROUND.replace("particles = 1200", 'radius = "2 cm"')
    found = run_case(ground_case(tmp_path / "case", text), tmp_path / "out", quickly=True)
    assert found["particles"] == pytest.approx(2000, rel=0.03)
    assert any("--quick" in notice for notice in found["notices"])


def test_time_step_and_cost_where_bonds_are_given(tmp_path):
    """Bonds, masses and critical step are those of the lattice built by hand; no step exceeds that of one spring.

    A mode of opposite neighbours has K >= 4 kn of its own two springs along an axis, so omega^2 >= 4 kn / m.
    """
    text = GROUND.replace("particles = 1200\nseed = 4", 'arrangement = "square"\nradius = "0.1 m"')
    text = text.replace('"1900 kg/m3"', f'"1900 kg/m3"\n{BONDED}').replace(
        '"2100 kg/m3"', f'"1900 kg/m3"\n{BONDED}'
    )
    case = parse_ground(text, ground_case(tmp_path))
    filling = fill(case, make_body(case).body)
    found = cost(case, filling)
    assert found.why == ""
    density = filling.density({"soil": 1900.0, "seam": 1900.0})
    own = case.materials["soil"].bonded
    build = AssemblyBuilder(2, contact_law="effective_modulus", bond_law="rock")
    build.add_material("all", density=1900.0, contact=own.contact, bond=own.bond)
    build.add_particles(filling.positions, filling.radii, "all", density=density)
    bonds = build.bond_within(1.05)
    assert found.bonds == len(bonds)
    assert 1.8 * filling.particles < len(bonds) < 2.0 * filling.particles, "one to the right, one above"
    by_hand = ParticleSimulation(build.build(), local_damping=0.7).critical_time_step
    assert found.critical_time_step == pytest.approx(by_hand, rel=0.01)
    # law rock: a bond of section 2 R and length 2 R has kn = Ec
    mass = float((density * math.pi * filling.radii**2).min())
    assert found.critical_time_step < 2.0 / math.sqrt(4.0 * 2e9 / mass)
    assert found.time_step == pytest.approx(0.5 * found.critical_time_step)
    assert found.step_seconds > 0.0


def test_no_time_step_without_stiffness(tmp_path):
    text = GROUND.replace('"2100 kg/m3"', f'"2100 kg/m3"\n{BONDED}')
    found = make_ground(parse_ground(text, ground_case(tmp_path))).result["cost"]
    assert found["why"] == "no stiffness is given for soil"
    assert found["memory_bytes"] > 0


def test_a_photograph_is_cut_where_it_should(tmp_path):
    """Two discs of 20 px, dark on light: two grains, and their area."""
    picture = Image.new("L", (100, 60), 220)
    pen = ImageDraw.Draw(picture)
    pen.ellipse([10, 20, 30, 40], fill=40)
    pen.ellipse([60, 20, 80, 40], fill=50)
    picture.save(tmp_path / "grains.png")
    dark = float((np.asarray(picture) < 100).sum())
    text = (
        'workflow = "ground"\n[source]\nphotograph = "grains.png"\nscale = "1 mm/px"\nmaterials = ["grain", "none"]\n'
        'grains = "grain"\n[particles]\nparticles = 200\n[material.grain]\ndensity = "2600 kg/m3"\n'
    )
    (tmp_path / "case.toml").write_text(text)
    found = run_case(tmp_path, tmp_path / "out")
    assert found["grains"] == 2
    assert found["materials"][0]["source_size"] == pytest.approx(dark * 1e-6)
    assert any(re.search(r"cut at the brightness 0\.\d+", notice) for notice in found["notices"])
    assert (tmp_path / "out" / "figures" / "cut.png").is_file()
    (tmp_path / "out" / "report.html").unlink()
    assert redraw_ground(tmp_path / "out", load_ground(tmp_path / "out")).is_file()


def test_a_terrain_with_a_layer(tmp_path):
    """The plane of `write_asc`, cut out between 20 m and 60 m: 58 m to 74 m, in the mean 66 m."""
    write_asc(tmp_path / "hill.asc")
    text = (
        'workflow = "ground"\n[source]\nterrain = "hill.asc"\nbase = "40 m"\ncut_out = [[20, 0], [60, 50]]\n'
        'layers = [{material = "soil", depth = "4 m"}, {material = "rock"}]\n[particles]\narrangement = "fcc"\n'
        'radius = "1.2 m"\n[material.soil]\ndensity = "1900 kg/m3"\n[material.rock]\ndensity = "2500 kg/m3"\n'
    )
    ground = make_ground(parse_ground(text, tmp_path))
    sizes = {row["name"]: row["source_size"] for row in ground.result["materials"]}
    assert sizes["soil"] == pytest.approx(40.0 * 50.0 * 4.0, rel=1e-9)
    assert sizes["rock"] == pytest.approx(40.0 * 50.0 * 22.0, rel=1e-9)
    named = {row["name"]: row["size"] for row in ground.result["surfaces"]}
    assert named["base"] == pytest.approx(40.0 * 50.0)
    assert named["surface"] == pytest.approx(50.0 * math.hypot(40.0, 16.0))
    assert ground.result["dimension"] == 3


def test_a_mesh_names_materials_itself(tmp_path):
    pytest.importorskip("meshio")
    write_msh(tmp_path / "section.msh")
    head = (
        'workflow = "ground"\n[source]\nmesh = "section.msh"\n[particles]\nparticles = 300\n'
        '[material.clay]\ndensity = "1900 kg/m3"\n'
    )
    with pytest.raises(InputError, match=r'^material\.fill: missing: the source has the material "fill"'):
        make_ground(parse_ground(head, tmp_path))
    both = parse_ground(head + '[material.fill]\ndensity = "2000 kg/m3"\n', tmp_path)
    assert [row["name"] for row in make_ground(both).result["materials"]] == ["clay", "fill"]


def test_boundaries_of_solids_are_kept(tmp_path, monkeypatch):
    """A cube of 1 m in an STL file: six square metres of boundary, kept so that they can be drawn again."""
    pytest.importorskip("pyvista")
    # spheres take seconds to draw, and are drawn elsewhere
    monkeypatch.setattr(ground_pictures, "filling_picture", lambda *_, **__: new_figure(3.0, 2.0))
    write_cube(tmp_path / "cube.stl")
    (tmp_path / "case.toml").write_text(
        'workflow = "ground"\n[source]\nsolids = {rock = "cube.stl"}\n[particles]\narrangement = "simple_cubic"\n'
        'radius = "0.125 m"\n[material.rock]\ndensity = "2500 kg/m3"\n'
    )
    found = run_case(tmp_path, tmp_path / "out")
    assert found["materials"][0]["source_size"] == pytest.approx(1.0)
    assert found["particles"] == 64
    assert found["surfaces"] == [{"name": "rock", "facets": 12, "size": pytest.approx(6.0)}]
    with Image.open(tmp_path / "out" / "figures" / "surfaces.png") as picture:
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 20
    (kept,) = read_surfaces(tmp_path / "out" / "surfaces-000000.vtkhdf")
    assert kept.name == "rock"
    assert np.linalg.norm(np.cross(*np.diff(kept.corners, axis=1).transpose(1, 0, 2)), axis=1).sum() == 12.0
    assert redraw_ground(tmp_path / "out", load_ground(tmp_path / "out")).is_file()


def test_without_pyvista_there_are_no_pictures_of_spheres(tmp_path, monkeypatch):
    def missing(*_: object, **__: object) -> None:
        raise InputError(
            "picture", "spheres are drawn by pyvista, which is not here", "Run: pip install pyvista"
        )

    monkeypatch.setattr(ground_pictures, "filling_picture", missing)
    write_asc(tmp_path / "hill.asc")
    (tmp_path / "case.toml").write_text(
        'workflow = "ground"\n[source]\nterrain = "hill.asc"\nbase = "40 m"\n[particles]\narrangement = "bcc"\n'
        'particles = 200\n[material.rock]\ndensity = "2500 kg/m3"\n'
    )
    found = run_case(tmp_path, tmp_path / "out")
    assert any("pyvista, which is not here" in warning for warning in found["warnings"])
    assert (tmp_path / "out" / "report.html").is_file()


def write_cube(path):
    """Binary STL of the unit cube."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    body = b"".join(struct.pack("<12fH", 0.0, 0.0, 0.0, *corners[list(t)].ravel(), 0) for t in triangles)
    path.write_bytes(b" " * 80 + struct.pack("<I", len(triangles)) + body)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("particles = 1200", 'radius = "40 m"',
         r"^particles\.radius = '40 m': the ground is 12 m by 6 m: it has no room for 20 such particles"),
        ("particles = 1200", 'radius = "0.05 mm"', r"^particles\.radius = '0\.05 mm'.*about 6\.9e\+09 such particles"),
        ("particles = 1200", 'particles = 1_000_000_000_000',
         r"^particles\.particles = 1000000000000: .* discs need about"),
        ("seed = 4", 'arrangement = "fcc"', r"^particles\.arrangement = 'fcc': there is no such arrangement in 2D"),
        ("seed = 4", "solid_fraction = 0.99", r"^particles\.solid_fraction = 0\.99: this is not between 0 and 0\.9"),
        ('"#d62728"', '"#00ff00" = "seam", "#d62728"',
         r'^source\.legend\."#00ff00" = .seam.: the picture does not show this colour'),
        ('"#d62728"', '"#d60000"', r"^source\.legend = .*bank\.png': the picture shows the colour #d62728"),
    ],
)  # fmt: skip
def test_what_only_the_body_tells(tmp_path, old, new, said):
    """What cannot be seen before the source is read is told at its key, too, and nothing is written."""
    text = GROUND.replace(old, new)
    if "1_000" in new:
        text = 'allow_implausible = ["particles.particles"]\n' + text
    with pytest.raises(InputError) as caught:
        run_case(ground_case(tmp_path / "case", text), tmp_path / "out")
    assert re.search(said, str(caught.value), re.MULTILINE), str(caught.value)
    assert not (tmp_path / "out").exists()


def test_a_damaged_file(tmp_path):
    case = ground_case(tmp_path / "case")
    (case / "bank.png").write_bytes(b"\x89PNG\r\n\x1a\nnot a picture")
    with pytest.raises(InputError, match=r"^source\.image = 'bank\.png': "):
        run_case(case, tmp_path / "out")
    assert not (tmp_path / "out").exists()
