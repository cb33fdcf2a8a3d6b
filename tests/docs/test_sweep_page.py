"""The pages know the keys of a sweep, its columns and what it leaves; their examples are sweeps that can be read."""

import json
import re

import pytest

from geodem import run_case
from geodem.case.sweep_reading import KEYS, MANY, parse_sweep
from geodem.case.sweep_values import RANGE_KEYS
from tests.docs.pages import DOCS, tables
from tests.ground_files import ground_case
from tests.small_cases import ROOT

PAGE = DOCS / "reference" / "case-file.md"
HOW_TO = DOCS / "how-to" / "sweep.md"


def rows(page, heading):
    return {key: row for row in tables(page)[heading] for key in re.findall(r"`(\w+)`", row[0])}


def test_keys_are_those_of_the_reader():
    assert set(rows(PAGE, "Top level of a sweep")) == set(KEYS)
    assert set(rows(PAGE, "A range")) == set(RANGE_KEYS)
    assert int(rows(PAGE, "Top level of a sweep")["allow_runs"][2]) == MANY


@pytest.fixture
def folder(tmp_path):
    template = ROOT / "geodem" / "templates" / "sweep" / "bank.toml"
    (tmp_path / "bank.toml").write_bytes(template.read_bytes())
    return tmp_path


def test_examples_are_sweeps(folder):
    text = PAGE.read_text()
    text = text[text.index("## A sweep") :]
    block = text[text.index("    workflow =") : text.index("`geodem new sweep DIR`")]
    assert len(parse_sweep(re.sub(r"^ {4}", "", block, flags=re.M), folder).runs) == 3
    first, table = re.findall(r"^```toml\n(.*?)^```", HOW_TO.read_text(), flags=re.S | re.M)
    assert len(parse_sweep(f"{first}\n{table}", folder).runs) == 12


def test_the_array_job_has_as_many_tasks_as_the_example_has_runs():
    assert "--array=1-12\n" in HOW_TO.read_text()


def test_keys_of_a_result(tmp_path):
    ground_case(tmp_path / "ground")
    sweep = 'workflow = "sweep"\ncase = "ground"\nprocesses = 1\n[vary]\n"particles.particles" = [300, 200]\n'
    (tmp_path / "case.toml").write_text(sweep)
    result = run_case(tmp_path, tmp_path / "out", command="geodem sweep case")
    told = set(rows(DOCS / "reference" / "result.md", "result.json of a sweep"))
    values = {"values"}  # of the runs, which the same table explains
    assert set(json.loads((tmp_path / "out" / "result.json").read_text())) == told - values
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "case.toml", "source", "runs", "figures", "result.json", "report.html", "sweep.csv",
    }  # fmt: skip
    assert result["columns"] == ["particles [-]", "neighbours of a particle [-]"]
