"""The script of the page on bodies does what the page says, and what it names exists."""

import importlib
import os
import re
import subprocess
import sys

from tests.docs.pages import DOCS, ROOT, snippet, tables

PAGE = DOCS / "how-to" / "ground-from-pictures-and-terrain.md"


def test_the_script_builds_a_wall_and_finds_the_factor_of_a_valley_side(tmp_path):
    (tmp_path / "bodies.py").write_text(snippet(PAGE, "python"))
    done = subprocess.run(
        [sys.executable, "bodies.py"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0].endswith(" 86")
    assert "+0.000" in done.stdout
    # Spencer's method gives 1.27 for this section, see docs/verification.md
    assert 1.22 < float(done.stdout.split()[-1]) < 1.33


def test_functions_and_modules_of_the_page_exist():
    for _, functions, modules in tables(PAGE)["Bodies"]:
        found = [
            importlib.import_module(f"geodem.builders.{name}") for name in re.findall(r"`(\w+)`", modules)
        ]
        for name in re.findall(r"(?:^|`|\()(\w+)", functions.replace(".body", "")):
            assert not name or any(hasattr(module, name) for module in found), name
