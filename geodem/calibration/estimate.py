"""A value with the interval that holds the true one."""

from __future__ import annotations

from dataclasses import dataclass

CONFIDENCE = 0.95
"""Share of the cases in which an interval holds the true value."""


@dataclass(frozen=True)
class Estimate:
    """A value and the interval that holds the true one in `CONFIDENCE` of the cases."""

    value: float
    low: float
    high: float

    def times(self, factor: float) -> Estimate:
        """The same of a quantity `factor` times as large."""
        return Estimate(self.value * factor, self.low * factor, self.high * factor)
