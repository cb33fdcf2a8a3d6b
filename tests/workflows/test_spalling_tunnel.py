"""The workflow as it is shipped, with few particles: the tunnel cracks where Kirsch's hoop stress is largest."""

from __future__ import annotations

import subprocess
import sys

from tests.small_cases import ROOT, environment

WORKFLOW = ROOT / "workflows" / "spalling_tunnel"


def test_it_checks_itself(tmp_path):
    command = [sys.executable, str(WORKFLOW / "run.py"), str(tmp_path / "out"), "--quick"]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "share_at_roof_and_floor: " in done.stdout
    assert (tmp_path / "out" / "cracks.png").stat().st_size > 20_000
