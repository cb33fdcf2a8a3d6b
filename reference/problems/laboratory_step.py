"""Hard rock at half the time step, on specimens enough to tell: `python -m reference run laboratory-step`.

One specimen's peak scatters by several per cent whatever is changed, rounding included, so that ten specimens (those of
`laboratory-convergence`) leave an error of the mean larger than what is asked for.
"""

from __future__ import annotations

from geodem.laboratory.pace import PACE
from geodem.laboratory.rig import STEP

from .laboratory_convergence import COARSE, paired, point, seconds
from .laboratory_points import measure_all
from .rows import Row

ROCK = "granite"
SEEDS = tuple(range(1, 41))
BOUND = 0.02
"""Of the mean ratio of the peaks."""


def run() -> list[Row]:
    """The same specimens, grips at the same speed, at the usual and at half the time step."""
    usual = [point(ROCK, "compression", COARSE, seed) for seed in SEEDS]
    half = [
        point(ROCK, "compression", COARSE, seed, pace=2.0 * PACE, time_share=0.5 * STEP) for seed in SEEDS
    ]
    answers = measure_all([*usual, *half])
    ratio = paired(answers, half, usual)
    quantity = (
        "compressive strength at half the time step, over that at the usual one; "
        f"deviation {100.0 * ratio.deviation:.2g} %, error {100.0 * ratio.error:.2g} %, {ratio.number} specimens"
    )
    spent = seconds(answers, [*usual, *half])
    return [
        Row(
            f"{ROCK}, {COARSE:g} across",
            quantity,
            ratio.value,
            1.0,
            ratio.value - 1.0,
            BOUND,
            spent,
            "asked for",
        )
    ]
