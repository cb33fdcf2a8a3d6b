"""Times left from work done and left, and how they are told."""

from __future__ import annotations

import math
import time

import pytest
from rich.console import Console

from geodem.run_progress import LEAST, Pace, RunUpdate, Work, time_left, together
from geodem.telling import TOLD_EVERY, progress_line


@pytest.fixture
def clock(monkeypatch):
    """A clock that is set by hand."""
    now = [100.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    return now


def test_work_takes_as_long_as_it_has_taken_compiling_left_out(clock):
    compiled = [3.0]
    pace = Pace(lambda: compiled[0], done=45.0, closing=2.0)
    # what comes before the first units does not count
    clock[0] = 100.0
    assert math.isnan(pace.left(Work(50.0, 60.0))[0])
    # 20 units in 15 s, 5 s of which were compiling: 0.5 s each, and what follows
    clock[0], compiled[0] = 115.0, 8.0
    assert pace.left(Work(70.0, 40.0, 100.0)) == pytest.approx((22.0, 52.0))
    left, most = pace.left(Work(70.0, 40.0))
    assert left == pytest.approx(22.0)
    assert math.isnan(most), "nothing but what is expected"


def test_nothing_is_told_while_little_is_done(clock):
    pace = Pace(lambda: 0.0, done=-1.0)
    pace.left(Work(0.0, 1.0))
    clock[0] += 10.0
    assert math.isnan(pace.left(Work(0.5 * LEAST, 1.0))[0])
    assert pace.left(Work(2.0 * LEAST, 1.0))[0] == pytest.approx(10.0 / (2.0 * LEAST))


@pytest.mark.parametrize(
    ("units", "each"),
    [
        # the latter half of a fifth of the work; half of four units is too little to tell of a hundred
        pytest.param(20, 3.0, id="latter half"),
        pytest.param(4, 2.0, id="all of little"),
    ],
)
def test_the_pace_is_that_of_the_latter_half_or_of_a_tenth(clock, units, each):
    pace = Pace(lambda: 0.0, done=-1.0)
    pace.left(Work(0.0, 100.0))
    # a second each for the first half, three for the other
    for done in range(1, units + 1):
        clock[0] += 1.0 if done <= units // 2 else 3.0
        left, _ = pace.left(Work(done, 100.0 - done))
    assert left == pytest.approx(each * (100.0 - units))


def test_parts_of_a_run_are_added():
    assert together([Work(1.0, 2.0), Work(3.0, 4.0, 9.0)]) == Work(4.0, 6.0, 11.0)
    assert math.isnan(together([Work(1.0, 2.0), Work(3.0, 4.0)]).most)


def test_times_in_words():
    assert time_left(math.nan) == ""
    assert time_left(30.0) == "about 30 s left"
    assert time_left(120.0, 600.0) == "about 2.0 min left, 10.0 min at most"


def test_without_a_terminal_a_long_stage_is_told_again_every_minute(clock, capsys):
    with progress_line(Console(force_terminal=False, width=200)) as watch:
        watch(RunUpdate("cut", "cutting"))
        for _ in range(4):
            clock[0] += 0.4 * TOLD_EVERY
            watch(RunUpdate("cut", "cutting", "half of the way", 90.0, 300.0))
    assert capsys.readouterr().out.splitlines() == [
        "cut: cutting",
        "  half of the way, about 1.5 min left, 5.0 min at most",
    ]
