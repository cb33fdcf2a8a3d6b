"""Pictures that cannot be used: the error names the file, the colour and the remedy."""

import math

import numpy as np
import pytest
from PIL import Image

from geodem.builders.from_image import label_image, section_from_image
from geodem.errors import InputError
from tests.builders.pictures import (
    COLOURS,
    SEAM,
    SLOPE,
    TILTED_SEAM,
    legend_of,
    raster,
    rgb,
    save,
)


@pytest.fixture
def slope(tmp_path):
    return save(raster(SLOPE), tmp_path / "slope.png")


LEGEND = {COLOURS["soil"]: "soil"}


@pytest.mark.parametrize("scale", [0.0, -0.1, math.nan, math.inf])
def test_bad_scale(slope, scale):
    with pytest.raises(
        InputError, match=r"^section\.scale = .*must be positive and finite \[m/px\].*0\.25 m/px"
    ):
        section_from_image(slope, scale=scale, legend=LEGEND)


def test_bad_origin_and_axis(slope):
    with pytest.raises(InputError, match=r"^section\.origin.*two finite lengths"):
        section_from_image(slope, scale=1.0, legend=LEGEND, origin=(0.0, math.nan))
    with pytest.raises(InputError, match=r"^section\.y_axis = 'left'.*\"up\" or \"down\""):
        section_from_image(slope, scale=1.0, legend=LEGEND, y_axis="left")


def test_missing_file_folder_and_no_image(tmp_path):
    with pytest.raises(InputError, match=r"^section\.image = .*none\.png.*does not exist"):
        section_from_image(tmp_path / "none.png", scale=1.0, legend=LEGEND)
    with pytest.raises(InputError, match="this is a folder"):
        section_from_image(tmp_path, scale=1.0, legend=LEGEND)
    (tmp_path / "text.png").write_text("not a picture")
    with pytest.raises(InputError, match="not a picture that can be read"):
        section_from_image(tmp_path / "text.png", scale=1.0, legend=LEGEND)


def test_damaged_file(slope, tmp_path):
    (tmp_path / "half.png").write_bytes(slope.read_bytes()[: slope.stat().st_size // 2])
    with pytest.raises(InputError, match=r"half\.png.*the picture is damaged"):
        section_from_image(tmp_path / "half.png", scale=1.0, legend=LEGEND)


def test_one_pixel(tmp_path):
    Image.new("RGB", (1, 1), COLOURS["soil"]).save(tmp_path / "dot.png")
    with pytest.raises(InputError, match="the picture has 1 x 1 pixels, too few to trace"):
        section_from_image(tmp_path / "dot.png", scale=1.0, legend=LEGEND)


def test_too_large(tmp_path):
    Image.new("1", (10_000, 6_000)).save(tmp_path / "large.png")
    with pytest.raises(InputError, match="10000 x 6000 pixels, more than 20000000"):
        section_from_image(tmp_path / "large.png", scale=1.0, legend=LEGEND)


@pytest.mark.parametrize("mode", ["RGB", "RGBA"])
def test_only_background(tmp_path, mode):
    Image.new(mode, (50, 50), (255, 255, 255, 0)[: len(mode)]).save(tmp_path / "empty.png")
    with pytest.raises(InputError, match=r"the whole picture is background.*#8c6d31"):
        section_from_image(tmp_path / "empty.png", scale=1.0, legend=LEGEND)


def test_colour_that_is_not_listed(tmp_path):
    path = save(raster(SEAM), tmp_path / "seam.png")
    picture = tmp_path / "out" / "where.png"
    with pytest.raises(InputError) as caught:
        section_from_image(path, scale=1.0, legend=LEGEND, picture=picture)
    text = str(caught.value)
    assert text.startswith("section.legend")
    assert "#d62728, which is not listed, on 2.50 % of its pixels" in text
    assert "nearest legend colour is #8c6d31" in text
    assert str(picture) in text
    marked = np.asarray(Image.open(picture))
    magenta = (marked == (255, 0, 255)).all(axis=2)
    assert magenta[130:135].all()
    assert not magenta[:128].any()
    assert not magenta[137:].any()


def test_picture_of_unlisted_colours_without_a_place_goes_to_a_temporary_folder(tmp_path):
    path = save(raster(SEAM), tmp_path / "seam.png")
    with pytest.raises(InputError, match="not listed") as caught:
        label_image(path, legend=LEGEND)
    assert caught.value.picture.is_file()
    assert tmp_path not in caught.value.picture.parents


@pytest.mark.parametrize("suffix", ["png", "jpg"])
def test_unlisted_colour_of_a_small_body(tmp_path, suffix):
    """A boulder of 0.3 % of the picture is refused; in a JPEG too, where edges have colours of their own."""
    scene = (
        300,
        200,
        [
            ("soil", [(0, 60), (300, 60), (300, 200), (0, 200)]),
            ("clay", [(100, 100), (114, 100), (114, 113), (100, 113)]),
        ],
    )
    path = save(raster(scene), tmp_path / f"a.{suffix}")
    with pytest.raises(InputError, match=r"which is not listed, on 0\.[23]\d % .*near column 10\d, row 10\d"):
        label_image(path, legend=LEGEND, picture=tmp_path / "where.png")


@pytest.mark.parametrize("thickness", [1, 2])
def test_forgotten_thin_seam_is_refused(tmp_path, thickness):
    """Left out silently, it would raise the factor of safety."""
    array = raster(SLOPE)
    array[170 : 170 + thickness] = rgb(COLOURS["clay"])
    path = save(array, tmp_path / "a.png")
    with pytest.raises(InputError, match="#1f77b4, which is not listed"):
        label_image(path, legend=LEGEND, picture=tmp_path / "where.png")


def test_listed_colour_that_is_not_shown(slope):
    with pytest.raises(
        InputError, match=r"^section\.legend\.\"#1f77b4\" = 'clay': the picture does not show"
    ):
        section_from_image(slope, scale=1.0, legend={**LEGEND, COLOURS["clay"]: "clay"})


def test_seam_too_thin_for_a_jpeg(tmp_path):
    path = save(raster(TILTED_SEAM), tmp_path / "a.jpg", quality=75)
    with pytest.raises(InputError, match=r"'seam' is about \d\.\d px thick.*Save the drawing as PNG"):
        section_from_image(path, scale=1.0, legend=legend_of(TILTED_SEAM))


def test_bad_legend(slope):
    with pytest.raises(InputError, match=r"^section\.legend: no colour is listed"):
        label_image(slope, legend={})
    with pytest.raises(
        InputError, match=r"^section\.legend\.\"brown\" = 'brown': this is not a colour.*#rrggbb"
    ):
        label_image(slope, legend={"brown": "soil"})
    with pytest.raises(InputError, match=r"^section\.background = '#ff': this is not a colour"):
        label_image(slope, legend=LEGEND, background=["#ff"])
    with pytest.raises(InputError, match="stands twice, as #FFF and #ffffff"):
        label_image(slope, legend={**LEGEND, "#FFF": "snow"}, background=["#ffffff"])


def test_black_that_is_not_listed_is_told_as_what_it_is(tmp_path):
    """Black is the number of what is transparent, and no listed colour."""
    Image.new("RGB", (60, 40), "#000000").save(tmp_path / "black.png")
    with pytest.raises(InputError, match=r"shows the colour #000000, which is not listed, on 100\.00 %"):
        section_from_image(tmp_path / "black.png", scale=1.0, legend=LEGEND, picture=tmp_path / "shown.png")
