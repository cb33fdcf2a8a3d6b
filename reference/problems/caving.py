"""Caving ground: `python -m reference run caving`.

Dry broken rock drawn through one opening, after Nedderman & Tuzun (`caving_draw`); and the workflows block_caving and
longwall as they are, held to what mines report: how much caved rock swells, how deep the surface over a long wall sinks
and how far beyond it. Nothing is lost on the way, and rock that is only under its own weight does not break.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import geodem
from geodem.io.frame_reading import ParticleFrame, frame_paths, read_frame
from geodem.measure.caving import subsidence, swelling

from .caving_draw import Draw, drawn, measured_zone, spreading, zone
from .rows import Row, at_most, relative

WORKFLOWS = Path(__file__).resolve().parents[2] / "workflows"

SEEDS = (1, 2)
"""Arrangements of dry rock that are drawn."""
ROCK = np.array([[5.0, 0.0], [55.0, 22.0]])
"""Corners of a box within the rock of both mines before anything is taken away [m]."""
UNDERCUT = np.array([10.0, 50.0])
DRIFT = np.array([[10.0, -11.0], [50.0, -4.0]])
"""Ends of the undercut, and a box within the full drift below it [m]."""
SEAM, COVER = 4.0, 24.0
PANEL = np.array([30.0, 60.0])
CAVED = np.array([[34.0, -3.5], [59.0, 18.0]])
"""Seam, rock over it, ends of the panel, and a box within what has caved over it [m]."""
SWELLING = (1.06, 1.24)
PALCHIK = "weathered rock over shallow mines: Palchik (2015), Int. J. Rock Mech. Min. Sci. 79:227-240"


class Mine(NamedTuple):
    """A workflow that was run."""

    result: dict[str, Any]
    frames: list[ParticleFrame]
    seconds: float


def within(
    name: str, quantity: str, value: float, low: float, high: float, seconds: float, source: str
) -> Row:
    """A row whose error is how far a value lies outside a published range, over the nearer end of it."""
    nearest = min(max(value, low), high)
    return Row(
        name, quantity, value, nearest, value / nearest - 1.0, 1e-9, seconds, f"{low:g} to {high:g}: {source}"
    )


def mined(name: str) -> Mine:
    """Run a workflow."""
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        result = geodem.run_case(WORKFLOWS / name, folder)
        frames = [read_frame(path) for path in frame_paths(Path(folder) / "frames")]
    return Mine(result, frames, time.perf_counter() - begun)


def rows_of_draw(draws: list[Draw]) -> list[Row]:
    """Velocities, and where what was drawn was."""
    own = np.array([spreading(each.speed).mean() for each in draws])
    b = float(own.mean())
    kinematic = "Nedderman & Tuzun (1979), B as measured"
    zones = np.array([measured_zone(each) for each in draws]).mean(axis=0)
    height, width = zone(float(np.mean([each.area for each in draws])), b)
    level = np.mean([spreading(each.speed) for each in draws], axis=0)
    seeds = f"mean of {len(draws)} arrangements"
    rows = [
        within(
            "dry rock drawn", "B of the velocities downwards, over the mean diameter [-]", b, 1.3, 3.5,
            sum(each.seconds for each in draws), "Nedderman & Tuzun (1979), Choi et al. (2005)",
        ),
        at_most(
            "dry rock drawn", "B from level to level: largest difference from its mean, over it [-], at most",
            float(np.abs(level / level.mean() - 1.0).max()), 0.25, 0.0, "one B for all: Nedderman & Tuzun (1979)",
        ),
        relative(
            "dry rock drawn", f"height of the zone it came from, in diameters [-], {seeds}", float(zones[0]), height,
            0.15, 0.0, kinematic,
        ),
        relative(
            "dry rock drawn", f"greatest width of that zone, in diameters [-], {seeds}", float(zones[1]), width, 0.15,
            0.0, kinematic,
        ),
    ]  # fmt: skip
    lost = max(abs(sum(each.masses[1:]) / each.masses[0] - 1.0) for each in draws)
    return [*rows, at_most("dry rock drawn", "mass lost, over all [-]", lost, 1e-12, 0.0, "none is lost")]


def rows_of_weight(name: str, mine: Mine) -> list[Row]:
    """What breaks under the weight alone, and what is lost until the end."""
    stages = mine.result["stages"]
    broken = sum(stages[0]["new_cracks"].values()) / mine.result["bonds"]
    taken = sum(stage.get("particles_removed", 0) for stage in stages)
    lost = len(mine.frames[0].radii) - len(mine.frames[-1].radii) - taken
    return [
        at_most(
            name, "bonds that break as it settles under its weight, over all [-], at most", broken, 0.01, mine.seconds,
            "nothing has been mined yet",
        ),
        Row(name, "particles that are neither there nor taken away", lost, 0.0, lost, 0.0, 0.0, "none is lost"),
    ]  # fmt: skip


def rows_of_block(mine: Mine) -> list[Row]:
    """How much the rock has swelled that fills the drift, and where the crater is."""
    first, last = mine.frames[0], mine.frames[-1]
    steps, full = 0, first
    for stage in mine.result["stages"]:
        steps += stage["steps"]
        if stage["name"] == "first draw":
            full = next(frame for frame in mine.frames if frame.step == steps)
    trough = subsidence(first.positions, first.radii, last.positions, last.radii)
    off = abs(trough.centre - UNDERCUT.mean()) / float(np.ptp(UNDERCUT))
    return [
        *rows_of_weight("block caving", mine),
        within(
            "block caving", "volume of the rock in the full drift over what it was [-]",
            swelling(first.positions, first.radii, ROCK, full.positions, full.radii, DRIFT), *SWELLING, 0.0, PALCHIK,
        ),
        at_most(
            "block caving", "centre of the crater from that of the undercut, over its width [-], at most", off, 0.05,
            0.0, "even rock caves evenly",
        ),
    ]  # fmt: skip


def rows_of_longwall(mine: Mine) -> list[Row]:
    """How much the rock over the panel has swelled, what that leaves of the seam for the trough, and how deep it is."""
    first, last = mine.frames[0], mine.frames[-1]
    trough = subsidence(first.positions, first.radii, last.positions, last.radii, columns=40)
    deep = float(np.nanmedian(trough.depth[trough.place > PANEL.mean()]))
    swollen = swelling(first.positions, first.radii, ROCK, last.positions, last.radii, CAVED)
    wide = float(np.ptp(PANEL))
    # what is over the panel now fills seam and cover less the trough
    grown = ((SEAM + COVER) * wide - trough.area) * (1.0 - 1.0 / swollen)
    return [
        *rows_of_weight("long wall", mine),
        relative(
            "long wall", "trough and what the caved rock has swelled by [m2]", trough.area + grown, SEAM * wide, 0.05,
            0.0, "the seam that was taken away",
        ),
        within(
            "long wall", "volume of the caved rock over what it was [-]", swollen, *SWELLING, 0.0, PALCHIK,
        ),
        at_most(
            "long wall", "subsidence, median over the inner half of the panel, over the seam [-], at most", deep / SEAM,
            0.9, 0.0, "National Coal Board (1975), Subsidence engineers' handbook: panels wider than 1.4 depths",
        ),
    ]  # fmt: skip


def run() -> list[Row]:
    """All of it."""
    return [
        *rows_of_draw([drawn(seed) for seed in SEEDS]),
        *rows_of_block(mined("block_caving")),
        *rows_of_longwall(mined("longwall")),
    ]
