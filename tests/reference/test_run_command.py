"""``python -m reference run``: rows are stored with their origin, and one figure out of bounds fails the run."""

from __future__ import annotations

import argparse
import json
from types import SimpleNamespace

import numpy as np
import pytest

from reference import results_file, run_command
from reference.problems.rows import relative


@pytest.mark.parametrize(("value", "status"), [(1.005, 0), (1.02, 1)])
def test_a_run_stores_its_rows_and_fails_on_a_miss(monkeypatch, tmp_path, capsys, value, status):
    rows = [relative("case", "figure", np.float64(value), np.float64(1.0), 0.01, 0.1)]
    monkeypatch.setattr(results_file, "FOLDER", tmp_path)
    monkeypatch.setitem(run_command.PROBLEMS, "ground", SimpleNamespace(run=lambda: rows))
    assert run_command.main(argparse.Namespace(name="ground")) == status
    stored = json.loads((tmp_path / "ground.json").read_text())
    assert stored["rows"][0]["good"] is (status == 0)
    assert stored["rows"][0]["error_percent"] == pytest.approx(100.0 * (value - 1.0))
    assert {"command", "date", "versions", "machine"} <= set(stored["header"])
    assert ("MISS" in capsys.readouterr().out) == (status == 1)


def test_what_is_no_number_is_never_within_a_limit():
    from reference.problems.rows import at_most

    assert at_most("a", "b", 0.5, 1.0, 0.0).good
    assert not at_most("a", "b", 1.1, 1.0, 0.0).good
    assert not at_most("a", "b", float("nan"), 1.0, 0.0).good


def test_a_group_may_be_asked_for_as_a_benchmark(monkeypatch, tmp_path):
    from reference.__main__ import main

    rows = [relative("case", "figure", 1.0, 1.0, 0.01, 0.1)]
    monkeypatch.setattr(results_file, "FOLDER", tmp_path)
    monkeypatch.setitem(run_command.PROBLEMS, "stability", SimpleNamespace(run=lambda: rows))
    assert main(["bench", "stability"]) == 0
    assert (tmp_path / "stability.json").is_file()
