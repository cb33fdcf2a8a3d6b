"""The script of the page on meshes does what the page says."""

import os
import subprocess
import sys

from tests.docs.pages import DOCS, ROOT, snippet

PAGE = DOCS / "how-to" / "meshes.md"


def test_the_script_reads_a_tunnel_and_fills_it(tmp_path):
    """Areas by hand: 40 m by 17 m less a circle of 3 m, all but its cap above 2 m; 40 m by 13 m less the cap."""
    (tmp_path / "tunnel.py").write_text(snippet(PAGE, "python"))
    done = subprocess.run(
        [sys.executable, "tunnel.py"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    first, second, *_, last = done.stdout.splitlines()
    # the cap of a circle of radius 3 above 2: r^2 acos(2/3) - 2 sqrt(5) = 3.098 m2
    assert first.startswith("('shale', 'till') [654.8")
    assert "516.9" in first
    assert "the surface moves -" in second
    assert "0.000" in done.stdout
    assert int(last.split()[0]) > 50
