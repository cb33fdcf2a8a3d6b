"""A slope with a weak seam whose failing mass is a rotating segment, as the engine would hand it over."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from geodem.measure.failure import describe_failure
from geodem.plotting.views import MethodView, ReportView

OUTLINE = np.array([[20.0, 20], [84, 20], [84, 40], [67.5, 40], [43, 27.75], [20, 27.75]])
SEAM = np.array([[20.0, 26.5], [84, 26.5], [84, 27], [20, 27]])
CENTRE, RADIUS = np.array([48.0, 58.0]), 31.0


def make_view(spacing=1.0, **changes):
    from shapely import Polygon, contains_xy

    rng = np.random.default_rng(1)
    corners = np.array([*OUTLINE, [20, 27], [20, 26.5], [84, 26.5], [84, 27]])
    ground, seam = Polygon(OUTLINE), Polygon(SEAM)
    lines = [ground.exterior, seam.exterior]
    on = [
        np.array([line.interpolate(s).coords[0] for s in np.arange(0.0, line.length, 0.8 * spacing)])
        for line in lines
    ]
    x, y = np.meshgrid(np.arange(20, 84, spacing), np.arange(20, 40, spacing * 0.866))
    x[::2] += 0.5 * spacing
    inner = np.column_stack([x.ravel(), y.ravel()]) + rng.uniform(-0.2, 0.2, (x.size, 2)) * spacing
    keep = contains_xy(ground.buffer(-0.5 * spacing), *inner.T) & ~contains_xy(
        seam.buffer(0.4 * spacing), *inner.T
    )
    positions = np.unique(np.concatenate([corners, *on, inner[keep]]).round(9), axis=0)
    triangles = Delaunay(positions).simplices.astype(np.int32)
    middle = positions[triangles].mean(axis=1)
    triangles = triangles[contains_xy(ground, *middle.T)]
    middle = positions[triangles].mean(axis=1)
    view = {
        "title": "Slope over a thin weak seam",
        "case_text": CASE,
        "positions": positions,
        "triangles": triangles,
        "triangle_material": contains_xy(seam, *middle.T).astype(np.int32),
        "materials": ("soil", "seam"),
        "material_rows": [
            {"name": "soil", "law": "Mohr-Coulomb", "unit weight": "18.84 kN/m3", "cohesion": "28.5 kPa",
             "friction angle": "20 deg", "dilation angle": "20 deg", "Young modulus": "100 MPa",
             "Poisson ratio": "0.3", "tensile strength": "none (full cone)"},
            {"name": "seam", "law": "Mohr-Coulomb", "unit weight": "18.84 kN/m3", "cohesion": "0 kPa",
             "friction angle": "10 deg", "dilation angle": "10 deg", "Young modulus": "100 MPa",
             "Poisson ratio": "0.3", "tensile strength": "none (full cone)"},
        ],
        "outlines": [("soil", [OUTLINE]), ("seam", [SEAM])],
        "supports": {"left": "roller", "right": "roller", "bottom": "fixed", "top": "free"},
        "loads": ["surcharge 20 kPa on the crest from x = 70 m to x = 80 m"],
        "surcharges": [((70.0, 40.0), (80.0, 40.0), 20e3)],
        "spacing": spacing,
        "methods": [
            make_method("strength-reduction", positions, triangles, 1.2552, 1.2668),
            make_method("gravity-increase", positions, triangles, 3.27, 3.31),
        ],
    }  # fmt: skip
    return ReportView(**{**view, **changes})


def make_method(kind, positions, triangles, stable, failed, **changes):
    """Bisection from 1 and 2 to [stable, failed], histories that flatten or run away."""
    arm = positions - CENTRE
    distance = np.hypot(*arm.T)
    share = 0.5 * (1.0 - np.tanh((distance - RADIUS) / 0.9))
    displacement = -0.012 * share[:, None] * np.column_stack([-arm[:, 1], arm[:, 0]])
    strain = 0.2 / np.cosh((distance - RADIUS) / 0.9) ** 2 * (0.5 + 0.5 * (40.0 - positions[:, 1]) / 20.0)
    displacement += 0.01 * np.random.default_rng(2).normal(size=displacement.shape) * share[:, None]
    critical = 0.5 * (stable + failed)
    factors = [(1.0, "coarse"), (critical * 1.3, "coarse"), (critical * 1.12, "coarse"),
               (critical * 0.95, "coarse"), (critical * 1.03, "fine"), (critical * 0.98, "fine"),
               (failed, "fine"), (stable, "fine")]  # fmt: skip
    trials, histories = [], []
    for factor, model in factors:
        ratio = factor / critical
        fails = ratio > 1.0
        steps = np.arange(0, 4001 if not fails else max(800, int(2000 - 9000 * (ratio - 1.0))), 50)
        settled = 0.02 / max(1e-3, abs(1.0 - ratio) + 0.03)
        path = (
            1e-3 * (ratio - 0.95) * (steps / 60.0) ** 1.7
            if fails
            else 0.01 * settled * (1 - np.exp(-steps / 700))
        )
        verdict = "failed" if fails else "stable"
        histories.append((factor, verdict, steps.astype(float), path))
        trials.append(
            {"factor": factor, "verdict": verdict, "steps": int(steps[-1]), "displacement": float(path[-1]),
             "criterion": "mean displacement above 5 elastic settlements" if fails
             else "unbalanced force below 1e-05 of the weight",
             "unbalanced": 3e-3 if fails else 9.8e-6, "seconds": 0.3, "model": model,
             "particles": 1000 if model == "coarse" else len(positions)}
        )  # fmt: skip
    values = {
        "value": critical,
        "stable": stable,
        "failed": failed,
        "criterion": "mean displacement above 5 elastic settlements",
        "trials": trials,
        "histories": histories,
        "failure": describe_failure(positions, triangles, displacement, strain),
    }
    return MethodView(kind, **{**values, **changes})


def make_result():
    angle = np.radians(np.linspace(-35.0, -98.0, 60))
    circle = CENTRE + [0.8, 0.5] + (RADIUS + 0.4) * np.column_stack([np.cos(angle), np.sin(angle)])
    return {
        "workflow": "slope",
        "particles": 2513,
        "dimension": 2,
        "factors": [
            {"kind": "strength-reduction", "value": 1.261, "stable": 1.2552, "failed": 1.2668,
             "criterion": "mean displacement above 5 elastic settlements"},
            {"kind": "gravity-increase", "value": 3.29, "stable": 3.27, "failed": 3.31, "criterion": "same"},
        ],
        "steps": 21345,
        "wall_time_s": 14.2,
        "compile_time_s": 0.21,
        "threads": 2,
        "seed": 1,
        "energy": {"external_work": 51234.0, "elastic": 10123.0, "plastic": 40001.0, "damping": 1107.0,
                   "kinetic": 2.9, "closure": 2.1e-5},
        "versions": {"geodem": "0.1.0", "python": "3.11.7", "numpy": "2.4.6"},
        "settings": {"tolerance": 0.01, "packing": "random"},
        "command": "geodem run case.toml --threads 2",
        "notices": ["boundary.top was not given: free"],
        "warnings": ["material.seam: c = 0 and a thin layer: check the thickness"],
        "neighbours": [
            {"method": "Bishop simplified", "factor": 1.271, "centre": [48.8, 58.5], "radius": 31.4,
             "surface": circle.tolist(), "notes": ["42,000 circles searched"]},
            {"method": "Spencer", "factor": 1.268, "centre": [48.8, 58.5], "radius": 31.4,
             "surface": circle.tolist(), "notes": []},
        ],
        "reference": {"factor": 1.26, "source": "ACADS problem 3 (a)"},
    }  # fmt: skip


CASE = """workflow = "slope"
title = "Slope over a thin weak seam"   # a comment
particles = 5000

[boundary]
left = "roller"
right = "roller"
bottom = "fixed"

[material.soil]
law = "mohr_coulomb"
cohesion = "28.5 kPa"
"""


@pytest.fixture(scope="session")
def view():
    return make_view()


@pytest.fixture
def result():
    return make_result()


@pytest.fixture(scope="session", name="make_view")
def _make_view():
    return make_view


@pytest.fixture(scope="session", name="make_method")
def _make_method():
    return make_method


@pytest.fixture(scope="session", name="make_result")
def _make_result():
    return make_result
