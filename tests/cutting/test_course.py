"""A small cut: forces of the parts, direction on the face, energy, and going on to the same bits."""

import math

import numpy as np
import pytest

from geodem.case.cutting_reading import parse_cutting
from geodem.cutting.course import Course
from geodem.cutting.outcome import outcome, over_way
from geodem.cutting.tool import PARTS
from geodem.cutting_building import make_cut
from tests.cutting_cases import small_case, small_text, with_tool


@pytest.fixture(scope="module")
def cut(tmp_path_factory):
    return make_cut(small_case(tmp_path_factory.mktemp("cut")))


@pytest.fixture(scope="module")
def course(cut):
    found = cut.begin()
    while not found.finished:
        found.advance()
    return found


def test_the_parts_make_up_what_the_wall_feels(course):
    c = course.columns()
    for axis in ("cutting", "normal"):
        total = sum(c[f"{axis}_{part}"] for part in PARTS)
        np.testing.assert_allclose(total, c[axis], atol=1e-6 * np.abs(c["cutting"]).max())
    assert c["cutting"].max() > 0.0


def test_the_work_is_the_force_along_the_way_and_the_account_closes(course):
    c = course.columns()
    done = np.trapezoid(c["cutting"], c["way"])
    # looks are some steps apart
    assert c["tool"][-1] == pytest.approx(done, rel=0.05)
    assert abs(c["imbalance"][-1]) < 0.01


def test_bonds_break_ahead_of_the_tip_and_pieces_come_off(course, cut):
    found = outcome(course, cut.solid_fraction)
    assert found.cracks["tension"] > 0
    assert found.cracks["ahead"] > 0
    assert found.fragments.mass.sum() == pytest.approx(course.assembly.mass.sum())
    assert found.specific_energy == pytest.approx(found.work / 0.004)


def test_a_smooth_face_feels_its_normal_alone(tmp_path):
    smooth = make_cut(with_tool(small_case(tmp_path), friction_angle=0.0))
    found = smooth.begin()
    while not found.finished:
        found.advance()
    c = found.columns()
    # tan(psi - alpha), psi = 0
    felt = c["cutting_face"] > 0.0
    assert felt.any()
    np.testing.assert_allclose(
        c["normal_face"][felt], -math.tan(math.radians(15.0)) * c["cutting_face"][felt], rtol=1e-9, atol=1e-6
    )


def test_what_moves_up_the_face_slides_and_what_moves_with_the_tool_sticks(course):
    s, felt = course.simulation, course.forces.now()
    assert felt.pressed > 0.0
    assert 0.0 <= felt.slid <= felt.pressed
    kept = s.now.copy()
    up = np.array([-math.sin(math.radians(15.0)), math.cos(math.radians(15.0))])
    s.now[:, s.columns.spin] = 0.0
    for share, slid in ((0.0, 0.0), (0.5, felt.pressed), (-0.5, 0.0)):
        s.now[:, s.columns.velocity] = course.speed() * (np.array([1.0, 0.0]) + share * up)
        assert course.forces.now().slid == pytest.approx(slid)
    # a grain that rolls up the face as it moves up does not slide: the point that touches stands still
    s.now[:, s.columns.velocity] = course.speed() * np.array([1.0, 0.0]) + 0.5 * up
    s.now[:, s.columns.spin] = 0.5 / s.now[:, [s.columns.radius]]
    assert course.forces.now().slid == pytest.approx(0.0)
    s.now[:] = kept


def test_nothing_sticks_to_the_tool_but_grains_to_each_other(tmp_path):
    rolling = small_text()
    text = rolling.replace('law = "linear_rolling"', 'law = "cohesive_frictional"')
    text = text.replace("rolling_friction = 1.0", 'adhesion = "2 kN"')
    text = text.replace("twisting_friction = 0.0", 'adhesion_shear = "3 kN"')
    assembly = make_cut(parse_cutting(text, tmp_path)).assembly
    assert assembly.contact_law == "cohesive_frictional"
    (tool,) = [wall for wall in assembly.walls if wall.name == "tool"]
    assert tool.contact["sandstone"].adhesion == tool.contact["sandstone"].adhesion_shear == 0.0


def test_a_kept_cut_goes_on_to_the_same_bits(cut, course):
    again = cut.begin()
    again.advance()
    tree = {
        "state": again.tree()["state"],
        "rows": again.tree()["rows"].copy(),
        "frames": again.tree()["frames"],
    }
    late = Course.resumed(cut.assembly, cut.plan, cut.placed, tree)
    while not late.finished:
        late.advance()
    np.testing.assert_array_equal(late.simulation.positions, course.simulation.positions)
    assert late.rows == course.rows
    assert [frame.way for frame in late.frames] == [frame.way for frame in course.frames]


def test_the_tool_sets_out_smoothly(course):
    c = course.columns()
    assert c["speed"][0] <= 0.01 * course.plan.speed
    assert c["speed"][-1] == pytest.approx(course.plan.speed)
    assert (np.diff(c["speed"]) >= 0.0).all()


def test_what_stands_in_the_way_is_let_go(cut):
    held = cut.assembly.held.any(axis=1)
    left = cut.assembly.positions[:, 0] < cut.placed.diameter
    high = cut.assembly.positions[:, 1] > cut.placed.place[1]
    assert cut.freed > 0
    assert not held[left & high].any()
    assert held[left & (cut.assembly.positions[:, 1] < 0.5 * cut.placed.place[1])].all()


def test_a_force_over_the_way_of_a_straight_line():
    # looks that lie unevenly
    way = np.concatenate([[0.0], np.linspace(1.0, 2.0, 300), np.linspace(2.01, 5.0, 100)])
    force = over_way(way, 2.0 + way, 1.0, 0.1, 1.0)
    # of a straight line from 3 to 7
    assert force.mean == pytest.approx(5.0)
    assert force.deviation == pytest.approx(4.0 / math.sqrt(12.0), rel=0.02)
    assert force.peak == pytest.approx(7.0, rel=0.02)
    # of four stretches, each ends at its peak: 4, 5, 6, 7
    assert force.peaks == pytest.approx(5.5, rel=0.03)
