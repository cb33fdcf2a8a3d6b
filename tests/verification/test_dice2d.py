"""DICE2D's twelve examples against closed forms and balances: reference/problems/dice2d.py."""

from __future__ import annotations

import pytest

from reference.problems import dice2d_contacts, dice2d_motion, dice2d_scenes
from tests.verification.rows import check


@pytest.mark.parametrize(
    "example",
    [
        dice2d_motion.falling,
        dice2d_motion.pendulum,
        dice2d_motion.bouncing,
        dice2d_motion.viscous_bouncing,
        dice2d_motion.sliding,
        dice2d_motion.rolling,
        dice2d_contacts.tension,
        dice2d_contacts.shear,
        dice2d_contacts.tension_failure,
        dice2d_contacts.shear_failure,
        dice2d_contacts.newton_balls,
        dice2d_scenes.run,
    ],
)
def test_example(example):
    """Every figure is within its bound."""
    check(*example())
