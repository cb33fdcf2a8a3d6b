"""Small irregular meshes for tests that must not depend on the packing of particles."""

from __future__ import annotations

import numpy as np
import shapely
from scipy.spatial import Delaunay

from geodem.laws.ground import mohr_coulomb
from geodem.model import Model, build_model

GRAVITY = 9.81


def mesh(outline, spacing, *, seed=1, lines=()):
    """Positions (n, 2) and counter-clockwise triangles (m, 3) of a polygon; particles on `lines` too."""
    outline = np.asarray(outline, dtype=float)
    polygon = shapely.Polygon(outline)
    runs = [*zip(outline, np.roll(outline, -1, axis=0), strict=True)]
    fixed = [_divided(np.array(a), np.array(b), spacing) for a, b in runs]
    fixed += [_divided(np.array(a, float), np.array(b, float), spacing, ends=False) for a, b in lines]
    fixed = np.concatenate(fixed)
    x0, y0, x1, y1 = polygon.bounds
    x, y = np.meshgrid(np.arange(x0, x1 + spacing, spacing), np.arange(y0, y1, spacing * np.sqrt(0.75)))
    x[1::2] += 0.5 * spacing
    inner = np.column_stack([x.ravel(), y.ravel()])
    inner += np.random.default_rng(seed).uniform(-0.2, 0.2, inner.shape) * spacing
    drawn = shapely.union_all([polygon.boundary, *[shapely.LineString(line) for line in lines]])
    clear = shapely.distance(shapely.points(inner), drawn) > 0.6 * spacing
    inner = inner[clear & shapely.contains_xy(polygon, inner[:, 0], inner[:, 1])]
    positions = np.concatenate([fixed, inner])
    triangles = Delaunay(positions).simplices
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    triangles = np.where((twice < 0.0)[:, None], triangles[:, ::-1], triangles)
    middle = positions[triangles].mean(axis=1)
    solid = (np.abs(twice) > 1e-9 * spacing**2) & shapely.contains_xy(polygon, middle[:, 0], middle[:, 1])
    return positions, triangles[solid].astype(np.int32)


def _divided(a, b, spacing, *, ends=True):
    count = max(1, round(float(np.hypot(*(b - a))) / spacing))
    return a + (b - a) * np.arange(0 if ends else 1, count)[:, None] / count


def soil(*, c=10e3, phi=20.0, psi=None, young=50e6, nu=0.3, tension=np.inf):
    """Mohr-Coulomb parameters; angles in degrees."""
    return mohr_coulomb.parameters(
        young_modulus=young,
        poisson_ratio=nu,
        cohesion=c,
        friction_angle=np.radians(phi),
        dilation_angle=np.radians(phi if psi is None else psi),
        tensile_strength=tension,
    )


def model(
    positions, triangles, parameters, *, material=None, load=None, held=None, unit_weight=20e3, **options
) -> Model:
    """A model on a fixed base and roller sides, unless `held` says otherwise."""
    parameters = [parameters] if isinstance(parameters, mohr_coulomb.MohrCoulombParameters) else parameters
    if held is None:
        held = np.zeros((len(positions), 2), dtype=bool)
        held[np.isin(positions[:, 0], [positions[:, 0].min(), positions[:, 0].max()]), 0] = True
        held[positions[:, 1] == positions[:, 1].min()] = True
    return build_model(
        positions,
        triangles,
        np.zeros(len(triangles), dtype=np.int32) if material is None else material,
        material_names=[f"soil {k}" for k in range(len(parameters))],
        law="mohr_coulomb",
        parameters=parameters,
        densities=[unit_weight / GRAVITY] * len(parameters),
        gravity=(0.0, -GRAVITY),
        load=np.zeros_like(positions) if load is None else load,
        held=held,
        **options,
    )


SLOPE = ((0.0, 0.0), (32.0, 0.0), (32.0, 10.0), (20.0, 10.0))  # 2:1, 10 m high, base at toe level


def slope(spacing=1.0, *, seed=1, **material) -> Model:
    """Griffiths & Lane (1999, Geotechnique 49:387) example 1: F = 1.4."""
    return model(*mesh(SLOPE, spacing, seed=seed), soil(**material))
