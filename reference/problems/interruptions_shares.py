"""Long runs of several scenes, done in shares: what is done is kept, and programs side by side share the work."""

from __future__ import annotations

import fcntl
import hashlib
import json
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from geodem.provenance import sources_digest

from .rows import Row

KEPT = 4.0 * 3600.0
"""How long rows count as those of a run that goes on [s]."""


def in_shares(names: Sequence[str], work: Callable[[str], list[Row]]) -> list[Row]:
    """Rows of all scenes, in their order.

    A scene that was done with the same sources within the last hours is not done again. Where the same is run by
    another program on this machine, each takes the scenes that nobody is at; both end with all rows.
    """
    folder = Path(tempfile.gettempdir()) / f"geodem-shares-{_sources()}"
    folder.mkdir(exist_ok=True)
    begun = time.time()
    for wait in (False, True):
        for name in names:
            done = folder / f"{name}.json"
            with _alone(folder / f"{name}.lock", wait) as free:
                if free and not (done.is_file() and begun - done.stat().st_mtime < KEPT):
                    part = done.with_suffix(".part")
                    part.write_text(json.dumps([row._asdict() for row in work(name)]))
                    part.rename(done)
    return [Row(**row) for name in names for row in json.loads((folder / f"{name}.json").read_text())]


@contextmanager
def _alone(lock: Path, wait: bool) -> Iterator[bool]:
    """Whether nobody else is at it; freed by the system, however the program ends."""
    with lock.open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
            return
        yield True


def _sources() -> str:
    """Of geodem and of these problems."""
    digest = hashlib.sha256(sources_digest().encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
