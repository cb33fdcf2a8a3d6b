"""What the pictures are drawn from: colours, outlines, supports, the moving mass."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.plotting import charts, drawing, scenes, theme
from geodem.plotting.check_picture import write_check_picture


def area(ring):
    """Shoelace formula."""
    x, y = np.asarray(ring)[:, 0], np.asarray(ring)[:, 1]
    return 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))


@pytest.mark.parametrize("colours", [theme.displacement_colours, theme.strain_colours])
def test_colour_maps_darken_evenly(colours):
    from skimage.color import (
        rgb2lab,
    )  # CIE Lab, an appearance model other than the one the maps are made with

    lightness = rgb2lab(colours()(np.linspace(0, 1, 256))[None, :, :3])[0, :, 0]
    steps = -np.diff(lightness)
    assert lightness[0] > 95
    assert lightness[-1] < 25
    assert steps.min() > 0.0
    assert steps.max() < 2.0 * steps.mean()


def test_materials_and_verdicts_can_be_told_apart():
    from skimage.color import deltaE_ciede2000, rgb2lab

    for names, least in ((theme.MATERIALS, 5.0), (list(theme.VERDICT_COLOURS.values()), 15.0)):
        colours = [tuple(int(name[k : k + 2], 16) / 255 for k in (1, 3, 5)) for name in names]
        lab = rgb2lab(np.array(colours)[None])[0]
        for place, one in enumerate(lab):
            for other in lab[place + 1 :]:
                assert deltaE_ciede2000(one, other) > least


def test_outline_is_one_closed_ring_of_the_grounds_area(view):
    rings = drawing.outline_rings(view.triangles)
    assert len(rings) == 1
    assert rings[0][0] == rings[0][-1]
    # the trapezoid under the slope: 64 x 7.75 + 16.5 x 12.25 + 24.5 x 12.25 / 2
    assert area(view.positions[rings[0][:-1]]) == pytest.approx(848.1875, rel=1e-3)


def test_outline_of_ground_with_a_hole():
    ring = [(0, 1, 4), (1, 5, 4), (1, 2, 5), (2, 6, 5), (2, 3, 6), (3, 7, 6), (3, 0, 7), (0, 4, 7)]
    rings = drawing.outline_rings(np.array(ring))
    assert sorted(sorted(set(chain.tolist())) for chain in rings) == [[0, 1, 2, 3], [4, 5, 6, 7]]


@pytest.mark.parametrize(
    ("side", "span"), [("left", (20, 27.75)), ("right", (20, 40)), ("bottom", (20, 84)), ("top", (67.5, 84))]
)
def test_supports_stand_where_the_ground_ends(view, side, span):
    spans = drawing.side_spans(view, side)
    assert len(spans) == 1
    np.testing.assert_allclose(spans[0], span, atol=1e-6)


def test_moving_mass_is_cut_along_the_slip_surface(view):
    failure = view.methods[0].failure
    rings = drawing.moving_polygons(view, failure.moving, failure.slip_surface)
    assert sum(area(ring) for ring in rings) == pytest.approx(failure.moving_area, rel=0.03)


def test_moving_mass_without_a_surface_is_its_triangles(view):
    moving = view.positions[:, 0] < 40.0
    rings = drawing.moving_polygons(view, moving, np.empty((0, 2)))
    assert sum(area(ring) for ring in rings) == pytest.approx(20.0 * 7.75, rel=0.08)
    assert drawing.moving_polygons(view, np.zeros_like(moving), np.empty((0, 2))) == []


def test_surfaces_that_all_but_coincide_share_a_line(view, make_result):
    with theme.style():
        _, axes = drawing.section_figure(view)
        one, two = make_result()["neighbours"]
        apart = np.asarray(two["surface"]) + np.array([3.0, 0.0])
        drawing.draw_neighbours(axes, [one, {**two, "surface": np.asarray(two["surface"]) + 0.05}])
        assert [line.get_label() for line in axes.get_lines()] == ["Bishop simplified (1.27), Spencer (1.27)"]
        drawing.draw_neighbours(axes, [one, {**two, "surface": apart}, {"method": "none", "factor": 1.0}])
        assert [line.get_label() for line in axes.get_lines()[1:]] == [
            "Bishop simplified (1.27)",
            "Spencer (1.27)",
        ]


def test_particles_belong_to_most_of_their_triangles_and_to_the_later_on_a_tie():
    triangles = np.array([[0, 1, 2], [0, 2, 3], [2, 3, 4]])
    owner = scenes.particle_materials(6, triangles, np.array([0, 0, 1]))
    assert owner.tolist() == [0, 0, 0, 1, 1, -1]


@pytest.mark.parametrize("largest", [1e-6, 0.013, 0.37, 40.0])
def test_deformation_is_drawn_at_a_round_scale(view, largest):
    direction = np.tile([0.6, -0.8], (len(view.positions), 1))
    scale = scenes.deformation_scale(view.positions, largest * direction)
    assert 0.018 * 64.0 < scale * largest <= 0.05 * 64.0 * (1 + 1e-9)  # 64 m wide
    assert scale / 10 ** np.floor(np.log10(scale * (1 + 1e-12))) == pytest.approx(1, abs=4.01)
    assert scenes.deformation_scale(view.positions, np.zeros_like(view.positions)) == 0.0


def test_photographs_are_embedded_small(tmp_path):
    from PIL import Image

    noise = np.random.default_rng(1).integers(0, 255, (2000, 3000, 3), dtype=np.uint8)
    Image.fromarray(noise).save(tmp_path / "photo.png")
    picture, kind = scenes.source_picture(tmp_path / "photo.png")
    assert kind == "image/jpeg"
    assert len(picture) < 1_000_000
    Image.fromarray(noise[:40, :60]).convert("P").save(tmp_path / "small.png")
    picture, kind = scenes.source_picture(tmp_path / "small.png")
    assert kind == "image/png"
    (tmp_path / "text.png").write_text("no picture")
    with pytest.raises(InputError, match="cannot be read"):
        scenes.source_picture(tmp_path / "text.png")


def test_check_picture_without_any_result(tmp_path, make_view):
    view = make_view(spacing=2.0, methods=[], horizontal_acceleration=-1.5, outlines=[])
    picture = write_check_picture(tmp_path / "check.png", view)
    assert (tmp_path / "check.png").read_bytes() == picture
    assert picture[:8] == b"\x89PNG\r\n\x1a\n"


def test_running_bracket_ignores_stable_factors_above_a_failed_one(make_method, view):
    trials = [
        {"factor": factor, "verdict": verdict}
        for factor, verdict in (
            (1.0, "stable"),
            (2.0, "failed"),
            (1.5, "undecided"),
            (1.6, "stable"),
            (1.4, "failed"),
        )
    ]
    method = make_method("strength-reduction", view.positions, view.triangles, 1.0, 1.4, trials=trials)
    lows, highs = charts._running_bracket(method)
    np.testing.assert_array_equal(lows, [1.0, 1.0, 1.0, 1.6, 1.0])
    np.testing.assert_array_equal(highs, [np.nan, 2.0, 2.0, 2.0, 1.4])


def test_one_trial_and_no_bracket_can_be_drawn(view):
    method = dataclasses.replace(
        view.methods[1], value=None, failed=None, stable=None, trials=view.methods[1].trials[:1], histories=[]
    )
    with theme.style():
        assert theme.png(charts.bracket_chart(method))[:4] == b"\x89PNG"
        assert theme.png(charts.history_chart(method))[:4] == b"\x89PNG"


def test_matplotlib_waits_until_it_is_needed_and_keeps_the_users_settings(view):
    code = (
        "import sys, geodem.plotting.report, geodem.plotting.check_picture;"
        "assert not {'matplotlib', 'shapely', 'scipy', 'h5py', 'PIL'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
    import matplotlib

    with matplotlib.rc_context({"font.size": 31.0, "axes.facecolor": "red"}):
        with theme.style():
            assert matplotlib.rcParams["axes.facecolor"] == "white"
        assert matplotlib.rcParams["font.size"] == 31.0
