"""What a case of breaking ground becomes."""

from __future__ import annotations

from pathlib import Path

import pytest

from geodem.breaking_building import build_works
from geodem.case.breaking_reading import parse_breaking

CASE = """\
workflow = "breaking"
title = "Floor that is opened"

[source]
box = ["12 m", "6 m"]
layers = [{material = "rock"}]

[particles]
particles = 300

[material.rock]
law = "rock"
density = "2500 kg/m3"
effective_modulus = "1 GPa"
stiffness_ratio = 2.0
tensile_strength = "5 MPa"
shear_strength = "15 MPa"
friction_coefficient = 0.5
bonding_range = 1.2

[boundary]
bottom = "rough"

[[stage]]
kind = "settle"
"""
OPENING = """
[[stage]]
kind = "remove-wall"
wall = "bottom"
from = [4, 0]
to = [8, 0]
"""


@pytest.mark.parametrize("more", ["", OPENING])
def test_a_wall_that_few_particles_touch_is_told_opened_or_not(more):
    warnings = build_works(parse_breaking(CASE + more, Path(""))).scene.warnings
    assert [words for words in warnings if "touch its wall (rough)" in words]
