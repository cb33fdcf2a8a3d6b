"""The script of the page on samples does what the page says."""

import os
import subprocess
import sys

from tests.docs.pages import DOCS, ROOT, snippet

PAGE = DOCS / "how-to" / "prepare-a-granular-sample.md"


def test_the_script_prepares_three_samples(tmp_path):
    (tmp_path / "sample.py").write_text(snippet(PAGE, "python"))
    done = subprocess.run(
        [sys.executable, "sample.py"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    dense, grown, heap = done.stdout.splitlines()
    assert dense.endswith("pressure 20000: reached")
    assert grown.endswith(": reached")
    assert heap.endswith("unbalanced ratio 0.001: reached")
    assert (tmp_path / "heap.png").read_bytes().startswith(b"\x89PNG")


def test_what_the_page_names_exists():
    from geodem import preparation
    from geodem.builders import sizes

    text = PAGE.read_text()
    for name in preparation.__all__:
        assert f"`{name}`" in text or name == "Grains"
    for name in ("equal", "uniform", "normal", "lognormal", "graded"):
        assert f"`{name}`" in text
        assert hasattr(sizes, name)
