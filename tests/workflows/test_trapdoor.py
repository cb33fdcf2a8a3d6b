"""A door sinks under sand, as it is shipped."""

from __future__ import annotations

import subprocess
import sys

from tests.small_cases import ROOT, environment, result_of

WORKFLOW = ROOT / "workflows" / "trapdoor"


def test_it_checks_itself(tmp_path):
    command = [sys.executable, str(WORKFLOW / "run.py"), "--quick", str(tmp_path / "out")]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "NOT AS EXPECTED" not in done.stdout
    assert result_of(tmp_path / "out")["status"] == "done"
