"""One line of a table of results."""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """A measured figure beside the one that is expected.

    `error` and `bound` are relative to `expected` unless the quantity says otherwise; the figure is good
    where |error| <= bound.
    """

    name: str
    quantity: str
    value: float
    expected: float
    error: float
    bound: float
    seconds: float

    @property
    def good(self) -> bool:
        """Within its bound."""
        return abs(self.error) <= self.bound


def relative(name: str, quantity: str, value: float, expected: float, bound: float, seconds: float) -> Row:
    """A row whose error is (value - expected) / |expected|."""
    return Row(name, quantity, value, expected, (value - expected) / abs(expected), bound, seconds)
