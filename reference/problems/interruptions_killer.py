"""A program that is ended by force, as `kill -9` does, at a chosen moment of a chosen write.

``python -m reference.problems.interruptions_killer MOMENT NUMBER PATTERN LOG MODULE [ARGUMENT ...]``

MOMENT is "half" (half of the file is on the disk, under its unfinished name), "whole" (all of it, not yet under its
own name), "after" (under its own name) or "never". NUMBER counts the writes of files whose names match PATTERN. LOG
takes the name of every file that was written, in order; "-": none.
"""

from __future__ import annotations

import os
import re
import runpy
import signal
import sys
from pathlib import Path

MOMENTS = ("half", "whole", "after")
_fsync, _replace = os.fsync, os.replace


class Killer:
    """Counts writes, and ends this process at one of them."""

    def __init__(self, moment: str, number: int, pattern: str, log: str) -> None:
        self.moment, self.number = moment, number
        self.pattern = re.compile(pattern)
        self.log = log
        self.left = number

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
            os.kill(os.getpid(), signal.SIGKILL)

    def _put(self, source: str, target: str) -> None:
        _replace(source, target)
        name = Path(target).name
        if self.log != "-":
            with open(self.log, "a") as log:
                log.write(f"{name}\n")
        if self.moment == "after" and self._due(name):
            os.kill(os.getpid(), signal.SIGKILL)

    def _due(self, name: str) -> bool:
        self.left -= bool(self.pattern.search(name))
        return self.left <= 0 and bool(self.pattern.search(name))


def main() -> None:
    """Arm, and become the program."""
    moment, number, pattern, log, module, *arguments = sys.argv[1:]
    Killer(moment, int(number), pattern, log).arm()
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
