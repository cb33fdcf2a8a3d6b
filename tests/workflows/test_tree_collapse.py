"""DICE2D's fir falls down, as it is shipped."""

from __future__ import annotations

import runpy
import subprocess
import sys

import numpy as np
from PIL import Image

from tests.small_cases import ROOT, environment, result_of

WORKFLOW = ROOT / "workflows" / "tree_collapse"


def test_it_checks_itself(tmp_path):
    command = [sys.executable, str(WORKFLOW / "run.py"), "--quick", str(tmp_path / "out")]
    done = subprocess.run(
        command, capture_output=True, text=True, env=environment(), timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "NOT AS EXPECTED" not in done.stdout
    assert result_of(tmp_path / "out")["status"] == "done"


def test_the_pictures_are_those_that_are_drawn_and_have_the_discs_of_the_book():
    for name, picture, discs in (("tree_collapse", "tree.png", 846), ("bonded_trees", "trees.png", 2539)):
        folder = ROOT / "workflows" / name
        drawn = runpy.run_path(str(folder / "draw.py"), run_name="imported")
        pixels = drawn["fir" if name == "tree_collapse" else "trees"]()
        with Image.open(folder / picture) as shipped:
            assert np.array_equal(np.array(shipped.convert("RGB")), pixels)
        assert int((pixels != 255).any(axis=2).sum()) == discs
