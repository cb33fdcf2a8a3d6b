"""Numbers with units: text such as "25 kPa" to SI floats and back.

Together with the case file this is the only place that knows units; everything below works in SI (m, Pa,
N/m3, kg/m3, rad, m/s2). Conversion is correctly rounded, so that "0.1 GPa", "100 MPa" and "1e8 Pa" are the
same bits.
"""

from __future__ import annotations

import difflib
import math
import re
import unicodedata
from fractions import Fraction
from typing import NamedTuple

from geodem.errors import InputError

GRAVITY = 9.81
"""Acceleration of gravity [m/s2]: turns a unit weight into a density, and is the unit "g".

Rounded as geotechnical practice rounds it (not the standard 9.80665), so that 1 t/m3 weighs 9.81 kN/m3.
"""

_POUND_FORCE = Fraction("4.4482216152605")  # [N], exact by definition
_FOOT = Fraction("0.3048")  # [m], exact by definition
_INCH = Fraction("0.0254")


class _Dimension(NamedTuple):
    name: str  # with its article, as a message needs it
    example: str
    units: dict[str, Fraction]  # symbol: size in SI
    shown: tuple[tuple[str, float], ...]  # symbol, smallest magnitude [SI] it is chosen for


def _sizes(units: dict[str, int | str | Fraction]) -> dict[str, Fraction]:
    return {symbol: Fraction(size) for symbol, size in units.items()}


_DIMENSIONS: dict[str, _Dimension] = {
    "length": _Dimension(
        "a length",
        "0.5 m",
        _sizes({"m": 1, "mm": "1e-3", "cm": "1e-2", "km": 1000, "ft": _FOOT, "in": _INCH}),
        (("mm", 0.0), ("m", 0.01), ("km", 1e4)),
    ),
    "area": _Dimension(
        "an area",
        "2 m2",
        _sizes({"m2": 1, "mm2": "1e-6", "cm2": "1e-4", "km2": "1e6", "ft2": _FOOT**2, "in2": _INCH**2}),
        (("m2", 0.0),),
    ),
    "stress": _Dimension(
        "a stress",
        "25 kPa",
        _sizes({"Pa": 1, "kPa": 1000, "MPa": "1e6", "GPa": "1e9", "bar": "1e5"})
        | _sizes({"N/m2": 1, "kN/m2": 1000, "MN/m2": "1e6", "N/mm2": "1e6"})
        | _sizes({"psf": _POUND_FORCE / _FOOT**2, "ksf": 1000 * _POUND_FORCE / _FOOT**2})
        | _sizes({"psi": _POUND_FORCE / _INCH**2, "ksi": 1000 * _POUND_FORCE / _INCH**2}),
        (("Pa", 0.0), ("kPa", 10.0), ("MPa", 1e6), ("GPa", 1e9)),
    ),
    "unit_weight": _Dimension(
        "a unit weight",
        "20 kN/m3",
        _sizes({"N/m3": 1, "kN/m3": 1000, "MN/m3": "1e6", "pcf": _POUND_FORCE / _FOOT**3}),
        (("N/m3", 0.0), ("kN/m3", 10.0)),
    ),
    "density": _Dimension(
        "a density",
        "2000 kg/m3",
        _sizes({"kg/m3": 1, "t/m3": 1000, "g/cm3": 1000}),
        (("kg/m3", 0.0),),
    ),
    "angle": _Dimension(
        "an angle",
        "30 deg",
        _sizes({"deg": Fraction(math.pi) / 180, "°": Fraction(math.pi) / 180, "rad": 1}),
        (("deg", 0.0),),
    ),
    "acceleration": _Dimension(
        "an acceleration",
        "0.15 g",
        _sizes({"g": str(GRAVITY), "m/s2": 1}),
        (("m/s2", 0.0),),
    ),
    "velocity": _Dimension(
        "a velocity",
        "0.1 m/s",
        _sizes({"m/s": 1, "mm/s": "1e-3", "cm/s": "1e-2", "km/h": "5/18", "ft/s": _FOOT}),
        (("mm/s", 0.0), ("m/s", 0.01)),
    ),
    "force": _Dimension(
        "a force",
        "50 kN",
        _sizes({"N": 1, "kN": 1000, "MN": "1e6", "lbf": _POUND_FORCE, "kip": 1000 * _POUND_FORCE}),
        (("N", 0.0), ("kN", 1e3), ("MN", 1e6)),
    ),
    "line_load": _Dimension(
        "a force per metre",
        "50 kN/m",
        _sizes({"N/m": 1, "kN/m": 1000, "MN/m": "1e6"}),
        (("N/m", 0.0), ("kN/m", 1e3), ("MN/m", 1e6)),
    ),
    "joint_stiffness": _Dimension(
        "a stiffness per area (stress per displacement)",
        "10 GPa/m",
        _sizes({"Pa/m": 1, "kPa/m": 1000, "MPa/m": "1e6", "GPa/m": "1e9"})
        | _sizes({"kPa/mm": "1e6", "MPa/mm": "1e9", "GPa/mm": "1e12"}),
        (("Pa/m", 0.0), ("kPa/m", 1e3), ("MPa/m", 1e6), ("GPa/m", 1e9)),
    ),
    "unit_mass": _Dimension(
        "a mass per length",
        "4 kg/m",
        _sizes({"kg/m": 1, "t/m": 1000, "g/m": "1e-3"}),
        (("kg/m", 0.0),),
    ),
    "time": _Dimension(
        "a time",
        "0.1 s",
        _sizes({"s": 1, "ms": "1e-3", "us": "1e-6", "µs": "1e-6", "min": 60, "h": 3600, "d": 86400}),
        (("s", 0.0),),
    ),
    "dimensionless": _Dimension(
        "a number without a unit",
        "0.3",
        _sizes({"": 1, "%": "1e-2", "percent": "1e-2"}),
        (("", 0.0),),
    ),
    "pixel_scale": _Dimension(
        "a picture scale (length per pixel)",
        "0.25 m/px",
        _sizes({"m/px": 1, "mm/px": "1e-3", "cm/px": "1e-2", "km/px": 1000, "ft/px": _FOOT, "in/px": _INCH}),
        (("mm/px", 0.0), ("m/px", 0.01)),
    ),
}

_ALIASES = {
    "degree": "deg",
    "degrees": "deg",
    "radian": "rad",
    "radians": "rad",
    "m/pixel": "m/px",
    "mm/pixel": "mm/px",
    "cm/pixel": "cm/px",
    "lbf/ft2": "psf",
    "lbf/in2": "psi",
    "lbf/ft3": "pcf",
}

_OWNER = {symbol: dimension for dimension, entry in _DIMENSIONS.items() for symbol in entry.units}

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_COMMA = re.compile(r"([+-]?\d+)((?:,\d+)+)(\.\d+)?\s*(.*)")
_POINT_AND_COMMA = re.compile(r"[+-]?\d+(?:\.\d+)+,\d+")
_RANGE = re.compile(r"(?:-|–|—|±|\.\.+|…|to |\+/-)\s*\.?\d")
_LONGEST = 80  # characters; nobody means a longer number, and exact arithmetic on one would take its time


def parse(text: object, dimension: str, *, place: str) -> float:
    """SI value of a number with a unit.

    Parameters
    ----------
    text : object
        What stands in the file: text such as ``"25 kPa"``; a bare number only where `dimension` has no unit.
    dimension : str
        ``length``, ``area``, ``stress``, ``unit_weight``, ``density``, ``angle``, ``acceleration``,
        ``velocity``, ``force``, ``line_load``, ``joint_stiffness``, ``unit_mass``,
        ``time``, ``dimensionless`` or ``pixel_scale``.
    place : str
        Dotted key, for the message.

    Returns
    -------
    float
        [m, m2, Pa, N/m3, kg/m3, rad, m/s2, m/s, N, N/m, Pa/m, kg/m, s, -, m/px]; always finite.

    Raises
    ------
    InputError
        No number, no unit, an unknown unit, a unit of another dimension, or a number that is not finite.
    """
    wanted = _DIMENSIONS[dimension]
    if isinstance(text, int | float) and not isinstance(text, bool):
        return _parse_bare(text, wanted, place)
    if not isinstance(text, str):
        raise InputError(
            place,
            f"{wanted.name} is needed here, not {describe(text)}",
            f"Write {_written(wanted)}.",
            value=short(text),
        )
    plain = unicodedata.normalize("NFKC", re.sub("[º˚]", "°", text)).replace("\N{MINUS SIGN}", "-").strip()
    if len(plain) > _LONGEST:
        raise InputError(
            place,
            "this is too long for a number with a unit",
            f"Write {_written(wanted)}.",
            value=short(text),
        )
    comma = _COMMA.fullmatch(plain)
    if comma:
        raise _comma_error(comma, text, place)
    both = _POINT_AND_COMMA.match(plain)
    if both:
        closed = both.group().replace(".", "").replace(",", ".") + plain[both.end() :]
        raise InputError(
            place, "there are a point and a comma in the number", f'Write "{closed}", without separators.', value=text
        )  # fmt: skip
    number = _NUMBER.match(plain)
    if number is None:
        raise _no_number(plain, text, wanted, place)
    unit = plain[number.end() :].strip()
    if _RANGE.match(unit):
        raise InputError(
            place, "this is a range, and one value is needed", "Give one; `geodem sweep` runs a case with several.",
            value=text,
        )  # fmt: skip
    if unit[:1].isdigit() or unit[:1] in {".", "'", "_"}:
        closed = re.sub(r"(?<=\d)[ '_](?=\d)", "", plain)
        raise InputError(place, "there is a gap inside the number", f'Write "{closed}".', value=text)
    symbol = re.sub(r"\^|\*\*|\s", "", unit)
    symbol = _ALIASES.get(symbol, symbol)
    if symbol not in wanted.units:
        raise _unit_error(number.group(), unit, symbol, wanted, text, place)
    value = _scaled(number.group(), wanted.units[symbol])
    if not math.isfinite(value):
        raise InputError(place, "the number is too large to be meant", "Give a finite number.", value=text)
    return value


def split(text: object) -> tuple[str, str, str] | None:
    """Number, unit and dimension of a number with a unit; None for all else.

    Parameters
    ----------
    text : object
        Text such as ``"25 kPa"``: "25", "kPa", "stress". A bare number has no unit and is dimensionless.
    """
    if isinstance(text, int | float) and not isinstance(text, bool):
        return repr(text), "", "dimensionless"
    number = _NUMBER.match(text.strip()) if isinstance(text, str) else None
    if number is None:
        return None
    assert isinstance(text, str)
    symbol = text.strip()[number.end() :].strip()
    dimension = _OWNER.get(_ALIASES.get(symbol, symbol))
    return None if dimension is None else (number.group(), symbol, dimension)


def in_unit(value: float, unit: str) -> float:
    """A value [SI] in a unit that `split` has found."""
    symbol = _ALIASES.get(unit, unit)
    return value / float(_DIMENSIONS[_OWNER[symbol]].units[symbol])


def show(value: float, dimension: str) -> str:
    """A value as a reader wants it: 25000.0 Pa is "25 kPa".

    Parameters
    ----------
    value : float
        SI; infinity is shown as "unlimited".
    dimension : str
        As for `parse`.

    Returns
    -------
    str
        Six significant digits at most, with a unit of suitable size.
    """
    if math.isinf(value):
        return "unlimited"
    symbol = _readable_unit(value, dimension)
    return f"{value / float(_DIMENSIONS[dimension].units[symbol]):.6g} {symbol}".strip()


def exact(value: float, dimension: str) -> str:
    """The shortest text in a readable unit that `parse` turns into exactly this finite value [SI]."""
    units = _DIMENSIONS[dimension].units
    symbol = _readable_unit(value, dimension)
    for digits in range(1, 18):
        number = f"{value / float(units[symbol]):.{digits}g}"
        if _scaled(number, units[symbol]) == value:
            return f"{_plain(number)} {symbol}".strip()
    base = next(symbol for symbol, size in units.items() if size == 1)
    return f"{_plain(repr(value))} {base}".strip()


def describe(value: object) -> str:
    """What kind of thing a value of a TOML file is, in words."""
    if isinstance(value, bool):
        return f"the switch {str(value).lower()}"
    if isinstance(value, int | float):
        return "a bare number"
    if isinstance(value, str):
        return "text"
    if isinstance(value, list):
        return "a list"
    if isinstance(value, dict):
        return "a table"
    return "a date or time"


def short(value: object) -> object:
    """The value itself, or the beginning of its text where that is long, for an error message."""
    if isinstance(value, int | float | bool) and abs(value) < 1e20:
        return value
    try:
        text = repr(value)
    except ValueError:  # Python refuses to write integers of thousands of digits
        return "a number of thousands of digits"
    return value if len(text) <= 72 else text[:69] + "..."


def _scaled(number: str, size: Fraction) -> float:
    approximate = float(number)
    if approximate == 0.0 or not math.isfinite(approximate):
        return approximate  # an absurd exponent must not become a fraction of a billion digits
    try:
        return float(Fraction(number) * size)
    except OverflowError:
        return math.inf


def _parse_bare(value: float, wanted: _Dimension, place: str) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(place, "the number is not finite", f"Write {_written(wanted)}.", value=short(value))
    if "" not in wanted.units:
        unit = wanted.example.split(" ", 1)[1]
        raise InputError(
            place,
            f"a bare number; {wanted.name} needs its unit",
            f'Write "{_plain(f"{number:.12g}")} {unit}" if {unit} is meant (text in quotes).',
            value=value,
        )
    return number


def _comma_error(comma: re.Match[str], text: str, place: str) -> InputError:
    whole, tail, fraction, unit = comma.groups()
    groups = tail[1:].split(",")
    as_thousands = f"{whole}{''.join(groups)}{fraction or ''} {unit}".strip()
    as_decimal = f"{whole}.{groups[0]} {unit}".strip()
    remedy = f'Write "{as_decimal}" with a decimal point.'
    if len(groups) > 1 or fraction:
        remedy = f'Write "{as_thousands}", without separators.'
    elif len(groups[0]) == 3:
        remedy = f'Write "{as_decimal}" with a decimal point, or "{as_thousands}" without separators.'
    return InputError(place, "there is a comma in the number (a decimal comma?)", remedy, value=text)


def _no_number(plain: str, text: str, wanted: _Dimension, place: str) -> InputError:
    if re.match(r"[+-]?(nan|inf)", plain, re.IGNORECASE):
        return InputError(place, "the number is not finite", f"Write {_written(wanted)}.", value=text)
    return InputError(
        place,
        f"there is no number in this; {wanted.name} is needed",
        f"Write {_written(wanted)}.",
        value=text,
    )


def _unit_error(number: str, unit: str, symbol: str, wanted: _Dimension, text: str, place: str) -> InputError:
    known = ", ".join(s for s in wanted.units if s)
    if not symbol:
        # `wanted` has units, or the empty symbol would have been known
        example = wanted.example.split(" ", 1)[1]
        return InputError(
            place,
            f"the unit is missing; {wanted.name} needs one",
            f'Write "{number} {example}" if {example} is meant; known: {known}.',
            value=text,
        )
    special = _special_unit(float(number), symbol, wanted)
    if special is not None:
        return InputError(place, special[0], special[1], value=text)
    if symbol in _OWNER:
        problem = (
            f"{unit} is the unit of {_DIMENSIONS[_OWNER[symbol]].name}, and {wanted.name} is needed here"
        )
        return InputError(place, problem, f"Write {_written(wanted)}; known: {known or 'none'}.", value=text)
    return InputError(
        place, f"unknown unit {unit!r}", f"{_nearest_unit(symbol, wanted)}Known here: {known}.", value=text
    )


def _special_unit(number: float, symbol: str, wanted: _Dimension) -> tuple[str, str] | None:
    """Problem and remedy for units that people do write and that need more than a list of known ones."""
    if symbol == "mPa":
        return (
            "mPa is a millipascal",
            f'Write "{number:g} MPa" for megapascals, "{number:g} kPa" for kilopascals.',
        )
    mass_per_area = {"t/m2": 1e3, "tf/m2": 1e3, "kg/m2": 1.0, "kgf/m2": 1.0, "kg/cm2": 1e4, "kgf/cm2": 1e4}
    if symbol in mass_per_area and "Pa" in wanted.units:
        pressure = show(number * mass_per_area[symbol] * GRAVITY, "stress")
        remedy = f'Write "{pressure}" if the weight of that mass is meant (g = {GRAVITY} m/s2).'
        return f"{symbol} is a mass over an area, not a stress", remedy
    mass_per_volume = {"tf/m3": 1e3, "kgf/m3": 1.0}
    if symbol in mass_per_volume and "kN/m3" in wanted.units:
        return (
            f"{symbol} is not an SI unit",
            f'Write "{show(number * mass_per_volume[symbol] * GRAVITY, "unit_weight")}".',
        )
    if symbol in {"lb/ft3", "lbs/ft3"}:
        return f"{symbol} may be a mass or a weight", f'Write "{number:g} pcf" for a unit weight (lbf/ft3).'
    if symbol in {"px/m", "pixel/m", "px/ft", "px/mm", "px/cm"} and number > 0.0:
        return (
            "pixels per length, and length per pixel is needed",
            f'Write "{1 / number:g} {symbol[-2:].strip("/")}/px".',
        )
    if symbol in {"dpi", "ppi"}:
        return (
            f"{symbol} says how a picture is printed, not how much ground a pixel shows",
            'Divide the width of the ground by the width of the picture in pixels, as in "0.25 m/px".',
        )
    if symbol in {"px", "pixel", "pixels"}:
        return "a number of pixels is not a length", f"Write {_written(wanted)}."
    if symbol in {"kg", "t", "lb"}:
        return f"{symbol} is a mass, and {wanted.name} is needed here", f"Write {_written(wanted)}."
    if symbol in {"grad", "gon", "'", '"'}:
        return (
            f"{symbol} is not read (a 400th of a turn, or degrees?)",
            f'Write "{number:g} deg" for degrees; 1 gon is 0.9 deg.',
        )
    owner = _OWNER.get(symbol)
    if owner == "density" and "kN/m3" in wanted.units:
        weight = show(number * float(_DIMENSIONS["density"].units[symbol]) * GRAVITY, "unit_weight")
        return (
            f"{symbol} is a density, not a unit weight",
            f'Use the key density instead, or write "{weight}".',
        )
    if owner == "unit_weight" and "kg/m3" in wanted.units:
        density = show(number * float(_DIMENSIONS["unit_weight"].units[symbol]) / GRAVITY, "density")
        return (
            f"{symbol} is a unit weight, not a density",
            f'Use the key unit_weight instead, or write "{density}".',
        )
    return None


def _nearest_unit(symbol: str, wanted: _Dimension) -> str:
    candidates = [*wanted.units, *(s for s in _OWNER if s not in wanted.units)]
    folded = {s.lower(): s for s in reversed(candidates) if s}
    near = difflib.get_close_matches(symbol.lower(), folded, n=1, cutoff=0.5)
    return f"Did you mean {folded[near[0]]!r}? " if near else ""


def _readable_unit(value: float, dimension: str) -> str:
    shown = _DIMENSIONS[dimension].shown
    if value == 0.0:
        return (
            _DIMENSIONS[dimension].example.split(" ", 1)[1] if "" not in _DIMENSIONS[dimension].units else ""
        )
    return [symbol for symbol, smallest in shown if abs(value) >= smallest][-1]


def _plain(number: str) -> str:
    """Without exponent where that is as short: 1e+02 as 100."""
    value = float(number)
    if "e" in number and 1e-4 <= abs(value) < 1e16:
        return repr(int(value)) if value.is_integer() else repr(value)
    return number.removesuffix(".0")


def _written(wanted: _Dimension) -> str:
    return wanted.example if "" in wanted.units else f'it like "{wanted.example}"'
