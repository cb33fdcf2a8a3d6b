"""Good files of every kind that ground is read from, small, for spoiling."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

SOIL = """
[material.{name}]
law = "mohr_coulomb"
unit_weight = "20 kN/m3"
cohesion = "12 kPa"
friction_angle = "20 deg"
young_modulus = "100 MPa"
poisson_ratio = 0.3
"""
_SLOPE = """\
workflow = "slope"
title = "Slope"
particles = 400
methods = ["strength-reduction"]

[section]
{section}

[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
"""
_GROUND = """\
workflow = "ground"
title = "Ground"

[source]
{source}

[particles]
particles = 200
"""
_CORNERS = [
    (0.0, 0.0),
    (20.0, 0.0),
    (30.0, 0.0),
    (30.0, 10.0),
    (20.0, 10.0),
    (8.0, 4.0),
    (0.0, 4.0),
    (20.0, 4.0),
]
_TRIANGLES = [(0, 1, 6), (1, 7, 5), (1, 5, 6), (1, 2, 7), (2, 3, 7), (3, 4, 7), (4, 5, 7)]
_BOX = [(x, y, z) for z in (0.0, 4.0) for y in (0.0, 3.0) for x in (0.0, 5.0)]
_BOX_FACES = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6),
              (0, 6, 2), (1, 3, 7), (1, 7, 5)]  # fmt: skip
_BOX_TETRAHEDRA = [(0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7)]

MATERIAL = """\
format = 1
name = "granite"
law = "rock"
density = "2630 kg/m3"
effective_modulus = "80 GPa"
stiffness_ratio = 2.5
tensile_strength = "15 MPa"
shear_strength = "60 MPa"
friction_coefficient = 0.7
"""


def write_sources(folder: Path) -> None:
    """section.png, slices/, heights.*, section.* and box.* in every format of meshes, scan.vti, rock.toml."""
    folder.mkdir(parents=True, exist_ok=True)
    picture = Image.new("RGB", (60, 30), "#8c6d31")
    pen = ImageDraw.Draw(picture)
    pen.rectangle([0, 15, 59, 19], fill="#d62728")
    pen.rectangle([0, 0, 29, 14], fill="#ffffff")
    picture.save(folder / "section.png")
    (folder / "slices").mkdir(exist_ok=True)
    for number in range(4):
        picture.save(folder / "slices" / f"slice-{number}.png")
    (folder / "rock.toml").write_text(MATERIAL)
    _write_terrains(folder)
    # meshio calls text files fit for debugging only
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        _write_meshes(folder)


def cases(templates: Path, workflows: Path) -> list[tuple[str, Path | None]]:
    """Texts of cases of every kind, and the folder of their files: None where they go with `write_sources`."""
    found: list[tuple[str, Path | None]] = [
        (path.read_text(encoding="utf-8"), path.parent)
        for root in (templates, workflows)
        for path in sorted(root.glob("*/case.toml"))
    ]
    sections = {
        ("soil", "seam"): 'image = "section.png"\nscale = "0.5 m/px"\n'
        'legend = {"#8c6d31" = "soil", "#d62728" = "seam"}',
        ("clay",): 'mesh = "section.msh"\nmesh_unit = "m"\nnames = {1 = "clay"}\nparticles_on = "nodes"',
        ("sand",): 'mesh = "section.vtk"\nnames = {1 = "sand"}\nmaterial_array = "material"',
        ("fill", "rock"): 'terrain = "heights.asc"\nline = [[2, 10], [38, 12]]\nbase = "0 m"\n'
        'layers = [{material = "fill", depth = "3 m"}, {material = "rock"}]\nstep = "2 m"',
    }
    for names, section in sections.items():
        text = _SLOPE.replace("{section}", section)
        if "particles_on" in section:
            text = text.replace("particles = 400\n", "")
        found.append((text + "".join(SOIL.replace("{name}", name) for name in names), None))
    legend = 'legend = {"#8c6d31" = "soil", "#d62728" = "seam"}\nbackground = ["#ffffff"]'
    sources = {
        (
            "soil",
            "seam",
        ): f'slices = "slices"\nvoxel = ["1 m", "1 m", "2 m"]\n{legend}\norigin = ["0 m", "1 m", "2 m"]',
        (
            "dark",
        ): 'photograph = "section.png"\nscale = "1 m/px"\nmaterials = ["dark", "none"]\nthresholds = [0.7]\n'
        'smoothing = 0.5\nlighting = 40\nsmallest = 3\ngrains = "dark"\napart = 5',
        ("ore",): 'grid = "scan.vti"\nthresholds = [0.5]\nmaterials = ["none", "ore"]\nscalars = "value"',
        ("block",): 'solids = {block = "box.stl"}\nlength_unit = "m"',
        ("clay",): 'mesh = "section.msh"\nlength_unit = "m"\nnames = {1 = "clay"}',
        ("cube",): 'mesh = "box.vtu"\nnames = {1 = "cube"}\nmaterial_array = "material"',
        ("fill", "rock"): 'terrain = "heights.npz"\nbase = "0 m"\nholes = "fill"\ndegrees = false\n'
        'layers = [{material = "fill", depth = "3 m"}, {material = "rock"}]\ncut_out = [[0, 0], [30, 30]]',
    }
    for names, source in sources.items():
        materials = "".join(f'\n[material.{name}]\ndensity = "1900 kg/m3"\n' for name in names)
        found.append((_GROUND.replace("{source}", source) + materials, None))
    grains = (
        'radius = "0.4 m"\nsize_ratio = 2.0\nsolid_fraction = 0.7\nseed = 3',
        'grading = [{radius = "0.3 m", passing = "0 %"}, {radius = "0.6 m", passing = "100 %"}]',
        'arrangement = "hexagonal"\nradius = "0.5 m"',
    )
    for particles in grains:
        text = _GROUND.replace("{source}", 'mesh = "section.msh"\nnames = {1 = "clay"}')
        found.append(
            (text.replace("particles = 200", particles) + '\n[material.clay]\nfile = "rock.toml"\n', None)
        )
    return found


def _write_terrains(folder: Path) -> None:
    import tifffile

    x, y = 4.0 * np.arange(11), 4.0 * np.arange(9)
    heights = 20.0 + 0.2 * x[:, None] + np.sin(0.3 * y)
    rows = heights.T[::-1]
    head = f"ncols {len(x)}\nnrows {len(y)}\nxllcenter 0\nyllcenter 0\ncellsize 4\nNODATA_value -9999\n"
    (folder / "heights.asc").write_text(
        head + "\n".join(" ".join(f"{h:.3f}" for h in row) for row in rows) + "\n"
    )
    np.savez(folder / "heights.npz", x=x, y=y, z=heights)
    tags = [(33550, "d", 3, (4.0, 4.0, 0.0), True), (33922, "d", 6, (0.0, 0.0, 0.0, 0.0, 34.0, 0.0), True)]
    tifffile.imwrite(folder / "heights.tif", rows.astype(np.float32), extratags=tags)


def _write_meshes(folder: Path) -> None:
    import meshio
    import pyvista

    flat = np.column_stack([_CORNERS, np.zeros(len(_CORNERS))])
    bodies = {
        "section": (flat, "triangle", np.array(_TRIANGLES)),
        "box": (np.array(_BOX), "tetra", np.array(_BOX_TETRAHEDRA)),
    }
    for name, (points, kind, cells) in bodies.items():
        one = np.ones(len(cells), dtype=np.int32)
        plain = meshio.Mesh(points, [(kind, cells)], cell_data={"material": [one]})
        for ending in ("vtk", "vtu"):
            meshio.write(folder / f"{name}.{ending}", plain, binary=False)
        meshio.write(folder / f"{name}.inp", meshio.Mesh(points, [(kind, cells)]), file_format="abaqus")
        tags = {"gmsh:physical": [one], "gmsh:geometrical": [one]}
        tagged = meshio.Mesh(points, [(kind, cells)], cell_data=tags)
        meshio.write(folder / f"{name}.msh", tagged, file_format="gmsh22", binary=False)
        meshio.write(folder / f"{name}4.msh", tagged, file_format="gmsh", binary=True)
    surface = meshio.Mesh(np.array(_BOX), [("triangle", np.array(_BOX_FACES))])
    meshio.write(folder / "box.stl", surface, binary=False)
    meshio.write(folder / "box-binary.stl", surface, binary=True)
    scan = pyvista.ImageData(dimensions=(7, 6, 5))
    scan.cell_data["value"] = np.linspace(0.0, 1.0, scan.n_cells)
    scan.save(folder / "scan.vti")
