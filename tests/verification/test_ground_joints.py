"""Joints in bonded particles against closed forms; all angles: reference/problems/ground_joints.py."""

from __future__ import annotations

import pytest

from reference.problems.ground_bolts import lining, pull_out
from reference.problems.ground_jaeger import intact, jaeger
from reference.problems.ground_priest import priest
from tests.verification.rows import check


@pytest.mark.parametrize(("angle", "across"), [(0.0, 30.0), (45.0, 20.0), (60.0, 20.0)])
def test_specimen_with_a_joint(angle, across):
    """Jaeger 1960: the joint slides at its strength within 5 %, or the rock breaks as if it were whole.

    Strengths of rock scatter by 6 % from one specimen to the next where it is 20 to 24 particles across.
    """
    check(jaeger(angle, across, intact(across)))


@pytest.mark.parametrize("wet", [False, True], ids=["dry", "wet"])
def test_block_on_a_plane(wet):
    """Priest 1993: factor within 2 %."""
    check(*priest(wet=wet, width=0.02))


def test_bolt_is_pulled_out():
    """Farmer 1975: stiffness within 2 %, profile within 5 %; grout and bar hold their strength within 2 %."""
    check(*pull_out())


def test_lining_bends_as_a_beam():
    """Deflection and extension within 2 %."""
    check(*lining())
