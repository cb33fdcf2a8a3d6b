"""The pages of the case file and of results know the keys of a tunnel."""

import json
import re

from geodem.case.tunnel_reading import DEFAULT_PARTICLES, DEFAULT_TOLERANCE, KEYS, parse_tunnel
from geodem.case.tunnel_stages import KEYS as STAGE_KEYS
from geodem.case.tunnel_supports import BOLT_KEYS, LINING_KEYS
from geodem.tunnel_run import run_tunnel
from geodem.tunnelling.plan import INCREMENTS, METHODS
from tests.case.test_tunnel_case import HERE, SMALL
from tests.docs.pages import DOCS, tables

PAGE = DOCS / "reference" / "case-file.md"


def keys(heading: str, page=PAGE) -> set[str]:
    return {key for row in tables(page)[heading] for key in re.findall(r"`(\w+)`", row[0])}


def test_keys_are_those_of_the_reader():
    assert keys("Top level of a tunnel") == set(KEYS)
    assert keys("[[stage]] of a tunnel") == set(STAGE_KEYS)
    assert keys("[[lining]] of a tunnel") == set(LINING_KEYS)
    assert keys("[[bolt]] of a tunnel") == set(BOLT_KEYS)
    text = PAGE.read_text()
    assert all(f'`"{method}"`' in text for method in METHODS)


def test_defaults_are_those_of_the_reader():
    text = PAGE.read_text()
    text = text[text.index("## A tunnel") :]
    block = text[text.index("    workflow =") : text.index("`geodem new tunnel DIR`")]
    case = parse_tunnel(re.sub(r"^ {4}", "", block, flags=re.M), HERE)
    told = {row[0].strip("`"): row[2] for row in tables(PAGE)["Top level of a tunnel"]}
    assert int(told["particles"]) == case.particles == DEFAULT_PARTICLES
    assert int(told["increments"]) == case.increments == INCREMENTS
    assert int(told["seed"]) == case.seed
    assert case.tolerance == DEFAULT_TOLERANCE


def test_keys_and_files_of_a_result(tmp_path):
    run_tunnel(parse_tunnel(SMALL, HERE), tmp_path / "out", threads=1)
    page = DOCS / "reference" / "result.md"
    assert set(json.loads((tmp_path / "out" / "result.json").read_text())) == keys(
        "result.json of a tunnel", page
    )
    for row in tables(page)["A tunnel"]:
        assert list((tmp_path / "out").glob(row[0].strip("`/"))), row[0]
