"""The smooth joint by itself: closed forms of Coulomb's joint, and what every law promises."""

from __future__ import annotations

import math

import pytest

from geodem.errors import InputError
from geodem.laws import JOINT_LAWS
from geodem.laws.joint import smooth_joint as law
from geodem.laws.protocol import check_law, make_parameters

KN, KS, PHI, C, T = 1e9, 4e8, math.radians(35.0), 2e5, 5e4
AREA = 0.03
GIVEN = {
    "normal_stiffness": KN, "shear_stiffness": KS, "friction_coefficient": math.tan(PHI), "cohesion": C,
    "tensile_strength": T,
}  # fmt: skip


def joint(
    overlap=0.0, slip=(0.0, 0.0, 0.0), *, intact=1.0, history=(0.0, 0.0, 0.0, 0.0), scale=1.0, **changed
):
    parameters = make_parameters(law, GIVEN | changed, "joint")
    return law.force(*parameters, overlap, *slip, AREA, intact, scale, *history)


@pytest.mark.parametrize("name", JOINT_LAWS)
def test_every_law_of_joints_keeps_the_protocol(name):
    check_law(JOINT_LAWS[name], "joint")


def test_springs_are_per_area():
    normal, x, y, z, dilated, *_ = joint(2e-5, (3e-5, -1e-5, 0.0))
    assert (normal, x, y, z) == pytest.approx((KN * AREA * 2e-5, KS * AREA * 3e-5, -KS * AREA * 1e-5, 0.0))
    assert dilated == 0.0


@pytest.mark.parametrize("scale", [1.0, 0.7])
def test_bonded_face_breaks_at_mohr_coulomb(scale):
    """Mas Ivars et al. 2011: tension where -sigma reaches T, shear where tau reaches c + sigma tan(phi)."""
    tension = joint(-scale * T / KN, scale=scale)[-2]
    assert tension == pytest.approx(1.0)
    for sigma in (0.0, 1e5, -2e4):
        tau = scale * C + sigma * math.tan(PHI)
        cut = joint(sigma / KN, (0.0, tau / KS, 0.0), scale=scale)[-1]
        assert cut == pytest.approx(1.0)


def test_broken_face_slides_by_coulomb_and_opens_freely():
    sigma = 3e5
    normal, x, y, _, dilated, *_ = joint(sigma / KN, (3e-2, 4e-2, 0.0), intact=0.0)
    assert normal == pytest.approx(sigma * AREA)
    assert (x, y) == pytest.approx((0.6 * normal * math.tan(PHI), 0.8 * normal * math.tan(PHI)))
    assert dilated == 0.0
    normal, x, *_ = joint(-1e-5, (1e-5, 0.0, 0.0), intact=0.0, history=(0.0, 50.0, 0.0, 0.0))
    assert (normal, x) == (0.0, 0.0)


def test_residual_cohesion_stays_under_pressure_only():
    sigma, left = 3e5, 1.5e5
    x = joint(sigma / KN, (1.0, 0.0, 0.0), intact=0.0, residual_cohesion=left)[1]
    assert x == pytest.approx(AREA * (sigma * math.tan(PHI) + left))
    assert joint(-1e-6, (1.0, 0.0, 0.0), intact=0.0, residual_cohesion=left)[1] == 0.0


def test_dilation_opens_by_its_angle():
    """What slides plastically lifts the face by tan(psi) times its way."""
    psi, sigma, way = 0.1, 3e5, 1e-2
    normal, x, _, _, dilated, *_ = joint(sigma / KN, (way, 0.0, 0.0), intact=0.0, dilation_coefficient=psi)
    elastic = x / (KS * AREA)
    assert normal == pytest.approx(sigma * AREA)
    assert dilated == pytest.approx(psi * (way - elastic))


def test_force_is_the_gradient_of_the_energy():
    parameters = make_parameters(law, GIVEN, "joint")
    overlap, slip, step = 1.5e-5, 2e-5, 1e-9

    def energy(u, s):
        kept = joint(u, (s, 0.5 * s, 0.0))[4:8]
        return law.energy(KN, KS, u, AREA, 1.0, *kept)

    normal, x, y, *_ = joint(overlap, (slip, 0.5 * slip, 0.0))
    assert parameters.normal_stiffness == KN
    by_closing = (energy(overlap + step, slip) - energy(overlap - step, slip)) / (2.0 * step)
    by_slipping = (energy(overlap, slip + step) - energy(overlap, slip - step)) / (2.0 * step)
    assert by_closing == pytest.approx(normal, rel=1e-6)
    assert by_slipping == pytest.approx(x + 0.5 * y, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("normal_stiffness", 0.0),
        ("friction_coefficient", -0.1),
        ("residual_cohesion", 3e5),
        ("cohesion", math.nan),
    ],
)
def test_parameters_out_of_range_are_named(name, value):
    with pytest.raises(InputError, match=name):
        make_parameters(law, GIVEN | {name: value}, "joint")
