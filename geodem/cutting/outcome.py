"""What a cut came to: forces, specific energy, chips, cracks ahead of the tool, energy account."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..measure.fragments import Fragments
from .course import ENERGIES, Course
from .tool import PARTS

Floats = NDArray[np.float64]

FLOOR_SHARE = 0.02
"""Share of the mean cutting force below which a face's mean force has no direction worth telling."""

PEAK_WINDOW = 0.5
"""Way over the mean diameter over which peaks are smoothed: what is shorter is the passing of single grains."""


@dataclass(frozen=True)
class Force:
    """A force over the way after entry [N] (2D: N per m of width).

    Attributes
    ----------
    mean, deviation, peak : float
        Over equal parts of the way; the peak is of the force smoothed over half a mean diameter.
    peaks : float
        Mean of the largest of every stretch of one depth [N].
    """

    mean: float
    deviation: float
    peak: float
    peaks: float


def over_way(way: Floats, values: Floats, first: float, diameter: float, stretch: float) -> Force:
    """A force over the way from `first` on.

    Parameters
    ----------
    way, values : (k,)
        Way [m], rising, and force there [N].
    first : float
        [m]
    diameter : float
        Mean, of the particles [m].
    stretch : float
        Way in which one peak is looked for [m].
    """
    at = way >= first
    if np.count_nonzero(at) < 3:
        return Force(math.nan, math.nan, math.nan, math.nan)
    w, v = way[at], values[at]
    even = np.linspace(w[0], w[-1], max(8 * len(w), 16))
    found = np.interp(even, w, v)
    mean = float(np.trapezoid(v, w) / (w[-1] - w[0]))
    count = max(1, round(PEAK_WINDOW * diameter / (even[1] - even[0])))
    smooth = np.convolve(found, np.full(count, 1.0 / count), mode="valid") if count < len(found) else found
    parts = np.array_split(smooth, max(1, int((w[-1] - w[0]) / stretch)))
    return Force(
        mean,
        float(found.std()),
        float(smooth.max()),
        float(np.mean([part.max() for part in parts if len(part)])),
    )


@dataclass(frozen=True, eq=False)
class Outcome:
    """A finished cut in numbers, SI; in 2D per metre of width.

    Attributes
    ----------
    first : float
        Way of the tool from which means are taken [m].
    cutting, normal : Force
        In total.
    parts : dict of str to (float, float)
        Mean cutting and normal force of every part of the tool [N].
    pressed, slid : float
        Mean normal force on the face, and that of contacts that slide up it [N].
    sliding : (float, float)
        Mean cutting and normal force of those contacts [N].
    work : float
        Of the tool, after entry and per way [J/m = N]: the mean cutting force as the energy account has it.
    volume : float
        Nominal: depth times way in the ground, after entry [m3/m].
    fragments : Fragments
    cut : (p,) bool
        Which pieces nothing holds any more.
    """

    first: float
    cutting: Force
    normal: Force
    parts: Mapping[str, tuple[float, float]]
    pressed: float
    slid: float
    sliding: tuple[float, float]
    work: float
    depth: float
    length: float
    fragments: Fragments
    cut: NDArray[np.bool_]
    cut_volume: float
    cracks: Mapping[str, float]
    energy: Mapping[str, float]
    imbalance: float

    @property
    def specific_energy(self) -> float:
        """Work after entry over the nominal volume, depth times way [J/m3 = Pa]."""
        return self.work / self.depth

    @property
    def face_angle(self) -> float:
        """Of the mean force on the face against the path [rad]: atan(Fn/Fc); nan where it hardly feels any."""
        cutting, normal = self.parts["face"]
        if not math.hypot(cutting, normal) > FLOOR_SHARE * abs(self.cutting.mean):
            return math.nan
        return math.atan2(normal, cutting)

    @property
    def sliding_share(self) -> float:
        """Share of the normal force on the face that slides up it [-]; nan where the face hardly feels any."""
        return self.slid / self.pressed if math.isfinite(self.face_angle) else math.nan

    @property
    def sliding_angle(self) -> float:
        """`face_angle` of what slides up the face alone [rad]; nan where nothing does."""
        cutting, normal = self.sliding
        return math.atan2(normal, cutting) if self.slid > 0.0 else math.nan

    @property
    def peak_stress(self) -> float:
        """Mean of the peaks of the cutting force over the depth [Pa]."""
        return self.cutting.peaks / self.depth

    @property
    def chips(self) -> NDArray[np.bool_]:
        """Pieces (p,) cut off that are more than a single grain."""
        return np.asarray(self.cut & ~self.fragments.single)


def outcome(course: Course, solid_fraction: float) -> Outcome:
    """Numbers of a cut; `solid_fraction` of the packing [-]."""
    plan, placed = course.plan, course.placed
    c = course.columns()
    first = placed.contact - float(placed.place[0]) + placed.entry
    way = c["way"]
    fragments = course.fragments(solid_fraction)
    held = course.assembly.held.any(axis=1)
    fixed = np.zeros(fragments.count, dtype=bool)
    fixed[np.unique(fragments.piece_of[held])] = True
    area = math.pi * course.assembly.radii**2 / solid_fraction
    after = way >= first

    def mean(name: str) -> float:
        return over_way(way, c[name], first, placed.diameter, plan.depth).mean

    parts = {part: (mean(f"cutting_{part}"), mean(f"normal_{part}")) for part in PARTS}
    work = math.nan
    if np.count_nonzero(after) > 1:
        w, e = way[after], c["tool"][after]
        work = float((e[-1] - e[0]) / (w[-1] - w[0]))
    return Outcome(
        first=first,
        cutting=over_way(way, c["cutting"], first, placed.diameter, plan.depth),
        normal=over_way(way, c["normal"], first, placed.diameter, plan.depth),
        parts=parts,
        pressed=mean("pressed"),
        slid=mean("slid"),
        sliding=(mean("cutting_slid"), mean("normal_slid")),
        work=work,
        depth=plan.depth,
        length=float(way[-1]) - (placed.contact - float(placed.place[0])),
        fragments=fragments,
        cut=~fixed,
        cut_volume=float(area[~fixed[fragments.piece_of]].sum()),
        cracks=crack_facts(course),
        energy={name: float(c[name][-1]) for name in ENERGIES},
        imbalance=float(c["imbalance"][-1]),
    )


def crack_facts(course: Course) -> dict[str, float]:
    """Cracks by mode, and how far ahead of the tip and below its path they ran.

    Of every crack, ahead and below are told from where the tip was when it broke [m]; the farthest are those that one
    in twenty exceeds.
    """
    s, placed = course.simulation, course.placed
    broken = s.broken_bonds()
    c = course.columns()
    tip = placed.place[0] + np.interp(broken.step, c["step"], c["way"])
    ahead = broken.place[:, 0] - tip
    below = placed.place[1] - broken.place[:, 1]
    front = ahead > placed.diameter
    facts: dict[str, float] = {
        "tension": int((broken.mode == 1).sum()),
        "shear": int((broken.mode == 2).sum()),
        "ahead": int(front.sum()),
        "below": int((below > 0.0).sum()),
    }
    facts["ahead_m"] = float(np.quantile(ahead[front], 0.95)) if front.any() else 0.0
    facts["below_m"] = float(np.quantile(below[below > 0.0], 0.95)) if (below > 0.0).any() else 0.0
    return facts


def chip_facts(found: Outcome) -> dict[str, Any]:
    """Number, share and size of what was cut off."""
    f, chips = found.fragments, found.chips
    grains = found.cut & f.single
    cut_mass = float(f.mass[found.cut].sum())
    facts: dict[str, Any] = {
        "chips": int(chips.sum()),
        "single_grains": int(grains.sum()),
        "cut_mass_kg_per_m": cut_mass,
        "share_of_single_grains": float(f.mass[grains].sum()) / cut_mass if cut_mass > 0.0 else 0.0,
        "volume_over_nominal": found.cut_volume / (found.depth * found.length)
        if found.length > 0.0
        else math.nan,
    }
    if chips.any():
        facts |= {
            "largest_m": float(f.size[chips].max()),
            "largest_box_m": [float(x) for x in f.extent[np.flatnonzero(chips)[0]]],
            "d50_m": f.size_passing(0.5, chips),
            "d80_m": f.size_passing(0.8, chips),
        }
    return facts
