"""A number that a page quotes from the code is the number in the code."""

import ast
import importlib
import re

import pytest

from tests.docs.pages import DOCS, tables

QUOTED = [
    (page.stem, row[0].strip("`"), row[1])
    for page in sorted(DOCS.rglob("*.md"))
    for rows in tables(page).values()
    for row in rows
    if re.fullmatch(r"`geodem\.[\w.]+`", row[0])
]


def _value(name):
    parts = name.split(".")
    for split in range(len(parts) - 1, 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:split]))
        except ModuleNotFoundError:
            continue
        for part in parts[split:]:
            found = getattr(found, part)
        return found
    raise AssertionError(name)


@pytest.mark.parametrize(("page", "name", "shown"), QUOTED, ids=lambda value: value)
def test_quoted_numbers(page, name, shown):
    assert ast.literal_eval(shown) == _value(name)


def test_there_is_something_to_compare():
    assert len(QUOTED) > 12
