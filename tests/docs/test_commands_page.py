"""The page of commands names every command and option there is."""

import inspect
from typing import get_args

import typer

from geodem.cli import app
from reference.__main__ import COMMANDS
from tests.docs.pages import DOCS, tables

PAGE = DOCS / "reference" / "commands.md"


def test_commands_and_options():
    rows = tables(PAGE)["geodem"]
    named = {row[0].strip("`").split()[1] for row in rows if row[0].startswith("`geodem ")}
    told = {
        (option.strip("`"), name.strip("`"))
        for row in rows
        if row[0].startswith("`--")
        for option in row[0].split(", ")
        for name in row[1].split(", ")
    }
    existing, options = set(), set()
    for command in app.registered_commands:
        name = command.callback.__name__
        existing.add(name)
        for parameter in inspect.signature(command.callback, eval_str=True).parameters.values():
            kinds = [
                kind for kind in get_args(parameter.annotation) if isinstance(kind, typer.models.OptionInfo)
            ]
            options |= {(f"--{parameter.name.replace('_', '-')}", name) for _ in kinds}
    assert named == existing
    assert told == options


def test_commands_of_the_reference():
    named = {row[0].split()[3].strip("`") for row in tables(PAGE)["python -m reference"]}
    assert named == set(COMMANDS)
