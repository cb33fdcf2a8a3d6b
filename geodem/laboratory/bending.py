"""Bending of a beam on two supports by a load in the middle.

The beam is a prism that lies: its axis is the span's, its width the height h of the beam. Supports and load are the
outermost particles within a small part of the span, driven across the beam and free along it.

Reference: extreme fibre stress 3 P L/(2 b h^2); deflection of the axis with what shear and the load at one place add
to it: Timoshenko & Goodier 1970, Theory of Elasticity, art. 40 (after von Karman and Seewald),
w = P L^3/(4 E b h^3) (1 + (2.4 + 1.5 nu) (h/L)^2 - 0.84 (h/L)^3). By the same article the fibre is stressed
by 5 % less than that at a span of four heights.
"""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from . import pace as paces
from .course import Driving, carry_out
from .driven import Driven, outermost
from .material import BondedMaterial
from .record import TestRecord
from .rig import STEP, Watch
from .specimen import Specimen

OVERHANG = 0.05
"""Of the length, beyond each support."""

BEARING = 0.1
"""Length of a support or of the load over the height of the beam."""

SLENDER = 3.0
"""Least span over height: below, it is no beam."""

POISSON = 0.2

FALL = 0.7
"""Share of the peak at which the test ends."""

OVERSHOOT = 1.5
"""Displacement at the peak over `Driven.scale`, at a guess."""

PILOT_SHARE = 0.9
"""Displacement at the peak over that of the fast pilot's."""

GAUGE = 2.0
"""Mean diameters around a point of the axis in which its deflection is read."""


def bend(
    specimen: Specimen,
    material: BondedMaterial,
    *,
    poisson_ratio: float | None = None,
    expected_displacement: float | None = None,
    pace: float = paces.PACE,
    time_share: float = STEP,
    fall: float = FALL,
    seed: int | None = None,
    watch: Watch | None = None,
) -> TestRecord:
    """Bend a beam at three points until it breaks.

    Parameters
    ----------
    specimen : Specimen
        Prism; its width is the height of the beam, its height the length.
    material : BondedMaterial
    poisson_ratio : float, optional
        For the share of shear in the deflection; `POISSON` where it is left out: an error of 0.1 there is one of 1 % in
        the modulus at a span of four heights.
    expected_displacement : float, optional
        Deflection at the peak, roughly [m]: sets the rate. A fast pilot finds it where it is left out.
    pace, time_share, fall, seed, watch
        As of `geodem.laboratory.brazilian.split`.

    Returns
    -------
    TestRecord
        `strength` is the flexural strength 3 P L/(2 b h^2) [Pa]; the curve `axial_stress` is that of the load, in the
        extreme fibre. Numbers: young_modulus [Pa] from the deflection, span [m], stiffness [N/m], peak_displacement
        [m], crack_offset: mean distance of the cracks behind the peak from the middle over the span [-].

    Raises
    ------
    InputError
        No prism or too short a one, or as of `geodem.laboratory.driven.Driven`.
    """
    begun = time.perf_counter()
    if specimen.shape != "prism":
        raise InputError(
            "specimen, shape", "what is bent is a prism", 'Give shape "prism"', value=specimen.shape
        )
    span = (1.0 - 2.0 * OVERHANG) * specimen.height
    if span < SLENDER * specimen.width:
        raise InputError(
            "specimen, height", f"a span of {span / specimen.width:.2g} heights is no beam",
            f"Make it at least {SLENDER / (1.0 - 2.0 * OVERHANG):.2g} times as long as it is high",
            value=specimen.height,
        )  # fmt: skip
    own = seed if seed is not None else (specimen.seed or 1)
    motion = bearings(specimen)
    driving = Driving(
        per_force=fibre_stress(specimen, 1.0),
        # a beam swings more slowly than a wave passes by as many times as it is slender
        high=specimen.height / specimen.diameter * span / specimen.width,
        overshoot=OVERSHOOT, share=PILOT_SHARE, fall=fall,
    )  # fmt: skip

    def mounted() -> Driven:
        return Driven(specimen, material, motion, time_share=time_share, seed=own)

    run = carry_out(mounted, driving, pace=pace, expected=expected_displacement, watch=watch)
    curves, top, driven = run.curves, run.top, run.driven
    s = driven.simulation
    cracks = driven.cracks(curves["steps"], curves["axial_stress"])
    at_peak = int(curves["tension_cracks"][top] + curves["shear_cracks"][top])
    late = np.abs(cracks.place[at_peak:, -1] - 0.5 * specimen.height)
    nu = POISSON if poisson_ratio is None else poisson_ratio
    numbers = {
        "young_modulus": modulus(specimen, driven, nu),
        "span": span,
        "crack_offset": float(late.mean() / span) if len(late) else math.nan,
        **run.numbers(top),
    }
    warnings = run.warnings(numbers, pace)
    if numbers["crack_offset"] > 0.25:
        warnings.append(
            "it broke far from the middle: by shear or at a support, and the strength is no flexural one"
        )
    return TestRecord(
        "three-point-bending", float(curves["axial_stress"][top]), run.failed, run.reason, curves, numbers, cracks,
        s.positions, s.positions - driven.start, run.steps, time.perf_counter() - begun, specimen.seed,
        tuple(warnings),
    )  # fmt: skip


def fibre_stress(specimen: Specimen, force: float) -> float:
    """Stress [Pa] of the extreme fibre under a force [N] in the middle of the span: 3 P L/(2 b h^2)."""
    span = (1.0 - 2.0 * OVERHANG) * specimen.height
    return 1.5 * force * span / (specimen.area * specimen.width)


def modulus(specimen: Specimen, driven: Driven, poisson_ratio: float) -> float:
    """Young's modulus [Pa] from the solved state: how far the axis bends between the supports and the middle."""
    across = specimen.positions[:, 0] - 0.5 * specimen.width
    near = GAUGE * specimen.diameter

    def moved(at: float) -> float:
        off = np.hypot(across, specimen.positions[:, -1] - at * specimen.height)
        return float(driven.unit[off < near, 0].mean())

    bent = 0.5 * (moved(OVERHANG) + moved(1.0 - OVERHANG)) - moved(0.5)
    slender = (1.0 - 2.0 * OVERHANG) * specimen.height / specimen.width
    more = 1.0 + (2.4 + 1.5 * poisson_ratio) / slender**2 - 0.84 / slender**3
    breadth = specimen.area / specimen.width
    return driven.stiffness / bent * slender**3 / (4.0 * breadth) * more


def bearings(specimen: Specimen) -> NDArray[np.float64]:
    """Motion (n, d) for `Driven` of the supports below and the load above, each of them half of the drive."""
    motion = np.full(specimen.positions.shape, np.nan)
    half = 0.5 * BEARING * specimen.width
    low, high = np.zeros(specimen.dimension - 1), specimen.size[1:].copy()
    length = specimen.height
    for at, sign in ((0.5, 1.0), (OVERHANG, -1.0), (1.0 - OVERHANG, -1.0)):
        low[-1], high[-1] = at * length - half, at * length + half
        ids, _ = outermost(specimen.positions, specimen.radii, 0, sign, low, high)
        off = np.abs(specimen.positions[ids, -1] - at * length)
        motion[ids[(off <= half) | (off == off.min(initial=math.inf))], 0] = -0.5 * sign
    return motion
