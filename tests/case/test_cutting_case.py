"""A case of cutting: read, written again, and all that is wrong in it told at once."""

import math
from dataclasses import replace

import pytest

from geodem.case.cutting_reading import parse_cutting
from geodem.errors import InputError, InputErrors
from tests.cutting_cases import TEXT, small_text


def errors_of(text, tmp_path):
    with pytest.raises(InputError) as raised:
        parse_cutting(text, tmp_path)
    found = raised.value.errors if isinstance(raised.value, InputErrors) else [raised.value]
    return {error.place: error for error in found}


def test_the_template_is_read_in_si(tmp_path):
    case = parse_cutting(TEXT, tmp_path)
    assert case.plan.depth == pytest.approx(0.004)
    assert case.plan.tool.rake == pytest.approx(math.radians(15.0))
    assert case.plan.tool.friction_angle == pytest.approx(math.radians(20.0))
    assert case.scene.boundary["left"] == "fixed"
    assert case.scene.materials["sandstone"].contact["rolling_friction"] == 1.0
    # defaults are told
    assert any("tool.height" in notice for notice in case.notices)


def test_what_is_written_is_read_as_the_same(tmp_path):
    text = small_text(start='"-3 mm"', height='"20 mm"', wear_flat='"1.5 mm"', tip_radius='"0.5 mm"')
    case = parse_cutting(text, tmp_path)
    again = parse_cutting(case.as_run_text(), tmp_path)
    assert again.plan == case.plan
    assert again.as_run_text() == case.as_run_text()
    assert again.seed == case.seed
    assert replace(again.scene, source=case.scene.source).materials == case.scene.materials


@pytest.mark.parametrize(
    ("keys", "place", "words"),
    [
        ({"rake": '"85 deg"'}, "tool.rake", "slanted"),
        ({"rake": '"70 deg"', "clearance": '"20 deg"'}, "tool.rake", "clearance"),
        ({"rake": "15"}, "tool.rake", ""),
        ({"clearance": '"0 deg"'}, "tool.clearance", "rub"),
        ({"distance": '"-5 mm"'}, "tool.distance", "away"),
        ({"speed": '"-1 m/s"'}, "tool.speed", "away"),
        ({"speed": '"400 m/s"'}, "tool.speed", "fast"),
        ({"height": '"2 mm"'}, "tool.height", "below the surface"),
        ({"wear_flat": '"-1 mm"'}, "tool.wear_flat", "negative"),
        ({"tip_radius": '"200 m"'}, "tool.tip_radius", "takes up most of the face"),
        ({"colour": '"red"'}, "tool.colour", "unknown key"),
    ],
)
def test_bad_input_names_its_key_and_says_what_to_do(keys, place, words, tmp_path):
    found = errors_of(small_text(**keys), tmp_path)
    assert place in found
    assert words in found[place].problem
    assert found[place].remedy


def test_lengths_and_speeds_are_told_with_their_units(tmp_path):
    found = errors_of(small_text(tip_radius='"200 m"'), tmp_path)
    assert str(found["tool.tip_radius"]).startswith("tool.tip_radius = '200 m': ")


def test_all_errors_come_at_once(tmp_path):
    found = errors_of(
        small_text(rake='"x"', speed='"0 m/s"').replace('bottom = "fixed"', 'bottom = "glued"'), tmp_path
    )
    assert {"tool.rake", "tool.speed", "boundary.bottom"} <= set(found)


def test_a_case_without_a_tool_says_so(tmp_path):
    text = small_text()
    found = errors_of(text[: text.index("[tool]")], tmp_path)
    assert found["tool"].problem == "missing"


def test_a_cut_is_2d(tmp_path):
    text = small_text().replace('box = ["30 mm", "18 mm"]', 'box = ["30 mm", "18 mm", "10 mm"]')
    assert "2D" in errors_of(text, tmp_path)["source"].problem
