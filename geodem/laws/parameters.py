"""What the laws of contacts and bonds share about their parameters: mixing two materials, and ranges."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

Parameters = TypeVar("Parameters", bound=NamedTuple)


class Fault(NamedTuple):
    """A parameter that cannot be used."""

    field: str
    problem: str
    remedy: str


def harmonic_mean(first: float, second: float) -> float:
    """Stiffness of two halves in series, each twice as stiff as its material's: 2 k1 k2/(k1 + k2)."""
    total = first + second
    # the quotient first: exactly k for two equal k, and nothing overflows
    return 2.0 * first * (second / total) if total > 0.0 else 0.0


def poisson_of_contact(
    young_first: float, poisson_first: float, young_second: float, poisson_second: float
) -> float:
    """Poisson's ratio of the one material whose E* and G* are those of the contact of two [-].

    1/E* = sum (1 - nu^2)/E and 1/G* = sum 2 (2 - nu)(1 + nu)/E (Johnson 1985, Contact Mechanics, eqs 4.20b and 7.42);
    of one material q = G*/E* = (1 - nu)/(2 (2 - nu)), so nu = (1 - 4 q)/(1 - 2 q).
    """
    if poisson_first == poisson_second:
        return poisson_first
    # times E1 E2
    pressed = (1.0 - poisson_first**2) * young_second + (1.0 - poisson_second**2) * young_first
    sheared = 2.0 * (2.0 - poisson_first) * (1.0 + poisson_first) * young_second
    sheared += 2.0 * (2.0 - poisson_second) * (1.0 + poisson_second) * young_first
    ratio = pressed / sheared
    return (1.0 - 4.0 * ratio) / (1.0 - 2.0 * ratio)


def one_material(
    young_first: float, poisson_first: float, young_second: float, poisson_second: float
) -> tuple[float, float]:
    """E [Pa] and nu [-] of the one material whose E* and G* are those of the contact of two.

    1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2; of a material and itself: exactly its own. Source: `poisson_of_contact`.
    """
    ratio = poisson_of_contact(young_first, poisson_first, young_second, poisson_second)
    # E/(1 - nu^2) over the share that the pair's nu takes away again: exactly E for two equal materials
    share_first = (1.0 - ratio * ratio) / (1.0 - poisson_first * poisson_first)
    share_second = (1.0 - ratio * ratio) / (1.0 - poisson_second * poisson_second)
    return harmonic_mean(young_first * share_first, young_second * share_second), ratio


def mixed(
    first: Parameters,
    second: Parameters,
    *,
    series: Sequence[str] = (),
    smaller: Sequence[str] = (),
    mean: Sequence[str] = (),
) -> Parameters:
    """Parameters between two materials, field by field: harmonic mean, the smaller one, or the mean.

    Every field of the tuple is to be named once; one that is not keeps the value of `first`.
    """
    one: dict[str, float] = first._asdict()
    other: dict[str, float] = second._asdict()
    values = {name: harmonic_mean(one[name], other[name]) for name in series}
    values |= {name: min(one[name], other[name]) for name in smaller}
    values |= {name: 0.5 * one[name] + 0.5 * other[name] for name in mean}
    made: Any = first._replace(**values)
    return made


def faults(
    parameters: NamedTuple,
    *,
    positive: Sequence[str] = (),
    not_negative: Sequence[str] = (),
    may_be_infinite: Sequence[str] = (),
) -> list[Fault]:
    """Fields of `parameters` outside their range. Strengths may be infinite: such a bond never breaks."""
    found = []
    for field, value in parameters._asdict().items():
        if math.isnan(value) or (math.isinf(value) and not (value > 0.0 and field in may_be_infinite)):
            found.append(Fault(field, "must be a finite number", "Give a finite number in SI units"))
        elif field in positive and not value > 0.0:
            found.append(Fault(field, "must be greater than 0", "Give a positive number in SI units"))
        elif field in not_negative and value < 0.0:
            found.append(Fault(field, "must not be negative", "Give 0 or a positive number in SI units"))
    return found
