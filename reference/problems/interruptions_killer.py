"""A program that is ended by force, as `kill -9` does, at a chosen moment of a chosen write.

``python -m reference.problems.interruptions_killer MOMENT NUMBER PATTERN LOG OFTEN MODULE [ARGUMENT ...]``

MOMENT is "half" (half of the file is on the disk, under its unfinished name), "whole" (all of it, not yet under its
own name), "after" (under its own name) or "never". NUMBER counts the writes of files whose names match PATTERN. LOG
takes the name of every file that was written, in order; "-": none. OFTEN: of a `Scene`.

Processes that do the runs of a sweep are armed like their parent; one that is ended takes that with it, as a power cut
does.
"""

from __future__ import annotations

import importlib
import os
import re
import runpy
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

MOMENTS = ("half", "whole", "after")
WORKER = "geodem.sweep_worker"
OFTEN = 0.05
"""Seconds between two places that can be gone on from, where a scene has such."""
_fsync, _replace = os.fsync, os.replace


class Killer:
    """Counts writes, and ends this process at one of them; its parent as well where `above` says so."""

    def __init__(self, moment: str, number: int, pattern: str, log: str, *, above: bool = False) -> None:
        self.moment, self.number = moment, number
        self.pattern = re.compile(pattern)
        self.log = log
        self.left = number
        self.above = above

    def arm(self) -> None:
        """Take the place of the system's calls that every write goes through."""
        vars(os).update(fsync=self._sync, replace=self._put)

    def _sync(self, descriptor: int) -> None:
        _fsync(descriptor)
        name = Path(os.readlink(f"/proc/self/fd/{descriptor}")).name
        if (
            self.moment in ("half", "whole")
            and name.endswith(".part")
            and self._due(name[1:].rsplit(".", 2)[0])
        ):
            if self.moment == "half":
                os.ftruncate(descriptor, os.fstat(descriptor).st_size // 2)
            self._end()

    def _put(self, source: str, target: str) -> None:
        _replace(source, target)
        name = Path(target).name
        if self.log != "-":
            with open(self.log, "a") as log:
                log.write(f"{name}\n")
        if self.moment == "after" and self._due(name):
            self._end()

    def _due(self, name: str) -> bool:
        self.left -= bool(self.pattern.search(name))
        return self.left <= 0 and bool(self.pattern.search(name))

    def _end(self) -> None:
        if self.above:
            os.kill(os.getppid(), signal.SIGKILL)
        os.kill(os.getpid(), signal.SIGKILL)


def arm_workers(own: list[str]) -> None:
    """Have every process of a sweep that is started from here begin as this program, with the same orders."""
    plain = subprocess.Popen

    class Armed(plain):  # type: ignore[misc, valid-type]
        def __init__(self, command: Any, *arguments: Any, **options: Any) -> None:
            if list(command)[-1] == WORKER:
                command = [sys.executable, "-m", f"{__package__}.interruptions_killer", *own, WORKER]
            super().__init__(command, *arguments, **options)

    vars(subprocess).update(Popen=Armed)


def main() -> None:
    """Arm, and become the program."""
    moment, number, pattern, log, often, module, *arguments = sys.argv[1:]
    Killer(moment, int(number), pattern, log, above=module == WORKER).arm()
    if often:
        place, _, name = often.partition(":")
        setattr(importlib.import_module(place), name, OFTEN)
    arm_workers(sys.argv[1:6])
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
