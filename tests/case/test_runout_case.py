"""Cases of run-out from their text."""

from __future__ import annotations

import math

import pytest

from geodem.case.runout import DEFAULT_DISCS, parse_runout
from geodem.errors import InputErrors

TEXT = """
workflow = "runout"
title = "Cut"
particles = 500
tolerance = 0.05
seed = 3
[section]
length_unit = "m"
regions = [
  {material = "upper", polygon = [[0,0],[24,0],[24,4],[16,4],[8,12],[0,12]]},
  {material = "lower", polygon = [[0,0],[24,0],[24,4],[16,4],[13,7],[0,7]]},
]
[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
[material.upper]
law = "mohr_coulomb"
density = "1900 kg/m3"
cohesion = "2 kPa"
friction_angle = "25 deg"
young_modulus = "20 MPa"
poisson_ratio = 0.3
[material.lower]
law = "mohr_coulomb"
density = "2100 kg/m3"
cohesion = "4 kPa"
friction_angle = "28 deg"
young_modulus = "20 MPa"
poisson_ratio = 0.3
"""
RUNOUT = """
[runout]
mass = "section"
start = "failing"
discs = 700
beyond = "33 ft"
restitution = 0.25
residual_friction_angle = {upper = "20 deg", lower = "0.4 rad"}
"""


def test_values_are_read_in_si(tmp_path):
    own = parse_runout(TEXT + RUNOUT, tmp_path).runout
    assert (own.mass, own.start, own.discs, own.restitution) == ("section", "failing", 700, 0.25)
    assert own.beyond == pytest.approx(33 * 0.3048)
    assert own.residual_friction == pytest.approx({"upper": math.radians(20.0), "lower": 0.4})


def test_defaults_are_told(tmp_path):
    case = parse_runout(TEXT, tmp_path)
    assert case.runout.discs == DEFAULT_DISCS
    assert case.runout.residual_friction == pytest.approx(
        {"upper": math.radians(25.0), "lower": math.radians(28.0)}
    )
    told = "\n".join(case.notices)
    for key in ("mass", "start", "discs", "beyond", "restitution", "residual_friction_angle.upper"):
        assert f"runout.{key} is not given" in told
    assert "cohesion is lost" in told
    assert "methods" not in told


def test_the_case_as_run_reads_back_the_same(tmp_path):
    case = parse_runout(TEXT + RUNOUT, tmp_path)
    text = case.as_run_text()
    again = parse_runout(text, tmp_path)
    assert again.runout == case.runout
    assert again.as_run_text() == text
    assert [note for note in again.notices if "not given" in note and "dilation" not in note] == []


def test_one_angle_for_all(tmp_path):
    case = parse_runout(TEXT + '[runout]\nresidual_friction_angle = "18 deg"\n', tmp_path)
    assert set(case.runout.residual_friction.values()) == {math.radians(18.0)}


@pytest.mark.parametrize(
    ("line", "place", "word"),
    [
        ('mass = "half"', "runout.mass", "not one of the choices"),
        ("discs = 20", "runout.discs", "below 100"),
        ("restitution = 1.5", "runout.restitution", "at most 1"),
        ('beyond = "-2 m"', "runout.beyond", ""),
        ('residual_friction_angle = "45 deg"', "runout.residual_friction_angle", "flow with"),
        ('residual_friction_angle = {uper = "20 deg"}', "runout.residual_friction_angle.uper", "unknown key"),
        ("colour = 3", "runout.colour", "unknown key"),
    ],
)
def test_what_cannot_be_is_told_with_its_place(tmp_path, line, place, word):
    with pytest.raises(InputErrors) as raised:
        parse_runout(f"{TEXT}[runout]\n{line}\n", tmp_path)
    (error,) = [error for error in raised.value.errors if error.place == place]
    assert word in error.problem


def test_all_errors_at_once_those_of_the_slope_too(tmp_path):
    text = TEXT.replace('friction_angle = "28 deg"', 'friction_angle = "36 deg"').replace(
        "seed = 3", "seed = -3"
    )
    with pytest.raises(InputErrors) as raised:
        parse_runout(f'{text}[runout]\ndiscs = 20\nmethods = ["x"]\n', tmp_path)
    places = [error.place for error in raised.value.errors]
    assert {"seed", "runout.discs", "runout.methods", "runout.residual_friction_angle.lower"} <= set(places)


def test_methods_are_no_key_of_a_run_out(tmp_path):
    with pytest.raises(InputErrors, match="methods"):
        parse_runout('methods = ["gravity-increase"]\n' + TEXT, tmp_path)
