"""Section: overlay of polygons, exact sharing of boundaries, and errors that name the corner."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from geodem.builders.section import Region, Section
from geodem.errors import InputError, InputErrors

SOIL = [[20, 20], [84, 20], [84, 40], [67.5, 40], [43, 27.75], [20, 27.75]]
SEAM = [[20, 26.5], [84, 26.5], [84, 27], [20, 27]]


def shoelace(points):
    x, y = np.asarray(points, dtype=float).T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def assert_conforming(section):
    """Disjoint interiors, no gap, and every common boundary with the same vertices on both sides."""
    polygons = [region.polygon for region in section.regions]
    assert all(polygon.is_valid for polygon in polygons)
    total = math.fsum(polygon.area for polygon in polygons)
    assert section.outline.area == pytest.approx(total, rel=1e-12)
    for i, one in enumerate(polygons):
        for other in polygons[i + 1 :]:
            assert one.intersection(other).area == pytest.approx(0.0, abs=1e-12 * total)
            # a vertex of one that lies on the other's boundary must be a vertex of the other too
            for first, second in ((one, other), (other, one)):
                vertices = {tuple(p) for p in shapely.get_coordinates(first)}
                theirs = {tuple(p) for p in shapely.get_coordinates(second)}
                limit = 1e-9 * math.sqrt(total)
                close = {p for p in vertices if second.boundary.distance(shapely.Point(p)) < limit}
                assert close <= theirs


def test_seam_lies_over_the_soil():
    section = Section.from_polygons([("soil", SOIL), ("seam", SEAM)])
    assert section.materials == ("soil", "seam")
    assert section.area("seam") == pytest.approx(64 * 0.5, rel=1e-12)
    assert section.area("soil") == pytest.approx(shoelace(SOIL) - 32.0, rel=1e-12)
    assert section.bounds == (20.0, 20.0, 84.0, 40.0)
    assert [region.material for region in section.regions] == ["soil", "soil", "seam"]
    assert len(section.parts) == 1
    assert_conforming(section)


def test_corners_come_back_as_typed():
    corners = [[0.1, 0.7], [10.3, 0.7], [10.3, 3.3], [0.1, 3.3]]
    lower = [[0.1, 0.7], [10.3, 0.7], [10.3, 1.9], [0.1, 1.9]]
    section = Section.from_polygons([("soil", corners), ("sand", lower)])
    found = {tuple(p) for region in section.regions for p in shapely.get_coordinates(region.polygon)}
    assert found == {(0.1, 0.7), (10.3, 0.7), (10.3, 3.3), (0.1, 3.3), (10.3, 1.9), (0.1, 1.9)}


def test_t_junction_typed_with_few_decimals_leaves_no_gap():
    # the corner (10/3, 20/3) of the lower layer lies on the upper layer's side only to 6 decimals
    upper = [[0, 0], [10, 20], [0, 20]]
    lower = [[0, 0], [10, 0], [10, 20], [3.333333, 6.666667]]
    section = Section.from_polygons([("upper", upper), ("lower", lower)])
    assert len(section.regions) == 2
    assert_conforming(section)
    assert section.outline.area == pytest.approx(200.0, rel=1e-6)
    assert len(section.outline.interiors) == 0


def test_survey_coordinates():
    offset = np.array([512_345.0, 5_432_109.0])
    section = Section.from_polygons([("soil", np.array(SOIL) + offset), ("seam", np.array(SEAM) + offset)])
    assert section.area("seam") == pytest.approx(32.0, rel=1e-8)
    assert_conforming(section)


def test_hole_and_closing_corner():
    outer = [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]
    inner = [[4, 4], [6, 4], [6, 6], [4, 6]]
    section = Section.from_polygons([("rock", outer), ("ore", inner)])
    assert len(section.regions[0].polygon.interiors) == 1
    assert section.area("rock") == pytest.approx(96.0)
    assert_conforming(section)


def test_neighbours_of_one_material_are_joined():
    section = Section.from_polygons(
        [("soil", [[0, 0], [5, 0], [5, 5], [0, 5]]), ("soil", [[5, 0], [10, 0], [10, 5], [5, 5]])]
    )
    assert len(section.regions) == 1
    assert section.area("soil") == pytest.approx(50.0)


def test_parts_that_touch_in_a_point_are_separate():
    section = Section.from_polygons(
        [("a", [[0, 0], [1, 0], [1, 1], [0, 1]]), ("b", [[1, 1], [3, 1], [3, 3], [1, 3]])]
    )
    assert [part.area for part in section.parts] == pytest.approx([4.0, 1.0])


def test_area_of_an_unknown_material():
    with pytest.raises(KeyError, match="it has soil"):
        Section.from_polygons([("soil", SOIL)]).area("clay")


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(*[st.integers(0, 40)] * 2, *[st.integers(1, 30)] * 2, st.floats(-3, 3)),
        min_size=1,
        max_size=5,
    )
)
def test_any_parallelograms_conform_and_the_later_wins(boxes):
    polygons = [
        (f"m{k}", [[x, y], [x + w, y + tilt], [x + w, y + h + tilt], [x, y + h]])
        for k, (x, y, w, h, tilt) in enumerate(boxes)
    ]
    shapes = [shapely.Polygon(corners) for _, corners in polygons]
    seen = [shape.difference(shapely.unary_union(shapes[k + 1 :])).area for k, shape in enumerate(shapes)]
    if min(seen) < 1e-3:  # hidden, or all but hidden
        return
    section = Section.from_polygons(polygons)
    assert_conforming(section)
    last = f"m{len(boxes) - 1}"
    assert section.area(last) == pytest.approx(boxes[-1][2] * boxes[-1][3], rel=1e-4)
    expected = shapely.unary_union(shapes)
    assert section.outline.area == pytest.approx(expected.area, rel=1e-4)


@pytest.mark.parametrize(
    ("polygon", "where", "what"),
    [
        ([[0, 0], [1, 0]], r"\[0\]\.polygon", "2 different corners, and needs at least 3"),
        ([[0, 0], [1, 0], [1, 0], [0, 0]], r"\[0\]\.polygon", "2 different corners"),
        ([], r"\[0\]\.polygon", "0 different corners"),
        ([[0, 0], [1, math.nan], [1, 1]], r"\[0\]\.polygon\[1\]", "not finite"),
        ([[0, 0], [1, 0], [math.inf, 1]], r"\[0\]\.polygon\[2\]", "not finite"),
        ([[0, 0], [4, 4], [4, 0], [0, 4]], r"\[0\]\.polygon", r"\(2, 2\) m \(self-intersection\)"),
        ([[0, 0], [5, 5], [10, 10]], r"\[0\]\.polygon", "no thickness"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0]], r"\[0\]\.polygon", "not pairs of numbers"),
        ([["a", 0], [1, 0], [1, 1]], r"\[0\]\.polygon", "not pairs of numbers"),
    ],
)
def test_bad_polygons_are_named(polygon, where, what):
    with pytest.raises(InputError, match=rf"^section\.regions{where}.*{what}"):
        Section.from_polygons([("soil", polygon)])


def test_the_place_names_the_region():
    with pytest.raises(InputError, match=r"^case\.ground\[1\]\.polygon: the polygon has 2"):
        Section.from_polygons([("soil", SOIL), ("seam", [[0, 0], [1, 1]])], place="case.ground")


def test_all_errors_come_at_once():
    with pytest.raises(InputErrors) as caught:
        Section.from_polygons([("soil", [[0, 0], [1, 0]]), ("", SOIL), ("seam", [[0, 0], [1, 1], [2, 2]])])
    assert [error.place for error in caught.value.errors] == [
        "section.regions[0].polygon",
        "section.regions[1].material",
        "section.regions[2].polygon",
    ]


def test_hidden_region():
    with pytest.raises(InputError, match=r"regions\[0\]\.polygon: later regions \(1, .*\) hide .*'seam'"):
        Section.from_polygons([("seam", SEAM), ("soil", [[0, 0], [100, 0], [100, 100], [0, 100]])])


def test_no_region():
    with pytest.raises(InputError, match="no region is given"):
        Section.from_polygons([])


def test_region_is_plain_data():
    polygon = shapely.box(0, 0, 1, 1)
    assert Section((Region("soil", polygon),)) == Section((Region("soil", polygon),))
