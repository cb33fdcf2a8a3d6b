"""The workflow as it is shipped, in its quick form."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

from tests.small_cases import ROOT, environment, result_of

WORKFLOW = ROOT / "workflows" / "rock_cutting"


def test_quick_run_from_python_checks_itself(tmp_path: Path):
    command = [sys.executable, str(WORKFLOW / "run.py"), str(tmp_path / "out"), "--quick"]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=240, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "OFF" not in done.stdout
    result = result_of(tmp_path / "out")
    assert result["quick"]
    expected = tomllib.loads((WORKFLOW / "expected.toml").read_text())
    for place, wanted in expected.items():
        found = result
        for key in place.split("."):
            found = found[key]
        assert wanted["quick"][0] <= found <= wanted["quick"][1], place
        assert wanted["source"]
