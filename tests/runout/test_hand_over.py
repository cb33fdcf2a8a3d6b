"""Failed ground handed over to discs: what has to be the same before and after."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from geodem.errors import InputError
from geodem.runout.carrying import carried_masses, carried_motion, shift_to_centre
from geodem.runout.flow import Flow
from geodem.runout.friction import MEASURED, DiscFriction, disc_friction
from geodem.runout.handing import HandOver, elastic_energy, hand_over
from geodem.runout.source import Source, failed_source, released_velocity
from tests.runout.slope import DENSITIES, SLIDE, failed_slope, turning

LOOSE = [DiscFriction(0.1, 1.0)] * 2


@pytest.fixture(scope="module")
def source() -> Source:
    model, state = failed_slope()
    return failed_source(model, state, DENSITIES, velocity=turning(model))


@pytest.fixture(scope="module")
def hand(source: Source) -> HandOver:
    return hand_over(source, LOOSE, discs=150, beyond=6.0, young_modulus=20e6, seed=3)


def quadrilaterals(source: Source) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mass, centroid and velocity of what every moving particle owns of every triangle."""
    model, _ = failed_slope()
    field, rows = turning(model), []
    for corners, kind in zip(model.triangles, model.triangle_material, strict=True):
        now, before = source.positions[corners], model.positions[corners]
        a, b = before[1] - before[0], before[2] - before[0]
        third = 0.5 * (a[0] * b[1] - a[1] * b[0]) / 3.0
        for k in range(3):
            if source.moving[corners[k]]:
                one, two, three = (now[(k + j) % 3] for j in range(3))
                ring = [one, (one + two) / 2.0, now.mean(axis=0), (one + three) / 2.0]
                centre = np.array(shapely.Polygon(ring).centroid.coords[0])
                share = np.linalg.solve(np.vstack([now.T, np.ones(3)]), [*centre, 1.0])
                rows.append((DENSITIES[kind] * third, *centre, *(share @ field[corners])))
    found = np.array(rows)
    return found[:, 0], found[:, 1:3], found[:, 3:]


def test_source_is_the_ground_above_the_slip_line(source: Source) -> None:
    # the wedge (3, 12), (8, 12), (16, 4): area by the shoelace formula, less than two particles off along its base
    area = 0.5 * abs((8 - 3) * (4 - 12) - (16 - 3) * (12 - 12))
    assert source.area == pytest.approx(area, rel=0.25)
    assert source.mass == pytest.approx(source.material_mass.sum(), rel=1e-14)
    upper = source.material_mass[0] / DENSITIES[0] + source.material_mass[1] / DENSITIES[1]
    assert upper == pytest.approx(source.area, rel=1e-12)
    assert source.downhill == 1.0
    assert source.slip_surface[0, 1] > source.slip_surface[-1, 1]
    moved = source.positions[source.moving].mean(axis=0)
    model, _ = failed_slope()
    assert np.hypot(*(moved - model.positions[source.moving].mean(axis=0))) == pytest.approx(SLIDE, rel=1e-9)


def test_mass_is_exact_in_all_and_by_material(source: Source, hand: HandOver) -> None:
    a, own = hand.simulation.assembly, hand.moving
    assert a.mass[own].sum() == pytest.approx(source.mass, rel=1e-13)
    for kind, mass in enumerate(source.material_mass):
        assert a.mass[own & (a.material == kind)].sum() == pytest.approx(mass, rel=1e-13)
    assert (a.mass > 0.0).all()


def test_centre_of_gravity_and_momenta_are_kept(source: Source, hand: HandOver) -> None:
    a, own = hand.simulation.assembly, hand.moving
    mass, where, speed = a.mass[own], a.positions[own], a.velocities[own]
    centre = mass @ where / mass.sum()
    assert centre == pytest.approx(source.centre, rel=1e-10)
    assert mass @ speed == pytest.approx(source.momentum, rel=1e-10)
    arm = where - centre
    moment = mass @ (arm[:, 0] * speed[:, 1] - arm[:, 1] * speed[:, 0]) + a.inertia[own] @ a.spins[own, 0]
    assert moment == pytest.approx(source.angular_momentum, rel=1e-10)
    # the source itself, summed another way: over quadrilaterals, about the origin
    mass, place, speed = quadrilaterals(source)
    assert mass.sum() == pytest.approx(source.mass, rel=1e-12)
    assert mass @ place / mass.sum() == pytest.approx(source.centre, rel=1e-10)
    about = mass @ (place[:, 0] * speed[:, 1] - place[:, 1] * speed[:, 0])
    orbit = source.centre[0] * source.momentum[1] - source.centre[1] * source.momentum[0]
    assert source.angular_momentum == pytest.approx(about - orbit, rel=1e-9)


def test_energy_jumps_by_less_than_a_percent(source: Source, hand: HandOver) -> None:
    a, own = hand.simulation.assembly, hand.moving
    kinetic = 0.5 * (
        a.mass[own] @ (a.velocities[own] ** 2).sum(axis=1) + a.inertia[own] @ a.spins[own, 0] ** 2
    )
    assert kinetic == pytest.approx(source.kinetic, rel=1e-10)
    height = a.mass[own] @ (a.positions[own, 1] - source.datum)
    assert height * source.gravity == pytest.approx(source.potential, rel=1e-10)
    bent = elastic_energy(hand.simulation)[own].sum()
    total = source.potential + source.kinetic + source.elastic
    assert abs(height * source.gravity + kinetic + bent - total) < 0.01 * total
    assert hand.error("energy") < 0.01
    # the discs press on one another by their weight
    assert bent > 0.0


def test_discs_rest_under_their_weight(hand: HandOver) -> None:
    # as they were brought to rest: what contacts remember is more than they may bear in the flow
    s, own, contacts = hand.simulation, hand.moving, hand.simulation.contacts()
    pairs, places = contacts.pairs, s.positions
    along = places[pairs[:, 1]] - places[pairs[:, 0]]
    along /= np.hypot(*along.T)[:, None]
    normal = hand.stiffness * np.maximum(contacts.overlap, 0.0)
    (shear,) = (values for name, values in contacts.history.items() if name.startswith("shear"))
    # normal pushes the first away from the second; shear acts on the first, along the normal turned left
    on_first = shear[:, None] * np.stack([-along[:, 1], along[:, 0]], axis=1) - normal[:, None] * along
    total = np.zeros_like(places)
    np.add.at(total, pairs[:, 0], on_first)
    np.add.at(total, pairs[:, 1], -on_first)
    weight = hand.mass[own].sum() * hand.source.gravity
    # the rigid ground bears the whole weight
    assert total[own].sum(axis=0) == pytest.approx([0.0, weight], abs=0.03 * weight)


def test_the_flow_loses_energy_and_falls(hand: HandOver) -> None:
    flow = Flow.of(hand)
    for _ in range(8):
        flow.advance()
    lost = np.array([look.dissipated for look in flow.looks])
    assert lost[0] == pytest.approx(0.0, abs=1e-9 * flow.energy)
    assert (np.diff(lost) > -1e-3 * flow.energy).all()
    assert flow.looks[-1].centre_y < flow.looks[0].centre_y
    assert flow.looks[-1].centre_x > flow.looks[0].centre_x
    held = ~hand.moving
    assert (flow.simulation.positions[held] == flow.start[held]).all()


def test_masses_and_motion_of_any_discs() -> None:
    model, state = failed_slope()
    source = failed_source(model, state, DENSITIES, velocity=turning(model))
    rng = np.random.default_rng(5)
    where = source.centre + rng.normal(0.0, 2.0, (80, 2)) + (0.1, -0.05)
    radii, material = rng.uniform(0.2, 0.4, 80), (np.arange(80) % 2).astype(np.int32)
    mass = carried_masses(source, radii, material)
    for kind in (0, 1):
        assert mass[material == kind].sum() == pytest.approx(source.material_mass[kind], rel=1e-12)
        assert np.ptp((mass / radii**2)[material == kind]) < 1e-9 * mass.max()
    where = where + shift_to_centre(source, where, mass)
    assert mass @ where / mass.sum() == pytest.approx(source.centre, rel=1e-12)
    inertia = 0.5 * mass * radii**2
    v, w = carried_motion(source, where, mass, inertia, rng.normal(0, 1, (80, 2)), rng.normal(0, 1, 80))
    assert mass @ v == pytest.approx(source.momentum, rel=1e-12)
    arm = where - source.centre
    turn = mass @ (arm[:, 0] * v[:, 1] - arm[:, 1] * v[:, 0]) + inertia @ w
    assert turn == pytest.approx(source.angular_momentum, rel=1e-10)


def test_packing_is_moved_by_less_than_a_disc(hand: HandOver) -> None:
    assert np.hypot(*hand.shift) < hand.diameter
    assert hand.settlement > 0.0


def test_released_velocity_holds_the_energy_given() -> None:
    model, state = failed_slope()
    state.velocity[:] = turning(model)
    moving = failed_source(model, state, DENSITIES).moving
    found = failed_source(
        model, state, DENSITIES, velocity=released_velocity(model, state, DENSITIES, moving, 1234.0)
    )
    assert found.kinetic == pytest.approx(1234.0, rel=1e-12)
    assert not released_velocity(model, state, DENSITIES, moving, 0.0).any()


def test_friction_is_read_backwards_and_refused_beyond() -> None:
    for sliding, angle in MEASURED[1:-1]:
        assert disc_friction(math.radians(angle)).sliding == pytest.approx(sliding, rel=1e-12)
    angles = np.radians(np.linspace(13.0, 32.0, 20))
    assert (np.diff([disc_friction(a).sliding for a in angles]) > 0.0).all()
    for angle in (5.0, 40.0):
        with pytest.raises(InputError, match="discs reach"):
            disc_friction(math.radians(angle))


def test_a_state_that_is_torn_apart_is_taken_as_far_as_its_triangles_hold() -> None:
    model, state = failed_slope()
    state.displacement *= 1000.0
    source = failed_source(model, state, DENSITIES)
    assert 0.0 < source.taken < 0.1
    moved = source.positions - model.positions
    assert moved == pytest.approx(source.taken * state.displacement)
    # mass is that of the ground before
    assert source.mass == pytest.approx(failed_source(*failed_slope(), DENSITIES).mass, rel=1e-12)


def test_nothing_moves_and_unknown_choices_are_refused() -> None:
    model, state = failed_slope()
    with pytest.raises(InputError, match="no such choice"):
        failed_source(model, state, DENSITIES, what="half")
    state.displacement[:] = 0.0
    with pytest.raises(InputError, match="nothing moves"):
        failed_source(model, state, DENSITIES)
    whole = failed_source(model, state, DENSITIES, what="section")
    assert whole.moving.sum() == (~model.held.any(axis=1)).sum()
