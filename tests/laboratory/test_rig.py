"""The rig: its elastic state against closed forms of lattices, its start without a shock, what it refuses."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.rig import FIRST_SHARE, Rig, even_density
from geodem.laboratory.specimen import Specimen, make_specimen

KAPPA = 2.5
MODULUS = 60e9
MATERIAL = BondedMaterial.rock(
    density=2600.0, effective_modulus=MODULUS, stiffness_ratio=KAPPA, tensile_strength=20e6,
    shear_strength=80e6, friction_angle=math.radians(30.0),
)  # fmt: skip


@cache
def discs() -> Specimen:
    return make_specimen(2, across=16, seed=2)


@cache
def spheres() -> Specimen:
    return make_specimen(3, across=9, packing="fcc")


def bearing_share(specimen: Specimen) -> float:
    """Section between the centres of the outermost particles of a lattice over that of the box."""
    sides = np.ptp(specimen.positions, axis=0)[:-1] / specimen.size[:-1]
    return float(np.prod(sides))


def test_triangular_discs_have_the_constants_of_their_lattice():
    # kn = Ec for equal discs; E = 2 sqrt3 kn (kn + ks)/(3 kn + ks), nu = (kn - ks)/(3 kn + ks)
    specimen = make_specimen(2, across=30, packing="triangular")
    young, poisson = Rig(specimen, MATERIAL).elastic_constants()
    kn, ks = MODULUS, MODULUS / KAPPA
    assert poisson == pytest.approx((kn - ks) / (3.0 * kn + ks), rel=0.01)
    whole = 2.0 * math.sqrt(3.0) * kn * (kn + ks) / (3.0 * kn + ks)
    assert young == pytest.approx(whole * bearing_share(specimen), rel=0.02)


def test_face_centred_spheres_have_the_constants_of_their_lattice():
    # along a cube axis, a = 2r: E = 2 sqrt2 kn (kn + 3 ks)/(a (3 kn + ks)), nu = (kn - ks)/(3 kn + ks)
    specimen = spheres()
    young, poisson = Rig(specimen, MATERIAL).elastic_constants()
    kn = 0.25 * math.pi * MODULUS * specimen.diameter
    ks = kn / KAPPA
    assert poisson == pytest.approx((kn - ks) / (3.0 * kn + ks), rel=0.05)
    whole = 2.0 * math.sqrt(2.0) * kn * (kn + 3.0 * ks) / (specimen.diameter * (3.0 * kn + ks))
    # half of the slanting links lie in planes of spheres along a side, half between them: as wide as the centres and a
    # quarter of a cell of sqrt2 diameters
    wide = float(np.ptp(specimen.positions[:, 0])) + 0.25 * math.sqrt(2.0) * specimen.diameter
    assert young == pytest.approx(whole * (wide / specimen.width) ** 2, rel=0.02)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_motion_begins_in_the_solved_state(sign):
    rig = Rig(discs(), MATERIAL)
    rig.begin(sign * 2e-8)
    s = rig.simulation
    # bonds are at the share of the first break, and none is broken
    assert s.utilisation[: len(s.assembly.bonds)].max() == pytest.approx(FIRST_SHARE, rel=1e-3)
    assert s.intact().all()
    stress = rig.axial_stress()
    assert stress == pytest.approx(rig.modulus * rig.strain, rel=1e-3)
    assert rig.axial_strain() == pytest.approx(rig.strain, rel=1e-6)
    rig.advance(200)
    assert s.intact().all()
    assert s.unbalanced_ratio() < 0.01
    # it goes on along the line, without a swing
    gone = rig.axial_strain()
    assert gone == pytest.approx(rig.strain + sign * 200 * 2e-8, rel=1e-6)
    assert rig.axial_stress() == pytest.approx(rig.modulus * gone, rel=0.01)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_motion_begins_in_equilibrium_where_contacts_open(sign):
    # contacts beside cement bear pressure alone: half of the links lose half of their stiffness
    lattice = make_specimen(2, across=12, packing="triangular")
    specimen = replace(lattice, radii=(1.0 + 1e-6) * lattice.radii)
    cement = {**MATERIAL.bond, "radius_factor": 1.0}
    rig = Rig(specimen, replace(MATERIAL, bond=cement, bond_law="cement"))
    rig.begin(sign * 1e-9)
    stress = rig.axial_stress()
    # neither what the springs would bear that act both ways, nor a shock on the way from there
    assert sign * stress < 0.99 * rig.modulus * abs(rig.strain)
    rig.advance(400)
    assert rig.axial_stress() == pytest.approx(stress, rel=0.01)
    assert rig.simulation.unbalanced_ratio() < 0.01
    assert rig.simulation.intact().all()


def test_both_grips_feel_the_same_force():
    rig = Rig(discs(), MATERIAL)
    rig.begin(1e-8)
    rig.advance(500)
    force = rig.simulation.forces[:, 1]
    lower, upper = -force[rig.lower].sum(), force[rig.upper].sum()
    assert upper == pytest.approx(lower, rel=2e-3)
    assert rig.axial_stress() == pytest.approx(upper / rig.specimen.area, rel=2e-3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_pressure_all_around_presses_alike(dimension):
    # before the axis is driven it bears what the sides bear, and lattices shrink alike in all directions
    specimen = make_specimen(2, across=20, packing="triangular") if dimension == 2 else spheres()
    pressure = 1e6
    rig = Rig(specimen, MATERIAL, confinement=pressure)
    rig.solve()
    shift = -pressure * (rig.pressed + rig.even * rig.squeezed)[rig.gauge]
    place = rig.start[rig.gauge]
    across = np.polyfit(place[:, 0], shift[:, 0], 1)[0]
    # the axial stress refers to the whole box, of which only what lies between the outermost centres bears
    along = np.polyfit(place[:, -1], shift[:, dimension - 1], 1)[0] * bearing_share(specimen)
    assert across == pytest.approx(along, rel=0.05)
    # C11 + C12 = sqrt3 kn of discs; C11 + 2 C12 = 2 sqrt2 kn/a of spheres
    stiff = math.sqrt(3.0) * MODULUS if dimension == 2 else 2.0 * math.sqrt(2.0) * 0.25 * math.pi * MODULUS
    assert across == pytest.approx(pressure / stiff, rel=0.03)


def test_pressure_does_not_turn_a_cylinder():
    specimen = make_specimen(3, across=9, shape="cylinder", seed=1)
    rig = Rig(specimen, MATERIAL, confinement=10e6)
    rig.begin(1e-8)
    s = rig.simulation
    away = specimen.positions[:, :2] - 0.5 * specimen.width

    def turned() -> float:
        gone = (s.positions - rig.start)[:, :2]
        return float((away[:, 0] * gone[:, 1] - away[:, 1] * gone[:, 0]).sum() / (away**2).sum())

    # what the start still moves has come to rest
    rig.advance(600)
    before = turned()
    rig.advance(300)
    assert abs(turned() - before) < 1e-3 * 10e6 / MODULUS


def test_masses_keep_their_sum_and_give_every_particle_one_frequency():
    radii = np.array([1.0, 1.3, 1.66])
    for dimension in (2, 3):
        mass = even_density(radii, dimension) * radii**dimension
        assert mass.sum() == pytest.approx((radii**dimension).sum())
        # stiffness goes with r^(d - 2)
        frequency = radii ** (dimension - 2) / mass
        assert frequency == pytest.approx(np.full(3, frequency[0]))


def test_what_cannot_be_gripped_is_refused():
    with pytest.raises(InputError, match="grips meet"):
        Rig(make_specimen(2, across=20, height=0.006, width=0.05, packing="square"), MATERIAL)
    loose = BondedMaterial(2600.0, MATERIAL.bond, MATERIAL.contact, bonding_range=1.001)
    with pytest.raises(InputError, match="bonding_range"):
        Rig(discs(), loose)
    with pytest.raises(InputError, match="tensile_strength"):
        Rig(discs(), MATERIAL.with_bond(tensile_strength=0.0))
