"""Pictures of bodies: what is drawn has the colours and counts of the filling."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.fill_body import fill_body
from geodem.builders.grid_body import grid_body
from geodem.builders.segmentation import segment
from geodem.plotting.bodies import filling_figure, filling_picture, particle_colours, segmentation_figure
from geodem.plotting.theme import png, style


@pytest.fixture(scope="module")
def two():
    labels = np.zeros((20, 10), dtype=int)
    labels[10:] = 1
    body = grid_body(labels, ["soil", "rock"], 0.1).with_grains("rock")
    return fill_body(body, arrangement="pixel")


def test_grains_have_colours_of_their_own(two):
    fills = ["#ff0000", "#00ff00"]
    colours = particle_colours(two, fills)
    assert (colours[two.material == 0] == (1.0, 0.0, 0.0, 1.0)).all()
    assert not (colours[two.material == 1] == (0.0, 1.0, 0.0, 1.0)).all(axis=1).any()
    assert len(np.unique(colours[two.material == 1], axis=0)) == 1


def test_discs_are_drawn_to_scale_with_the_names_of_materials(two):
    with style():
        figure = filling_figure(two, title="Two")
        assert png(figure).startswith(b"\x89PNG")
    (axes,) = figure.axes
    assert axes.get_aspect() == 1.0
    assert axes.get_xlim() == pytest.approx((0.0, 2.0))
    assert len(axes.collections[0].get_offsets()) == 200
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["soil (100)"]


def test_a_segmentation_shows_its_thresholds(two):
    grey = np.tile(np.linspace(0.1, 0.9, 20), (10, 1))
    cut = segment(grey, thresholds=[0.3, 0.6])
    with style():
        figure = segmentation_figure(grey, cut, two, title="Ramp")
    lines = [line.get_xdata()[0] for line in figure.axes[1].lines]
    assert lines == [0.3, 0.6]
    assert figure.axes[2].get_title(loc="left") == "3 classes"
    assert figure.axes[3].get_title(loc="left") == "200 discs"


def test_spheres_are_rendered_in_their_colours():
    pytest.importorskip("pyvista")
    body = grid_body(np.zeros((4, 4, 4), dtype=int), ["rock"], 1.0)
    filling = fill_body(body, arrangement="pixel")
    with style():
        figure = filling_picture(
            filling, title="Cube", fills=["#2040ff"], shown=filling.positions[:, 2] < 2.0
        )
    image = np.asarray(figure.axes[0].images[0].get_array())
    blue = (image[..., 2] > 120) & (image[..., 0] < 90)
    assert blue.mean() > 0.3
