"""Every kind of case has all that the commands ask of one, and nothing else knows which kinds there are."""

from __future__ import annotations

import inspect
from importlib import import_module
from importlib.resources import files

import pytest

from geodem import kinds
from geodem.case import load_any
from geodem.kinds import KINDS, Kind, kind_of, kind_of_result

every_kind = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)

PLACES = {
    "reader": ("text", "folder"),
    "runner": (
        "case", "out", "threads", "quickly", "overwrite", "watch", "stop_asked", "command",
    ),
    "redrawer": ("folder", "case"),
    "checker": ("case", "picture", "console"),
    "answerer": ("result",),
}  # fmt: skip


def function(place: str):
    module, _, name = place.partition(":")
    return getattr(import_module(f"geodem.{module}"), name)


@every_kind
def test_functions_are_there_and_take_what_they_are_given(kind):
    for attribute, names in PLACES.items():
        assert tuple(inspect.signature(function(getattr(kind, attribute))).parameters) == names, attribute
    resumer = inspect.signature(function(kind.resumer))
    resumer.bind("folder", "case", threads=1, watch=None, stop_asked=None, command="")


@every_kind
def test_its_template_is_a_case_of_its_kind(kind):
    case = load_any(files("geodem") / "templates" / kind.name)
    assert case.workflow == kind.name
    assert f'workflow = "{kind.name}"' in case.as_run_text()
    assert case.title


@every_kind
def test_what_a_sweep_tabulates_has_units(kind):
    assert kind.command.split()[0] == "geodem"
    assert all(name.endswith("]") and " [" in name for name in kind.table), kind.table


def test_a_case_that_names_no_kind_is_what_it_looks_like():
    assert kind_of({"workflow": "laboratory"}).name == "laboratory"
    assert kind_of({"section": {}}).name == "slope"
    assert kind_of({"workflow": "grond", "source": {}}).name == "ground"
    assert kind_of({"workflow": 3}).name == "slope"
    assert kind_of_result({"workflow": "ground"}).name == "ground"
    assert kind_of_result(None).name == "slope"


def test_a_new_kind_is_one_entry(monkeypatch, tmp_path, capsys):
    """A kind that this test makes up is read, run and told by the commands."""
    import sys
    import types

    from geodem import cli
    from geodem.io.run_folder import RunFolder

    class Pile:
        workflow, title, notices, questions = "pile", "A pile", (), ()

        def as_run_text(self) -> str:
            return 'workflow = "pile"\n'

    def run(case, out, **options):
        folder = RunFolder(out, case.as_run_text(), "pile")
        folder.claim(overwrite=options["overwrite"])
        with folder.going({"workflow": "pile", "warnings": []}):
            (out / "report.html").write_text("pile")
            return folder.finish({"height_m": 3.0})

    module = types.ModuleType("geodem.pile")
    module.parse = lambda text, folder: Pile()
    module.run = run
    module.resume = lambda folder, case, **options: run(case, folder, overwrite=False)
    module.redraw = lambda folder, case: folder / "report.html"
    module.check = lambda case, picture, console: {"expected_s": 1.0}
    module.answer = lambda result: [(f"{result['height_m']} m high", "")]
    monkeypatch.setitem(sys.modules, "geodem.pile", module)
    functions = {key: f"pile:{verb}" for key, verb in zip(
        ("reader", "runner", "resumer", "redrawer", "checker", "answerer"),
        ("parse", "run", "resume", "redraw", "check", "answer"), strict=True,
    )}  # fmt: skip
    entry = Kind("pile", "geodem run", **functions)
    monkeypatch.setattr(kinds, "KINDS", {**KINDS, "pile": entry})
    for user in ("geodem.workflow", "geodem.checking", "geodem.cli", "geodem.case.document"):
        monkeypatch.setattr(import_module(user), "KINDS", kinds.KINDS)
    (tmp_path / "case.toml").write_text('workflow = "pile"\n')
    for command in (("run", tmp_path, "--out", tmp_path / "out"), ("resume", tmp_path / "out")):
        monkeypatch.setattr(sys, "argv", ["geodem", *map(str, command)])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        assert ended.value.code == 0
        assert "3.0 m high" in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", ["geodem", "lab", str(tmp_path)])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 2
    assert "geodem run" in capsys.readouterr().err
