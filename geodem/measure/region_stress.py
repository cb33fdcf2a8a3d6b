"""Mean stress in a circle or sphere or in a box, from the forces of the links that cross it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from .stress import stress_of_contacts

Floats = NDArray[np.float64]


def stress_in_region(
    forces: ArrayLike, starts: ArrayLike, branches: ArrayLike, centre: ArrayLike, radius: float
) -> Floats:
    """Mean stress in a circle (2D) or sphere (3D), positive in tension.

    Every link is a line from centre to centre that carries its force, and counts by the share of it that lies inside:
    sum of f_i l_j share over the volume. Summed over regions that fill a body it is the stress of the body, and no
    particle's area has to be told from that of the voids.
    Source: the mean stress theorem for the force network, as in Bagi 1996, Mech. Mater. 22:165, with Weber's sum.

    Parameters
    ----------
    forces : (k, d) [N]
        On the first particle of every link.
    starts : (k, d) [m]
        Centre of that particle.
    branches : (k, d) [m]
        From there to the centre of the second one, or to where it touches a wall.
    centre : (d,) [m]
    radius : float
        [m]

    Returns
    -------
    (d, d) [Pa] (2D: forces in N per m)

    Raises
    ------
    InputError
        Arrays that do not belong together, a radius that is none.
    """
    if not (math.isfinite(radius) and radius > 0.0):
        raise InputError("region, radius", "this is no radius", "Give metres, more than 0", value=radius)
    begin, branch = np.asarray(starts, dtype=float), np.asarray(branches, dtype=float)
    middle = np.asarray(centre, dtype=float)
    if begin.shape != branch.shape or begin.ndim != 2 or middle.shape != begin.shape[1:]:
        raise InputError(
            "region",
            f"starts {begin.shape}, branches {branch.shape} and a centre {middle.shape} do not belong together",
            "Give one row of each a link, and a centre of as many coordinates",
        )
    volume = math.pi * radius**2 if begin.shape[1] == 2 else 4.0 / 3.0 * math.pi * radius**3
    share = share_inside(begin, branch, middle, radius)
    return stress_of_contacts(forces, share[:, None] * branch, volume)


def share_inside(starts: Floats, branches: Floats, centre: Floats, radius: float) -> Floats:
    """Share (k,) of lines from `starts` (k, d) along `branches` (k, d) that lies within `radius` of a centre [-]."""
    away = starts - centre
    # |away + t branch|^2 = radius^2
    a = (branches**2).sum(axis=1)
    half = (away * branches).sum(axis=1)
    rest = half**2 - a * ((away**2).sum(axis=1) - radius**2)
    safe = np.where(a > 0.0, a, 1.0)
    root = np.sqrt(np.maximum(rest, 0.0))
    first, last = np.clip((-half - root) / safe, 0.0, 1.0), np.clip((-half + root) / safe, 0.0, 1.0)
    return np.where((rest > 0.0) & (a > 0.0), last - first, 0.0)


def stress_in_box(
    forces: ArrayLike, starts: ArrayLike, branches: ArrayLike, low: ArrayLike, high: ArrayLike
) -> Floats:
    """Mean stress (d, d) [Pa] in a box between two corners (d,) [m]; the rest as of `stress_in_region`.

    Raises
    ------
    InputError
        Arrays that do not belong together, corners that bound no box.
    """
    begin, branch = np.asarray(starts, dtype=float), np.asarray(branches, dtype=float)
    least, most = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    if begin.shape != branch.shape or begin.ndim != 2 or not least.shape == most.shape == begin.shape[1:]:
        raise InputError(
            "region",
            f"starts {begin.shape}, branches {branch.shape} and corners {least.shape} do not belong together",
            "Give one row of each a link, and corners of as many coordinates",
        )
    if not (most > least).all():
        raise InputError(
            "region, corners", "they bound no box", "Give the lowest and the highest coordinates"
        )
    # of each line, from where to where it is between the two faces of every pair
    still = branch == 0.0
    safe = np.where(still, 1.0, branch)
    one, other = (least - begin) / safe, (most - begin) / safe
    within = (begin >= least) & (begin <= most)
    first = np.where(still, np.where(within, 0.0, np.inf), np.minimum(one, other)).max(axis=1)
    last = np.where(still, np.where(within, 1.0, -np.inf), np.maximum(one, other)).min(axis=1)
    share = np.maximum(np.minimum(last, 1.0) - np.maximum(first, 0.0), 0.0)
    return stress_of_contacts(forces, share[:, None] * branch, float(np.prod(most - least)))
