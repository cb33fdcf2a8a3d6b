"""Outcomes of trials on disk: each a file of its own, so that an interrupted calibration repeats none of them."""

from __future__ import annotations

import hashlib
from pathlib import Path

from ..io.files import read_json, write_json
from ..provenance import sources_digest
from .trial import Outcome


class StoredOutcomes(dict[str, Outcome]):
    """Outcomes by `Trial.key` for `calibrate`; what is put in is written at once, whole or not at all.

    Parameters
    ----------
    folder : pathlib.Path
        What an earlier run left there is taken, where the same version of geodem and its libraries made it.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self.folder = folder
        for path in sorted(folder.glob("trial-*.json")):
            stored = read_json(path)
            if stored is not None and stored.get("sources") == sources_digest():
                super().__setitem__(str(stored["trial"]), stored["outcome"])

    def __setitem__(self, key: str, outcome: Outcome) -> None:
        """Raises InputError where the file cannot be written."""
        super().__setitem__(key, outcome)
        name = hashlib.sha256(key.encode()).hexdigest()[:16]
        content = {"trial": key, "sources": sources_digest(), "outcome": outcome}
        write_json(self.folder / f"trial-{name}.json", content)
