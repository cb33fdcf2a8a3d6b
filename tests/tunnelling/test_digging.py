"""Excavation in stages: what stays in equilibrium, what is carried, and the closed form of a round hole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.tunnelling.digging import Digging
from geodem.tunnelling.ground import internal_forces, standing
from geodem.tunnelling.plan import Bolts, DepthStress, Lining, Stage
from geodem.tunnelling.progress import Progress
from reference.problems.tunnels_deep import convergence, equilibrium, medium, quarter, salencon
from tests.tunnelling.tunnels import level_ground


@pytest.fixture(scope="module")
def hole():
    """The hole of P16, a quarter of it, psi = phi, 1200 particles."""
    return quarter(30.0, 1200)


def test_the_closed_form_gives_the_published_figures():
    """Itasca's verification problem: R0/a = 1.735, u = 28.10 mm (psi 30) and 12.17 mm (psi 0)."""
    assert salencon(0.0, medium(30.0)).rim == pytest.approx(1.735, rel=3e-4)
    assert salencon(0.0, medium(30.0)).displacement == pytest.approx(28.10e-3, rel=3e-4)
    assert salencon(0.0, medium(0.0)).displacement == pytest.approx(12.17e-3, rel=5e-4)


def test_the_hole_of_the_verification_manuals():
    """Wall displacement within 3 %, yielded zone within 1.5 % (P16)."""
    for row in convergence(30.0, 2500):
        assert row.good, (row.quantity, row.value, row.expected)


def test_the_whole_reaction_curve(hole):
    """Displacement under every pressure within 3 % of Salencon's; elastic at first."""
    rows = hole.progress.rows
    assert len(rows) == 21
    for row in rows[1:]:
        exact = salencon((1.0 - row["relaxed"]) * 30e6, medium(30.0))
        assert row["mean"] == pytest.approx(exact.displacement, rel=0.03), row["relaxed"]
    # the elastic branch ends at p = (2 P - q)/(Kp + 1) = 12.012 MPa; single particles on the wall yield earlier
    assert all(row["yielded_area"] == 0.0 for row in rows if row["pressure"] > 15.1e6)
    assert max(row["plastic_radius_ratio"] for row in rows if row["pressure"] > 12.1e6) < 1.02
    assert rows[-1]["yielded_area"] > 0.0


def test_a_ring_meets_the_ground_where_both_curves_cross():
    """Pressure and displacement within 3 %; thrust p a within 1 %."""
    ring = Lining("ring", "hole", 0.05, 20e9, 0.2)
    stages = (
        Stage("dig", excavate=("hole",), relax=0.8), Stage("line", install=("ring",)), Stage("rest", relax=1.0),
    )  # fmt: skip
    last = quarter(30.0, 1200, stages, linings=(ring,)).progress.rows[-1]
    pressure, displacement = equilibrium(0.8, ring.axial_stiffness, medium(30.0))
    assert last["lining_pressure"] == pytest.approx(pressure, rel=0.03)
    assert last["mean"] == pytest.approx(displacement, rel=0.03)
    assert last["largest_thrust"] == pytest.approx(last["lining_pressure"], rel=0.01)


def test_what_is_taken_out_is_missed_by_nothing_but_the_wall():
    """With all forces kept the standing ground is in equilibrium; they act on the wall alone."""
    ground, plan = level_ground()
    digging = Digging(ground, plan)
    digging.set_up(plan.stages[0])
    stands = standing(digging.ground, [0])
    model = stands.model
    stress = digging.progress.stress[stands.point]
    missing = digging.external(stands) + model.weight + model.load - internal_forces(model, stress)
    scale = np.abs(digging.external(stands)).max()
    assert np.abs(missing[~model.held]).max() < 1e-9 * scale
    wall = set(np.unique(digging.ground.wall(0, [0])).tolist())
    pushed = np.flatnonzero(np.abs(digging.progress.kept[0]).max(axis=1) > 1e-6 * scale)
    assert set(pushed.tolist()) <= wall
    # the weight of the plug that is gone is what the wall misses upwards: pi 2^2 m2 of 20 kN/m3
    assert digging.progress.kept[0][:, 1].sum() == pytest.approx(-np.pi * 4.0 * 20e3, rel=0.02)


def test_stress_before_the_digging_has_the_given_k0():
    """sigma_y = gamma z and sigma_x = K0 sigma_y, at rest without any displacement."""
    ground, plan = level_ground(k0=0.6)
    digging = Digging(ground, plan)
    x, y = ground.model.positions.T
    inside = (y > -8.0) & (y < 10.0) & (np.abs(x) < 14.0)
    stress = ground.model.particle_mean(digging.initial.stress)[inside]
    # the mean over the ground around a particle lies off it by a share of the spacing, some 2 m here
    assert np.allclose(stress[:, 1], -20e3 * (12.0 - y[inside]), rtol=0.02, atol=6e3)
    assert np.mean(stress[:, 1] + 20e3 * (12.0 - y[inside])) == pytest.approx(0.0, abs=500.0)
    assert np.allclose(stress[:, 0], 0.6 * stress[:, 1], rtol=0.02, atol=1e3)


def test_stress_that_the_ground_cannot_bear_is_refused():
    ground, plan = level_ground(cohesion=1e3)
    with pytest.raises(InputError, match="beyond the strength") as caught:
        Digging(ground, replace(plan, initial=DepthStress(0.2)))
    assert "k0" in caught.value.place
    assert "(1 - sin phi)/(1 + sin phi)" in caught.value.remedy


def test_half_a_plan_gone_on_with_gives_the_same_bits():
    """Stopped within a stage, with lining and bolts, through a checkpoint tree."""
    ground, plan = level_ground()
    lining = Lining("shell", "tunnel", 0.2, 15e9)
    bolts = Bolts("bolts", (((0.0, 2.0), (0.0, 5.0)), ((2.0, 0.0), (5.0, 0.0))), 5e-4, 200e9, 1e5, 1.5)
    stages = (*plan.stages, Stage("support", install=("shell", "bolts")), Stage("rest", relax=1.0))
    plan = replace(plan, stages=stages, linings=(lining,), bolts=(bolts,))
    whole = Digging(ground, plan, increments=6).run()

    class Stop(Exception):
        pass

    def stop(digging):
        if digging.progress.stage == 2 and digging.progress.increment == 1:
            raise Stop

    first = Digging(ground, plan, increments=6, on_increment=stop)
    with pytest.raises(Stop):
        first.run()
    tree = first.progress.to_tree()
    second = Digging(ground, plan, increments=6, progress=Progress.from_tree(tree)).run()
    assert second.stress.tobytes() == whole.stress.tobytes()
    assert second.displacement.tobytes() == whole.displacement.tobytes()
    assert all(a.tobytes() == b.tobytes() for a, b in zip(second.support, whole.support, strict=True))
    assert second.rows == whole.rows
    assert whole.rows[-1]["largest_bolt_force"] > 0.0
    assert whole.rows[-1]["lining_pressure"] > 0.0


def test_an_opening_that_does_not_stand_is_bracketed():
    """Weak clay: somewhere between kept and gone there is no rest any more; nothing is relaxed beyond it."""
    ground, plan = level_ground(cohesion=2e3, k0=1.0)
    plan = replace(plan, stages=(Stage("dig", excavate=("tunnel",), relax=1.0),))
    progress = Digging(ground, plan, increments=10).run()
    collapse = progress.collapse
    assert collapse is not None
    assert 0.3 < collapse.stable < collapse.failed <= collapse.stable + 0.0101
    assert 0.0 < collapse.pressure_failed < collapse.pressure_stable
    assert max(row["relaxed"] for row in progress.rows) == pytest.approx(collapse.stable)
