"""One line of a table of results."""

from __future__ import annotations

from typing import NamedTuple


class Row(NamedTuple):
    """A measured figure beside the one that is expected.

    `error` and `bound` are relative to `expected` unless the quantity says otherwise; the figure is good
    where |error| <= bound. `source` says where the expected figure is from.
    """

    name: str
    quantity: str
    value: float
    expected: float
    error: float
    bound: float
    seconds: float
    source: str = ""

    @property
    def good(self) -> bool:
        """Within its bound."""
        return abs(self.error) <= self.bound


def relative(
    name: str, quantity: str, value: float, expected: float, bound: float, seconds: float, source: str = ""
) -> Row:
    """A row whose error is (value - expected) / |expected|."""
    return Row(name, quantity, value, expected, (value - expected) / abs(expected), bound, seconds, source)


def at_most(name: str, quantity: str, value: float, limit: float, seconds: float, source: str = "") -> Row:
    """A row whose error is how far the size of the value lies above a limit, over the limit; rounding is let pass."""
    # in this order of the two, what is no number stays none and is not good
    return Row(name, quantity, value, limit, max(abs(value) / limit - 1.0, 0.0), 1e-9, seconds, source)
