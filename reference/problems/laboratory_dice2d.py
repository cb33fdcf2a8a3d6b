"""DICE2D's tests of strength: tension, splitting, compression, triaxial: `python -m reference run laboratory-dice2d`.

Zhao (2015), High Performance Computing and the Discrete Element Model, section 3.3, with the laboratory's own tests:
specimens between grips, started from the elastic state, loaded slowly. Draws docs/pictures/laboratory_dice2d_*.png.
"""

from __future__ import annotations

from pathlib import Path

from . import laboratory_dice2d_strength as strength
from . import laboratory_dice2d_tension as tension
from .rows import Row

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"


def run() -> list[Row]:
    """All of them."""
    influences, studies = tension.influences()
    split_rows, split_studies = strength.splitting()
    pressed_rows, pressed_studies = strength.compression()
    confined_rows, confined = strength.triaxial()
    (PICTURES / "laboratory_dice2d_tension.png").write_bytes(tension.draw(studies))
    (PICTURES / "laboratory_dice2d_strength.png").write_bytes(
        strength.draw(split_studies, pressed_studies, confined)
    )
    return [
        *tension.regular(),
        *influences,
        *tension.irregular_discs(),
        *strength.strengths(),
        *split_rows,
        *pressed_rows,
        *confined_rows,
    ]
