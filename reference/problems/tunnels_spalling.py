"""A tunnel in hard rock under anisotropic stress: Kirsch's stresses before it breaks, then where and when it spalls.

Bonded discs of the law `rock`; the far field is brought about, a circle is excavated and its face relaxed in stages.
The outline moves as that of an infinite plate would (Kirsch 1898; Muskhelishvili 1953, section 56a), so that the plate
is infinite in effect. Then the far field grows, all components alike, and bonds break. The strength of the rock is
measured: uniaxial compression of specimens with the same bonds and grains.

The wall is as rough as its grains are large, and grains that stand out of it bear little: what is missing beside
Kirsch's thrust is that of a layer of a quarter of a grain, so it falls with the size of the grains.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .rows import Row, at_most, relative
from .tunnels_spalling_ground import (
    FIELD,
    GROWTH,
    HALF,
    RAYS,
    RINGS,
    ROCK,
    SIZE_RATIO,
    SOME,
    Tunnel,
    excavate,
    mean_hoop,
    raise_load,
    rays,
    thrust_stress,
)
from .tunnels_spalling_kirsch import RADIUS
from .tunnels_spalling_onset import Laboratory, expected_load, laboratory

Floats = NDArray[np.float64]

SIZES = {3_000: 16, 12_000: 8, 48_000: 4}
"""Arrangements by their number of discs: stresses are means. The first one of the last is loaded until it breaks."""
HALF_A_GRAIN = 0.5
"""The outermost grains lack the neighbours on one side: what is missing is less than half of one."""
FALLING = 0.75
"""An error that falls with the size of grains is at most this share of that at twice the size."""
MARTIN = 0.4
"""Onset of spalling in situ: largest stress at the wall over the compressive strength, 0.4 +- 0.1 (Martin 1997)."""


@dataclass(frozen=True)
class Elastic:
    """Tunnels of one size before anything breaks.

    Attributes
    ----------
    across : float
        Mean grains across the radius [-].
    hoop : (n, rings)
        Hoop stress at roof and floor of every tunnel [Pa], of all rays by their second harmonic.
    first : (n, k)
        Loads at which the first bonds of every tunnel would break, ascending.
    grains : float
        Per area [1/m2].
    seconds : float
    """

    across: float
    hoop: Floats
    first: Floats
    grains: float
    seconds: float

    def missing(self, ring: int = 0) -> Floats:
        """Thickness (n,) [grains] of a layer that would bear what a ring bears less than Kirsch has it."""
        low, high = RINGS[ring]
        return (1.0 - self.hoop[:, ring] / kirsch_at(ring)) * (high - low) * self.across


def at_roof_and_floor(values: Floats) -> float:
    """Of values (RAYS,) their mean and second harmonic at 90 degrees."""
    shapes = np.column_stack([np.ones(RAYS), -np.cos(2.0 * rays())])
    return float(np.linalg.lstsq(shapes, values, rcond=None)[0].sum())


def kirsch_at(ring: int) -> float:
    """Kirsch's hoop stress at roof and floor in a ring [Pa]."""
    return at_roof_and_floor(mean_hoop(*RINGS[ring]))


def elastic(particles: int, seeds: int) -> tuple[Elastic, Tunnel]:
    """Tunnels of one size, and the first of them."""
    begun = time.perf_counter()
    hoop, first, kept, across = [], [], None, 0.0
    for seed in range(1, seeds + 1):
        tunnel = excavate(particles, seed)[0]
        s = tunnel.simulation
        hoop.append([at_roof_and_floor(thrust_stress(s, *ring)) for ring in RINGS])
        used = np.where(s.intact()[:, None], s.utilisation[: len(s.assembly.bonds)], 0.0).max(axis=1)
        first.append(1.0 / np.sort(used)[: -1 - SOME : -1])
        across += RADIUS / (2.0 * float(s.assembly.radii.mean())) / seeds
        kept = kept or tunnel
    assert kept is not None
    grains = particles / (2.0 * HALF * RADIUS) ** 2
    found = Elastic(across, np.array(hoop), np.array(first), grains, time.perf_counter() - begun)
    return found, kept


def rows_of_rings(found: Elastic) -> list[Row]:
    """Hoop stress at roof and floor beside Kirsch's, means over the tunnels of one size."""
    rows = []
    for k, (low, high) in enumerate(RINGS):
        rows.append(
            relative(
                "hoop stress" if k else "hoop stress, wall", f"roof and floor, {low:g} to {high:g} radii [Pa]",
                float(found.hoop[:, k].mean()), kirsch_at(k), 0.03 if k else 0.10, 0.0 if k else found.seconds,
                f"Kirsch (1898); {found.across:.0f} grains across the radius, {len(found.hoop)} tunnels",
            )
        )  # fmt: skip
    return rows


def rows_of_sizes(sizes: list[Elastic]) -> list[Row]:
    """What is missing at the wall, in grains, and where the hoop stress there goes to with their size."""
    rows = [
        at_most(
            "hoop stress, wall",
            f"{each.across:.0f} grains across the radius: missing thrust, as a layer in grains [-], at most",
            float(each.missing().mean()), HALF_A_GRAIN, each.seconds, f"of order 1; {len(each.hoop)} tunnels",
        )
        for each in sizes
    ]  # fmt: skip
    size = np.concatenate([np.full(len(each.hoop), 1.0 / each.across) for each in sizes])
    hoop = np.concatenate([each.hoop[:, 0] for each in sizes])
    # tunnels of few grains differ most from one another
    weight = np.concatenate([np.full(len(each.hoop), 1.0 / each.hoop[:, 0].std(ddof=1)) for each in sizes])
    lines = np.column_stack([np.ones(len(size)), size]) * weight[:, None]
    limit = float(np.linalg.lstsq(lines, hoop * weight, rcond=None)[0][0])
    rows.append(
        relative(
            "hoop stress, wall", "on a line over the size of grains, at size 0 [Pa]", limit, kirsch_at(0), 0.03, 0.0,
            f"Kirsch (1898); {len(size)} tunnels",
        )
    )  # fmt: skip
    return rows


def rows_of_first_cracks(sizes: list[Elastic], found: Laboratory) -> list[Row]:
    """Load of the first crack beside that by the cracks of specimens; and when specimens begin to crack.

    The larger grains are, the less they feel of the peak at the wall: what is over falls with their size.
    """
    peak = 3.0 * FIELD[0] - FIELD[1]
    # as many cracks as tunnels: one in each on average
    own = [float(np.sort(each.first, axis=None)[len(each.first) - 1]) for each in sizes]
    other = [expected_load(found, 1.0, FIELD, each.grains) for each in sizes]
    over = [one / two - 1.0 for one, two in zip(own, other, strict=True)]
    specimens = "cracks a grain in specimens under Kirsch's stresses"
    rows = [
        relative(
            "first crack", f"{sizes[-1].across:.0f} grains across the radius: hoop stress of Kirsch at the wall [Pa]",
            own[-1] * peak, other[-1] * peak, 0.25, 0.0, specimens,
        )
    ]  # fmt: skip
    for k in range(1, len(sizes)):
        rows.append(
            at_most(
                "first crack", f"what it is over, {sizes[k].across:.0f} grains across the radius against "
                f"{sizes[k - 1].across:.0f} [-], at most", over[k] / over[k - 1], FALLING, 0.0,
                f"half for order 1; {100.0 * over[k]:.0f} % and {100.0 * over[k - 1]:.0f} % over {specimens}",
            )
        )  # fmt: skip
    rows.append(
        relative(
            "crack initiation", "of specimens, over their compressive strength [-]", found.initiation / found.strength,
            MARTIN, 0.25, found.seconds, "onset of spalling in situ, 0.4 +- 0.1: Martin (1997)",
        )
    )  # fmt: skip
    return rows


def rows_of_spalling(tunnel: Tunnel, grains: float, found: Laboratory) -> list[Row]:
    """Load a tunnel until it cracks: where, and when."""
    begun = time.perf_counter()
    s = tunnel.simulation
    most = float(np.where(s.intact()[:, None], s.utilisation[: len(s.assembly.bonds)], 0.0).max())
    first = 1.0 / most
    peak = 3.0 * FIELD[0] - FIELD[1]
    raise_load(tunnel, [first * (0.999 + GROWTH * k) for k in range(60)], 3 * SOME)
    seconds = time.perf_counter() - begun
    some = next((load for load, count in tunnel.cracks if count >= SOME), math.nan)
    away = np.abs(np.abs(np.array(tunnel.angles)) - 0.5 * math.pi)
    there = (away < math.radians(30.0)) & (np.array(tunnel.distances) < 1.3)
    share = float(there.mean()) if len(there) else 0.0
    kirsch = "Kirsch's 3 p1 - p2 at roof and floor"
    return [
        Row(
            "first cracks", f"share of the first {SOME} at roof and floor, within 30 deg and 1.3 radii [-]", share, 1.0,
            1.0 - share, 0.1, seconds, "where Kirsch's hoop stress is largest",
        ),
        relative(
            "onset", f"hoop stress of Kirsch at {SOME} cracks over the compressive strength [-]",
            some * peak / found.strength, 1.0, 0.5, 0.0, f"{kirsch}; strength {found.strength / 1e6:.4g} MPa",
        ),
        relative(
            "onset", "hoop stress of Kirsch at the first crack over the crack initiation stress [-]",
            first * peak / found.initiation, 1.0, 0.5, 0.0,
            f"{kirsch}; initiation {found.initiation / 1e6:.4g} MPa",
        ),
        relative(
            "onset", f"hoop stress of Kirsch at the wall at {SOME} cracks [Pa]", some * peak,
            expected_load(found, SOME, FIELD, grains) * peak, 0.25, 0.0,
            "cracks a grain in specimens under Kirsch's stresses",
        ),
    ]  # fmt: skip


def run() -> list[Row]:
    """All rows."""
    sizes, tunnel = [], None
    for particles, seeds in SIZES.items():
        tunnel = None  # room for the next
        found, tunnel = elastic(particles, seeds)
        sizes.append(found)
    assert tunnel is not None
    known = laboratory(ROCK, SIZE_RATIO)
    return [
        *rows_of_rings(sizes[-1]),
        *rows_of_sizes(sizes),
        *rows_of_first_cracks(sizes, known),
        *rows_of_spalling(tunnel, sizes[-1].grains, known),
    ]
