"""Sections of slopes from meshes and terrains: what is read, what is refused, what a case writes back."""

from __future__ import annotations

import re

import numpy as np
import pytest

from geodem.building import case_identity, make_particles, make_section, portable_text, quick
from geodem.case import MeshSection, TerrainSection, parse_case
from geodem.errors import InputError
from tests.ground_files import AREAS, slope_case, write_asc, write_msh

pytest.importorskip("meshio")

LINE = "line = [[10, 40], [90, 40]]"
TERRAIN = f'terrain = "hill.asc"\n{LINE}\nbase = "30 m"'
LAYERS = 'layers = [{material = "clay", depth = "3 m"}, {material = "fill"}]'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("files")
    write_msh(place / "section.msh")
    write_msh(place / "mm.msh", unit=1e-3)
    write_asc(place / "hill.asc")
    return place


def test_a_mesh_has_the_areas_of_its_groups(folder):
    """Areas of the polygons that were meshed."""
    case = parse_case(slope_case('mesh = "section.msh"', "clay", "fill"), folder)
    assert isinstance(case.section, MeshSection)
    assert case.section.materials == ("clay", "fill")
    assert case.section.bounds == (0.0, 0.0, 30.0, 10.0)
    section = make_section(case)
    for name, area in AREAS.items():
        assert section.area(name) == pytest.approx(area, rel=1e-9)
    assert any("No length_unit was given" in text for text in case.notices)


def test_millimetres_are_metres_of_the_same_ground(folder):
    case = parse_case(slope_case('mesh = "mm.msh"\nlength_unit = "mm"', "clay", "fill"), folder)
    assert make_section(case).area("fill") == pytest.approx(AREAS["fill"], rel=1e-9)
    with pytest.raises(
        ValueError, match=r"section\.length_unit: the ground would be 3e\+04 m by 1e\+04 m.*mm"
    ):
        parse_case(slope_case('mesh = "mm.msh"', "clay", "fill"), folder)


def test_particles_on_the_nodes_are_the_nodes(folder):
    case = parse_case(
        slope_case('mesh = "section.msh"\nparticles_on = "nodes"', "clay", "fill", head=""), folder
    )
    assert case.particles is None
    assert case.spacing is None
    assert isinstance(case.section, MeshSection)
    particles = make_particles(case, make_section(case), particles=None)
    nodes = case.section.mesh.nodes
    assert np.array_equal(np.unique(particles.positions, axis=0), np.unique(nodes, axis=0))
    coarse = quick(case)
    assert coarse.section.particles_on == "polygons"
    assert coarse.particles is not None


@pytest.mark.parametrize(
    ("section", "names", "head"),
    [
        ('mesh = "section.msh"', ("clay", "fill"), "particles = 400\n"),
        ('mesh = "mm.msh"\nlength_unit = "mm"', ("clay", "fill"), 'spacing = "1 m"\n'),
        ('mesh = "section.msh"\nparticles_on = "nodes"', ("clay", "fill"), ""),
        ('mesh = "mm.msh"\nmesh_unit = "mm"\nrefine = [{box = [[1, 1], [2, 2]], spacing = "0.5 m"}]',
         ("clay", "fill"), "particles = 400\n"),
        (f'{TERRAIN}\n{LAYERS}\nstep = "2.5 m"', ("clay", "fill"), "particles = 400\n"),
        (TERRAIN, ("rock",), "particles = 400\n"),
    ],
)  # fmt: skip
def test_a_case_as_run_is_the_same_case(folder, section, names, head):
    case = parse_case(slope_case(section, *names, head=head), folder)
    again = parse_case(portable_text(case), folder)
    assert portable_text(again) == portable_text(case)
    assert case_identity(again) == case_identity(case)
    assert make_section(again).regions == make_section(case).regions
    assert again.section.refine == case.section.refine


def test_identity_changes_with_the_file(folder, tmp_path):
    text = slope_case('mesh = "section.msh"', "clay", "fill")
    write_msh(tmp_path / "section.msh", spacing=1.1)
    assert case_identity(parse_case(text, folder)) != case_identity(parse_case(text, tmp_path))


def test_a_line_across_a_plane(folder):
    """80 m along a plane that rises by 0.4: 54 m at x = 10 and 86 m at x = 90, the mean is the height over the base."""
    case = parse_case(slope_case(f"{TERRAIN}\n{LAYERS}", "clay", "fill"), folder)
    assert isinstance(case.section, TerrainSection)
    assert case.section.bounds == pytest.approx((0.0, 30.0, 80.0, 86.0))
    section = make_section(case)
    assert section.area("clay") == pytest.approx(80.0 * 3.0, rel=1e-9)
    assert section.area("fill") == pytest.approx(80.0 * (70.0 - 30.0 - 3.0), rel=1e-9)


def test_one_material_needs_no_layers(folder):
    case = parse_case(slope_case(TERRAIN, "rock"), folder)
    assert case.section.materials == ("rock",)
    assert make_section(case).area("rock") == pytest.approx(80.0 * 40.0, rel=1e-9)


def test_a_line_in_degrees_is_that_of_the_file(tmp_path):
    """A degree of latitude has 110.6 to 111.7 km (WGS 84); here 0.001 degrees at 45 degrees north."""
    heights = np.full((6, 6), 200.0)
    np.savez(tmp_path / "dem.npz", elevation=heights, dx=1e-3, dy=1e-3, xmin=7.0, ymin=45.0)
    line = 'terrain = "dem.npz"\ndegrees = true\nline = [[7.002, 45.001], [7.002, 45.003]]\nbase = "100 m"'
    case = parse_case(slope_case(line, "rock"), tmp_path)
    left, _, right, _ = case.section.bounds
    assert right - left == pytest.approx(2e-3 * 111_132.0, rel=1e-4)
    assert any("Degrees became metres" in text for text in case.notices)


MESH = 'mesh = "section.msh"'


@pytest.mark.parametrize(
    ("section", "names", "said"),
    [
        (MESH, ("clay",), r'section\.mesh: the file has the material "fill", and no \[material\.NAME\] has this name.*'
                          r'Add \[material\.fill\].*The file has "clay", "fill"; the case has "clay"'),
        (MESH, ("clay", "filling"), r'Did you mean "filling"\?.*the case has "clay", "filling"'),
        ('mesh = "sektion.msh"', ("clay",), r"section\.mesh = 'sektion.msh': there is no such file\. Did you mean "
                                            r'"section\.msh"\?'),
        (f'{MESH}\nscale = "1 m/px"', ("clay", "fill"),
         r"section\.scale = '1 m/px': this belongs to a section from an image"),
        (f"{MESH}\n{TERRAIN}", ("clay",), r"section: mesh and terrain are both given.*exactly one"),
        (f'{MESH}\nparticles_on = "knots"', ("clay", "fill"), r'section\.particles_on = .knots.*"polygons", "nodes"'),
        (f'{MESH}\nparticles_on = "nodes"', ("clay", "fill"),
         r"^particles = 400: the nodes of the mesh are the particles"),
        (f'{MESH}\nlength_unit = "mi"', ("clay", "fill"), r"section\.length_unit = 'mi'"),
        ('mesh = "hill.asc"', ("clay",), r"section\.mesh = 'hill\.asc': files of the kind '\.asc' are not read"),
        (f'{MESH}\nsize = "1 m"', ("clay", "fill"), r"section\.size = 1\.0: section\.msh is a mesh already"),
        ('terrain = "hill.asc"\nbase = "30 m"', ("rock",), r"section\.line: missing"),
        (f'terrain = "hill.asc"\n{LINE}', ("rock",), r"section\.base: missing"),
        (TERRAIN.replace('"30 m"', "30"), ("rock",),
         r'section\.base = 30: a bare number; a length needs its unit.*"30 m"'),
        (TERRAIN.replace('"30 m"', '"60 m"'), ("rock",), r"section\.base = '60 m': the surface goes down to 54 m"),
        (TERRAIN.replace("90", "900"), ("rock",), r"section\.line: it leaves the terrain at"),
        (TERRAIN.replace("[90, 40]", "[90]"), ("rock",), r"section\.line\[1\] = \[90\]: two numbers are needed"),
        (TERRAIN, ("rock", "soil"), r"section\.layers: missing.*from the surface down"),
        (f"{TERRAIN}\n{LAYERS}", ("clay",), r"section\.layers\[1\]\.material = 'fill': no material has this name"),
        (f'{TERRAIN}\nlayers = [{{material = "clay"}}, {{material = "fill"}}]', ("clay", "fill"),
         r"section\.layers\[0\]\.depth: missing"),
        (f'{TERRAIN}\nlayers = [{{material = "clay", depth = "3 m"}}]', ("clay",),
         r"section\.layers\[0\]\.depth = '3 m': the last layer reaches down to the base"),
        (f"{TERRAIN}\nlayers = 3", ("clay",), r"section\.layers = 3: a list is needed"),
        (f"{TERRAIN}\ndegrees = 1", ("rock",), r"section\.degrees = 1: a switch is needed"),
        (TERRAIN.replace("hill.asc", "section.msh"), ("rock",),
         r"section\.terrain = 'section\.msh': this is no terrain"),
    ],
)  # fmt: skip
def test_what_is_refused(folder, section, names, said):
    with pytest.raises(InputError) as caught:
        parse_case(slope_case(section, *names), folder)
    assert re.search(said, str(caught.value), re.MULTILINE | re.DOTALL), str(caught.value)
