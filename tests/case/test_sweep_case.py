"""Sweeps: the runs that come of one, what is refused and in which words, and that a sweep writes back what it is."""

from __future__ import annotations

import math
import re
import tomllib

import pytest

from geodem.case import load_any
from geodem.case.document_places import put, steps_of, value_at, written
from geodem.case.sweep_reading import parse_sweep, read_sweep
from geodem.case.toml_text import toml_text
from geodem.errors import InputError, InputErrors
from tests.ground_files import ground_case
from tests.small_cases import ROOT, SLOPE

HEAD = 'workflow = "sweep"\ntitle = "Bank"\ncase = "bank.toml"\n'
COHESION = '[vary]\n"material.soil.cohesion" = ["5 kPa", "10 kPa"]\n'
GRID = HEAD + COHESION + '"material.soil.friction_angle" = ["20 deg", "25 deg", "30 deg"]\n'


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "bank.toml").write_text(SLOPE)
    return tmp_path


def values_of(case, key):
    return [run.values[key] for run in case.runs]


def test_a_grid_has_every_value_with_every_other(folder):
    case = parse_sweep(GRID, folder)
    assert [run.number for run in case.runs] == [1, 2, 3, 4, 5, 6]
    assert values_of(case, "material.soil.cohesion") == ["5 kPa"] * 3 + ["10 kPa"] * 3
    assert values_of(case, "material.soil.friction_angle") == ["20 deg", "25 deg", "30 deg"] * 2
    third = case.read(case.runs[2])
    assert third.materials["soil"].cohesion == 5000.0
    assert third.materials["soil"].friction_angle == math.radians(30.0)
    assert third.seed == 3, "all else is that of the case"
    assert case.kind == "slope"
    assert load_any(folder / "bank.toml").materials["soil"].cohesion == 10_000.0


def test_keys_may_be_tables(folder):
    nested = HEAD + '[vary.material.soil]\ncohesion = ["5 kPa", "10 kPa"]\n[vary]\nseed = [1, 2]\n'
    case = parse_sweep(nested, folder)
    assert case.keys == ("material.soil.cohesion", "seed")
    assert len(case.runs) == 4


def test_together(folder):
    text = 'together = [["material.soil.cohesion", "seed"]]\n'
    case = parse_sweep(HEAD + text + COHESION + "seed = [7, 8]\nparticles = [300, 400]\n", folder)
    found = [
        tuple(run.values[key] for key in ("material.soil.cohesion", "seed", "particles")) for run in case.runs
    ]
    assert found == [("5 kPa", 7, 300), ("5 kPa", 7, 400), ("10 kPa", 8, 300), ("10 kPa", 8, 400)]


def test_runs_from_a_table(folder):
    (folder / "runs.csv").write_text("material.soil.cohesion,seed,title\n5 kPa,7,soft\n\n10 kPa,8,firm\n")
    case = parse_sweep(HEAD + 'runs = "runs.csv"\n[vary]\nparticles = [300, 400]\n', folder)
    assert values_of(case, "seed") == [7, 7, 8, 8]
    assert values_of(case, "title") == ["soft", "soft", "firm", "firm"]
    assert values_of(case, "particles") == [300, 400] * 2


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ('{from = "10 kPa", to = "30 kPa", count = 3}', ["10 kPa", "20 kPa", "30 kPa"]),
        ('{from = "0.1 MPa", to = "0.3 MPa", step = "100 kPa"}', ["0.1 MPa", "0.2 MPa", "0.3 MPa"]),
        ('{from = "10 kPa", to = "0.03 MPa", step = "10 kPa"}', ["10 kPa", "20 kPa", "30 kPa"]),
        ('{from = "1 kPa", to = "100 kPa", count = 3, spacing = "log"}', ["1 kPa", "10 kPa", "100 kPa"]),
        ('{from = "30 kPa", to = "10 kPa", step = "-10 kPa"}', ["30 kPa", "20 kPa", "10 kPa"]),
    ],
)
def test_ranges(folder, given, expected):
    case = read_sweep(HEAD + f'[vary]\n"material.soil.cohesion" = {given}\n', folder)
    assert values_of(case, "material.soil.cohesion") == expected


def test_ranges_of_numbers_without_units(folder):
    case = read_sweep(HEAD + "[vary]\nseed = {from = 1, to = 4, step = 1}\n", folder)
    assert values_of(case, "seed") == [1, 2, 3, 4]
    case = read_sweep(
        HEAD + '[vary]\n"material.soil.poisson_ratio" = {from = 0.1, to = 0.3, count = 3}\n', folder
    )
    assert values_of(case, "material.soil.poisson_ratio") == [0.1, 0.2, 0.3]


WRONG = [
    # nothing is run where any run could not be
    ("material.soil.cohesion", "material.soil.cohession",
     r'^vary\.material\.soil\.cohession: unknown key\. Did you mean "cohesion"'),
    ("material.soil.cohesion", "material.clay.cohesion",
     r"^vary\.material\.clay\.cohesion = .*: the case has no material\.clay\. .*There is in material: soil"),
    ("material.soil.cohesion", "section.regions[3].material",
     r"^vary\.section\.regions\[3\]\.material = .*: the case has no section\.regions\[3\]\. .*1 entries"),
    ('"5 kPa"', '"5 deg"', r"^vary\.material\.soil\.cohesion = '5 deg': deg is the unit of an angle"),
    ('"5 kPa"', "5", r"^vary\.material\.soil\.cohesion = 5: a bare number"),
    ('["5 kPa", "10 kPa"]', "[]", r"^vary\.material\.soil\.cohesion: the list is empty\. Write"),
    ('["5 kPa", "10 kPa"]', '"5 kPa"', r"^vary\.material\.soil\.cohesion = '5 kPa': one value is no list"),
    ('["5 kPa", "10 kPa"]', '["5 kPa", "5 kPa"]', r"^vary\.material\.soil\.cohesion = .*: this value stands twice"),
    ('["5 kPa", "10 kPa"]', '{from = "5 kPa", to = "10 kPa"}', r"a range has either count or step"),
    ('["5 kPa", "10 kPa"]', '{from = "5 kPa", to = "10 deg", count = 2}', r"another kind of quantity"),
    ('["5 kPa", "10 kPa"]', '{from = "5 kPa", to = "9 kPa", step = "-1 kPa"}', r"does not lead from the one end"),
    ('["5 kPa", "10 kPa"]', '{from = "-1 kPa", to = "9 kPa", count = 3, spacing = "log"}', r"of positive values only"),
    ('["5 kPa", "10 kPa"]', '{from = "5 kPa", to = "10 kPa", step = "1 Pa"}',
     r"^vary: this makes 5,001 runs\. .*allow_runs = 5001"),
    ('["5 kPa", "10 kPa"]', '{from = "5 kPa", to = "10 kPa", count = 1000000000}',
     r"^vary\.material\.soil\.cohesion\.count = 1000000000: so many values are no sweep"),
    ('["5 kPa", "10 kPa"]', '{from = "5 kPa", to = "10 kPa", step = "1e-75 kPa"}',
     r"^vary\.material\.soil\.cohesion\.step = '1e-75 kPa': this makes 5e\+75 values"),
    ("material.soil.cohesion", f"section.regions[{'9' * 5000}].material", r"this is no key"),
    ("material.soil.cohesion", "material..cohesion", r"this is no key"),
    ('case = "bank.toml"', 'case = "benk.toml"', r"^case = 'benk\.toml': there is no such case file"),
    ('case = "bank.toml"\n', "", r"^case: missing\. Write case ="),
    ('case = "bank.toml"\n', 'case = "bank.toml"\nprocesses = 1000000000\n',
     r"^processes = 1000000000: no machine does so many at a time"),
    ('case = "bank.toml"\n', 'case = "bank.toml"\nallow_runs = 1000000000\n',
     r"^allow_runs = 1000000000: no sweep has more than 100,000 runs"),
    (COHESION, "", r"^vary: missing\. Add \[vary\]"),
    ('case = "bank.toml"\n', 'case = "bank.toml"\nprocesses = 0\n', r"^processes = 0: this is below 1"),
    ('case = "bank.toml"\n', 'case = "bank.toml"\ntogether = [["seed", "material.soil.cohesion"]]\n',
     r"^together\[0\] = 'seed': this key is not varied"),
    (COHESION, COHESION + '[table]\n"factor" = "factors[0].value"\n', r"^table\.factor = .*: this name has no unit"),
    (COHESION, COHESION + '[table]\n"factor [-]" = "factors.[0"\n', r'^table\."factor \[-\]" = .*: this is no key'),
    ("title", "titel", r'^titel: unknown key\. Did you mean "title"'),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "said"), WRONG, ids=range(len(WRONG)))
def test_what_is_refused(folder, old, new, said):
    text = HEAD + COHESION
    assert old in text
    with pytest.raises(InputError) as caught:
        parse_sweep(text.replace(old, new), folder)
    assert re.search(said, str(caught.value), re.MULTILINE), str(caught.value)


def test_a_fault_is_told_once_for_a_value(folder):
    """Six runs, of which every second has a wrong value of one key and all a wrong one of another."""
    text = GRID.replace('"25 deg"', '"25 kPa"')
    (folder / "bank.toml").write_text(SLOPE.replace("seed = 3", "seed = -3"))
    with pytest.raises(InputErrors) as caught:
        parse_sweep(text, folder)
    assert [error.place for error in caught.value.errors] == [
        "case, seed",
        "vary.material.soil.friction_angle",
    ]


def test_what_looks_mistaken_is_allowed_in_the_case(folder):
    text = HEAD + COHESION.replace('"10 kPa"', '"4 GPa"')
    with pytest.raises(InputError, match=r"Did you mean .4 MPa.*\n?.*at the top of the case"):
        parse_sweep(text, folder)
    (folder / "bank.toml").write_text('allow_implausible = ["material.soil.cohesion"]\n' + SLOPE)
    assert len(parse_sweep(text, folder).runs) == 2


def test_many_runs_that_are_meant(folder):
    text = HEAD + "allow_runs = 1500\n[vary]\nseed = {from = 1, to = 1500, step = 1}\n"
    assert len(read_sweep(text, folder).runs) == 1500


def test_a_sweep_of_sweeps_is_refused(folder):
    (folder / "sweep.toml").write_text(GRID)
    with pytest.raises(InputError, match="this is a sweep, too"):
        parse_sweep(GRID.replace("bank.toml", "sweep.toml"), folder)


def test_a_sweep_as_run_is_the_same_sweep_in_another_folder(tmp_path):
    """Its case and what this names go with it; runs are the same, whatever the folder."""
    case = ground_case(tmp_path / "given" / "case")
    (case / "case.toml").write_text((case / "case.toml").read_text().replace("bank.png", "../bank.png"))
    (case / "bank.png").rename(case.parent / "bank.png")
    (case.parent / "runs.csv").write_text("particles.seed\n1\n2\n")
    text = (
        'workflow = "sweep"\ncase = "case"\nruns = "runs.csv"\n[vary]\n"particles.particles" = [200, 300]\n'
    )
    sweep = parse_sweep(text, case.parent)
    beside, copies = sweep.beside()
    assert set(copies) == {"source/case/case.toml", "source/bank.png", "source/runs-runs.csv"}
    moved = tmp_path / "moved"
    for place, path in copies.items():
        (moved / place).parent.mkdir(parents=True, exist_ok=True)
        (moved / place).write_bytes(path.read_bytes())
    again = parse_sweep(beside.as_run_text(), moved)
    assert again.beside()[0].as_run_text() == beside.as_run_text()
    ours, theirs = ([each.identity(run, False) for run in each.runs] for each in (sweep, again))
    assert ours == theirs
    assert len(set(ours)) == 4
    (case.parent / "bank.png").write_bytes(b"another")
    assert sweep.identity(sweep.runs[0], False) != ours[0]


def test_documents_read_back_as_they_were():
    texts = [path.read_text() for path in sorted((ROOT / "geodem" / "templates").rglob("*.toml"))]
    texts += [path.read_text() for path in sorted((ROOT / "workflows").rglob("*.toml"))]
    texts.append(
        'a = [1, -2.5e-300, true, "ü\\n\\"", [[0.1], []]]\n"b c" = {d = {}, "e.f" = [{g = 1}]}\n[h]\n[h.i]\n'
    )
    for text in texts:
        document = tomllib.loads(text)
        assert tomllib.loads(toml_text(document)) == document


@pytest.mark.parametrize(
    ("place", "steps"),
    [
        ("a.b-c", ("a", "b-c")),
        ('a."#8c.d".e', ("a", "#8c.d", "e")),
        ("a[0].b[-1]", ("a", 0, "b", -1)),
        ("a[kind=strength-reduction].b", ("a", ("kind", "strength-reduction"), "b")),
    ],
)
def test_places(place, steps):
    assert steps_of(place, at="here") == steps
    assert written(steps) == place


@pytest.mark.parametrize("place", ["", "a.", ".a", "a[", "a b", "a[x]", "[0]"])
def test_what_is_no_place(place):
    with pytest.raises(InputError, match="this is no key"):
        steps_of(place, at="here")


def test_values_at_places():
    document = {"a": [{"kind": "x", "b": 1}, {"kind": "y", "b": 2}], "c": {"d": 3.0}, "e": [1, 1, 1]}
    assert value_at(document, steps_of("a[kind=y].b", at="")) == 2
    assert value_at(document, steps_of("a[-1].b", at="")) == 2
    assert value_at(document, steps_of("c.d", at="")) == 3.0
    for nothing in ("a[2].b", "a[kind=z].b", "c.e", "c.d.e", "a.b"):
        assert value_at(document, steps_of(nothing, at="")) is None
    put(document, steps_of("e[1]", at=""), 5, at="")
    put(document, steps_of("a[kind=x].b", at=""), 7, at="")
    put(document, steps_of("c.new", at=""), 8, at="")
    assert (document["e"], document["a"][0]["b"], document["c"]["new"]) == ([1, 5, 1], 7, 8)
