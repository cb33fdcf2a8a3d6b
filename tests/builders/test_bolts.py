"""Bolts and linings as they are built; what they bear: tests/verification/test_ground_joints.py."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.bolts import Bar, Grout, add_bolt, add_lining
from geodem.builders.packings import lattice
from geodem.errors import InputError

CONTACT = {"effective_modulus": 1e9, "stiffness_ratio": 2.0, "friction_coefficient": 0.5}
BOND = {
    "effective_modulus": 1e9, "stiffness_ratio": 2.0, "tensile_strength": 1e9, "shear_strength": 1e9,
    "friction_coefficient": 0.5,
}  # fmt: skip


def ground(dimension, bond_law="rock"):
    build = AssemblyBuilder(dimension, "effective_modulus", bond_law)
    build.add_material("rock", density=2500.0, contact=CONTACT, bond=BOND if bond_law == "rock" else None)
    box = (4.0, 2.0) if dimension == 2 else (3.0, 1.2, 1.2)
    build.add_particles(
        lattice("hexagonal" if dimension == 2 else "fcc", 0.1, box=box).positions, 0.1, "rock"
    )
    if bond_law == "rock":
        build.bond_within(1.05)
    return build


@pytest.mark.parametrize("dimension", [2, 3])
def test_shares_add_up_to_the_length_and_the_mass_is_the_bars(dimension):
    build = ground(dimension)
    first = build.particles
    head, end = (0.5, 1.0, 0.6)[:dimension], (2.5, 1.0, 0.6)[:dimension]
    bolt = add_bolt(
        build,
        "bolt",
        head,
        end,
        Bar(1e8, density_per_length=12.0),
        Grout(1e8, 1e5),
        spacing=0.1,
        grouted=(0.5, 1.5),
    )
    made = build.build()
    assert made.joints is not None
    assert bolt.particles[0] == first
    assert len(bolt.pieces) == 20
    assert made.mass[bolt.particles].sum() == pytest.approx(12.0 * 0.1 * 21)
    grout = np.isin(made.joints.pairs[:, 1], bolt.particles) & ~np.isin(
        made.joints.pairs[:, 0], bolt.particles
    )
    assert made.joints.area[grout].sum() == pytest.approx(1.0)
    # overlaps of bolt and ground are no mistake, and the bolt's material touches nothing
    assert made.joints.untouched.tolist() == [1]


def test_plate_presses_on_what_the_grout_does_not_hold():
    build = ground(2)
    bolt = add_bolt(
        build, "bolt", (0.1, 1.0), (2.0, 1.0), Bar(1e8, pretension=5e4), Grout(1e8), spacing=0.1, grouted=(0.5, 2.0),
        plate=True,
    )  # fmt: skip
    assert len(bolt.plate) == 4
    assert (bolt.plate[:, 0] == bolt.particles[0]).all()


def test_lining_has_the_section_it_is_given():
    """Radius sqrt(3 EI/EA), and as many particles as the outline is long in diameters."""
    build = ground(2)
    axial, bending = 3e9, 3e9 * 0.05**2 / 3.0
    angle = np.linspace(0.0, 2.0 * math.pi, 200, endpoint=False)
    ring = add_lining(
        build, "concrete", np.stack([8.0 + 2.0 * np.cos(angle), 8.0 + 2.0 * np.sin(angle)], axis=1),
        axial_stiffness=axial, bending_stiffness=bending, density_per_length=250.0, contact=CONTACT, closed=True,
    )  # fmt: skip
    made = build.build()
    assert made.radii[ring] == pytest.approx(0.05)
    assert len(ring) == round(2.0 * math.pi * 2.0 / 0.1)
    assert made.mass[ring].sum() == pytest.approx(250.0 * 4.0 * math.pi, rel=1e-3)


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"spacing": 0.0}, "spacing"),
        ({"end": (0.5, 1.0)}, "length"),
        ({"grouted": (5.0, 6.0)}, "grouted"),
        ({"bar": Bar(0.0)}, "axial_stiffness"),
        ({"bar": Bar(1e8, yield_force=1.0, pretension=2.0)}, "pretension"),
    ],
)
def test_bad_bolts_are_refused(changed, named):
    given = {
        "head": (0.5, 1.0), "end": (2.5, 1.0), "bar": Bar(1e8), "grout": Grout(1e8), "spacing": 0.1,
        "grouted": (0.0, math.inf),
    } | changed  # fmt: skip
    head, end, bar, grout = (given.pop(name) for name in ("head", "end", "bar", "grout"))
    with pytest.raises(InputError, match=named):
        add_bolt(ground(2), "bolt", head, end, bar, grout, **given)


def test_what_cannot_hold_a_bolt_is_refused():
    with pytest.raises(InputError, match="bond law"):
        add_bolt(ground(2, None), "b", (0.5, 1.0), (2.5, 1.0), Bar(1e8), Grout(1e8), spacing=0.1)
    with pytest.raises(InputError, match="rock"):
        add_lining(
            ground(2, None), "l", [(0.0, 5.0), (3.0, 5.0)], axial_stiffness=1e9, bending_stiffness=1e6,
            density_per_length=1.0, contact=CONTACT,
        )  # fmt: skip
