"""A process that carries out tasks: they come pickled through its input, what happens goes pickled to its output.

Started by `geodem.laboratory.processes`; ends with its input.
"""

from __future__ import annotations

import os
import pickle
import sys
import traceback
from typing import BinaryIO

from ..errors import InputError
from .processes import Task


def main() -> None:
    """Serve until there is no more."""
    # what anything prints must not come between the messages
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    try:
        while True:
            try:
                task = pickle.load(sys.stdin.buffer)
            except EOFError:
                return
            _serve(task, answers)
    except (BrokenPipeError, KeyboardInterrupt):
        # the one who would read it has gone
        os._exit(1)


def _serve(task: Task, answers: BinaryIO) -> None:
    def say(*message: object) -> None:
        pickle.dump(message, answers)
        answers.flush()

    more = (lambda told: say("at", told),) if task.tells else ()
    try:
        say("done", task.function(*task.arguments, *more))
    except InputError as error:
        say("refused", error.place, error.problem, error.remedy, error.value)
    except BrokenPipeError:
        raise
    except Exception:
        say("failed", traceback.format_exc())


if __name__ == "__main__":
    main()
