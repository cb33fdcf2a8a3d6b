"""What a run tells whoever watches it."""

from __future__ import annotations

import math
from typing import NamedTuple


class RunUpdate(NamedTuple):
    """Where a run is.

    Attributes
    ----------
    stage : str
        What is done, in a word: "build", "settle".
    text : str
        What is done, in words. A new one is a new line where there is no terminal.
    detail : str
        How far it is; shown on a terminal only, and may change at every batch of steps.
    seconds_left : float
        NaN where nobody knows.
    """

    stage: str
    text: str
    detail: str = ""
    seconds_left: float = math.nan
