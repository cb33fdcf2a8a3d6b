"""The case as it is shipped: read and built; `python -m reference run cutting` cuts it."""

from __future__ import annotations

import math
import tomllib

import pytest

from geodem.case.cutting_reading import parse_cutting
from geodem.cutting_building import make_cut
from tests.small_cases import ROOT

WORKFLOW = ROOT / "workflows" / "dice2d_cutter"


def test_the_case_has_the_numbers_of_table_4_2():
    case = parse_cutting((WORKFLOW / "case.toml").read_text(encoding="utf-8"), WORKFLOW)
    cut = make_cut(case)
    expected = tomllib.loads((WORKFLOW / "expected.toml").read_text(encoding="utf-8"))
    low, high = expected["particles"]["within"]
    assert low <= cut.assembly.particles <= high
    # Zhao 2015, table 4.2 and section 4.3.2
    rock = case.scene.materials["rock"]
    assert rock.bond["normal_stiffness"] == 1e8
    assert rock.bond["shear_stiffness"] == 3e7
    assert rock.bond["tensile_strength"] == 4e7
    assert rock.bond["cohesion"] == 2e8
    assert rock.bond["width_ratio"] == 0.1
    assert math.degrees(math.atan(rock.bond["friction_coefficient"])) == pytest.approx(30.0)
    assert case.plan.damping == 0.01
    assert case.plan.speed == 5.0
    # the face stands at 30 deg to the horizontal
    assert 90.0 - math.degrees(case.plan.tool.rake) == pytest.approx(30.0)
    assert cut.scene.box.tolist() == [[0.0, 0.0], [400.0, 200.0]]
