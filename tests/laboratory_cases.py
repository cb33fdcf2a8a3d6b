"""Small cases of the laboratory for the tests of the whole chain."""

from __future__ import annotations

from pathlib import Path

LABORATORY = """\
workflow = "laboratory"
title = "Small granite"
seed = 3
seeds = 2

[specimen]
across = 12

[material]
law = "rock"
density = "2630 kg/m3"
effective_modulus = "80 GPa"
stiffness_ratio = 2.5
tensile_strength = "15 MPa"
shear_strength = "60 MPa"
friction_coefficient = 0.7

[[test]]
kind = "uniaxial-compression"

[[test]]
kind = "direct-tension"

[[test]]
kind = "triaxial-compression"
confinement = "10 MPa"
"""

TENSION = LABORATORY[: LABORATORY.index("[[test]]")].replace("across = 12", "across = 10").replace(
    "seeds = 2", "seeds = 6"
) + ('[[test]]\nkind = "direct-tension"\n')
"""The shortest test there is."""

CALIBRATION = """\
workflow = "calibration"
title = "Small sandstone"
seed = 2

[specimen]
across = 10

[rock]
density = "2300 kg/m3"
young_modulus = "15 GPa"
poisson_ratio = 0.22
uniaxial_compressive_strength = "70 MPa"
tensile_strength = "6.5 MPa"
friction_angle = "41 deg"
"""


def write_case(folder: Path, text: str = LABORATORY) -> Path:
    """A folder that holds a case."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text(text)
    return folder
