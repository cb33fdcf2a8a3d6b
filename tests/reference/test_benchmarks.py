"""Benchmarks of speed store what they measured, side by side."""

from __future__ import annotations

import argparse
import json
from statistics import median

import pytest

from reference import limits, results_file
from reference.backends import BACKENDS
from reference.benchmarks import alternating, bond_laws, checks, features, frontier, large, peers, statics
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


def run(benchmark, words, folder, monkeypatch):
    """Rows by check that a benchmark stores."""
    monkeypatch.setattr(results_file, "FOLDER", folder)
    assert benchmark.main(parsed(benchmark, words)) == 0
    rows = json.loads((folder / f"{benchmark.NAME}.json").read_text())["rows"]
    return {row["check"]: row for row in rows}


def test_checks_are_told_as_met_or_missed(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(results_file, "FOLDER", tmp_path)
    results = checks.Results("made-up")
    results.add(checks.check("speed", [3.0, 1.0, 2.0], least=2.0))
    results.add(checks.check("memory", [5.0], unit="B", most=4.0))
    results.add(checks.check("speed", [1.0], least=2.0))
    speed, memory = json.loads((tmp_path / "made-up.json").read_text())["rows"]
    assert [checks.met(row) for row in (speed, memory)] == [False, False]
    assert (memory["measured"], memory["held_to_most"]) == (5.0, 4.0)
    told = capsys.readouterr().out.splitlines()
    assert told[0] == "speed: 2 (1 to 3), held to at least 2: met"
    assert told[1] == "memory: 5 B, held to at most 4: MISSED"
    assert checks.ratios([(1.0, 2.0), (2.0, 6.0)]) == [2.0, 3.0]


def test_equilibrium_both_ways(monkeypatch, tmp_path):
    rows = run(statics, "--cases lattice --count 300 --rounds 1", tmp_path, monkeypatch)
    first = next(iter(rows.values()))
    assert all(first["reached"])
    held = [row for row in rows.values() if row["held_to_most"] is not None]
    assert held
    assert all(checks.met(row) for row in held)


def test_features_and_searches_are_timed(monkeypatch, tmp_path):
    words = "--parts cost search threads --features gravity --few 300 --count 300 --rounds 1 --seconds 0.01"
    rows = run(features, words, tmp_path, monkeypatch)
    assert [name.split(",")[0] for name in rows] == [
        "time with gravity over bare normal contact",
        "time of a search over a force step",
        "time of a search over a force step",
        "one thread over two",
        "one thread over two",
    ]
    for row in rows.values():
        ((first, second),) = row["seconds"]
        assert row["measured"] == pytest.approx(second / first)


def test_bond_laws_are_compared_on_the_same_pairs():
    simulations = [bond_laws.bonded_specimen(2, 8.0, law) for law in bond_laws.LAWS]
    assert [s.features.bond_law for s in simulations] == list(bond_laws.LAWS)
    assert len({s.pairs.pairs for s in simulations}) == 1
    assert len({len(s.assembly.bonds) for s in simulations}) == 1


def test_features_differ_by_what_they_are_called():
    bare = features.pressed_discs(100).features
    every = features.pressed_discs(100, features.FEATURES).features
    names = (
        "shear",
        "rotation",
        "orientation",
        "gravity",
        "walls",
        "local_damping",
        "global_damping",
        "energy",
    )
    for name in (*names, "contact_viscous", "bond_viscous"):
        assert getattr(every, name), name
        assert not getattr(bare, name), name
    assert every.bond_law == "two_springs"
    assert bare.bond_law is None


def test_large_scenes_in_small(monkeypatch, tmp_path):
    monkeypatch.setattr(large, "elsewhere", lambda **task: large.run_scene(task))
    rows = run(large, "--sizes 240 380 --steps 300 --rounds 1 --threads 1", tmp_path, monkeypatch)
    sane = [row for name, row in rows.items() if checks.met(row) is not None and "time of" not in name]
    assert len(sane) >= 8
    # memory by the particle is that of a million only
    assert [row["check"] for row in sane if not checks.met(row) and row["unit"] != "B"] == []
    shuffled = next(row for name, row in rows.items() if "rows at random" in name)
    assert shuffled["sorted"][0]["contacts"] == shuffled["shuffled"][0]["contacts"]


def test_errors_fall_as_the_square_of_the_step(monkeypatch, tmp_path):
    words = "--pairs 50 --free 4 --long 5 --periods 2 --rounds 1"
    rows = run(frontier, words, tmp_path, monkeypatch).values()
    swings = {row["setting"]: row["measured"] for row in rows if row["problem"] == "swing"}
    assert swings[0.7] / swings[0.35] == pytest.approx(4.0, rel=0.05)
    # leap-frog: omega' = 2/dt asin(omega dt/2), a shorter period by (omega dt)^2/24
    rate, _ = frontier.lowest_mode(frontier.chain(4))
    assembly = frontier.cantilever(4).build()
    step = 0.5 * frontier.ParticleSimulation(assembly).critical_time_step
    assert swings[0.5] == pytest.approx((rate * step) ** 2 / 24.0, rel=0.02)
    met = [checks.met(row) for row in rows if checks.met(row) is not None]
    assert met == [True] * 3
    rests = [row["measured"] for row in rows if row["problem"] == "rest" and row["setting"] == 1e-6]
    assert max(rests) < 1e-4
