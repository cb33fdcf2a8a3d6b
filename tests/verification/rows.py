"""Figures that must lie within their bounds."""

from __future__ import annotations


def check(*rows):
    """Every figure is within its bound."""
    assert rows
    for row in rows:
        assert row.good, (
            f"{row.name}, {row.quantity}: {row.value:.6g} for {row.expected:.6g}, error {row.error:+.3g}"
        )
