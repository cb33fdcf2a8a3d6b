"""Loads at which a bond of `two_particles.LAWS` breaks, in closed form from the papers."""

from __future__ import annotations

from math import pi
from typing import NamedTuple

from tests.contract.two_particles import LAWS, RADIUS_B


class Load(NamedTuple):
    """Forces [N] (normal: pressure positive) and moments [N m] at which the bond breaks, and how."""

    label: str
    mode: str
    normal: float = 0.0
    shear: float = 0.0
    twist: float = 0.0
    bend: float = 0.0


def two_springs():
    """Zhao 2015, eqs 1.29-1.30: each spring carries N/2 -+ M/db and Fs/2; tension Ft/2, shear F tan(phi) + Fc/2."""
    given = LAWS["two_springs"]
    ft, fc, tan = given["tensile_strength"], given["cohesion"], given["friction_coefficient"]
    db = given["width_ratio"] * 2.0 * RADIUS_B
    return [
        Load("tension", "tension", normal=-ft),
        Load("bending", "tension", bend=ft / 2 * db),
        Load("tension and bending", "tension", normal=-0.4 * ft, bend=0.3 * ft * db),
        Load("pressed and bent", "tension", normal=0.5 * ft, bend=0.75 * ft * db),
        Load("shear", "shear", shear=fc),
        Load("pressed and sheared", "shear", normal=200.0, shear=fc + 200.0 * tan),
        Load("drawn and sheared", "shear", normal=-60.0, shear=fc - 60.0 * tan),
        # the less pressed spring carries 100 - 60 = 40 N, and half of the shear
        Load("pressed, bent and sheared", "shear", normal=200.0, bend=60.0 * db, shear=fc + 2 * 40.0 * tan),
    ]


def section(name, dimension):
    """Potyondy & Cundall 2004, eqs 14-17, with the moments' share beta and the friction of the shear strength.

    The section's radius is that of the smaller grain, times a radius factor where the law has one.
    """
    given = LAWS[name]
    radius = given.get("radius_factor", 1.0) * RADIUS_B
    area, inertia = (2 * radius, 2 / 3 * radius**3)
    if dimension == 3:
        area, inertia = (pi * radius**2, pi / 4 * radius**4)
    sigma, tau, tan = given["tensile_strength"], given["shear_strength"], given["friction_coefficient"]
    bending = sigma * inertia / radius / given["moment_contribution"]
    loads = [
        Load("tension", "tension", normal=-sigma * area),
        Load("bending", "tension", bend=bending),
        Load("tension and bending", "tension", normal=-0.4 * sigma * area, bend=0.6 * bending),
        Load("pressed and bent", "tension", normal=0.5 * sigma * area, bend=1.5 * bending),
        Load("shear", "shear", shear=tau * area),
        Load("pressed and sheared", "shear", normal=5e5 * area, shear=(tau + 5e5 * tan) * area),
        Load("drawn and sheared", "shear", normal=-2e5 * area, shear=(tau - 2e5 * tan) * area),
    ]
    if dimension == 3:
        twisting = tau * (pi / 2 * radius**4) / radius / given["moment_contribution"]
        loads += [
            Load("twist", "shear", twist=twisting),
            Load("shear and twist back", "shear", shear=0.3 * tau * area, twist=-0.7 * twisting),
        ]
    return loads


def rotational_bond(dimension):
    """LAMMPS, bond_style bpm/rotational: -N/frc + |Fs|/fsc + |Mb|/Mbc + |Mt|/Mtc = 1, mode of the larger part."""
    given = LAWS["rotational_bond"]
    frc, fsc = given["tensile_strength"], given["shear_strength"]
    mbc, mtc = given["bending_strength"], given["twisting_strength"]
    loads = [
        Load("tension", "tension", normal=-frc),
        Load("bending", "tension", bend=mbc),
        Load("tension and bending", "tension", normal=-0.4 * frc, bend=0.6 * mbc),
        Load("pressed and bent", "tension", normal=0.5 * frc, bend=1.5 * mbc),
        Load("shear", "shear", shear=fsc),
        Load("pressed and sheared", "shear", normal=0.5 * frc, shear=1.5 * fsc),
        Load("drawn and sheared", "shear", normal=-0.3 * frc, shear=0.7 * fsc),
        Load("sheared and drawn", "tension", normal=-0.7 * frc, shear=0.3 * fsc),
    ]
    if dimension == 3:
        loads += [
            Load("twist", "shear", twist=mtc),
            Load("shear and twist back", "shear", shear=0.3 * fsc, twist=-0.7 * mtc),
            Load("all four", "shear", normal=-0.2 * frc, shear=0.3 * fsc, twist=0.4 * mtc, bend=0.1 * mbc),
        ]
    return loads


STRENGTHS = {
    ("two_springs", 2): two_springs(),
    ("parallel_bond", 2): section("parallel_bond", 2),
    ("parallel_bond", 3): section("parallel_bond", 3),
    ("cement", 2): section("cement", 2),
    ("cement", 3): section("cement", 3),
    ("rock", 2): section("rock", 2),
    ("rock", 3): section("rock", 3),
    ("rotational_bond", 2): rotational_bond(2),
    ("rotational_bond", 3): rotational_bond(3),
}
