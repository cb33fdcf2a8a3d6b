"""Long work: the part of docs/verification.md on the time left that is told, memory, and results on the way."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from reference.pages_particles import figures

WORK = "long-work"
MEMORY = "long-memory"


def long_sections(read: Callable[[str], Any], header: Callable[[Any], str], not_run: str) -> list[str]:
    """Times left by kind of run; memory and histories."""
    parts = [
        "## Long work\n",
        "### The time left that is told\n",
        "A run of every kind, in a process of its own, tells how long it still takes. The error of a time left, or of "
        "the work left, is taken over that of the whole run, and looked at once a tenth of it has passed. Where nobody "
        "can know, as in a search whose trials may go on, a time that it takes at most is told as well: a few trials "
        "near to the critical factor take a large part of all the time, and which these are shows when they have gone "
        "on for a while. Kernels were compiled before; while one is compiled a run says so, with the time that takes. "
        "How it is made: "
        "[stop and resume](how-to/resume-and-interrupt.md#how-long-it-still-takes).\n",
    ]
    parts += _table(read(WORK), WORK, header, not_run)
    parts += [
        "### Memory, and results as they come\n",
        "Memory is that of the process, at the end over a tenth of the way. A killed run is one that was ended by "
        "force after 0.7 of the time that the whole one takes.\n",
    ]
    return [*parts, *_table(read(MEMORY), MEMORY, header, not_run)]


def _table(results: Any, name: str, header: Callable[[Any], str], not_run: str) -> list[str]:
    if not results.rows:
        return [not_run.format(name=name, command=f"python -m reference run {name}") + "\n"]
    return [header(results), figures(results.rows)]
