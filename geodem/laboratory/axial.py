"""Tests along the axis: uniaxial and triaxial (in 2D biaxial) compression, direct tension."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np

from ..errors import InputError
from . import pace as paces
from .failure_plane import failure_numbers
from .material import BondedMaterial
from .record import Floats, TestRecord
from .rig import FIRST_SHARE, STEP, Motion, Prepare, Rig, Watch, seen_cracks
from .specimen import Specimen

FALL = 0.7
"""Share of the peak at which a test ends: it has failed for certain."""

INITIATION = 0.01
"""Crack initiation: this share of the cracks at the peak is there (Potyondy & Cundall 2004, section 4.2)."""

FARTHER = 3.0
"""How much farther and faster a pilot goes on that has not come to the peak."""

RATIO = 0.05
"""Unbalanced ratio at the peak above which a warning is given: forces of inertia are no longer small."""


def compress(
    specimen: Specimen,
    material: BondedMaterial,
    *,
    confinement: float = 0.0,
    expected_strain: float | None = None,
    pace: float = paces.PACE,
    time_share: float = STEP,
    fall: float = FALL,
    seed: int | None = None,
    watch: Watch | None = None,
    share: float = FIRST_SHARE,
    prepare: Prepare | None = None,
) -> TestRecord:
    """Compress along the axis under a constant pressure on the sides, past the peak.

    Parameters
    ----------
    specimen : Specimen
        Prism or cylinder.
    material : BondedMaterial
    confinement : float
        [Pa]
    expected_strain : float, optional
        Axial strain at the peak, roughly: sets the rate. A fast pilot finds it where it is left out.
    pace : float
        See `geodem.laboratory.pace`.
    time_share : float
        Of the critical time step.
    fall : float
        Share of the peak (less the confinement) at which the test ends.
    seed : int, optional
        Of the scatter of bond strengths; the specimen's where it is left out.
    share : float
        Of the load of the first break, at which the motion begins; less where something slides before.
    prepare : callable, optional
        See `Rig`: joints are cut by it.

    Returns
    -------
    TestRecord
        `strength` is the largest axial stress [Pa]. Numbers: young_modulus [Pa], poisson_ratio, peak_strain,
        residual_stress [Pa], crack_initiation_stress and crack_damage_stress [Pa], confinement [Pa],
        failure_angle [rad] to the axis and localisation (`geodem.laboratory.failure_plane`).

    Raises
    ------
    InputError
        A confinement that is none; a specimen that cannot be gripped.
    """
    if not (math.isfinite(confinement) and confinement >= 0.0):
        raise InputError("confinement", "this is no pressure", "Give Pa, 0 or more", value=confinement)
    kind = "triaxial-compression" if confinement else "uniaxial-compression"
    return _along(
        kind,
        specimen,
        material,
        1.0,
        confinement,
        expected_strain,
        pace,
        time_share,
        fall,
        seed,
        watch,
        share,
        prepare,
    )


def pull(
    specimen: Specimen,
    material: BondedMaterial,
    *,
    expected_strain: float | None = None,
    pace: float = paces.PACE,
    time_share: float = STEP,
    fall: float = FALL,
    seed: int | None = None,
    watch: Watch | None = None,
) -> TestRecord:
    """Pull along the axis until it breaks; parameters and errors as of `compress`, `strength` is positive [Pa]."""
    return _along(
        "direct-tension", specimen, material, -1.0, 0.0, expected_strain, pace, time_share, fall, seed, watch,
        FIRST_SHARE, None,
    )  # fmt: skip


def _along(
    kind: str,
    specimen: Specimen,
    material: BondedMaterial,
    sign: float,
    confinement: float,
    expected: float | None,
    pace: float,
    time_share: float,
    fall: float,
    seed: int | None,
    watch: Watch | None,
    share: float,
    prepare: Prepare | None,
) -> TestRecord:
    begun = time.perf_counter()
    if specimen.shape == "disc":
        raise InputError(
            "specimen, shape", f"a disc is for splitting, not for {kind}", "Take a prism", value="disc"
        )
    if not (math.isfinite(pace) and pace > 0.0):
        raise InputError("pace", "these are no steps per particle", f"Give {paces.PACE:g}", value=pace)
    high = specimen.height / specimen.diameter
    own = seed if seed is not None else (specimen.seed or 1)

    def mounted() -> Rig:
        return Rig(
            specimen, material, confinement=confinement, time_share=time_share, seed=own, prepare=prepare
        )

    steps = 0
    fastest: tuple[Rig, Motion] | None = None
    if not paces.sound(expected):
        rig, motion, failed = _pilot(mounted, sign, confinement, high, fall, share)
        steps += rig.simulation.steps
        curves = motion.curves()
        reached = paces.PILOT_SHARE["tension" if sign < 0.0 else "compression"]
        expected = reached * float(curves["axial_strain"][np.argmax(curves["axial_stress"])])
        fastest = None if failed else (rig, motion)
    assert expected is not None
    if fastest is None:
        rig = mounted()
        rate = paces.rate_of(expected, high, pace)
        rig.begin(sign * rate, share=share)
        motion = Motion(rig, sign)
        failed, reason = motion.until_failure(
            every=paces.looks_every(expected, rate), fall=fall, longest=paces.longest(expected),
            floor=confinement, watch=watch,
        )  # fmt: skip
    else:
        # what does not fail when it is driven fast does not when it is driven slowly
        rig, motion = fastest
        steps -= rig.simulation.steps
        rate = abs(rig.rate)
        failed, reason = False, f"no failure up to an axial strain of {motion.rows[-1][1]:.2%}"
    young, poisson = rig.elastic_constants()
    curves = motion.curves()
    s = rig.simulation
    stress = curves["axial_stress"]
    top = int(np.argmax(stress))
    cracks = seen_cracks(rig, curves["steps"], stress)
    at_peak = cracks.stress[: int(curves["tension_cracks"][top] + curves["shear_cracks"][top])]
    numbers = {
        "young_modulus": young,
        "poisson_ratio": poisson,
        "peak_strain": float(curves["axial_strain"][top]),
        "residual_stress": float(stress[-1]),
        "confinement": confinement,
        "unbalanced_ratio": float(curves["unbalanced_ratio"][max(top - 5, 0) : top + 1].mean()),
        "crack_initiation_stress": _initiation(
            at_peak, float(stress[top]) if len(cracks.stress) else math.nan
        ),
        "crack_damage_stress": _damage(curves, top),
        "tension_cracks_at_peak": float(curves["tension_cracks"][top]),
        "shear_cracks_at_peak": float(curves["shear_cracks"][top]),
        "bonds": float(len(s.assembly.bonds)),
        "rate_per_step": rate,
        **failure_numbers(specimen, cracks),
    }
    warnings = []
    if numbers["unbalanced_ratio"] > RATIO:
        warnings.append(
            f"forces of inertia are not small at the peak (unbalanced ratio {numbers['unbalanced_ratio']:.2g}): "
            f"load more slowly (pace above {pace:g})"
        )
    if not failed:
        warnings.append(f"{reason}: the strength is the largest stress that was reached, not a peak")
    return TestRecord(
        kind, float(stress[top]), failed, reason, curves, numbers, cracks, s.positions, s.positions - rig.start,
        steps + s.steps, time.perf_counter() - begun, specimen.seed, tuple(warnings),
    )  # fmt: skip


def _pilot(
    mounted: Callable[[], Rig], sign: float, confinement: float, high: float, fall: float, share: float
) -> tuple[Rig, Motion, bool]:
    """A fast test that only finds out how far the peak is; whether it failed at all."""
    rig = mounted()
    rig.approach(sign, share=share)
    # tension goes about as far as the first break, compression several times as far
    guess = rig.first_break * (1.2 if sign < 0.0 else 4.0)
    # under pressure a bond may be near its strength from the start
    guess = max(guess, 6.0 * confinement / rig.modulus)
    rate = paces.rate_of(guess, high, paces.PILOT)
    rig.set_in_motion(sign * rate)
    motion = Motion(rig, sign)
    while True:
        failed, _ = motion.until_failure(
            every=paces.looks_every(guess, rate), fall=fall, longest=paces.longest(guess), floor=confinement
        )
        if failed or paces.longest(guess) >= paces.MOST_STRAIN:
            return rig, motion, failed
        # the weakest of many unlike bonds breaks far before the specimen
        guess, rate = FARTHER * guess, FARTHER * rate
        rig.drive(sign * rate)


def _initiation(stress: Floats, otherwise: float) -> float:
    """Stress at which `INITIATION` of the cracks before the peak are there [Pa].

    `otherwise` where there are none: the peak, if the first crack makes it, or nan.
    """
    if not len(stress):
        return otherwise
    return float(stress[min(int(INITIATION * len(stress)), len(stress) - 1)])


def _damage(curves: dict[str, Floats], top: int) -> float:
    """Axial stress [Pa] where the middle begins to dilate: its volumetric strain is largest, before the peak."""
    volumetric = curves["gauge_axial"] + curves["gauge_lateral"]
    if top == 0:
        return math.nan
    return float(curves["axial_stress"][int(np.argmax(volumetric[: top + 1]))])
