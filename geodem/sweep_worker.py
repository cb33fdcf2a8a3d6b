"""A process that does runs of a sweep one after the other, for `geodem.sweep_hands`.

The first line that it is given says which sweep, each further one the number of a run; the number is given back when
the run has ended, and on the way the seconds that it still takes.

It stops what it is at, so that it can be gone on with, when nobody is left to read that.
"""

from __future__ import annotations

import json
import math
import os
import queue
import sys
import threading
import time
from pathlib import Path
from typing import Any

from .case.document import read_text
from .case.sweep_reading import read_sweep
from .errors import StoppedError
from .sweep_record import LEFT, carry_out

TELL_SECONDS = 0.5
"""Between two tellings of how long a run still takes."""


def main() -> None:
    """Serve until there is no more."""
    # what anything prints must not come between the answers
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    order = json.loads(sys.stdin.readline())
    out = Path(order["out"])
    case = read_sweep(*read_text(out / "case.toml"))
    numbers: queue.Queue[int | None] = queue.Queue()
    alone = threading.Event()

    def listen() -> None:
        for line in sys.stdin:
            numbers.put(int(line))
        alone.set()
        numbers.put(None)

    threading.Thread(target=listen, daemon=True).start()
    said = 0.0

    def tell_left(update: Any) -> None:
        """How long the run still takes, where it knows."""
        nonlocal said
        left = getattr(update, "seconds_left", math.nan)
        if math.isfinite(left) and time.perf_counter() - said > TELL_SECONDS:
            said = time.perf_counter()
            print(f"{LEFT} {left:.6g}", file=answers, flush=True)

    while (number := numbers.get()) is not None:
        try:
            carry_out(
                case, case.runs[number - 1], out, threads=order["threads"], quickly=order["quick"],
                overwrite=order["overwrite"], watch=tell_left, stop_asked=alone.is_set,
            )  # fmt: skip
            print(number, file=answers, flush=True)
        except (StoppedError, BrokenPipeError):
            # the one who would read it has gone, or wants no more
            os._exit(0)


if __name__ == "__main__":
    main()
