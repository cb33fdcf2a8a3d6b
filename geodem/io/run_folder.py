"""The folder of a run: what already stands in it, what may be written over, and what is kept of a run that stops."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import InputError, StoppedError
from ..provenance import sources_digest, versions
from .checkpoint import CheckpointFormat, Tree, read_checkpoint, write_checkpoint
from .files import cannot_write, read_json, remove, remove_unfinished, write_json, write_whole

RESULTS = ("result.json", "checkpoint.h5")
"""Files that tell that a run has written to a folder."""

CLEARED = "cleared"
"""Status of a folder whose results are being replaced: what is left of them counts for nothing."""

PARTS = "parts"
PART = CheckpointFormat(
    "geodem-part",
    1,
    "a finished part of a run",
    "Give the folder of a run",
    "Run the case again: geodem run CASE --out DIR --overwrite",
)


class RunFolder:
    """The folder of one case's run.

    Nothing is written before `claim`. What `begin`, `keep` and `finish` write is whole at any moment, so that a run may
    be killed anywhere and goes on with the parts that it had finished.

    Parameters
    ----------
    path : pathlib.Path
    case_text : str
        What case.toml will hold: the case as it is run, its files named as they stand in the folder.
    identity : str
        Of all that decides the result, whatever the version: as of `geodem.io.checkpoint.checksum`.
    written : iterable of str
        Patterns of the files that a run writes beside those that every run writes.
    sources : mapping of str to pathlib.Path, optional
        Files and folders that the case names: place in the folder, and where they are copied from.
    """

    def __init__(
        self,
        path: Path,
        case_text: str,
        identity: str,
        *,
        written: Iterable[str] = (),
        sources: Mapping[str, Path] | None = None,
    ) -> None:
        self.path = path
        self.case_text = case_text
        self.identity = identity
        self.written = ("result.json", "report.html", "history.csv", f"{PARTS}/*.h5", *written)
        self.sources = dict(sources or {})
        self._head: dict[str, Any] = {}
        self._begun = time.perf_counter()
        self._before = 0.0

    def stored(self) -> dict[str, Any]:
        """What result.json holds where it is of this case; else nothing."""
        held = read_json(self.path / "result.json") or {}
        return held if held.get("identity") == self.identity else {}

    def finished(self, needed: Iterable[str] = ("report.html",)) -> dict[str, Any] | None:
        """The result of this case by this version of geodem; None where it is not done or a `needed` file is gone."""
        held = self.stored()
        there = all((self.path / name).is_file() for name in needed)
        done = held.get("status") == "done" and held.get("sources_digest") == sources_digest()
        return held if done and there else None

    def claim(self, *, overwrite: bool = False, shared: bool = False) -> bool:
        """Make the folder ready; whether it holds a run of the same case, to be gone on with.

        Parameters
        ----------
        overwrite : bool
            Take away what another run left, or the same one.
        shared : bool
            Others may be writing there, from other machines as well: parts of files that they are at are left alone.

        Raises
        ------
        InputError
            It is no folder, it cannot be made, it holds results of another case, or a case file that no run has
            written; nothing was touched.
        """
        folder = self.path
        if folder.exists() and not folder.is_dir():
            raise InputError(
                "--out", "there is a file of that name", "Choose another folder", value=str(folder)
            )
        ours = any((folder / name).exists() for name in RESULTS)
        case_file = folder / "case.toml"
        if not ours and case_file.exists():
            if case_file.read_text(encoding="utf-8", errors="replace") != self.case_text:
                raise InputError(
                    "--out", "the folder holds a case file, which the results would write over",
                    "Choose another folder, such as a new one within it", value=str(folder),
                )  # fmt: skip
        same = ours and bool(self.stored())
        overwrite = overwrite or is_cleared(folder)
        if ours and not same and not overwrite:
            raise InputError(
                "--out", "the folder holds results of another case",
                "Choose another folder, or add --overwrite", value=str(folder),
            )  # fmt: skip
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise cannot_write(folder, error) from error
        if not shared:
            remove_unfinished(folder)
        if ours and overwrite:
            self.void()
            for pattern in self.written:
                for path in folder.glob(pattern):
                    if path != folder / "result.json":
                        remove(path)
            return False
        return same

    def void(self) -> None:
        """Have a result that is there say that it counts for nothing.

        It stays until it is written anew: without it, what a killed run leaves would look like files of the user's.
        """
        held = read_json(self.path / "result.json")
        if held is not None:
            write_json(self.path / "result.json", {"workflow": held.get("workflow"), "status": CLEARED})

    def write_case(self) -> None:
        """case.toml as it is run, and the files that it names."""
        for place, path in self.sources.items():
            _copy(path, self.path / place)
        write_whole(self.path / "case.toml", self.case_text)

    def begin(self, head: Mapping[str, Any]) -> None:
        """Write the case, and a result that says "stopped", so that a run that is ended by force is resumed as well.

        `head` is what is known before anything is run, "workflow" among it. The clock goes on from what `stored` says.
        """
        self._before = float(self.stored().get("wall_time_s") or 0.0)
        self._head = dict(head)
        self.write_case()
        self.stop({})

    @contextmanager
    def going(
        self, head: Mapping[str, Any], partial: Callable[[], Mapping[str, Any]] | None = None
    ) -> Iterator[None]:
        """`begin`, and where the work within raises StoppedError, `stop` with what `partial` gives."""
        self.begin(head)
        try:
            yield
        except StoppedError:
            self.stop(partial() if partial is not None else {})
            raise

    def seconds(self) -> float:
        """Wall time since this was made, and of the runs that are gone on from [s]."""
        return round(self._before + time.perf_counter() - self._begun, 3)

    def whole(self, result: Mapping[str, Any], status: str = "done") -> dict[str, Any]:
        """A result with all that every run tells: what result.json will hold, for the report that comes before it."""
        seconds = result.get("wall_time_s") or self.seconds()
        told = {"wall_time_s": seconds, "status": status, "versions": versions(), **self._mark()}
        return {**self._head, **result, **told}

    def stop(self, result: Mapping[str, Any]) -> dict[str, Any]:
        """Write result.json of a run that is not finished; what it holds."""
        return write_json(self.path / "result.json", self.whole(result, "stopped"))

    def finish(self, result: Mapping[str, Any]) -> dict[str, Any]:
        """Write result.json of a finished run; what it holds. Last of all, so that "done" has all beside it."""
        return write_json(self.path / "result.json", self.whole(result))

    def keep(self, name: str, tree: Mapping[str, Any]) -> None:
        """Keep a finished part: arrays, plain data (anything JSON can hold) or further trees, by name."""
        held = {"part": dict(tree), **self._mark()}
        write_checkpoint(self.path / PARTS / f"{name}.h5", held, PART)

    def part(self, name: str) -> Tree | None:
        """A part that was kept of this case by this version, to the same bits; None where there is none."""
        try:
            held = read_checkpoint(self.path / PARTS / f"{name}.h5", PART)
        except InputError:
            return None
        if any(held.get(key) != value for key, value in self._mark().items()):
            return None
        found: Tree | None = held.get("part")
        return found

    def _mark(self) -> dict[str, Any]:
        return {"identity": self.identity, "sources_digest": sources_digest()}


def resumable(folder: Path) -> bool:
    """Whether a folder holds a run that was stopped and can be gone on with."""
    stored = read_json(folder / "result.json") or {}
    return (folder / "checkpoint.h5").is_file() or stored.get("status") == "stopped"


def is_cleared(folder: Path) -> bool:
    """Whether a folder is one whose results were being replaced when that was ended by force."""
    cleared = (read_json(folder / "result.json") or {}).get("status") == CLEARED
    return cleared and not (folder / "checkpoint.h5").is_file()


def _copy(source: Path, target: Path) -> None:
    """A file, or the files of a folder, as they are."""
    if source.is_dir():
        if source.resolve() == target.resolve():
            return
        for stale in target.iterdir() if target.is_dir() else ():
            remove(stale)
        for entry in sorted(source.iterdir()):
            if entry.is_file():
                _copy(entry, target / entry.name)
    elif source.resolve() != target.resolve():
        write_whole(target, source.read_bytes())
