"""Ground that yields against closed forms and limit analysis; longer runs: reference/problems/ground.py."""

from __future__ import annotations

import pytest

from reference.problems.ground_collapse import footing_plate, footing_pressure, tunnel
from reference.problems.ground_elastic import geostatic, kirsch, lame


def check(*rows):
    """Every figure is within its bound."""
    assert rows
    for row in rows:
        assert row.good, (
            f"{row.name}, {row.quantity}: {row.value:.6g}, {100 * row.error:+.2f} % off {row.expected:.6g}"
        )


def test_level_ground():
    """Vertical stress gamma z within 0.1 %, K0 = nu/(1 - nu) within 1 %, solved and relaxed."""
    check(*geostatic(2500))


def test_hole_in_a_stressed_plate():
    """Kirsch 1898: 80 MPa at the side wall within 3 %, the field from 1.25 a on within 1 % in the mean."""
    check(*kirsch(2500))


def test_thick_cylinder():
    """Lame: inner displacement within 0.5 %, wall stress within 3 %."""
    check(*lame(2500))


@pytest.mark.parametrize("kind", ["surcharge", "self-weight"])
@pytest.mark.parametrize("cover", [1.0, 2.0])
def test_tunnel_in_clay(cover, kind):
    """Collapse within 1.5 % of the middle of the bounds of finite-element limit analysis."""
    check(tunnel(cover, kind, 1500))


def test_tunnel_in_nearly_incompressible_clay():
    """Poisson's ratio does not enter the collapse load: no locking at 0.49."""
    check(tunnel(1.0, "self-weight", 1000, poisson=0.49))


@pytest.mark.parametrize(("friction", "seed"), [(0.0, 1), (30.0, 1), (30.0, 2)])
def test_pressure_on_a_strip(friction, seed):
    """Prandtl 1921: q = 5.1416 c within 1.5 %, 30.14 c within 2.5 %."""
    check(footing_pressure(friction, 1500, seed=seed))


@pytest.mark.parametrize("rough", [True, False], ids=["rough", "smooth"])
@pytest.mark.parametrize("friction", [0.0, 30.0])
def test_rigid_plate_on_a_strip(friction, rough):
    """The same limits for a plate that is pushed down, rough or smooth."""
    check(*footing_plate(friction, 2500, rough=rough))
