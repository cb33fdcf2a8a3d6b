"""What the tests of the commands share."""

from __future__ import annotations

import sys

import pytest

from geodem import cli
from tests.small_cases import Answer


@pytest.fixture
def call(monkeypatch, capsys):
    """Run a command in this process, as the program `geodem` does."""

    def run(*arguments: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["geodem", *map(str, arguments)])
        capsys.readouterr()
        status = 0
        try:
            cli.main()
        except SystemExit as end:
            status = int(end.code or 0)
        printed = capsys.readouterr()
        return Answer(status, printed.out, printed.err)

    return run
