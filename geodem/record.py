"""What is known of one search for a factor, and its way into a checkpoint and back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .io.history import write_history
from .measure.energy import EnergyAccount
from .stability.bracket import Trial
from .stability.search import Search, Snapshot
from .state import FIELDS, State

HISTORY_COLUMNS = (
    "method [-]",
    "model [-]",
    "factor [-]",
    "step [-]",
    "unbalanced force ratio [-]",
    "displacement of what moves [m]",
)


@dataclass
class MethodRecord:
    """What is known of one method: all of it goes into the checkpoint."""

    kind: str
    coarse: list[Trial] = field(default_factory=list)
    coarse_value: float | None = None
    fine: list[Trial] = field(default_factory=list)
    stable: Snapshot | None = None
    failed: Snapshot | None = None
    current: float | None = None
    history: list[tuple[int, float, float]] = field(default_factory=list)
    state: State | None = None
    zero_dilation: list[Trial] = field(default_factory=list)
    done: bool = False

    def to_tree(self) -> dict[str, Any]:
        """As a checkpoint tree."""
        tree: dict[str, Any] = {
            "kind": self.kind,
            "coarse": [t.as_dict(history=True) for t in self.coarse],
            "coarse_value": self.coarse_value,
            "fine": [t.as_dict(history=True) for t in self.fine],
            "zero_dilation": [t.as_dict(history=True) for t in self.zero_dilation],
            "current": self.current,
            "history": self.history,
            "done": self.done,
        }
        for name, snapshot in (("stable", self.stable), ("failed", self.failed)):
            if snapshot is not None:
                tree[name] = {
                    "factor": snapshot.factor,
                    "energy": list(snapshot.energy),
                    "state": _state_tree(snapshot.state),
                }
        if self.state is not None and self.current is not None:
            tree["state"] = _state_tree(self.state)
        return tree

    @classmethod
    def from_tree(cls, tree: Mapping[str, Any]) -> MethodRecord:
        """From a checkpoint tree."""
        snapshots = {
            name: Snapshot(
                tree[name]["factor"], _state_from(tree[name]["state"]), EnergyAccount(*tree[name]["energy"])
            )
            for name in ("stable", "failed")
            if name in tree
        }
        return cls(
            kind=tree["kind"],
            coarse=[_trial(t) for t in tree["coarse"]],
            coarse_value=tree["coarse_value"],
            fine=[_trial(t) for t in tree["fine"]],
            zero_dilation=[_trial(t) for t in tree["zero_dilation"]],
            current=tree["current"],
            history=[(int(a), b, c) for a, b, c in tree["history"]],
            state=_state_from(tree["state"]) if "state" in tree else None,
            done=tree["done"],
            **snapshots,
        )


def write_trials(path: Path, records: Iterable[MethodRecord], under_way: Search | None = None) -> None:
    """history.csv: every trial's unbalanced force and displacement, batch by batch.

    Parameters
    ----------
    path : pathlib.Path
    records : iterable of MethodRecord
    under_way : Search, optional
        One on a coarse model, whose trials are not in its record yet.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    write_history(path, HISTORY_COLUMNS, _lines(records, under_way))


def _lines(records: Iterable[MethodRecord], under_way: Search | None) -> Iterator[tuple[object, ...]]:
    for record in records:
        for trial in (*record.coarse, *record.fine):
            for entry in trial.history:
                yield (record.kind, trial.model, trial.factor, *entry)
        if record.current is not None:
            for entry in record.history:
                yield (record.kind, "fine", record.current, *entry)
    if under_way is None:
        return
    for trial in under_way.trials:
        for entry in trial.history:
            yield (under_way.method.kind, trial.model, trial.factor, *entry)
    if under_way.current is not None:
        for entry in under_way.history:
            yield (under_way.method.kind, under_way.model, under_way.current, *entry)


def _trial(data: Mapping[str, Any]) -> Trial:
    history = [(int(a), b, c) for a, b, c in data["history"]]
    return Trial(**{**data, "history": history})


def _state_tree(state: State) -> dict[str, Any]:
    return {**state.arrays(), "numbers": state.numbers()}


def _state_from(tree: Mapping[str, Any]) -> State:
    return State(**{field.name: tree[field.name] for field in FIELDS}, **tree["numbers"])
