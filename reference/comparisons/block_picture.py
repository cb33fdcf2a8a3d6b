"""Curves of pressed blocks: kept in results/block-curves.json, drawn as docs/pictures/compare_block.png."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from geodem.plotting.theme import FAILED, STABLE, new_figure, png, quiet_axes, style

from ..posed import Floats
from ..results_file import load_rows, store_rows

STORED = "block-curves"
PICTURE = Path(__file__).resolve().parents[2] / "docs" / "pictures" / "compare_block.png"


def curve(
    law: str, code: str, seed: int, ours: tuple[Floats, Floats], theirs: tuple[Floats, Floats]
) -> dict[str, Any]:
    """Strain and stress [Pa] of geodem and of the other code, as they are stored."""
    strain, stress = ours
    return {
        "law": law,
        "code": code,
        "seed": seed,
        "strain": [float(f"{value:.5g}") for value in strain],
        "stress": [float(f"{value:.5g}") for value in stress],
        "other_strain": [float(f"{value:.5g}") for value in theirs[0]],
        "other_stress": [float(f"{value:.5g}") for value in theirs[1]],
    }


def keep(curves: Sequence[dict[str, Any]]) -> None:
    """Store the curves of a code beside those of the others, and draw them all."""
    new = {one["law"] for one in curves}
    kept = [one for one in load_rows(STORED) if one["law"] not in new]
    rows = sorted([*kept, *curves], key=lambda one: (one["code"], one["law"], one["seed"]))
    store_rows(STORED, rows, "python -m reference " + " ".join(sys.argv[1:]))
    PICTURE.write_bytes(drawn(rows))


def drawn(rows: Sequence[dict[str, Any]]) -> bytes:
    """A picture with a panel for every law: geodem as a broad line, the other code thin upon it."""
    laws = list(dict.fromkeys((one["law"], one["code"]) for one in rows))
    with style():
        figure = new_figure(3.7 * len(laws), 3.6)
        panels = figure.subplots(1, len(laws), squeeze=False)[0]
        for axes, (law, code) in zip(panels, laws, strict=True):
            own = [one for one in rows if one["law"] == law]
            for k, one in enumerate(own):
                axes.plot(
                    [100.0 * e for e in one["strain"]], [s / 1e3 for s in one["stress"]], "-", color=STABLE,
                    linewidth=3.0, alpha=0.45, label="geodem" if k == 0 else None,
                )  # fmt: skip
                axes.plot(
                    [100.0 * e for e in one["other_strain"]], [s / 1e3 for s in one["other_stress"]], "-",
                    color=FAILED, linewidth=0.9, label=code.upper() if k == 0 else None,
                )  # fmt: skip
            axes.set_title(f"{law}, {len(own)} blocks")
            axes.set_xlabel("strain [%]")
            axes.set_ylabel("stress [kPa]")
            axes.set_ylim(bottom=0.0)
            axes.legend()
            quiet_axes(axes)
        return png(figure)
