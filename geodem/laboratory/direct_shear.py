"""Direct shear: the halves of a block pushed past each other under a constant normal stress.

The block stands in a split box: the outermost particles of the upper half are driven one way, those of the lower half
the other way, with a gap between them in the middle where the block is to fail. The bottom is held along the normal;
the top carries the normal stress as constant forces, so that it may rise and the block dilate. The box's sides are
smooth that way. In 3D the walls along the drive hold the block across it.

Reference: Muralha et al. 2014, ISRM suggested method for laboratory determination of the shear strength of rock joints,
Rock Mech. Rock Eng. 47:291-302: peak and residual shear strength at constant normal load, dilation.
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
from .record import Floats, TestRecord
from .rig import STEP, Watch
from .specimen import Specimen

GAP = 3.0
"""Between the halves of the box, over the mean diameter."""

THICK = 1.0
"""Of the box's hold on the block, over the mean diameter."""

FALL = 0.9
"""Share of the peak below which the block has failed."""

BEYOND = 3.0
"""The test goes on to this many times the displacement at the peak, for the residual strength."""

LAST = 0.25
"""Share of the way beyond the peak, at its end, over which the residual strength is the mean."""

SLOPE = 0.5
"""The dilation angle is that of the way from the peak on, over this share of the displacement there."""

OVERSHOOT = 3.0
"""Displacement at the peak over `Driven.scale`, at a guess."""

PILOT_SHARE = 0.9
"""Displacement at the peak over that of the fast pilot's."""


def shear(
    specimen: Specimen,
    material: BondedMaterial,
    *,
    normal_stress: float,
    expected_displacement: float | None = None,
    pace: float = paces.PACE,
    time_share: float = STEP,
    seed: int | None = None,
    watch: Watch | None = None,
) -> TestRecord:
    """Shear a block across its middle, along the first axis; the normal stress is along the last one.

    Parameters
    ----------
    specimen : Specimen
        Prism, about as high as it is wide.
    material : BondedMaterial
    normal_stress : float
        [Pa], 0 or more.
    expected_displacement : float, optional
        Of the halves against each other at the peak, roughly [m]: sets the rate. A fast pilot finds it where it is left
        out.
    pace, time_share, seed, watch
        As of `geodem.laboratory.brazilian.split`.

    Returns
    -------
    TestRecord
        `strength` is the peak shear stress [Pa]; the curve `axial_stress` is the shear stress, `dilation` the rise of
        the top [m]. Numbers: residual_stress [Pa], shear_stiffness [Pa/m], dilation_angle [rad] behind the peak,
        peak_displacement [m], normal_stress [Pa].

    Raises
    ------
    InputError
        No prism, too few particles between the halves, a normal stress that is none, or as of
        `geodem.laboratory.driven.Driven`.
    """
    begun = time.perf_counter()
    if specimen.shape != "prism":
        raise InputError(
            "specimen, shape", "what is sheared is a prism", 'Give shape "prism"', value=specimen.shape
        )
    if not (math.isfinite(normal_stress) and normal_stress >= 0.0):
        raise InputError("normal stress", "this is no pressure", "Give Pa, 0 or more", value=normal_stress)
    if specimen.height < (GAP + 4.0 * THICK) * specimen.diameter:
        raise InputError(
            "specimen, height", "the halves of the box meet: the block is too low",
            "Make it higher, or the particles smaller", value=specimen.height,
        )  # fmt: skip
    own = seed if seed is not None else (specimen.seed or 1)
    motion = box_halves(specimen)
    top_ids, share = _top(specimen)
    load = np.zeros(motion.shape)
    load[top_ids, -1] = -normal_stress * specimen.area * share
    driving = Driving(
        per_force=1.0 / specimen.area, high=max(specimen.across, specimen.height / specimen.diameter),
        overshoot=OVERSHOOT, share=PILOT_SHARE, fall=FALL, beyond=BEYOND,
    )  # fmt: skip

    def mounted() -> Driven:
        return Driven(specimen, material, motion, load=load, time_share=time_share, seed=own)

    def rise(driven: Driven) -> float:
        moved = driven.simulation.positions[top_ids, -1] - driven.start[top_ids, -1]
        return float(share @ (moved - driven.loaded[top_ids, specimen.dimension - 1]))

    run = carry_out(
        mounted, driving, pace=pace, expected=expected_displacement, more={"dilation": rise}, watch=watch
    )
    curves, top, driven = run.curves, run.top, run.driven
    s = driven.simulation
    cracks = driven.cracks(curves["steps"], curves["axial_stress"])
    way = curves["displacement"]
    end = way >= way[-1] - LAST * (way[-1] - way[top])
    numbers = {
        "normal_stress": normal_stress,
        "residual_stress": float(curves["axial_stress"][end].mean()),
        "shear_stiffness": driving.per_force * driven.stiffness,
        "dilation_angle": dilation_angle(way, curves["dilation"], top),
        **run.numbers(top),
    }
    warnings = run.warnings(numbers, pace)
    return TestRecord(
        "direct-shear", float(curves["axial_stress"][top]), run.failed, run.reason, curves, numbers, cracks,
        s.positions, s.positions - driven.start, run.steps, time.perf_counter() - begun, specimen.seed,
        tuple(warnings),
    )  # fmt: skip


def box_halves(specimen: Specimen) -> NDArray[np.float64]:
    """Motion (n, d) for `Driven` of what the halves of the box hold."""
    places, size = specimen.positions, specimen.size
    thick = THICK * specimen.diameter
    up = places[:, -1] - 0.5 * size[-1]
    half = np.abs(up) > 0.5 * GAP * specimen.diameter
    bottom, top = places[:, -1] < thick, places[:, -1] > size[-1] - thick
    ends = (places[:, 0] < thick) | (places[:, 0] > size[0] - thick)
    motion = np.full(places.shape, np.nan)
    pushed = half & (ends | bottom | top)
    motion[pushed, 0] = 0.5 * np.sign(up[pushed])
    motion[bottom, -1] = 0.0
    if specimen.dimension == 3:
        sides = half & ((places[:, 1] < thick) | (places[:, 1] > size[1] - thick))
        motion[sides, 1] = 0.0
    return motion


def _top(specimen: Specimen) -> tuple[NDArray[np.int64], Floats]:
    """Particles that bear the normal stress, and their shares."""
    return outermost(
        specimen.positions, specimen.radii, specimen.dimension - 1, 1.0, np.zeros(specimen.dimension - 1),
        specimen.size[:-1],
    )  # fmt: skip


def dilation_angle(displacement: Floats, dilation: Floats, top: int) -> float:
    """Slope of the dilation [m] over the displacement [m] behind the peak as an angle [rad]; nan without curve."""
    behind = np.flatnonzero(
        (displacement >= displacement[top]) & (displacement <= (1.0 + SLOPE) * displacement[top])
    )
    if len(behind) < 3:
        return math.nan
    return math.atan(float(np.polyfit(displacement[behind], dilation[behind], 1)[0]))
