"""Whether another code's answer is whole: every array there, of the shape that was asked for, every number finite."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .program import BackendError, last_words


def checked(code: str, found: Mapping[str, Any], shapes: Mapping[str, tuple[int, ...]], printed: str) -> None:
    """Raise BackendError, with the code's last words, where an array is absent, short or not finite."""
    for name, shape in shapes.items():
        if name not in found:
            raise BackendError(f"{code} gave half an answer: there are no {name}. {last_words(printed)}")
        got = np.shape(found[name])
        if got != shape:
            raise BackendError(
                f"{code} gave half an answer: {name} are {got} where {shape} was asked for. {last_words(printed)}"
            )
        if not np.isfinite(np.asarray(found[name], dtype=float)).all():
            first = np.argwhere(~np.isfinite(np.asarray(found[name], dtype=float)))[0].tolist()
            raise BackendError(
                f"{code} gave numbers that are not finite: {name} at {first}. {last_words(printed)}"
            )
