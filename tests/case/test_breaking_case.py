"""Cases of breaking ground: what is read, what is refused with its remedy, and that writing gives the same again."""

from __future__ import annotations

import pytest

from geodem.breaking_building import build_works
from geodem.breaking_quick import quick
from geodem.case.breaking_reading import parse_breaking
from geodem.errors import InputErrors

GROUND = """\
workflow = "breaking"
title = "Small"

[source]
regions = [{material = "rock", polygon = [[0, 0], [12, 0], [12, 8], [0, 8]]}]

[particles]
particles = 120

[material.rock]
law = "two_springs"
density = "2500 kg/m3"
normal_stiffness = "1e8 N/m"
shear_stiffness = "4e7 N/m"
tensile_strength = "1e6 N"
cohesion = "2e6 N"
friction_coefficient = 0.6
width_ratio = 0.1

[material.rock.contact]
law = "linear_frictional"
normal_stiffness = "1e8 N/m"
shear_stiffness = "4e7 N/m"
friction_coefficient = 0.6

[boundary]
left = "wall"
right = "wall"
bottom = "wall"

"""
POINT = '[[point]]\nname = "top"\nat = [6, 7.5]\n\n'
SETTLE = '[[stage]]\nkind = "settle"\n\n'


def parse(text, tmp_path):
    return parse_breaking(GROUND + text, tmp_path)


def refused(text, tmp_path):
    with pytest.raises(InputErrors) as found:
        parse(text, tmp_path)
    return [str(error) for error in found.value.errors]


ALL = POINT + '[[wall]]\nname = "tray"\npoints = [[20, 0], [25, 0]]\nfriction = 0.25\n\n' + "".join(
    f"[[stage]]\n{stage}\n\n"
    for stage in (
        'kind = "settle"\nfactor = 0.5\nrest = 1e-3',
        'kind = "gravity"\nfactor = 1.0',
        'kind = "excavate"\nname = "drift"\ncentre = [6, 4]\nradius = "1.5 m"\nshares = 4',
        'kind = "excavate"\npolygon = [[0, 6], [3, 6], [3, 9], [0, 9]]\nmaterial = "rock"\ncome_to_rest = false',
        'kind = "strength"\nmaterial = ["rock"]\nfactor = 1.25',
        'kind = "gravity-increase"\ntolerance = 0.1\ngoes_on = "failed"',
        'kind = "strength-reduction"\nstart = 0.8\nhighest = 20\nmoving_share = 0.02',
        'kind = "move-wall"\nwall = "tray"\nvelocity = ["0 m/s", "-20 cm/s"]\ntime = "50 ms"',
        'kind = "remove-wall"\nwall = "bottom"\nfrom = [4, 0]\nto = [7, 0]',
        'kind = "remove-wall"\nwall = "tray"',
        'kind = "run"\ntime = "2 s"\nuntil_rest = true\nframes_every = "0.5 s"',
    )
)  # fmt: skip


def test_every_stage_is_read_and_written_to_the_same_numbers(tmp_path):
    case = parse(ALL, tmp_path)
    text = case.as_run_text()
    again = parse_breaking(text, tmp_path)
    assert again.as_run_text() == text
    assert [stage.values for stage in again.stages] == [stage.values for stage in case.stages]
    kinds = [stage.kind for stage in case.stages]
    assert kinds.count("excavate") == 2
    moved = case.stages[kinds.index("move-wall")].values
    assert moved["velocity"] == (0.0, -0.2)
    assert moved["time"] == 0.05
    assert case.walls[0].friction == 0.25
    assert case.damping == 0.7


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ('[[stage]]\nkind = "gravity-increase"\n', "stage[0].kind", "before the ground has settled"),
        (SETTLE * 2, "stage[1].kind", "since the first stage"),
        ('[[stage]]\nkind = "dig"\n', "stage[0].kind", "not one of the choices"),
        ("", "stage", "missing"),
        (SETTLE + '[[stage]]\nkind = "excavate"\n', "stage[1].polygon", "missing"),
        (SETTLE + '[[stage]]\nkind = "excavate"\ncentre = [1, 1]\n', "stage[1].centre", "radius is missing"),
        (SETTLE + '[[stage]]\nkind = "excavate"\nmaterial = "ore"\n', "stage[1].material", "no such material"),
        (SETTLE + '[[stage]]\nkind = "run"\n', "stage[1].time", "missing"),
        (SETTLE + '[[stage]]\nkind = "run"\ntime = 5\n', "stage[1].time", "unit"),
        (SETTLE + '[[stage]]\nkind = "run"\ntime = "1 s"\nfactor = 2\n', "stage[1].factor", "no such key"),
        (SETTLE + '[[stage]]\nkind = "remove-wall"\nwall = "top"\n', "stage[1].wall", "no such wall"),
        (SETTLE + '[[stage]]\nkind = "remove-wall"\nwall = "bottom"\n' * 1 + '\n[[stage]]\nkind = "remove-wall"\n'
         'wall = "bottom"\n', "stage[2].wall", "no such wall"),
        (SETTLE + '[[stage]]\nkind = "remove-wall"\nwall = "left"\nfrom = [0, 1]\n', "stage[1].from", "two ends"),
        (SETTLE + '[[stage]]\nkind = "gravity"\nfactor = -1\n', "stage[1].factor", "above 0"),
        ('[motion]\ndamping = 1.5\n\n' + SETTLE, "motion.damping", "between 0 and 1"),
        ('[[wall]]\nname = "rock"\npoints = [[0, -5], [5, -5]]\n\n' + SETTLE, "wall[0].name", "has this name"),
        (SETTLE + '[[stage]]\nkind = "run"\ntime = "1 s"\nframes_every = "1e-12 s"\n', "stage[1].frames_every",
         "1e+12 frames (10,000 at most)"),
        (SETTLE + '[[stage]]\nkind = "excavate"\nmaterial = "rock"\nshares = 1000000000\n', "stage[1].shares",
         "10,000 at most"),
        (SETTLE.replace("\n", "\npatience = 1e30\n", 1), "stage[0].patience", "at most 10000"),
        (SETTLE + '[[stage]]\nkind = "gravity-increase"\ntolerance = 1e-300\n', "stage[1].tolerance", "above 1e-06"),
        ('[loads]\ngravity = ["0 m/s2", "-9.81e30 m/s2"]\n\n' + SETTLE, "loads.gravity", "as heavy as this"),
        (POINT * 2 + SETTLE, "point[1].name", "another point"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_where_it_stands(text, place, words, tmp_path):
    errors = refused(text, tmp_path)
    assert any(error.startswith(place) and words in error for error in errors), errors


def test_all_that_is_wrong_comes_at_once(tmp_path):
    errors = refused(
        '[[stage]]\nkind = "run"\n\n[[stage]]\nkind = "dig"\n\n[motion]\ndamping = 2\n', tmp_path
    )
    assert len(errors) == 3


def test_places_without_ground_are_refused_before_anything_runs(tmp_path):
    text = '[[point]]\nname = "bird"\nat = [6, 20]\n\n' + SETTLE
    text += '[[stage]]\nkind = "excavate"\ncentre = [50, 4]\nradius = "2 m"\n'
    with pytest.raises(InputErrors) as found:
        build_works(parse(text, tmp_path))
    words = [str(error) for error in found.value.errors]
    assert any("point[0].at" in word and "in the air" in word for word in words)
    assert any("stage[1].centre" in word and "outside the ground" in word for word in words)


def test_an_opening_beside_its_wall_is_refused(tmp_path):
    text = SETTLE + '[[stage]]\nkind = "remove-wall"\nwall = "bottom"\nfrom = [40, 0]\nto = [50, 0]\n'
    with pytest.raises(ValueError, match=r"stage\[1\].from"):
        build_works(parse(text, tmp_path))


def test_a_side_with_an_opening_is_a_chain_of_pieces(tmp_path):
    text = SETTLE + '[[stage]]\nkind = "remove-wall"\nwall = "bottom"\nfrom = [4, 0]\nto = [7, 0]\n'
    works = build_works(parse(text, tmp_path))
    assert works.scene.walls == ("left", "right", "bottom, piece 0", "bottom, opening 1", "bottom, piece 1")
    pieces = {wall.name: wall for wall in works.scene.assembly.walls}
    assert pieces["bottom, opening 1"].segments[0, :, 0].tolist() == [4.0, 7.0]
    assert works.stages[1].walls == ("bottom, opening 1",)
    # as smooth as the wall that it is a piece of
    contact = pieces["bottom, piece 0"].contact["rock"]
    assert contact.friction_coefficient == 0.0


def test_quick_ground_is_as_strong_as_the_case(tmp_path):
    """Forces for each contact over the diameter are the strength of the ground."""
    big = GROUND.replace("particles = 120", "particles = 6000")
    case = parse_breaking(big + SETTLE, tmp_path)
    few = quick(case)
    assert few.scene.particles.particles == 2500
    grown = few.scene.materials["rock"].bond["tensile_strength"] / 1e6
    assert grown == pytest.approx((6000 / 2500) ** 0.5, rel=0.02)
    assert few.scene.materials["rock"].bond["normal_stiffness"] == 1e8
    assert "as strong" in few.notices[-1]
