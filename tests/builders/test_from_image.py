"""Pictures to sections: outlines to a part of a pixel, and every kind of file.

The truth is the polygon that was drawn. Distances are Hausdorff distances between all outlines [px].
"""

import math
import tracemalloc

import numpy as np
import pytest
import shapely
from PIL import Image, ImageDraw

from geodem.builders.from_image import label_image, section_from_image
from geodem.builders.image_mixtures import nearest
from geodem.builders.image_pixels import Pixels
from geodem.builders.section import Section
from tests.builders.pictures import (
    ANGLE,
    CIRCLE,
    COLOURS,
    LAYERS,
    SEAM,
    SLOPE,
    TILTED_SEAM,
    assert_conforming,
    corners_of,
    distance,
    legend_of,
    outlines,
    raster,
    rgb,
    save,
    truth_of,
)


@pytest.mark.parametrize(
    ("scene", "kind", "bound", "area_bound", "most_corners"),
    [
        (SLOPE, "blended", 0.05, 0.001, 6),
        (SLOPE, "stairs", 0.5, 0.002, 6),
        (SLOPE, "jpeg 90", 0.2, 0.002, 6),
        (SLOPE, "jpeg 75", 0.2, 0.002, 6),
        (SEAM, "blended", 0.05, 0.001, 14),
        # the toe at half a pixel is not seen in stairs
        (SEAM, "stairs", 0.55, 0.005, 14),
        (SEAM, "jpeg 90", 0.2, 0.01, 14),
        (SEAM, "jpeg 75", 0.2, 0.01, 14),
        (LAYERS, "blended", 0.05, 0.001, 16),
        # the thinnest layer is 20 px: 0.25 px lost at its foot are 1.2 %
        (LAYERS, "stairs", 0.6, 0.015, 16),
        (LAYERS, "jpeg 90", 0.2, 0.005, 16),
        (LAYERS, "jpeg 75", 0.2, 0.005, 16),
        (CIRCLE, "blended", 0.3, 0.001, 50),
        (CIRCLE, "stairs", 0.95, 0.002, 45),
        (CIRCLE, "jpeg 90", 1.0, 0.002, 45),
        (CIRCLE, "jpeg 75", 1.0, 0.002, 45),
        (TILTED_SEAM, "blended", 0.05, 0.005, 12),
        (TILTED_SEAM, "stairs", 0.3, 0.05, 12),
    ],
)
def test_outlines(tmp_path, scene, kind, bound, area_bound, most_corners):
    array = raster(scene, samples=1 if kind == "stairs" else 8)
    if kind.startswith("jpeg"):
        path = save(array, tmp_path / "section.jpg", quality=int(kind[5:]))
    else:
        path = save(array, tmp_path / "section.png")
    section = section_from_image(path, scale=1.0, legend=legend_of(scene), y_axis="down")
    truth = truth_of(scene)
    assert distance(section, truth) <= bound
    assert section.materials == truth.materials
    assert len(section.regions) == len(truth.regions)
    for material in truth.materials:
        assert section.area(material) == pytest.approx(truth.area(material), rel=area_bound)
    assert corners_of(section) <= most_corners
    assert_conforming(section)


def test_any_slope(tmp_path):
    rng = np.random.default_rng(7)
    for _ in range(6):
        toe, crest = rng.uniform(30, 170, 2)
        left, right = rng.uniform(40, 140), rng.uniform(190, 270)
        ends = rng.uniform(-6, 6, 2)
        corners = [
            (0, 200),
            (0, toe + ends[0]),
            (left, toe),
            (right, crest),
            (300, crest + ends[1]),
            (300, 200),
        ]
        scene = (300, 200, [("soil", corners)])
        for samples, bound in ((4, 0.35), (1, 0.8)):
            path = save(raster(scene, samples), tmp_path / "slope.png")
            section = section_from_image(path, scale=1.0, legend=legend_of(scene), y_axis="down")
            assert distance(section, truth_of(scene)) <= bound
            assert corners_of(section) <= 8


def test_scale_origin_and_upright_axis(tmp_path):
    path = save(raster(SEAM), tmp_path / "seam.png")
    section = section_from_image(path, scale=0.1, legend=legend_of(SEAM), origin=(20.0, 20.0))
    assert section.bounds == (20.0, 20.0, 84.0, 40.0)
    truth = Section.from_polygons(
        [(name, [(20 + 0.1 * x, 40 - 0.1 * y) for x, y in corners]) for name, corners in SEAM[2]]
    )
    assert distance(section, truth) <= 0.005  # 0.05 px
    assert section.area("seam") == pytest.approx(64.0 * 0.5, rel=1e-3)
    # the sides are exactly upright, from the base up
    for x in (20.0, 84.0):
        side = [p for p in shapely.get_coordinates(outlines(section)) if abs(p[0] - x) < 0.2]
        assert all(p[0] == x for p in side)


def test_upside_down(tmp_path):
    array = raster(SLOPE)
    upright = section_from_image(
        save(array, tmp_path / "a.png"), scale=0.1, legend=legend_of(SLOPE), y_axis="up"
    )
    flipped = section_from_image(
        save(array[::-1], tmp_path / "b.png"), scale=0.1, legend=legend_of(SLOPE), y_axis="down"
    )
    assert distance(upright, flipped) < 1e-3
    assert upright.outline.centroid.y < 10.0  # the ground lies below the air


def test_margin_sides_are_exactly_straight(tmp_path):
    """Layers that meet a free side share one x, so that a roller acts on all of it."""
    for samples, name in ((8, "a.png"), (1, "b.png"), (8, "c.jpg")):
        path = save(raster(LAYERS, samples), tmp_path / name)
        section = section_from_image(path, scale=1.0, legend=legend_of(LAYERS))
        left, low, right, high = section.bounds
        points = shapely.get_coordinates(outlines(section))
        for axis, value in ((0, left), (0, right), (1, low), (1, high)):
            near = points[np.abs(points[:, axis] - value) < 3.0]
            assert len(near) >= 2
            assert (near[:, axis] == value).all()


@pytest.mark.parametrize("kind", ["palette", "bmp", "opacity", "straight edge colour", "tiff", "gif", "webp"])
def test_kinds_of_file(tmp_path, kind):
    array = raster(LAYERS, samples=1 if kind in ("palette", "gif") else 8)
    plain = Image.fromarray(np.rint(array).astype(np.uint8))
    bound = 0.6 if kind in ("palette", "gif", "webp") else 0.05
    if kind == "palette":
        image, path = plain.quantize(8, dither=Image.Dither.NONE), tmp_path / "a.png"
        assert image.mode == "P"
    elif kind in ("opacity", "straight edge colour"):
        inside = raster(LAYERS, colours=dict.fromkeys(COLOURS, "#000000")).mean(axis=2)
        opacity = 255.0 - inside
        # what a drawing program stores: the colour of the ground alone, and how much of the pixel it covers
        colour = (array - 255.0 * (1 - opacity / 255.0)[..., None]) / np.maximum(opacity / 255.0, 1e-9)[
            ..., None
        ]
        if kind == "opacity":
            colour[opacity == 0.0] = (12.0, 200.0, 34.0)  # the colour of a clear pixel means nothing
        image = Image.fromarray(
            np.rint(np.dstack([np.clip(colour, 0, 255), opacity])).astype(np.uint8), "RGBA"
        )
        path = tmp_path / "a.png"
    else:
        image, path = plain, tmp_path / f"a.{kind}"
    image.save(path)
    section = section_from_image(path, scale=1.0, legend=legend_of(LAYERS), y_axis="down")
    assert distance(section, truth_of(LAYERS)) <= bound
    assert_conforming(section)


@pytest.mark.parametrize("mode", ["L", "I;16", "LA", "1"])
def test_grey_pictures(tmp_path, mode):
    grey = dict(COLOURS, soil="#000000")
    array = raster(SLOPE, colours=grey, samples=1 if mode == "1" else 8)[..., 0]
    if mode == "I;16":
        image = Image.fromarray(np.rint(array * 257.0).astype(np.uint16))
        assert image.mode == "I;16"
    else:
        image = Image.fromarray(np.rint(array).astype(np.uint8)).convert(mode)
    image.save(tmp_path / "grey.png")
    section = section_from_image(tmp_path / "grey.png", scale=1.0, legend={"#000": "soil"}, y_axis="down")
    assert distance(section, truth_of(SLOPE)) <= (0.5 if mode == "1" else 0.05)


def test_exif_orientation(tmp_path):
    image = Image.fromarray(np.rint(raster(SLOPE)).astype(np.uint8))
    exif = Image.Exif()
    exif[0x0112] = 6  # the camera was turned: the viewer turns the stored picture clockwise by 90 degrees
    image.rotate(90, expand=True).save(tmp_path / "a.jpg", quality=92, exif=exif)
    section = section_from_image(tmp_path / "a.jpg", scale=1.0, legend=legend_of(SLOPE), y_axis="down")
    assert section.bounds == pytest.approx((0.0, 50.0, 640.0, 200.0), abs=0.1)
    assert distance(section, truth_of(SLOPE)) <= 0.3


def test_pillow_drawing(tmp_path):
    """Polygons drawn directly, without blending, as a script of a user would."""
    image = Image.new("RGB", (320, 200), "white")
    corners = [(0, 199), (0, 120), (100, 120), (220, 60), (319, 60), (319, 199)]
    ImageDraw.Draw(image).polygon(corners, fill=COLOURS["soil"])
    image.save(tmp_path / "a.bmp")
    section = section_from_image(
        tmp_path / "a.bmp", scale=1.0, legend={COLOURS["soil"]: "soil"}, y_axis="down"
    )
    # pillow fills the pixels of the corners too: whole pixels from their upper left corners
    truth = Section.from_polygons(
        [("soil", [(0, 200), (0, 120), (100, 120), (220, 60), (320, 60), (320, 200)])]
    )
    assert distance(section, truth) <= 1.0
    assert len(section.regions[0].polygon.exterior.coords) == 7


BLACK_ON_WHITE = (
    300,
    200,
    [
        ("white", [(0, 20), (300, 60), (300, 200), (0, 200)]),
        ("black", [(0, 120), (140, 90.3), (300, 150), (300, 200), (0, 200)]),
        ("rock", [(220, 200), (240, 170), (270, 200)]),
    ],
)


@pytest.mark.parametrize("kind", ["blended", "jpeg"])
def test_blended_edge_is_no_layer_of_the_colour_between(tmp_path, kind):
    path = tmp_path / ("a.png" if kind == "blended" else "a.jpg")
    save(raster(BLACK_ON_WHITE, background=COLOURS["seam"]), path)
    image = label_image(path, legend=legend_of(BLACK_ON_WHITE), background=[COLOURS["seam"]])
    labels = image.labels.copy()
    grey = image.materials.index("rock") + 1
    rows, columns = np.nonzero(labels == grey)
    assert columns.min() > 215  # the edge between black and white runs from column 0
    assert rows.min() > 160
    section = section_from_image(
        path, scale=1.0, legend=legend_of(BLACK_ON_WHITE), background=[COLOURS["seam"]], y_axis="down"
    )
    assert distance(section, truth_of(BLACK_ON_WHITE)) <= (0.3 if kind == "blended" else 1.0)
    assert len(section.regions) == 3


@pytest.mark.parametrize("thickness", [2.0, 2.6, 3.0])
def test_thin_seam_inside_one_material_survives_its_in_between_colour(tmp_path, thickness):
    """The seam's grey is a mixture of black and white, but it has black on both sides."""
    scene = (
        300,
        200,
        [
            ("white", [(0, 0), (300, 0), (300, 60), (0, 60)]),
            ("black", [(0, 60), (300, 60), (300, 200), (0, 200)]),
            ("rock", [(0, 100), (300, 130), (300, 130 + thickness), (0, 100 + thickness)]),
        ],
    )
    path = save(raster(scene), tmp_path / "a.png")
    section = section_from_image(path, scale=1.0, legend=legend_of(scene), background=[], y_axis="down")
    truth = truth_of(scene)
    assert section.area("rock") == pytest.approx(300 * thickness, rel=0.05)
    assert distance(section, truth) <= 0.35
    assert_conforming(section)


def test_level_seam_of_two_pixels_at_a_half_pixel(tmp_path):
    scene = (
        300,
        100,
        [
            ("soil", [(0, 20), (300, 20), (300, 100), (0, 100)]),
            ("seam", [(0, 50.5), (300, 50.5), (300, 52.5), (0, 52.5)]),
        ],
    )
    path = save(raster(scene), tmp_path / "a.png")
    section = section_from_image(path, scale=1.0, legend=legend_of(scene), y_axis="down")
    assert section.area("seam") == pytest.approx(600.0, rel=0.01)
    assert distance(section, truth_of(scene)) <= 0.05


def test_blend_in_linear_light(tmp_path):
    """Some programs blend light, not stored values; edges move by a part of a pixel, no colour appears."""
    fine = raster((SEAM[0] * 4, SEAM[1] * 4, [(n, 4.0 * np.asarray(c)) for n, c in SEAM[2]]), samples=1)
    light = (fine / 255.0) ** 2.2
    linear = light.reshape(SEAM[1], 4, SEAM[0], 4, 3).mean(axis=(1, 3)) ** (1 / 2.2) * 255.0
    section = section_from_image(
        save(linear, tmp_path / "a.png"), scale=1.0, legend=legend_of(SEAM), y_axis="down"
    )
    assert distance(section, truth_of(SEAM)) <= 0.35
    assert len(section.regions) == 3


def test_png_made_from_a_jpeg(tmp_path):
    save(raster(LAYERS), tmp_path / "a.jpg", quality=60)
    Image.open(tmp_path / "a.jpg").save(tmp_path / "a.png")
    section = section_from_image(tmp_path / "a.png", scale=1.0, legend=legend_of(LAYERS), y_axis="down")
    assert distance(section, truth_of(LAYERS)) <= 1.0
    assert len(section.regions) == 3


def test_specks_are_absorbed_and_a_tunnel_is_kept(tmp_path):
    scene = (
        200,
        200,
        [
            ("soil", [(0, 40), (200, 40), (200, 200), (0, 200)]),
            ("white", np.c_[100 + 20 * np.cos(ANGLE), 120 + 20 * np.sin(ANGLE)]),
        ],
    )
    array = raster(scene)
    rng = np.random.default_rng(2)
    clean = section_from_image(
        save(array, tmp_path / "a.png"), scale=1.0, legend={COLOURS["soil"]: "soil"}, y_axis="down"
    )
    for _ in range(12):
        row, column = rng.integers(60, 90), rng.integers(5, 190)
        array[row : row + 2, column : column + 2] = 255.0
        array[5 + row % 20, column] = rgb(COLOURS["soil"])
    dirty = section_from_image(
        save(array, tmp_path / "b.png"), scale=1.0, legend={COLOURS["soil"]: "soil"}, y_axis="down"
    )
    assert len(clean.regions[0].polygon.interiors) == 1
    assert clean.area("soil") == pytest.approx(200 * 160 - math.pi * 400, rel=0.001)
    assert len(dirty.regions) == 1
    assert len(dirty.regions[0].polygon.interiors) == 1
    assert dirty.area("soil") == pytest.approx(clean.area("soil"), rel=0.001)


def test_shares(tmp_path):
    path = save(raster(SEAM, samples=1), tmp_path / "a.png")
    image = label_image(path, legend=legend_of(SEAM))
    assert image.labels.shape == (200, 640)
    assert image.materials == ("soil", "seam")
    assert image.shares["seam"] == pytest.approx(5 / 200, abs=1e-12)
    assert image.shares["soil"] == pytest.approx(truth_of(SEAM).area("soil") / 128000, rel=0.003)


def test_two_colours_of_one_material(tmp_path):
    path = save(raster(SEAM), tmp_path / "a.png")
    legend = {COLOURS["soil"]: "soil", COLOURS["seam"]: "soil"}
    section = section_from_image(path, scale=1.0, legend=legend, y_axis="down")
    assert len(section.regions) == 1
    assert section.area("soil") == pytest.approx(truth_of(SEAM).outline.area, rel=1e-3)


def test_same_picture_same_bits(tmp_path):
    path = save(raster(LAYERS), tmp_path / "a.jpg", quality=75)
    one, two = (section_from_image(path, scale=0.1, legend=legend_of(LAYERS)) for _ in range(2))
    assert [region.polygon.wkb for region in one.regions] == [region.polygon.wkb for region in two.regions]


def test_random_mosaics_fit_together(tmp_path):
    """Cells of nearest points, with short sides and sharp corners: valid and without gaps whatever comes."""
    rng = np.random.default_rng(3)
    names = ["soil", "seam", "clay", "rock"]
    for samples, suffix in ((4, "png"), (1, "png"), (4, "jpg")):
        points = rng.uniform([0, 0], [150, 100], (25, 2))
        owner = rng.integers(0, 5, 25)
        x, y = (np.arange(150 * samples) + 0.5) / samples, (np.arange(100 * samples) + 0.5) / samples
        grid = np.stack(np.meshgrid(x, y), axis=-1)
        cell = np.argmin(((grid[:, :, None, :] - points) ** 2).sum(axis=3), axis=2)
        colours = np.array([*(rgb(COLOURS[name]) for name in names), (255, 255, 255)])
        array = colours[owner[cell]].reshape(100, samples, 150, samples, 3).mean(axis=(1, 3))
        path = save(array, tmp_path / f"a.{suffix}")
        section = section_from_image(path, scale=1.0, legend={COLOURS[name]: name for name in names})
        assert_conforming(section)
        for k, name in enumerate(names):
            expected = (owner[cell] == k).sum() / samples**2
            assert section.area(name) == pytest.approx(expected, abs=60.0 if suffix == "jpg" else 25.0)


def test_a_large_picture_takes_little_memory():
    """Beside the result of 3 bytes a pixel a table of all 256^3 colours; sorting pixels takes 40 bytes each."""
    pixels = Pixels(
        np.zeros((2000, 2000, 3), dtype=np.uint8), np.full((2000, 2000), 255, dtype=np.uint8), False
    )
    tracemalloc.start()
    try:
        classes, sure = nearest(pixels, np.array([[0, 0, 0], [255, 255, 255], [0, 0, 0]]), 16.0)
        highest = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert not classes.any()
    assert sure.all()
    assert highest < 3 * 256**3 + 20 * 4_000_000
