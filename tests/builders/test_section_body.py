"""Drawn bodies: polygons and boxes of layers."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.body import OUTSIDE
from geodem.builders.fill_body import fill_body
from geodem.builders.section import Section
from geodem.builders.section_body import SectionBody, box_body
from geodem.errors import InputError


def test_a_later_region_lies_over_an_earlier_one():
    square = [[0, 0], [4, 0], [4, 2], [0, 2]]
    hole = [[1, 0.5], [2, 0.5], [2, 1.5], [1, 1.5]]
    body = SectionBody(Section.from_polygons([("rock", square), ("ore", hole)]))
    assert body.materials == ("rock", "ore")
    assert body.sizes == pytest.approx([7.0, 1.0])
    found = body.material_at(np.array([[0.5, 1.0], [1.5, 1.0], [5.0, 1.0]]))
    assert found.tolist() == [0, 1, OUTSIDE]
    # the ground lies on the left of its outline: the area inside is 8 m2 (shoelace)
    ends = body.surfaces[0].corners
    area = 0.5 * (ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 1, 0] * ends[:, 0, 1]).sum()
    assert area == pytest.approx(8.0)


def test_layers_count_from_the_top():
    body = box_body((2.0, 3.0, 5.0), [("soil", 1.0), ("rock", 3.0), ("soil", 9.0)], origin=(1.0, 0.0, -5.0))
    assert body.materials == ("soil", "rock")
    assert body.sizes == pytest.approx([6.0 * 2.0, 6.0 * 3.0])
    inside = np.array([[2.0, 1.0, -0.5], [2.0, 1.0, -1.5], [2.0, 1.0, -4.5], [0.5, 1.0, -1.0]])
    assert body.material_at(inside).tolist() == [0, 1, 0, OUTSIDE]


def test_a_box_is_filled_with_its_mass():
    body = box_body((4.0, 2.0), [("rock", 1.0)])
    filling = fill_body(body, arrangement="square", radius=0.1)
    density = filling.density({"rock": 2500.0})
    assert float((density * np.pi * filling.radii**2).sum()) == pytest.approx(2500.0 * 8.0)


@pytest.mark.parametrize(
    ("size", "layers", "match"),
    [
        ((1.0,), [("a", 1.0)], "sides"),
        ((1.0, 1.0), [], "layers"),
        ((1.0, 1.0), [("a", 2.0), ("b", 1.0)], "thick"),
    ],
)
def test_boxes_that_are_none(size, layers, match):
    with pytest.raises(InputError, match=match):
        box_body(size, layers)
