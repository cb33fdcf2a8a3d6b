"""A process that carries out orders: they come pickled through its input, what happens goes pickled to its output.

Started by `geodem.laboratory.workers`; ends with its input.
"""

from __future__ import annotations

import os
import pickle
import sys
import traceback
from typing import BinaryIO

from ..errors import InputError


def main() -> None:
    """Serve until there is no more."""
    # what anything prints must not come between the messages
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    try:
        while True:
            try:
                order = pickle.load(sys.stdin.buffer)
            except EOFError:
                return
            _serve(order, answers)
    except (BrokenPipeError, KeyboardInterrupt):
        # the one who would read it has gone
        os._exit(1)


def _serve(order: object, answers: BinaryIO) -> None:
    from .orders import TestOrder, carry_out

    def say(*message: object) -> None:
        pickle.dump(message, answers)
        answers.flush()

    assert isinstance(order, TestOrder)
    try:
        say("done", carry_out(order, lambda strain, stress: say("at", strain, stress)))
    except InputError as error:
        say("refused", error.place, error.problem, error.remedy, error.value)
    except BrokenPipeError:
        raise
    except Exception:
        say("failed", traceback.format_exc())


if __name__ == "__main__":
    main()
