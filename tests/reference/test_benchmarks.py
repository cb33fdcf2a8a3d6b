"""Benchmarks of speed store what they measured, side by side."""

from __future__ import annotations

import argparse
import json
from statistics import median

import pytest

from reference import limits, results_file
from reference.backends import BACKENDS
from reference.benchmarks import alternating, peers
from reference.benchmarks import limits as limits_benchmark


def parsed(module, words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    module.add_arguments(parser)
    return parser.parse_args(words.split())


def test_two_programs_are_timed_in_turn():
    order = []

    def program(name, seconds):
        def run(steps):
            order.append((name, steps))
            return seconds

        return run

    first, second = alternating.alternate(program("a", 0.01), program("b", 0.02), seconds=1.0, rounds=3)
    assert [name for name, _ in order] == ["a", "b", *"ababab"]
    assert order[-2:] == [("a", 100), ("b", 50)]
    row = alternating.compared(first, second)
    assert (row["ratio"], row["ratio_low"], row["ratio_high"]) == (2.0, 2.0, 2.0)


def test_speed_against_a_peer_is_stored_with_both_laws(monkeypatch, tmp_path, capsys):
    missing = BACKENDS["liggghts"].available()
    if missing:
        pytest.skip(missing)
    monkeypatch.setattr(results_file, "FOLDER", tmp_path)
    words = "--scenes spheres --with liggghts --sizes 300 --threads 1 --rounds 3 --seconds 0.01"
    assert peers.main(parsed(peers, words)) == 0
    (row,) = json.loads((tmp_path / "peers.json").read_text())["rows"]
    assert (row["scene"], row["code"], row["particles"], row["threads"]) == ("spheres", "liggghts", 300, 1)
    # the same scene on both sides: as many contacts, up to those that open or close meanwhile
    assert row["contacts"] == pytest.approx(row["contacts_ours"], rel=0.05)
    assert row["ours"] == median(row["ours_all"])
    assert row["ratio"] == median(b / a for a, b in zip(row["ours_all"], row["theirs_all"], strict=True))
    assert row["held_to"] == 1.5
    assert "liggghts" in capsys.readouterr().out


@pytest.mark.skipif(limits.available() is not None, reason=str(limits.available()))
def test_speed_against_the_limits_is_stored_with_its_share_of_memory(monkeypatch, tmp_path):
    monkeypatch.setattr(results_file, "FOLDER", tmp_path)
    words = "--scenes touching --sizes 1000 --threads 1 --rounds 3 --seconds 0.01"
    assert limits_benchmark.main(parsed(limits_benchmark, words)) == 0
    (row,) = json.loads((tmp_path / "limits.json").read_text())["rows"]
    assert row["share_of_triad"] == pytest.approx(100.0 * row["pairs"] / row["ours"] / row["triad"])
    assert row["ratio_low"] <= row["ratio"] <= row["ratio_high"]
