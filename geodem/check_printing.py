"""What the checks of all kinds of cases print alike."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .units import show

if TYPE_CHECKING:
    from rich.console import Console


def print_notices(notices: Sequence[str], more: Sequence[str], console: Console) -> None:
    """Defaults under one heading, what else was noted under another."""
    taken = [text for text in notices if " is not given: " in text]
    noted = [*(text for text in notices if text not in taken), *more]
    for head, texts in (("Taken by default", taken), ("Noted", noted)):
        if texts:
            console.print(f"{head}:")
        for text in texts:
            console.print(f"  [dim]{escaped(text)}[/]")


def show_rounded(value: float, dimension: str) -> str:
    """Three significant digits with a fitting unit."""
    return show(float(f"{value:.3g}"), dimension)


def expected_time(seconds: float) -> str:
    """A time that is only about right: 0.3 s, 20 s, 5 min, 2.1 h."""
    if seconds < 60.0:
        return f"{seconds:.1g} s" if seconds < 10.0 else f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def escaped(text: str) -> str:
    """Text in which brackets are brackets, not markup."""
    from rich.markup import escape

    return escape(text)
