"""The page of the case file knows the keys and defaults of ground, and that of results what it leaves."""

import json
import re

from geodem import run_case
from geodem.case import parse_ground
from geodem.case.ground import ParticleOptions
from geodem.case.ground_reading import KEYS, MATERIAL_KEYS
from geodem.case.ground_source import SOURCES
from geodem.case.ground_tables import ARRANGEMENTS, DEFAULT_PARTICLES, PARTICLE_KEYS
from tests.docs.pages import DOCS, tables
from tests.ground_files import ground_case

PAGE = DOCS / "reference" / "case-file.md"


def rows(heading):
    return {row[0].strip("`"): row for row in tables(PAGE)[heading]}


def test_keys_are_those_of_the_reader():
    named = {key for row in tables(PAGE)["Top level of ground"] for key in re.findall(r"`(\w+)`", row[0])}
    assert named == set(KEYS)
    assert set(rows("[particles] of ground")) == set(PARTICLE_KEYS)
    assert set(rows("[material.NAME] of ground")) == set(MATERIAL_KEYS)
    told = rows("[source]")
    assert list(told)[: len(SOURCES)] == list(SOURCES)
    assert set(told) == {*SOURCES, *(key for keys in SOURCES.values() for key in keys)}
    for key, row in list(told.items())[len(SOURCES) :]:
        owners = {kind for kind, keys in SOURCES.items() if key in keys}
        named = set(re.findall(r"`(\w+)`", row[1]))
        assert named <= {*owners, "legend", "grains"}, key
        assert owners <= named or named & {"legend", "grains"}, key


def test_defaults_are_those_of_the_reader():
    told = {key: row[2] for key, row in rows("[particles] of ground").items()}
    usual = ParticleOptions()
    assert told["arrangement"] == f'`"{usual.arrangement}"`'
    assert int(told["particles"]) == DEFAULT_PARTICLES
    assert float(told["size_ratio"]) == usual.size_ratio
    assert int(told["seed"]) == usual.seed
    text = PAGE.read_text()
    for name in ARRANGEMENTS:
        assert f'`"{name}"`' in text, name


def test_the_smallest_case_parses(tmp_path):
    text = PAGE.read_text()
    text = text[text.index("## Ground") :]
    block = text[text.index("    workflow =") : text.index("`geodem new ground DIR`")]
    (tmp_path / "section.png").write_bytes(b"")
    case = parse_ground(re.sub(r"^ {4}", "", block, flags=re.M), tmp_path)
    assert list(case.materials) == ["gravel"]


def test_keys_and_files_of_a_result(tmp_path):
    run_case(ground_case(tmp_path / "case"), tmp_path / "out", command="geodem run case")
    page = DOCS / "reference" / "result.md"
    told = {key for row in tables(page)["result.json of ground"] for key in re.findall(r"`(\w+)`", row[0])}
    assert set(json.loads((tmp_path / "out" / "result.json").read_text())) == told
    files = {row[0].strip("`") for row in tables(page)["Ground"]}
    written = {path.name + "/" * path.is_dir() for path in (tmp_path / "out").iterdir()}
    assert written - {"case.toml", "report.html", "result.json", "figures/"} == files - {
        "surfaces-000000.vtkhdf"
    }
