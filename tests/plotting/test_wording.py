"""Numbers and verdicts in words: rounding must never move a factor out of its bracket."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geodem.plotting.wording import (
    bound,
    factor,
    found,
    gravity_verdict,
    number,
    percent,
    powers,
    seconds,
    verdict,
)


@given(
    st.floats(0.02, 200.0),
    st.floats(1e-4, 0.2),
)
def test_the_shown_factor_lies_in_its_bracket(middle, width):
    stable, failed = middle * (1 - width / 2), middle * (1 + width / 2)
    assert stable <= float(factor(0.5 * (stable + failed), stable, failed)) <= failed
    assert bound(stable, failed) != bound(failed, stable)


@pytest.mark.parametrize(
    ("entry", "shown", "how"),
    [
        ((1.261, 1.2552, 1.2668), "1.26", "stable at 1.255, failed at 1.267"),
        ((1.2575, 1.2572, 1.2578), "1.2575", "stable at 1.2572, failed at 1.2578"),
        ((1.2575, 1.25748, 1.25752), "1.2575", "stable at 1.25748, failed at 1.25752"),
        ((None, 5.0, None), "above 5.000", "stable at 5.000, no failure found"),
        ((None, None, 0.2), "below 0.200", "failed at 0.200, no stable state found"),
        ((None, None, None), "not found", "no trial was decided"),
    ],
)  # fmt: skip
def test_headline(entry, shown, how):
    value, stable, failed = entry
    told = found({"kind": "strength-reduction", "value": value, "stable": stable, "failed": failed})
    assert told == ("Factor of safety", shown, f"(strength reduction; {how})")


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ((1.25, 1.245, 1.255), ("stands", "80 %")),  # 1 / 1.25
        ((0.8, 0.796, 0.804), ("does not stand", "1.25 times")),  # 1 / 0.8
        ((1.0, 0.995, 1.005), ("at its limit",)),
        ((None, 10.0, None), ("still stands", "10.000")),
        ((None, None, 0.5), ("does not stand",)),
        ((None, None, 1.5), ("not decided",)),
        ((None, 0.5, None), ("not decided",)),
        ((None, None, None), ("No trial was decided",)),
    ],
)
def test_verdict(entry, words):
    value, stable, failed = entry
    said = verdict({"value": value, "stable": stable, "failed": failed})
    for word in words:
        assert word in said


@pytest.mark.parametrize(
    ("entry", "word"),
    [
        ((3.29, 3.27, 3.31), "multiplied by 3.29"),
        ((None, 10.0, None), "stands"),
        ((0.8, 0.796, 0.804), "does not stand"),
        ((1.0, 0.995, 1.005), "at its limit"),
        ((None, None, 1.5), "not decided"),
    ],
)
def test_gravity_verdict_never_speaks_of_safety(entry, word):
    value, stable, failed = entry
    said = gravity_verdict({"value": value, "stable": stable, "failed": failed})
    assert word in said
    assert "safety" not in said


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (21345, "21,345"),
        (51234.0, "51,234"),
        (0.0021, "0.002100"),
        (9.8e-6, "9.80·10⁻⁶"),
        (-3.2e9, "-3.20·10⁹"),
        (0.0, "0"),
        (float("nan"), "none"),
        (float("inf"), "unlimited"),
        (None, "none"),
        ("20 kPa", "20 kPa"),
        (True, "True"),
    ],
)
def test_number(value, shown):
    assert number(value) == shown


def test_percent_and_seconds():
    assert percent(1.261, 1.271) == "\N{MINUS SIGN}0.8 %"
    assert percent(1.271, 1.261) == "+0.8 %"
    assert [seconds(value) for value in (0.21, 14.2, 200, 7320, "slow")] == [
        "0.21 s",
        "14.2 s",
        "3 min 20 s",
        "2 h 2 min",
        "slow",
    ]


def test_powers_of_ten_are_written_out():
    assert powers("force below 1e-05 of 2.5e+06 N, 0.0005") == "force below 10⁻⁵ of 2.5·10⁶ N, 0.0005"
