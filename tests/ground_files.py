"""Small files that ground is read from, and cases of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from tests.meshes import mesh

# 4 m of clay below, a slope of fill above it
OUTLINE = [(0.0, 0.0), (30.0, 0.0), (30.0, 4.0), (30.0, 10.0), (18.0, 10.0), (8.0, 4.0), (0.0, 4.0)]
AREAS = {"clay": 120.0, "fill": 0.5 * (22.0 + 12.0) * 6.0}
BOUNDARY = '[boundary]\nleft = "roller"\nright = "roller"\nbottom = "fixed"\n'

SOIL = """
[material.{name}]
law = "mohr_coulomb"
unit_weight = "20 kN/m3"
cohesion = "12 kPa"
friction_angle = "20 deg"
dilation_angle = "20 deg"
young_modulus = "100 MPa"
poisson_ratio = 0.3
"""

GROUND = """\
workflow = "ground"
title = "Bank"

[source]
image = "bank.png"
scale = "0.1 m/px"
legend = {"#8c6d31" = "soil", "#d62728" = "seam"}

[particles]
particles = 1200
seed = 4

[material.soil]
density = "1900 kg/m3"

[material.seam]
density = "2100 kg/m3"
"""

BONDED = """\
law = "rock"
effective_modulus = "2 GPa"
stiffness_ratio = 2.0
tensile_strength = "2 MPa"
shear_strength = "8 MPa"
friction_coefficient = 0.5
"""


def write_bank(folder: Path) -> Path:
    """bank.png: 12 m by 6 m, soil with a level seam from 2 m to 3 m, sky in the upper left quarter."""
    folder.mkdir(parents=True, exist_ok=True)
    picture = Image.new("RGB", (120, 60), "#8c6d31")
    pen = ImageDraw.Draw(picture)
    pen.rectangle([0, 30, 119, 39], fill="#d62728")
    pen.rectangle([0, 0, 59, 29], fill="#ffffff")
    picture.save(folder / "bank.png")
    return folder / "bank.png"


def ground_case(folder: Path, text: str = GROUND) -> Path:
    """A folder with bank.png and a case of it."""
    write_bank(folder)
    (folder / "case.toml").write_text(text)
    return folder


def write_msh(path: Path, spacing: float = 1.0, unit: float = 1.0) -> Path:
    """A mesh of `OUTLINE` in gmsh's format 2.2: the groups clay, up to 4 m, and fill."""
    level = [((8.0, 4.0), (30.0, 4.0))]
    positions, triangles = mesh(OUTLINE, spacing, lines=level)
    upper = positions[triangles].mean(axis=1)[:, 1] > 4.0
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    lines += ["$PhysicalNames", "2", '2 1 "clay"', '2 2 "fill"', "$EndPhysicalNames"]
    lines += ["$Nodes", str(len(positions))]
    lines += [f"{k} {x / unit!r} {y / unit!r} 0" for k, (x, y) in enumerate(positions.tolist(), start=1)]
    lines += ["$EndNodes", "$Elements", str(len(triangles))]
    lines += [
        f"{k} 2 2 {1 + up} {1 + up} {a + 1} {b + 1} {c + 1}"
        for k, ((a, b, c), up) in enumerate(
            zip(triangles.tolist(), upper.astype(int).tolist(), strict=True), start=1
        )
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*lines, "$EndElements"]) + "\n")
    return path


def write_asc(path: Path, *, rise: float = 0.4, cells: int = 21, size: float = 5.0) -> Path:
    """A plane that rises eastwards by `rise`, 50 m at the west; heights at the middles of cells from x = y = 0 on."""
    x = size * np.arange(cells)
    rows = ["ncols 21", f"nrows {cells}", "xllcenter 0", "yllcenter 0", f"cellsize {size}"]
    rows += [" ".join(repr(50.0 + rise * float(place)) for place in x)] * cells
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(rows) + "\n")
    return path


def slope_case(section: str, *names: str, head: str = "particles = 400\n") -> str:
    """A case of a slope with this section and materials of these names."""
    methods = 'methods = ["strength-reduction"]\ntolerance = 0.05\n'
    soils = "".join(SOIL.replace("{name}", name) for name in names)
    return f'workflow = "slope"\ntitle = "Slope"\n{head}{methods}\n[section]\n{section}\n{BOUNDARY}{soils}'
