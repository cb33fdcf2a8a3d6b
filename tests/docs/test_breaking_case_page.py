"""The page of the case file knows the keys, choices and defaults of breaking ground."""

import re

from geodem.case.breaking import BreakingCase
from geodem.case.breaking_reading import KEYS, MOTION_KEYS, parse_breaking
from geodem.case.breaking_stages import STAGES
from tests.case.test_breaking_case import GROUND, SETTLE
from tests.docs.pages import DOCS, tables

PAGE = DOCS / "reference" / "case-file.md"


def keys(heading):
    return {key: row for row in tables(PAGE)[heading] for key in re.findall(r"`(\w+)`", row[0])}


def test_keys_are_those_of_the_reader():
    assert set(keys("Top level of breaking ground")) == set(KEYS)
    assert set(keys("[motion]")) == set(MOTION_KEYS)
    told = keys("[[stage]]")
    assert set(told) == {"kind", "name", *(key for own in STAGES.values() for key in own)}
    for kind in STAGES:
        assert f'`"{kind}"`' in told["kind"][1]


def test_each_key_is_told_with_its_stages():
    searches = {"gravity-increase", "strength-reduction"}
    for key, row in keys("[[stage]]").items():
        owners = {kind for kind, own in STAGES.items() if key in own}
        if row[3] == "all":
            continue
        if row[3] == "all but walls":
            assert owners == set(STAGES) - {"move-wall", "remove-wall"}, key
            continue
        words = {word.strip() for word in row[3].split(",")}
        named = (words - {"searches"}) | (searches if "searches" in words else set())
        assert named == owners, key


def test_defaults_are_those_of_the_reader(tmp_path):
    text = (
        GROUND
        + SETTLE
        + '[[stage]]\nkind = "gravity-increase"\n\n[[stage]]\nkind = "excavate"\nmaterial = "rock"\n'
    )
    case = parse_breaking(text, tmp_path)
    told = {key: row[2] for key, row in keys("[[stage]]").items()}
    for stage in case.stages[1:]:
        for key, value in stage.values.items():
            if key == "material":
                continue
            shown = told[key].strip("`").strip('"')
            if isinstance(value, bool):
                assert shown == str(value).lower(), key
            elif isinstance(value, str):
                assert shown == value, key
            else:
                assert float(shown) == value, key
    motion = {key: float(row[2]) for key, row in keys("[motion]").items()}
    assert motion == {"damping": BreakingCase.damping, "time_step_factor": BreakingCase.time_step_factor}
    assert case.damping == motion["damping"]
