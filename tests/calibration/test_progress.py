"""The time left of a calibration: a range, as the number of its rounds is not known before."""

from __future__ import annotations

import math
import time

import pytest

from geodem.calibration.fit import _progress


def told(number, spent, running=(), workers=1, after=3.0):
    return _progress(number, 3, 4, spent, running, workers, after, time.perf_counter())


def test_nothing_is_told_before_a_specimen_is_done():
    first = told(1, [])
    assert math.isnan(first.seconds_left)
    assert math.isnan(first.seconds_most)
    assert first.text == "round 1 of at most 3, 0 of at most 12 specimens tested"


def test_two_rounds_at_least_and_three_at_most_and_what_shows_the_bonds():
    # 10 s a specimen, three of them for what follows
    found = told(1, [9.0, 11.0])
    assert found.seconds_left == pytest.approx((10 - 2 + 3) * 10.0)
    assert found.seconds_most == pytest.approx((12 - 2 + 3) * 11.0), "as long as the longest"
    # what is under way counts, up to the mean; and to the mean once it has taken longer
    assert told(1, [10.0], running=[4.0, 8.0]).seconds_left == pytest.approx((10 - 1 + 3) * 10.0 - 12.0)
    assert told(1, [10.0], running=[4.0, 40.0]).seconds_left == pytest.approx((10 - 1 + 3) * 25.0 - 29.0)
    assert told(1, [10.0, 10.0], workers=2).seconds_left == pytest.approx(55.0)
    last = told(3, [10.0] * 10)
    assert last.seconds_left == last.seconds_most == pytest.approx(50.0)
