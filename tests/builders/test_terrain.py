"""Terrains: heights and volumes against closed forms, files of three kinds, sections along lines."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import trapezoid
from scipy.interpolate import RegularGridInterpolator

from geodem.builders.fill_body import fill_body
from geodem.builders.terrain import Layer
from geodem.builders.terrain_files import degree_lengths, read_terrain, terrain_from
from geodem.errors import InputError


@pytest.fixture
def hills():
    """80 m x 120 m at 10 m by 20 m, from (500, 1000) m."""
    x, y = np.meshgrid(np.arange(9), np.arange(7), indexing="ij")
    return terrain_from(
        50.0 + 4.0 * np.sin(x) + 3.0 * np.cos(2.0 * y) + 0.5 * x * y, (500.0, 1000.0), (10.0, 20.0)
    )


@pytest.fixture(scope="module")
def jacksboro():
    """matplotlib's sample elevation model."""
    from matplotlib.cbook import get_sample_data

    return Path(str(get_sample_data("jacksboro_fault_dem.npz", asfileobj=False)))


def test_heights_are_those_of_another_bilinear_interpolation(hills):
    axes = [hills.origin[k] + hills.spacing[k] * np.arange(hills.elevation.shape[k]) for k in (0, 1)]
    points = hills.bounds[0] + np.random.default_rng(2).random((500, 2)) * np.ptp(hills.bounds, axis=0)
    points[:4] = [(500, 1000), (580, 1000), (580, 1120), (500, 1120)]
    expected = RegularGridInterpolator(axes, hills.elevation)(points)
    assert hills.height(points) == pytest.approx(expected, rel=1e-12)
    assert np.isnan(hills.height(np.array([(499.9, 1010.0), (540.0, 1120.1)]))).all()


def test_volumes_are_exact_for_the_bilinear_surface(hills):
    body = hills.body(base=20.0, layers=[Layer("soil", 2.0), Layer("clay", 5.0), Layer("rock")])
    whole = trapezoid(trapezoid(hills.elevation - 20.0, dx=20.0), dx=10.0)
    area = 80.0 * 120.0
    assert body.sizes == pytest.approx([2.0 * area, 3.0 * area, whole - 5.0 * area], rel=1e-12)
    # a plane through three corners, and a closed surface of triangles
    corners = next(surface.corners for surface in body.surfaces if surface.name == "surface")
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (up[:, 2] > 0.0).all()
    prisms = 0.5 * up[:, 2] * (corners[:, :, 2].mean(axis=1) - 20.0)
    assert prisms.sum() == pytest.approx(whole, rel=2e-3)


def test_layers_follow_the_surface_down_to_the_base(hills):
    body = hills.body(base=20.0, layers=[Layer("soil", 2.0), Layer("clay", 5.0), Layer("rock")])
    top = float(hills.height(np.array([(533.0, 1071.0)]))[0])
    depths = np.array([-0.01, 0.01, 1.99, 2.01, 4.99, 5.01, top - 20.01, top - 19.99])
    points = np.column_stack([np.full(8, 533.0), np.full(8, 1071.0), top - depths])
    assert body.material_at(points).tolist() == [-1, 0, 0, 1, 1, 2, 2, -1]
    assert body.material_at(np.array([(499.0, 1071.0, 30.0)])).tolist() == [-1]


def test_particles_stand_for_the_volumes(hills):
    body = hills.body(base=20.0, layers=[Layer("soil", 8.0), Layer("rock")])
    filling = fill_body(body, particles=20_000)
    for share, size in zip(filling.shares, body.sizes, strict=True):
        assert share.represented == pytest.approx(size, rel=0.005)


def test_a_section_is_the_ground_below_its_line(hills):
    section = hills.section_along(
        [(500, 1040), (580, 1040)], base=20.0, layers=[Layer("soil", 2.0), Layer("rock")]
    )
    heights = hills.elevation[:, 2]
    assert section.bounds == pytest.approx((0.0, 20.0, 80.0, heights.max()))
    assert section.area("soil") == pytest.approx(160.0, rel=1e-9)
    assert section.area("rock") == pytest.approx(trapezoid(heights - 22.0, dx=10.0), rel=1e-9)


def test_a_section_along_corners_is_unrolled(hills):
    corners = [(500, 1000), (530, 1040), (580, 1040)]
    section = hills.section_along(corners, base=20.0, step=0.05)
    assert section.bounds[2] == pytest.approx(100.0)
    outline = np.array(section.regions[0].polygon.exterior.coords)
    top = outline[outline[:, 1] > 20.0]
    for x, place in ((25.0, (515.0, 1020.0)), (50.0, (530.0, 1040.0)), (75.0, (555.0, 1040.0))):
        nearest = top[np.argmin(np.abs(top[:, 0] - x))]
        assert nearest == pytest.approx((x, hills.height(np.array([place]))[0]), abs=1e-6)


def test_a_cut_out_is_the_same_ground(hills):
    part = hills.crop((515.0, 1030.0), (555.0, 1079.0))
    assert part.bounds.tolist() == [[510.0, 1020.0], [560.0, 1080.0]]
    points = np.array([(510.0, 1020.0), (541.0, 1066.0), (560.0, 1080.0)])
    assert part.height(points) == pytest.approx(hills.height(points), rel=1e-12)


def test_degrees_have_the_lengths_of_the_ellipsoid():
    """Kilometres of a degree of longitude and latitude on WGS 84, as tabled in Wikipedia's Longitude and Latitude."""
    for latitude, kilometres in (
        (0.0, (111.320, 110.574)),
        (45.0, (78.847, 111.132)),
        (60.0, (55.800, 111.412)),
    ):
        assert degree_lengths(latitude) == pytest.approx(np.multiply(kilometres, 1e3), abs=0.6)


def test_the_sample_of_matplotlib_has_its_north_up(jacksboro):
    terrain = read_terrain(jacksboro, degrees=True)
    rows = np.load(jacksboro)["elevation"]
    assert terrain.elevation.shape == rows.T.shape
    # the first row of the archive is the northern one
    assert terrain.elevation[0, -1] == rows[0, 0]
    assert terrain.elevation[-1, 0] == rows[-1, -1]
    assert terrain.bounds[1] == pytest.approx([402, 343] * degree_lengths(36.58958) * 0.00083333333, rel=1e-6)
    assert "Degrees became metres" in terrain.remarks[0]
    with pytest.raises(InputError, match="look like longitude and latitude"):
        read_terrain(jacksboro)


def test_a_section_of_the_sample_has_the_factor_of_the_method_of_slices(jacksboro):
    from reference.problems import ground_terrain

    terrain = read_terrain(jacksboro, degrees=True)
    section = ground_terrain.line_section(terrain, ground_terrain.LAYERS["one material"])
    expected = ground_terrain.slices(section, "bishop")
    assert ground_terrain.factor(section, particles=1000) == pytest.approx(expected, rel=0.04)


FORMATS = ["npz rows", "npz x y z", "geotiff", "geotiff points", "ascii", "ascii centres"]


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_gives_the_same_terrain(tmp_path, kind):
    x, y = np.arange(6), np.arange(4)
    heights = 100.0 + 7.0 * x[:, None] + 2.0 * y[None, :] ** 2
    rows = heights.T[::-1]
    square = "asc" in kind
    step = (5.0, 5.0) if square else (5.0, 8.0)
    if kind == "npz rows":
        path = tmp_path / "t.npz"
        np.savez(path, elevation=rows, dx=5.0, dy=8.0, xmin=1000.0, ymin=2000.0)
    elif kind == "npz x y z":
        path = tmp_path / "t.npz"
        np.savez(path, x=1000.0 + 5.0 * x, y=2000.0 + 8.0 * y, z=heights)
    elif kind.startswith("geotiff"):
        path = tmp_path / "t.tif"
        _write_geotiff(path, rows, points=kind.endswith("points"))
    else:
        path = tmp_path / "t.asc"
        where = "xllcenter 1000\nyllcenter 2000" if "centres" in kind else "xllcorner 997.5\nyllcorner 1997.5"
        body = "\n".join(" ".join(f"{z:g}" for z in row) for row in rows)
        path.write_text(f"ncols 6\nnrows 4\n{where}\ncellsize 5\nNODATA_value -9999\n{body}\n")
    terrain = read_terrain(path)
    assert terrain.elevation == pytest.approx(heights)
    assert terrain.origin == pytest.approx([1000.0, 2000.0])
    assert terrain.spacing == pytest.approx(step)
    assert terrain.remarks == ()


def _write_geotiff(path, rows, *, points=False, degrees=False, hole=None):
    """ModelPixelScale, ModelTiepoint of the upper left corner or pixel, and the keys, as OGC 19-008r4 has them."""
    import tifffile

    north = 2000.0 + 8.0 * (len(rows) - 1)
    west, top = (1000.0, north) if points else (1000.0 - 2.5, north + 4.0)
    scale = (5.0, 8.0, 0.0)
    if degrees:
        west, top, scale = -84.0, 36.0, (0.001, 0.001, 0.0)
    keys = (1, 1, 0, 2, 1024, 0, 1, 2 if degrees else 1, 1025, 0, 1, 2 if points else 1)
    tags = [
        (33550, "d", 3, scale, True),
        (33922, "d", 6, (0.0, 0.0, 0.0, west, top, 0.0), True),
        (34735, "H", len(keys), keys, True),
    ]
    if hole is not None:
        tags.append((42113, "s", 0, f"{hole:g}", True))
    tifffile.imwrite(path, rows.astype(np.float32), extratags=tags)


def test_a_geotiff_says_itself_whether_it_is_in_degrees(tmp_path):
    _write_geotiff(tmp_path / "t.tif", np.full((5, 5), 100.0), degrees=True)
    terrain = read_terrain(tmp_path / "t.tif")
    assert terrain.spacing == pytest.approx(0.001 * degree_lengths(36.0 - 0.0025), rel=1e-9)


@pytest.mark.parametrize("kind", ["tif", "asc"])
def test_holes_are_refused_or_filled_and_told(tmp_path, kind):
    rows = np.tile(100.0 + 10.0 * np.arange(8.0), (7, 1))
    rows[3, 4] = rows[3, 5] = -9999.0
    path = tmp_path / f"t.{kind}"
    if kind == "tif":
        _write_geotiff(path, rows, hole=-9999.0)
    else:
        body = "\n".join(" ".join(map(str, row)) for row in rows)
        path.write_text(
            f"ncols 8\nnrows 7\nxllcorner 0\nyllcorner 0\ncellsize 5\nNODATA_value -9999\n{body}\n"
        )
    with pytest.raises(InputError, match="2 of 56 heights are missing"):
        read_terrain(path)
    terrain = read_terrain(path, holes="fill")
    # an even slope goes on through the hole
    assert terrain.elevation[4:6, 3] == pytest.approx([140.0, 150.0], abs=1e-6)
    assert terrain.remarks == ("2 heights were missing and filled from those around them.",)


def test_files_that_are_no_terrain_are_refused(tmp_path):
    def refused(name, problem, content=None, **arrays):
        path = tmp_path / name
        if content is not None:
            path.write_bytes(content)
        elif arrays:
            np.savez(path, **arrays)
        with pytest.raises(InputError, match=problem):
            read_terrain(path)

    refused("absent.npz", "no such file")
    refused("a.obj", "no terrain that can be read", b"v 0 0 0")
    refused("a.npz", "holds other", other=np.zeros(3))
    # NumPy and zipfile have errors of their own for each of these
    refused("empty.npz", "the file is damaged", b"")
    refused("head.npz", "the file is damaged", b"PK\x03\x04-")
    refused("cut.npz", "the file is damaged", (tmp_path / "a.npz").read_bytes()[:-30])
    refused(
        "b.npz",
        "not ascending in equal steps",
        x=np.array([0.0, 1.0, 3.0]),
        y=np.arange(2.0),
        z=np.zeros((3, 2)),
    )
    refused("c.npz", "z has the shape", x=np.arange(3.0), y=np.arange(2.0), z=np.zeros((2, 3)))
    refused("d.npz", "not two positive lengths", elevation=np.zeros((3, 3)), dx=0.0, dy=1.0)
    refused("e.npz", "not a grid of heights", elevation=np.zeros((1, 3)), dx=1.0, dy=1.0)
    refused("f.npz", "damaged", b"PK no archive")
    refused("a.tif", "no TIFF|damaged", b"no tiff at all")
    refused("a.asc", "lacks ncols", b"1 2 3\n4 5 6\n")
    refused("b.asc", "has 3 heights", b"ncols 2\nnrows 2\ncellsize 1\n1 2 3\n")
    refused(
        "c.asc", r"a height is no number.*'1,5'.*decimal points", b"ncols 2\nnrows 1\ncellsize 1\n1 1,5\n"
    )
    holes = b"ncols 2\nnrows 2\ncellsize 1\nnodata_value -9\n-9 -9\n-9 -9\n"
    refused("d.asc", "all of its 4 heights are missing.*no-data value", holes)
    import tifffile

    tifffile.imwrite(tmp_path / "plain.tif", np.zeros((4, 4), dtype=np.float32))
    refused("plain.tif", "does not say where its pixels lie")


@pytest.mark.parametrize(
    ("points", "options", "problem"),
    [
        ([(500, 1000), (581, 1000)], {}, "leaves the terrain"),
        ([(500, 1000)], {}, "two or more places"),
        ([(500, 1000), (500, 1000)], {}, "stands twice"),
        ([(500, 1000), (540, 1000)], {"base": 53.0}, "base is not below it"),
        ([(500, 1000), (540, 1000)], {"base": np.nan}, "base is not below it"),
        ([(500, 1000), (540, 1000)], {"step": 0.0}, "not a positive number"),
        (
            [(500, 1000), (540, 1000)],
            {"layers": [Layer("soil", 40.0), Layer("rock")]},
            "lower side of 'soil'",
        ),
        (
            [(500, 1000), (540, 1000)],
            {"layers": [Layer("a", 5.0), Layer("b", 2.0), Layer("c")]},
            "do not grow",
        ),
        ([(500, 1000), (540, 1000)], {"layers": [Layer("soil", 5.0)]}, "do not grow"),
        ([(500, 1000), (540, 1000)], {"layers": []}, "there is none"),
        ([(500, 1000), (540, 1000)], {"layers": [Layer("soil")], "step": 1e-9}, "are too many"),
        ([(500, 1000), (540, 1000)], {"layers": [Layer("soil")], "step": 1e-320}, "are too many"),
    ],
)
def test_lines_layers_and_bases_that_cannot_be_are_refused(hills, points, options, problem):
    with pytest.raises(InputError, match=problem):
        hills.section_along(points, **{"base": 20.0, **options})


def test_bodies_and_cut_outs_that_cannot_be_are_refused(hills):
    with pytest.raises(InputError, match="goes down to 47"):
        hills.body(base=50.0)
    with pytest.raises(InputError, match="no terrain lies between"):
        hills.crop((600.0, 1000.0), (700.0, 1100.0))
