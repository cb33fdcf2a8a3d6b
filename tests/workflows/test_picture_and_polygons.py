"""A slope given by its corners and the same slope drawn: one factor."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from PIL import Image, ImageDraw

from geodem.analysis import Analysis
from geodem.case import parse_case
from geodem.stability.bracket import bracket
from tests.small_cases import ROOT

SLOPES = ROOT / "reference" / "problems" / "slopes"
PIXELS = 200
"""Height of the picture."""

SMOOTHING = 8


def drawn(polygon: list[list[float]], path: Path) -> tuple[float, float, float]:
    """The polygon as an anti-aliased picture; returns metres per pixel, and x and y of its lower left corner."""
    left, right = min(x for x, _ in polygon), max(x for x, _ in polygon)
    bottom, top = min(y for _, y in polygon), max(y for _, y in polygon)
    scale = (top - bottom) / PIXELS
    width = int((right - left) / scale) + 3  # some white at the right: the section may end within a pixel
    fine = scale / SMOOTHING
    picture = Image.new("RGB", (width * SMOOTHING, PIXELS * SMOOTHING), "#ffffff")
    # the pen paints the last pixel too, hence the half
    corners = [((x - left) / fine - 0.5, (top - y) / fine - 0.5) for x, y in polygon]
    ImageDraw.Draw(picture).polygon(corners, fill="#c8a464")
    picture.resize((width, PIXELS), Image.Resampling.BOX).save(path)
    return scale, left, bottom


def factor(text: str, folder: Path) -> float:
    analysis = Analysis(parse_case(text, folder))
    analysis.build()
    analysis.search()
    found = bracket(analysis.records["strength-reduction"].fine).value
    assert found is not None
    return found


@pytest.mark.parametrize("name", ["P01", "P03"])
def test_the_factor_is_the_same(name, tmp_path):
    text = (SLOPES / f"{name}.toml").read_text()
    section = tomllib.loads(text)["section"]
    (region,) = section["regions"]
    start, end = text.index("[section]"), text.index("[boundary]")
    options = (
        f'particles = 2000\nmethods = ["strength-reduction"]\ntolerance = 0.005\ntitle = "{name}"\nseed = 1\n'
    )
    rest = 'workflow = "slope"\n' + options
    scale, left, bottom = drawn(region["polygon"], tmp_path / "section.png")
    picture = (
        f'[section]\nimage = "section.png"\nscale = "{scale!r} m/px"\norigin = [{left}, {bottom}]\n'
        f'legend = {{"#c8a464" = "{region["material"]}"}}\nbackground = ["#ffffff"]\n\n'
    )
    from_corners = factor(rest + text[start:], tmp_path)
    from_picture = factor(rest + picture + text[end:], tmp_path)
    assert from_picture == pytest.approx(from_corners, rel=0.01)
