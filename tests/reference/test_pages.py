"""The generated pages, from results made up so that every figure on them can be worked out by hand."""

import json
import re

import pytest

from reference.pages import read_results, write_pages
from reference.pages_bodies import GROUPS as BODIES
from reference.pages_compare import COMPARED
from reference.pages_laboratory import GROUPS as LABORATORY
from reference.pages_particles import GROUPS
from tests.docs.pages import tables

HEADER = {
    "command": "python -m reference bench slopes",
    "date": "2026-01-02",
    "versions": {"geodem": "0.1.0", "numpy": "2.0"},
    "machine": "2 cores",
}


def _row(case, asked, error, seconds, **changes):
    row = {
        "case": case,
        "method": "strength-reduction",
        "dilation": "associated",
        "asked": asked,
        "particles": asked,
        "spacing": 0.5,
        "factor": None if error is None else 2.0 * (1.0 + error / 100.0),
        "stable": 1.0,
        "failed": 3.0,
        "undecided": [],
        "published": 2.0,
        "published_source": "Author 1950 | table 1",
        "error_percent": error,
        "seconds": seconds,
        "seconds_build": 0.25,
        "steps": 1000,
        "threads": 1,
    }
    return {**row, **changes}


ROWS = [
    _row("A", 1000, 1.0, 1.0),
    _row("B", 1000, -4.0, 2.0),
    _row("C", 1000, 0.0, 6.0),
    _row("A", 4000, 0.5, 8.0),
    _row("B", 4000, -1.5, 16.0, undecided=[1.9, 1.95]),
    _row("C", 4000, None, 16.0, failed=None),
    _row("A", 1000, 3.0, 1.0, method="gravity-increase", published=5.0),
    _row("A", 1000, -2.0, 1.0, dilation="zero"),
]
GROUND = [
    {"name": "ring", "quantity": "wall stress [Pa]", "value": 79.2e6, "expected": 80e6, "error_percent": -1.0,
     "bound_percent": 1.5, "particles": 2500, "seconds": 0.5, "source": "Kirsch 1898"},
    {"name": "ring", "quantity": "closure [m]", "value": 0.0104, "expected": 0.01, "error_percent": 4.0,
     "bound_percent": 3.0, "particles": 2500, "seconds": 0.5, "source": "Kirsch 1898"},
]  # fmt: skip


@pytest.fixture
def written(tmp_path):
    results = tmp_path / "results"
    results.mkdir()
    (results / "slopes.json").write_text(json.dumps({**HEADER, "rows": ROWS}))
    (results / "ground.json").write_text(json.dumps({"header": HEADER, "rows": GROUND}))
    write_pages(results, tmp_path / "docs")
    return tmp_path / "docs"


def _tables_below(page, heading):
    """Tables of a page below a heading, by the first cell of their lines."""
    found = tables(page)
    assert heading in found, list(found)
    return found[heading]


def test_summary_of_errors(written):
    rows = _tables_below(
        written / "verification.md",
        "Strength reduction: factor of safety, dilation angle equal to the friction angle",
    )
    # of 1, -4 and 0: mean -1, mean size 5/3, median size 1, largest 4 at B
    assert rows[0] == ["1000", "3", "-1.00", "1.67", "1.00", "4.00", "B"]
    # the open bracket of C has no error
    assert rows[1] == ["4000", "2", "-0.50", "1.00", "1.00", "1.50", "B"]
    assert rows[2] == ["A", "2", "2.02 (+1.0)", "2.01 (+0.5)"]
    assert rows[4] == ["C", "2", "2 (+0.0)", "open"]


def test_remarks_on_open_brackets_and_undecided_trials(written):
    text = (written / "verification.md").read_text()
    assert "- B at 4000: undecided at 1.9, 1.95" in text
    assert "- C at 4000: open bracket (stable 1, failed -)" in text


def test_methods_and_flow_rules_are_not_mixed(written):
    text = (written / "verification.md").read_text()
    headings = re.findall(r"^### (.*)$", text.split("## Discs and spheres")[0], flags=re.M)
    assert [heading.split(":")[0] for heading in headings] == [
        "Strength reduction", "Strength reduction", "Gravity increase", "Published answers",
    ]  # fmt: skip
    zero = _tables_below(
        written / "verification.md", "Strength reduction: factor of safety, dilation angle zero"
    )
    assert zero[0][2] == "-2.00"


def test_sources_and_origin(written):
    text = (written / "verification.md").read_text()
    assert "| A |  | gravity-increase | 5 | Author 1950 \\| table 1 |" in text
    origin = "Command: `python -m reference bench slopes`; date: 2026-01-02; "
    assert origin + "versions: geodem 0.1.0, numpy 2.0; machine: 2 cores." in text


def test_ground_figures_and_their_bounds(written):
    rows = _tables_below(written / "verification.md", "Ground")
    assert [row[6] for row in rows] == ["yes", "**no**"]
    assert rows[0][4:6] == ["-1.00", "1.5"]
    assert "1 of 2 figures lie within their bounds" in (written / "verification.md").read_text()


def test_particle_figures_and_their_bounds(tmp_path):
    results = tmp_path / "results"
    results.mkdir()
    row = {"name": "ball", "quantity": "spin [rad/s]", "value": 9.9, "expected": 10.0, "error_percent": -1.0,
           "bound_percent": 0.5, "good": False, "source": "closed form"}  # fmt: skip
    rows = [row, {**row, "value": 10.01, "error_percent": 0.1, "good": True}]
    (results / "fewbody.json").write_text(json.dumps({"header": HEADER, "rows": rows}))
    write_pages(results, tmp_path / "docs")
    page = tmp_path / "docs" / "verification.md"
    assert _tables_below(page, "One and two spheres") == [
        ["ball", "spin [rad/s]", "9.9", "10", "-1", "0.5", "**no**", "closed form"],
        ["ball", "spin [rad/s]", "10.01", "10", "+0.1", "0.5", "yes", "closed form"],
    ]
    assert "1 of 2 figures lie within their bounds" in page.read_text()


def test_comparisons_with_other_codes(tmp_path):
    results = tmp_path / "results"
    results.mkdir()
    row = {"scene": "oblique", "code": "yade", "version": "2023", "quantity": "positions", "difference": 2e-14,
           "bound": 1e-11, "good": True}  # fmt: skip
    rows = [row, {**row, "quantity": "spins", "difference": 0.0}, {**row, "scene": "beam", "difference": None,
            "good": False}, {**row, "code": "liggghts", "version": "3.8.0", "bound": None}]  # fmt: skip
    (results / "compare-fewbody.json").write_text(json.dumps({"header": HEADER, "rows": rows}))
    (results / "compare-dam-break.json").write_text(json.dumps({"header": HEADER, "rows": rows[:1]}))
    write_pages(results, tmp_path / "docs")
    page = tmp_path / "docs" / "verification.md"
    assert _tables_below(page, "A few spheres, a thousand steps") == [
        ["yade", "oblique", "positions 2.0e-14; spins 0", "1.0e-11", "yes"],
        ["yade", "beam", "positions no number", "1.0e-11", "**no**"],
        ["liggghts", "oblique", "positions 2.0e-14", "-", "yes"],
    ]
    text = page.read_text()
    assert "2 of 3 comparisons lie within their bounds" in text
    assert "Compared with yade 2023, liggghts 3.8.0." in text
    # one that has no text of its own
    assert _tables_below(page, "Dam break")[0][1] == "oblique"


def test_interruptions_are_counted_by_kind(tmp_path):
    results = tmp_path / "results"
    results.mkdir()

    def row(name, quantity, value, expected):
        return {"name": name, "quantity": quantity, "value": value, "expected": expected, "good": True}

    rows = [
        row("slope", "kills at a random moment", 3.0, 3.0),
        row("slope", "kills in writing its outputs", 4.0, 4.0),
        row("slope", "kills in all", 7.0, 7.0),
        row("slope", "broken files, other bits, errors", 1.0, 0.0),
        row("slope", "runs ended by Ctrl-C", 2.0, 2.0),
        row("slope", "wrong with runs ended by Ctrl-C", 0.0, 0.0),
        row("sweep", "runs ended by a full file", 0.0, 0.0),
        row("sweep", "wrong with runs ended by a full file", 0.0, 0.0),
    ]
    (results / "interruptions.json").write_text(json.dumps({"header": HEADER, "rows": rows}))
    write_pages(results, tmp_path / "docs")
    page = tmp_path / "docs" / "verification.md"
    assert _tables_below(page, "Runs that are ended by force") == [
        ["slope", "3", "-", "4", "2", "-", "-", "-", "-", "-", "1"],
        ["sweep", "-", "-", "-", "-", "-", "0", "-", "-", "-", "0"],
    ]
    assert "killed 7 times" in page.read_text()
    assert "**1 wrong**" in page.read_text()


def test_times(written):
    rows = _tables_below(
        written / "performance.md",
        "Strength reduction: factor of safety, dilation angle equal to the friction angle",
    )
    # seconds 1, 2 and 6
    assert rows[0] == ["1000", "3", "3", "2", "6", "0.25", "1000", "1"]


def test_picture_of_error_against_time(written):
    from PIL import Image

    assert "pictures/error_against_time.png" in (written / "performance.md").read_text()
    with Image.open(written / "pictures" / "error_against_time.png") as picture:
        assert picture.width > 600  # a panel for each of the two methods


def _check(name, measured, least=None, most=None, **details):
    return {"check": name, "unit": "s", "measured": measured, "low": 0.5 * measured, "high": measured,
            "held_to_least": least, "held_to_most": most, **details}  # fmt: skip


def test_what_the_engine_is_held_to(tmp_path):
    from PIL import Image

    results, docs = tmp_path / "results", tmp_path / "docs"
    results.mkdir()
    limits = {"scene": "touching", "particles": 10_000, "threads": 2, "ratio": 1.5, "ratio_low": 1.25,
              "ratio_high": 1.75, "share_of_triad": 0.35, "held_to_ratio": 1.6, "held_to_share": 0.3}  # fmt: skip
    peer = {"scene": "bonded-discs", "code": "yade", "particles": 10_000, "threads": 1, "ratio": 30.0,
            "ratio_low": 29.0, "ratio_high": 31.0, "held_to": 20.0}  # fmt: skip
    point = {"problem": "rest", "driver": "relaxation"}
    frontier = [
        _check("error at 1e-3", 1e-3, most=1e-4, setting=1e-3, seconds=[0.1, 0.3, 0.2], **point),
        _check("error at 1e-5", 1e-5, setting=1e-5, seconds=[1.0, 2.0, 4.0], **point),
    ]
    for name, rows in {
        "limits": [limits], "peers": [peer], "frontier": frontier,
        "features": [_check("first step", 0.2, most=0.3), _check("gravity", 1.0)],
    }.items():  # fmt: skip
        (results / f"{name}.json").write_text(json.dumps({"header": HEADER, "rows": rows}))
    assert docs / "pictures" / "engine_error_against_time.png" in write_pages(results, docs)
    page = docs / "performance.md"
    assert _tables_below(page, "Against what the machine allows") == [
        ["speed over the same loop in C, 10000 touching spheres, 2 threads", "at least 1.6", "1.5", "1.25 to 1.75",
         "**no**"],
        ["share of the triad, 10000 touching spheres, 2 threads", "at least 0.3", "0.35", "-", "yes"],
    ]  # fmt: skip
    assert _tables_below(page, "Against other codes")[0][:3] == [
        "speed over YADE, 10000 bonded discs, 1 thread", "at least 20", "30",
    ]  # fmt: skip
    assert _tables_below(page, "What features cost, and what rest saves") == [
        ["first step", "at most 0.3 s", "0.2 s", "0.1 to 0.2", "yes"],
        ["gravity", "-", "1 s", "0.5 to 1", "-"],
    ]
    # what is held to something, then every point of the curves
    curve = _tables_below(page, "Run time against error")
    assert [row[-1] for row in curve] == ["**no**", "0.001", "1e-05"]
    assert curve[2][:4] == ["rest", "relaxation", "unbalanced ratio 1e-05", "2"]
    assert "`python -m reference bench large`" in page.read_text()
    with Image.open(docs / "pictures" / "engine_error_against_time.png") as picture:
        assert picture.width > 300


def test_run_time_against_error_of_several_codes(tmp_path):
    from PIL import Image

    results, docs = tmp_path / "results", tmp_path / "docs"
    results.mkdir()

    def row(code, driver, setting, error, seconds, **details):
        about = {
            "problem": "pack",
            "code": code,
            "driver": driver,
            "setting": setting,
            "setting_unit": "steps",
        }
        name = f"{code} {driver} {setting}"
        return _check(name, error, **about, seconds=seconds, weight_error=0.5, **details)

    nan = float("nan")
    rows = [
        row("geodem", "slow", 100, 0.5, [1.0, 1.0, 9.0]),
        row("geodem", "slow", 200, 0.01, [2.0, 2.0, 9.0]),
        row("geodem", "quick", 1, 0.002, [3.0]),
        row("yade", "slow", 200, 0.005, [6.0, 8.0, 7.0]),
        row("liggghts", "slow", 200, 0.02, [0.1]),
        # a run that never came to its answer
        row("liggghts", "slow", 400, nan, [nan]),
        {**_check("start", 2.0), "problem": "start", "code": "yade"},
    ]
    (results / "frontier-codes.json").write_text(json.dumps({"header": HEADER, "rows": rows}))
    assert docs / "pictures" / "codes_error_against_time.png" in write_pages(results, docs)
    page = docs / "performance.md"
    (said,) = [line for line in page.read_text().splitlines() if line.startswith("- **Settling pack**")]
    # the median of 2, 2 and 9; 7 over 2
    assert (
        "To 1 % geodem is the fastest (slow, 2 s); YADE (slow) takes 3.5 times as long; LIGGGHTS does not reach it. "
        "No code reaches 0.1 %."
    ) in said
    assert _tables_below(page, "Start") == [["YADE", "2"]]
    curve = _tables_below(page, "All points")
    # the force on the walls is a second error of the same runs
    assert len(curve) == 2 * 5
    assert curve[1] == ["pack", "geodem", "slow", "200 steps", "2", "0.01"]
    assert curve[6] == ["weight", "geodem", "slow", "200 steps", "2", "0.5"]
    with Image.open(docs / "pictures" / "codes_error_against_time.png") as picture:
        assert picture.width > 300


def test_fuzzing_is_told_a_line_a_family(tmp_path):
    rows = _fuzzed("cases", 5000, 4321, 0, 0.25) + _fuzzed("pictures", 20, 7, 2, 11.0)
    whole = [("inputs tried", 5020, 10_000), ("taken otherwise than in use or words", 2, 0)]
    rows += [
        {"name": "all", "quantity": what, "value": value, "expected": expected}
        for what, value, expected in whole
    ]
    (tmp_path / "fuzzing.json").write_text(json.dumps({"header": HEADER, "rows": rows}))
    write_pages(tmp_path, tmp_path / "docs")
    page = tmp_path / "docs" / "verification.md"
    assert _tables_below(page, "Spoilt input") == [
        ["cases", "5,000", "4,321", "none", "0.25", "10", "12", "1074"],
        ["pictures", "20", "7", "**2**", "11", "10", "12", "1074"],
    ]
    assert "5,020 inputs" in page.read_text()
    assert "2 ended otherwise" in page.read_text()


def _fuzzed(family, tried, refused, wrong, slowest):
    found = [
        ("inputs tried", tried, tried), ("taken otherwise than in use or words", wrong, 0),
        ("slowest input [s]", slowest, 10.0), ("growth of resident memory [MB]", 12.0, 1073.741824),
    ]  # fmt: skip
    source = f"seed 1; {refused} refused in words"
    return [
        {"name": family, "quantity": what, "value": value, "expected": expected, "source": source}
        for what, value, expected in found
    ]


def test_nothing_was_run(tmp_path):
    docs = tmp_path / "docs"
    (docs / "pictures").mkdir(parents=True)
    stale = docs / "pictures" / "error_against_time.png"
    stale.write_bytes(b"of an earlier run")
    write_pages(tmp_path / "no results", docs)
    text = (docs / "verification.md").read_text()
    # slopes, ground, stability, interruptions, fuzzing, order, long work and memory, and the groups
    groups = (GROUPS, BODIES, LABORATORY, COMPARED)
    assert text.count("This has not been run yet") == 8 + sum(map(len, groups))
    assert "`python -m reference bench slopes`" in text
    assert "error_against_time" not in (docs / "performance.md").read_text()
    assert not stale.exists()


def test_a_file_that_is_something_else_is_refused(tmp_path):
    path = tmp_path / "slopes.json"
    path.write_text("[]")
    with pytest.raises(ValueError, match="rows"):
        read_results(path)
