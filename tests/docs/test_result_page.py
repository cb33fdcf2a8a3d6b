"""The page of results names every key and file that a run leaves, and nothing else."""

import json
import re

import pytest

from geodem.workflow import run_case
from tests.docs.pages import DOCS, ROOT, snippet, tables

PAGE = DOCS / "reference" / "result.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A small run of the README's case without its dilation angle, so that everything is in the result."""
    place = tmp_path_factory.mktemp("run")
    text = snippet(ROOT / "README.md", "toml").replace('dilation_angle = "20 deg"\n', "")
    text = "particles = 300\ntolerance = 0.05\n" + text
    (place / "case.toml").write_text(
        text + '\n[reference]\nfactor = 1.38\nsource = "Griffiths & Lane 1999"\n'
    )
    run_case(place, place / "out")
    return place / "out"


def _keys(position):
    rows = list(tables(PAGE)["result.json"])
    split = next(index for index, row in enumerate(rows) if row[0] == "`kind`")
    chosen = rows[:split] if position == "top" else rows[split:]
    return {key for row in chosen for key in re.findall(r"`(\w+)`", row[0])}


def test_keys_of_result_json(folder):
    assert set(json.loads((folder / "result.json").read_text())) == _keys("top")


def test_keys_of_a_factor(folder):
    factors = json.loads((folder / "result.json").read_text())["factors"]
    assert [entry["kind"] for entry in factors] == ["strength-reduction", "gravity-increase"]
    assert set(factors[0]) == _keys("factor")
    assert set(factors[1]) == _keys("factor") - {"reference", "zero_dilation"}
    row = next(row for row in tables(PAGE)["result.json"] if row[0] == "`failure`")
    assert set(factors[0]["failure"]) == set(re.findall(r"`(\w+)`", row[1]))


def test_files(folder):
    patterns = [name for row in tables(PAGE)["The folder"] for name in re.findall(r"`([^`]+)`", row[0])]
    patterns = [pattern.replace("METHOD", "*") for pattern in patterns]
    for pattern in patterns:
        assert list(folder.glob(pattern)), pattern
    for path in folder.rglob("*"):
        assert path.is_dir() or any(path in folder.glob(pattern) for pattern in patterns), path
