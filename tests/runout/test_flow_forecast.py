"""When a flow is expected to rest: its steps are counted, no clock."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from geodem.runout.flow import AT_REST, LONGEST, LOOK, RESTS, SLOWER, Flow, Look
from geodem.runout.friction import disc_friction, friction_tangent

STEP = 1e-3


def flow(kinetic, *, friction=0.4):
    """A flow of unit height and gravity with these kinetic energies, one a look; it rests at a thousandth."""
    assembly = SimpleNamespace(radii=np.full(1, 0.5))
    simulation = SimpleNamespace(
        time_step=STEP, steps=round((len(kinetic) - 1) * LOOK / STEP), assembly=assembly
    )
    looks = [Look(LOOK * k, 0.0, 0.0, energy, 0.0, 0.0, 0.0, 0.0, 0.0) for k, energy in enumerate(kinetic)]
    return Flow(
        simulation, start=np.zeros((1, 2)), moving=np.ones(1, dtype=bool), mass=np.ones(1),
        surface=np.zeros((2, 2)), gravity=1.0, datum=0.0, height=1.0, downhill=1.0, energy=1.0, friction=friction,
        looks=looks,
    )  # fmt: skip


def rest_of(work):
    return STEP * (work.done + work.left)


@pytest.mark.parametrize("degrees", [13.0, 20.0, 31.5])
def test_discs_have_the_friction_angle_that_they_were_chosen_for(degrees):
    assert friction_tangent(disc_friction(math.radians(degrees))) == pytest.approx(
        math.tan(math.radians(degrees))
    )


def test_at_first_the_friction_says_when_it_rests():
    for friction in (0.2, 0.4):
        begun = flow([0.0, 0.1, 0.4, 0.9], friction=friction).work()
        assert rest_of(begun) == pytest.approx(RESTS / friction)
        assert STEP * (begun.done + begun.most) == pytest.approx(LONGEST)


def test_then_how_long_it_took_to_slow_down():
    """By the pace at which it slows down it would go on for longer here."""
    rising = [0.0, 0.3, 0.6, 0.8, 1.0]
    half, tenth = [*rising, 0.9, 0.8, 0.6, 0.49], [*rising, 0.9, 0.8, 0.6, 0.4, 0.2, 0.099]
    shares = dict(SLOWER)
    # nothing is known yet of seven looks before a slow fall
    assert rest_of(flow(half).work()) == pytest.approx(shares[0.5] * 8 * LOOK)
    assert rest_of(flow(tenth).work()) == pytest.approx(shares[0.1] * 10 * LOOK)


def test_what_is_almost_at_rest_rests_soon():
    falling = [1.0, *(0.5 ** np.arange(1, 14))]
    little = AT_REST
    left = math.log2(falling[-1] / little) * LOOK if falling[-1] > little else 0.0
    assert STEP * flow(falling).work().left <= left + 3.0 * LOOK
