"""Numbers with units. Expected sizes of units: BIPM SI brochure; NIST SP 811 (foot, pound-force)."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from geodem import units
from geodem.errors import InputError

DIMENSIONS = (
    "length",
    "area",
    "stress",
    "unit_weight",
    "density",
    "angle",
    "acceleration",
    "velocity",
    "force",
    "line_load",
    "dimensionless",
    "pixel_scale",
)


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("25 kPa", "stress", 25e3),
        ("25kPa", "stress", 25e3),
        ("  25   kPa ", "stress", 25e3),
        ("+2.5e1 kPa", "stress", 25e3),
        (".5 MPa", "stress", 5e5),
        ("5. Pa", "stress", 5.0),
        ("30 GPa", "stress", 3e10),
        ("25 kN/m2", "stress", 25e3),
        ("25 kN/m^2", "stress", 25e3),
        ("25 kN/m²", "stress", 25e3),
        ("25 kN / m**2", "stress", 25e3),
        ("2 N/mm2", "stress", 2e6),
        ("1 psf", "stress", pytest.approx(47.88026, rel=1e-7)),
        ("1 ksf", "stress", pytest.approx(47880.26, rel=1e-7)),
        ("1 psi", "stress", pytest.approx(6894.757, rel=1e-7)),
        ("1 bar", "stress", 1e5),
        ("20 kN/m3", "unit_weight", 20e3),
        ("20 kN/m^3", "unit_weight", 20e3),
        ("20 kN/m³", "unit_weight", 20e3),
        ("20000 N/m3", "unit_weight", 20e3),
        ("0.02 MN/m3", "unit_weight", 20e3),
        ("1 pcf", "unit_weight", pytest.approx(157.0875, rel=1e-6)),
        ("1920 kg/m3", "density", 1920.0),
        ("1.92 t/m3", "density", 1920.0),
        ("1.92 g/cm3", "density", 1920.0),
        ("180 deg", "angle", math.pi),
        ("180°", "angle", math.pi),
        ("180 º", "angle", math.pi),
        ("90 degrees", "angle", math.pi / 2),
        ("0.6 rad", "angle", 0.6),
        ("0.15 g", "acceleration", pytest.approx(1.4715, rel=1e-15)),
        ("\N{MINUS SIGN}2 m/s2", "acceleration", -2.0),
        ("2 m/s^2", "acceleration", 2.0),
        ("36 km/h", "velocity", 10.0),
        ("1 m", "length", 1.0),
        ("250 mm", "length", 0.25),
        ("25 cm", "length", 0.25),
        ("2 km", "length", 2000.0),
        ("1 ft", "length", 0.3048),
        ("1 in", "length", 0.0254),
        ("1 ft2", "area", 0.09290304),
        ("50 kN", "force", 5e4),
        ("20 kN/m", "line_load", 2e4),
        ("0.25 m/px", "pixel_scale", 0.25),
        ("250 mm/pixel", "pixel_scale", 0.25),
        (0.3, "dimensionless", 0.3),
        (2, "dimensionless", 2.0),
        ("30 %", "dimensionless", 0.3),
        ("30 percent", "dimensionless", 0.3),
    ],
)
def test_value(text: object, dimension: str, expected: float) -> None:
    assert units.parse(text, dimension, place="here") == expected


def test_the_same_stress_is_the_same_bits_in_every_unit() -> None:
    for texts in (
        ("0.1 GPa", "100 MPa", "1e5 kPa", "1e8 Pa", "100 N/mm2"),
        ("28.5 kPa", "0.0285 MPa", "28500 Pa"),
    ):
        assert len({units.parse(text, "stress", place="") for text in texts}) == 1


@pytest.mark.parametrize(
    ("text", "dimension", "words"),
    [
        (25, "stress", ["bare number", '"25 kPa"']),
        (2.5e6, "stress", ['"2500000 kPa"']),
        (20, "unit_weight", ['"20 kN/m3"']),
        (30, "angle", ['"30 deg"']),
        (0.25, "pixel_scale", ['"0.25 m/px"']),
        ("25", "stress", ["unit is missing", "25 kPa"]),
        ("25 kN/m3", "stress", ["unit of a unit weight", "a stress is needed"]),
        ("25 kPa", "unit_weight", ["unit of a stress"]),
        ("20 kN/m", "stress", ["force per metre"]),
        ("5 m", "acceleration", ["unit of a length"]),
        ("9 g", "density", ["unit of an acceleration"]),
        ("0.3 m", "dimensionless", ["unit of a length"]),
        ("25 kpa", "stress", ["unknown unit", "'kPa'"]),
        ("25 Mpa", "stress", ["'MPa'"]),
        ("25 KN/m2", "stress", ["'kN/m2'"]),
        ("25 mPa", "stress", ["millipascal", "MPa", "kPa"]),
        ("25 wibble", "stress", ["unknown unit", "Known here: Pa, kPa"]),
        ("30 grad", "angle", ["30 deg"]),
        ("10 t/m2", "stress", ["mass over an area", '"98.1 kPa"']),
        ("1 kg/cm2", "stress", ['"98.1 kPa"']),
        ("2 t/m3", "unit_weight", ["is a density", "key density", '"19.62 kN/m3"']),
        ("2 tf/m3", "unit_weight", ['"19.62 kN/m3"']),
        ("9.81 kN/m3", "density", ["is a unit weight", "key unit_weight", '"1000 kg/m3"']),
        ("120 lb/ft3", "unit_weight", ['"120 pcf"']),
        ("4 px/m", "pixel_scale", ['"0.25 m/px"']),
        ("4 px/mm", "pixel_scale", ['"0.25 mm/px"']),
        ("4 px", "length", ["pixels is not a length"]),
        ("4 kg", "length", ["is a mass"]),
        ("28,5 kPa", "stress", ["comma", '"28.5 kPa"']),
        ("1,000 kPa", "stress", ['"1.000 kPa"', '"1000 kPa"']),
        ("1,000,000 kPa", "stress", ['"1000000 kPa"']),
        ("100.000,5 kPa", "stress", ["a point and a comma", '"100000.5 kPa"']),
        ("1.000.000,5 kPa", "stress", ['"1000000.5 kPa"']),
        ("10-20 kPa", "stress", ["a range", "Give one"]),
        ("10 – 20 kPa", "stress", ["a range"]),
        ("10 kPa ± 2 kPa", "stress", ["unknown unit"]),
        ("300 dpi", "pixel_scale", ["how a picture is printed", "width of the picture in pixels"]),
        ("28 500 kPa", "stress", ["gap", '"28500 kPa"']),
        ("28_500 kPa", "stress", ["gap", '"28500 kPa"']),
        ("1.2.3 kPa", "stress", ["gap"]),
        ("nan kPa", "stress", ["not finite"]),
        ("-inf kPa", "stress", ["not finite"]),
        ("1e999 kPa", "stress", ["too large"]),
        ("1e308 GPa", "stress", ["too large"]),
        ("1e999999999 kPa", "stress", ["too large"]),
        (math.nan, "dimensionless", ["not finite"]),
        (math.inf, "stress", ["not finite"]),
        (10**400, "stress", ["not finite"]),
        pytest.param(1 << 40000, "dimensionless", ["not finite"], id="more digits than Python writes"),
        ("kPa", "stress", ["no number", "25 kPa"]),
        ("", "stress", ["no number"]),
        ("1" * 100 + " kPa", "stress", ["too long"]),
        (True, "stress", ["switch true"]),
        (["25 kPa"], "stress", ["not a list"]),
        ({}, "dimensionless", ["not a table"]),
        (None, "dimensionless", ["is needed here"]),
    ],
)
def test_refused(text: object, dimension: str, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        units.parse(text, dimension, place="material.soil.key")
    message = str(caught.value)
    assert message.startswith("material.soil.key")
    for word in words:
        assert word in message


@pytest.mark.parametrize(
    ("value", "dimension", "text"),
    [
        (25e3, "stress", "25 kPa"),
        (28.5e3, "stress", "28.5 kPa"),
        (1e8, "stress", "100 MPa"),
        (6e10, "stress", "60 GPa"),
        (0.0, "stress", "0 kPa"),
        (-2.5e3, "stress", "-2.5 kPa"),
        (math.inf, "stress", "unlimited"),
        (18.84e3, "unit_weight", "18.84 kN/m3"),
        (1920.0, "density", "1920 kg/m3"),
        (math.radians(20), "angle", "20 deg"),
        (0.5, "length", "0.5 m"),
        (0.002, "length", "2 mm"),
        (4e4, "length", "40 km"),
        (0.25, "pixel_scale", "0.25 m/px"),
        (0.3, "dimensionless", "0.3"),
    ],
)
def test_shown(value: float, dimension: str, text: str) -> None:
    assert units.show(value, dimension) == text


@given(
    st.floats(allow_nan=False, allow_infinity=False, min_value=-1e290, max_value=1e290),
    st.sampled_from(DIMENSIONS),
)
@example(0.1, "angle")
@example(5e-324, "stress")
@example(1e22, "length")
def test_exact_text_reads_back_to_the_same_bits(value: float, dimension: str) -> None:
    back = units.parse(units.exact(value, dimension), dimension, place="")
    assert back.hex() == value.hex() or back == value == 0.0


@given(st.text(max_size=30) | st.floats() | st.integers() | st.booleans(), st.sampled_from(DIMENSIONS))
def test_anything_else_is_an_input_error(text: object, dimension: str) -> None:
    refused: InputError | None = None
    try:
        value = units.parse(text, dimension, place="here")
    except InputError as error:
        refused = error
    if refused is None:
        assert math.isfinite(value)
    else:
        assert str(refused).startswith("here")
        assert len(refused.remedy) > 5
