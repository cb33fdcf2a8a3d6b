"""Other codes as programs: how one is started, watched and ended, and how it is told that it failed."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path

LAST_WORDS = 2000
"""Characters of a program's output that an error repeats."""

TIMEOUT = 3600.0
"""Seconds after which a program is taken to hang, where nothing else is said."""


class BackendError(RuntimeError):
    """Another code is missing, failed, gave half an answer, or cannot stand for the scene."""


def start(
    name: str, command: Sequence[str], folder: Path, environment: dict[str, str], timeout: float = TIMEOUT
) -> str:
    """Run a program in `folder`; return what it printed.

    Its output goes to a file, so that nothing is lost where it has to be ended; it is ended with all its children.

    Raises
    ------
    BackendError
        It cannot be started, ends with another status than 0, says ERROR, or is not done after `timeout` seconds.
        The message repeats its last words.
    """
    printed = folder / "printed.txt"
    with printed.open("wb") as out:
        try:
            running = subprocess.Popen(
                list(command), cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=out,
                stderr=subprocess.STDOUT, start_new_session=True,
            )  # fmt: skip
        except OSError as error:
            raise BackendError(f"{name} cannot be started: {error}") from error
        try:
            status = running.wait(timeout)
        except subprocess.TimeoutExpired:
            _end(running)
            raise BackendError(
                f"{name} was not done after {timeout:g} s and was ended. {last_words(printed)}"
            ) from None
        except BaseException:
            _end(running)
            raise
    if status:
        how = f"signal {signal.Signals(-status).name}" if status < 0 else f"status {status}"
        raise BackendError(f"{name} failed ({how}). {last_words(printed)}")
    said = printed.read_text(encoding="utf-8", errors="replace")
    if "ERROR" in said:
        raise BackendError(f"{name} told of an error. {last_words(printed)}")
    return said


def _end(running: subprocess.Popen[bytes]) -> None:
    """End a program and all that it started."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(running.pid, signal.SIGKILL)
    running.wait()


def last_words(printed: Path | str) -> str:
    """The end of what a program printed, for an error."""
    said = printed if isinstance(printed, str) else printed.read_text(encoding="utf-8", errors="replace")
    said = said.strip()
    if not said:
        return "It printed nothing."
    return f"Its last words:\n{said[-LAST_WORDS:]}"


def clean_environment(**more: str) -> dict[str, str]:
    """This process's environment without what belongs to its own Python."""
    own = ("PYTHONHOME", "PYTHONPATH", "VIRTUAL_ENV", "LD_LIBRARY_PATH")
    kept = {name: value for name, value in os.environ.items() if name not in own}
    return kept | more


def refuse(name: str, reason: str) -> BackendError:
    """The error for a scene that a code's laws cannot stand for."""
    return BackendError(f"{name} cannot run this scene: {reason}")
