"""What geodem survives, in its small form: reference/problems/stability.py."""

from __future__ import annotations

import pytest

from reference.problems import (
    stability_abuse,
    stability_contrasts,
    stability_ground,
    stability_rest,
    stability_stops,
    stability_timestep,
)
from tests.verification.rows import check


@pytest.mark.parametrize("case", [("linear_frictional", None, 2), ("effective_modulus", "rock", 2)])
def test_time_step_to_the_critical_one_and_beyond(case):
    check(*stability_timestep.rows(1000, [case]))


def test_restitution_shortens_the_critical_step():
    """Without its dashpots in the critical step this one exploded at half of it."""
    check(*stability_timestep.rows(1000, [("hooke", None, 3)]))


@pytest.mark.parametrize("part", [stability_contrasts.overlaps, stability_stops.kept])
def test_part(part):
    check(*part())


def test_little():
    check(*stability_stops.little(20_000))


def test_contrasts():
    check(*stability_contrasts.contrasts(5000))


def test_nothing_tunnels():
    check(*stability_abuse.tunnelling((0.01, 0.3, 3.0, 1e4)))


def test_bonds_sheared_at_once():
    check(*stability_abuse.sheared_bonds(("rock",)))


def test_what_must_stop_stops():
    check(*stability_stops.stops(pulls=(1e6,)))


def test_rest():
    check(*stability_rest.rest(20_000, [(2, "linear_frictional")]))


def test_rotation():
    """What is left falls as the fourth power of the angle of a step: here 0.36 degrees."""
    check(*stability_rest.rotation(2, 1000, [("two_springs", 2), ("rock", 3)]))


def test_ground():
    check(*stability_ground.scales())
