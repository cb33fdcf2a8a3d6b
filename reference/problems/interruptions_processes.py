"""Programs that are started to be interrupted, found again with all the processes that they have started."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import tempfile
import time
import uuid
from pathlib import Path
from typing import IO, NamedTuple

from .fuzzing_judge import ROOT

MARK = "GEODEM_INTERRUPTED_RUN"
"""Variable in the environment of a program and of all that it starts."""


class Program(NamedTuple):
    """A program under way, and the value of its mark.

    What it complains of goes to a file: a pipe would be open for as long as any process that it has started.
    """

    process: subprocess.Popen[bytes]
    mark: str
    complaints: IO[bytes]

    def wait(self, seconds: float | None = None) -> str:
        """Wait for it, and for nothing that it has started; what it complained of. Raises TimeoutExpired."""
        self.process.wait(seconds)
        with self.complaints as file:
            file.seek(0)
            return file.read().decode(errors="replace")


def start(command: list[str]) -> Program:
    """A program with its own group, as a shell starts it."""
    mark = uuid.uuid4().hex
    complaints = tempfile.TemporaryFile()  # noqa: SIM115
    running = subprocess.Popen(
        command,
        cwd=ROOT,
        env={**os.environ, MARK: mark},
        stdout=subprocess.DEVNULL,
        stderr=complaints,
        start_new_session=True,
        # a shell ignores it for what it starts in the background, and so would what is started from here
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    return Program(running, mark, complaints)


def marked(mark: str, what: str = "") -> list[int]:
    """Processes with a mark that have not ended, those of a command that holds `what`."""
    found = []
    for place in Path("/proc").iterdir():
        if place.name.isdigit():
            with contextlib.suppress(OSError):
                own = f"{MARK}={mark}".encode() in (place / "environ").read_bytes().split(b"\0")
                if own and what.encode() in (place / "cmdline").read_bytes():
                    found.append(int(place.name))
    return found


def end_all(mark: str) -> None:
    """End every process of a mark by force, as a power cut does."""
    while left := marked(mark):
        for number in left:
            with contextlib.suppress(ProcessLookupError):
                os.kill(number, signal.SIGKILL)
        time.sleep(0.01)


def left_behind(mark: str, seconds: float) -> list[int]:
    """Processes of a mark that are still there after so long."""
    end = time.monotonic() + seconds
    while (left := marked(mark)) and time.monotonic() < end:
        time.sleep(0.05)
    return left
