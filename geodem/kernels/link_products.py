"""The stiffness of a network times displacements, link by link: for networks whose matrix would not fit.

The same strains as in `geodem.integrators.network`; a link's row of numbers is read once, and no matrix is made.
"""

from __future__ import annotations

from functools import cache
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .._jit import compile_kernel

if TYPE_CHECKING:
    from ..integrators.network import Links, Springs

Floats = NDArray[np.float64]


def disc_products(first, second, normal, arms, kn, ks, k_bend, moved, force):
    """force (n, 3) += K moved (n, 3): x, y [m], rotation [rad]."""
    for p in range(len(first)):
        a, b = first[p], second[p]
        x, y = normal[p, 0], normal[p, 1]
        along = -moved[a, 0]
        across = -moved[a, 1]
        turned = -moved[a, 2]
        rolled = -arms[p, 0] * moved[a, 2]
        if b >= 0:
            along += moved[b, 0]
            across += moved[b, 1]
            turned += moved[b, 2]
            rolled -= arms[p, 1] * moved[b, 2]
        pull = kn[p] * (along * x + across * y)
        shear = ks[p] * (across * x - along * y + rolled)
        bend = k_bend[p] * turned
        fx, fy = pull * x - shear * y, pull * y + shear * x
        force[a, 0] -= fx
        force[a, 1] -= fy
        force[a, 2] -= arms[p, 0] * shear + bend
        if b >= 0:
            force[b, 0] += fx
            force[b, 1] += fy
            force[b, 2] += bend - arms[p, 1] * shear


def sphere_products(first, second, normal, arms, kn, ks, k_twist, k_bend, moved, force):
    """force (n, 6) += K moved (n, 6): x, y, z [m], rotations [rad]."""
    for p in range(len(first)):
        a, b = first[p], second[p]
        x, y, z = normal[p, 0], normal[p, 1], normal[p, 2]
        ux, uy, uz = -moved[a, 0], -moved[a, 1], -moved[a, 2]
        tx, ty, tz = -moved[a, 3], -moved[a, 4], -moved[a, 5]
        # arm_a theta_a + arm_b theta_b
        rx, ry, rz = arms[p, 0] * moved[a, 3], arms[p, 0] * moved[a, 4], arms[p, 0] * moved[a, 5]
        if b >= 0:
            ux, uy, uz = ux + moved[b, 0], uy + moved[b, 1], uz + moved[b, 2]
            tx, ty, tz = tx + moved[b, 3], ty + moved[b, 4], tz + moved[b, 5]
            rx += arms[p, 1] * moved[b, 3]
            ry += arms[p, 1] * moved[b, 4]
            rz += arms[p, 1] * moved[b, 5]
        extension = ux * x + uy * y + uz * z
        sx = ks[p] * (ux - extension * x - (ry * z - rz * y))
        sy = ks[p] * (uy - extension * y - (rz * x - rx * z))
        sz = ks[p] * (uz - extension * z - (rx * y - ry * x))
        pull = kn[p] * extension
        fx, fy, fz = pull * x + sx, pull * y + sy, pull * z + sz
        # n x shear
        mx, my, mz = y * sz - z * sy, z * sx - x * sz, x * sy - y * sx
        twist = (k_twist[p] - k_bend[p]) * (tx * x + ty * y + tz * z)
        bx, by, bz = twist * x + k_bend[p] * tx, twist * y + k_bend[p] * ty, twist * z + k_bend[p] * tz
        force[a, 0] -= fx
        force[a, 1] -= fy
        force[a, 2] -= fz
        force[a, 3] -= arms[p, 0] * mx + bx
        force[a, 4] -= arms[p, 0] * my + by
        force[a, 5] -= arms[p, 0] * mz + bz
        if b >= 0:
            force[b, 0] += fx
            force[b, 1] += fy
            force[b, 2] += fz
            force[b, 3] += bx - arms[p, 1] * mx
            force[b, 4] += by - arms[p, 1] * my
            force[b, 5] += bz - arms[p, 1] * mz


@cache
def _kernel() -> ModuleType:
    return compile_kernel([disc_products, sphere_products], {}, parallel=False)


def link_product(links: Links, springs: Springs | None, moved: Floats) -> Floats:
    """K u (n, d + s) [N, N m] of displacements and rotations u (n, d + s) [m, rad]."""
    force = np.zeros_like(moved)
    dimension = links.normal.shape[1]
    shared = (links.first, links.second, links.normal, links.arms, links.kn, links.ks)
    if dimension == 2:
        _kernel().disc_products(*shared, links.k_bend, moved, force)
    else:
        _kernel().sphere_products(*shared, links.k_twist, links.k_bend, moved, force)
    if springs is not None:
        there = moved[springs.particle, :dimension]
        along = (there * springs.direction).sum(axis=1)[:, None] * springs.direction
        pull = springs.along[:, None] * along + springs.across[:, None] * (there - along)
        np.add.at(force, (springs.particle[:, None], np.arange(dimension)), pull)
    return force
