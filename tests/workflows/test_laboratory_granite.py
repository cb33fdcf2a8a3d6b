"""The workflow as it is shipped, in its quick form."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

from tests.small_cases import ROOT, environment, result_of

WORKFLOW = ROOT / "workflows" / "laboratory_granite"


def test_quick_run_from_python_checks_itself(tmp_path: Path):
    command = [sys.executable, str(WORKFLOW / "run.py"), str(tmp_path / "out"), "--quick"]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=240, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{tmp_path}/out/report.html" in done.stdout
    result = result_of(tmp_path / "out")
    expected = tomllib.loads((WORKFLOW / "expected.toml").read_text())
    for key, wanted in expected.items():
        found = result["properties"][key]["mean"]
        assert abs(found / wanted["value"] - 1.0) <= wanted["quick"], key
    assert result["tests"][0]["kind"] == "uniaxial-compression"
    assert all(all(test["failed"]) for test in result["tests"])
