"""Spoilt input is used or refused in words, within seconds and a stated memory: `reference run fuzzing`, small."""

from __future__ import annotations

from contextlib import nullcontext

import pytest

from geodem.errors import InputError
from reference.problems.fuzzing_families import FAMILIES, fuzz, longest
from reference.problems.fuzzing_judge import Judge, limited

SEED = 7
COUNTS = {
    "cases": 120, "kinds": 60, "checks": 8, "case text": 40, "tables of runs": 30,
    "materials": 40, "pictures": 12, "meshes": 60, "terrains": 50, "checkpoints": 60,
    "histories": 30, "results": 30, "fillings": 20,
}  # fmt: skip


def test_every_family_is_tried():
    assert set(COUNTS) == set(FAMILIES)


@pytest.mark.parametrize("family", COUNTS)
def test_spoilt_input(family, tmp_path):
    judge = Judge(family, longest(family))
    # what draws is loaded by the first checks, which takes more than an input may
    with nullcontext() if family == "checks" else limited():
        fuzz(judge, tmp_path, COUNTS[family], SEED)
    assert not judge.findings, f"seed {SEED}\n" + "\n".join(map(str, judge.findings.values()))
    assert judge.cases == pytest.approx(COUNTS[family], abs=5)
    # it is spoilt indeed
    assert judge.refused > 0.3 * judge.cases
    assert judge.slowest < longest(family)


def raises(error: BaseException):
    def read() -> None:
        raise error

    return read


@pytest.mark.parametrize(
    ("error", "what"),
    [
        (KeyError("a"), "KeyError"),
        (MemoryError(), "MemoryError"),
        (SystemExit(1), "SystemExit"),
        (InputError("", "wrong", "Mend it."), "an error without its place"),
        (InputError("a", "wrong", " "), "an error without its remedy"),
        (InputError("a", "\ud800", "Mend it."), "an error that cannot be printed"),
    ],
)
def test_the_judge_sees_what_is_wrong(error, what):
    judge = Judge("own")
    judge.judge(raises(error), "given")
    assert [finding.what.split(":")[0] for finding in judge.findings.values()] == [what]


def test_the_judge_lets_words_pass_and_ends_what_hangs(monkeypatch):
    judge = Judge("own")
    judge.judge(raises(InputError("a", "wrong", "Mend it.")), "given")
    judge.judge(lambda: None, "given")
    assert (judge.cases, judge.refused, judge.findings) == (2, 1, {})
    monkeypatch.setattr("reference.problems.fuzzing_judge.SECONDS", 0.05)

    def forever() -> None:
        while True:
            pass

    judge.judge(forever, "given")
    assert "not done within" in next(iter(judge.findings.values())).what


def test_memory_is_limited():
    with limited(1 << 26), pytest.raises(MemoryError):
        bytearray(1 << 28)
    assert len(bytearray(1 << 28)) == 1 << 28
