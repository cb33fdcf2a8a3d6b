"""What the pages tell a reader to type exists."""

import ast
import inspect
import math
import re

import pytest

import geodem
from geodem.case import parse_case
from tests.docs.pages import DOCS, ROOT, pages, snippet

README = ROOT / "README.md"


def _indented_python(page):
    """Blocks of a page that import geodem."""
    blocks = re.findall(r"(?:^(?: {4}.*)?\n)+", page.read_text(encoding="utf-8"), flags=re.M)
    return [re.sub(r"^ {4}", "", block, flags=re.M) for block in blocks if "import geodem" in block]


def test_the_case_of_the_readme_is_the_published_slope(tmp_path):
    """Griffiths & Lane 1999, example 1: 2:1, c/(gamma H) = 0.05, phi = 20 deg."""
    case = parse_case(snippet(README, "toml"), tmp_path)
    soil = case.materials["soil"]
    weight = soil.density * 9.81
    assert soil.cohesion / (weight * 10.0) == pytest.approx(0.05)
    assert math.degrees(soil.friction_angle) == pytest.approx(20.0)
    assert case.section.bounds == (0.0, 0.0, 32.0, 10.0)


def test_the_smallest_case_of_the_reference_parses(tmp_path):
    text = (DOCS / "reference" / "case-file.md").read_text()
    block = text[text.index("    workflow =") : text.index("`geodem new slope DIR`")]
    case = parse_case(re.sub(r"^ {4}", "", block, flags=re.M), tmp_path)
    assert list(case.materials) == ["soil"]


@pytest.mark.parametrize(
    ("page", "source"),
    [
        (README, snippet(README, "python")),
        *((page, block) for page in sorted(DOCS.rglob("*.md")) for block in _indented_python(page)),
    ],
    ids=lambda value: value.stem if hasattr(value, "stem") else "",
)
def test_python_names_exist_and_take_these_arguments(page, source):
    used = [
        node
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "geodem"
    ]
    assert used
    assert {node.attr for node in used} <= set(geodem.__all__)
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and node.func in used:
            keywords = {keyword.arg: None for keyword in node.keywords}
            inspect.signature(getattr(geodem, node.func.attr)).bind(*[None] * len(node.args), **keywords)


def test_every_geodem_command_exists():
    from geodem.cli import app

    commands = {command.name or command.callback.__name__ for command in app.registered_commands}
    for page in pages():
        text = page.read_text(encoding="utf-8")
        typed = re.findall(r"^ {4}(?:\S*/)?geodem (\w+)", text, flags=re.M) + re.findall(
            r"`geodem (\w+)", text
        )
        assert set(typed) - {"COMMAND"} <= commands, page


def test_every_make_target_exists():
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), flags=re.M))
    for page in pages():
        assert (
            set(re.findall(r"(?:^ {4}|`)make (\w+)", page.read_text(encoding="utf-8"), flags=re.M)) <= targets
        ), page


def test_every_file_named_in_the_text_exists():
    for page in pages():
        for name in re.findall(
            r"`((?:geodem|reference|workflows|tests)/[\w./-]+)`", page.read_text(encoding="utf-8")
        ):
            if not name.startswith("reference/results"):
                assert (ROOT / name).exists(), f"{page}: {name}"
