"""Drawn sections whose outlines are known, for the tests of sections from pictures.

A picture is made by asking for 8 x 8 points of every pixel (or only its centre, for stairs) in which polygon
they lie. Corners are in pixels from the upper left corner, y downwards.
"""

import math

import numpy as np
import pytest
import shapely
from PIL import Image

from geodem.builders.section import Section

COLOURS = {
    "soil": "#8c6d31",
    "seam": "#d62728",
    "clay": "#1f77b4",
    "rock": "#7f7f7f",
    "white": "#ffffff",
    "black": "#000000",
}
SLOPE = (640, 200, [("soil", [(0, 200), (0, 150.25), (250, 150.25), (450.5, 50), (640, 50), (640, 200)])])
# 64 m x 20 m at 0.1 m/px with a seam of 0.5 m
SEAM = (
    640,
    200,
    [
        ("soil", [(0, 200), (640, 200), (640, 0), (475, 0), (230, 122.5), (0, 122.5)]),
        ("seam", [(0, 135), (640, 135), (640, 130), (0, 130)]),
    ],
)
# three layers with a white margin on all sides
LAYERS = (
    420,
    200,
    [
        (
            "soil",
            [
                (20.375, 190.25),
                (400.75, 190.25),
                (400.75, 30.25),
                (250, 30.25),
                (120.5, 100.25),
                (20.375, 100.25),
            ],
        ),
        ("clay", [(20.375, 150), (400.75, 120), (400.75, 190.25), (20.375, 190.25)]),
        ("rock", [(20.375, 170), (200, 175), (400.75, 160), (400.75, 190.25), (20.375, 190.25)]),
    ],
)
ANGLE = np.linspace(0.0, 2.0 * math.pi, 240, endpoint=False)
CIRCLE = (
    240,
    200,
    [
        ("rock", [(0, 0), (240, 0), (240, 200), (0, 200)]),
        ("soil", np.c_[120.3 + 70.0 * np.cos(ANGLE), 99.6 + 70.0 * np.sin(ANGLE)]),
    ],
)
TILTED_SEAM = (
    300,
    200,
    [
        ("soil", [(0, 40), (300, 40), (300, 200), (0, 200)]),
        ("seam", [(0, 90), (300, 140), (300, 142.1), (0, 92.1)]),
    ],
)


def rgb(colour):
    return tuple(int(colour[k : k + 2], 16) for k in (1, 3, 5))


def covers(corners, width, height, samples):
    """Which sample points lie in a polygon: those with an odd number of sides to their left."""
    toggle = np.zeros((height * samples, width * samples + 1), dtype=np.int8)
    y = (np.arange(height * samples) + 0.5) / samples
    points = np.asarray(corners, dtype=float)
    for (x0, y0), (x1, y1) in zip(points, np.roll(points, -1, axis=0), strict=True):
        rows = np.flatnonzero((y > min(y0, y1)) & (y <= max(y0, y1)))
        crossing = (x0 + (y[rows] - y0) * (x1 - x0) / (y1 - y0)) if len(rows) else np.zeros(0)
        first = np.clip(np.ceil(crossing * samples - 0.5), 0, width * samples).astype(int)
        np.add.at(toggle, (rows, first), 1)
    return np.cumsum(toggle[:, :-1], axis=1, dtype=np.int8) % 2 == 1


def raster(scene, samples=8, colours=COLOURS, background="#ffffff"):
    """Picture as an array of float, shape (rows, columns, 3)."""
    width, height, regions = scene
    owner = np.zeros((height * samples, width * samples), dtype=np.int8)
    for index, (_, corners) in enumerate(regions):
        owner[covers(corners, width, height, samples)] = index + 1
    blocks = owner.reshape(height, samples, width, samples)
    result = np.zeros((height, width, 3))
    for index, colour in enumerate([background, *(colours[name] for name, _ in regions)]):
        part = (blocks == index).sum(axis=3, dtype=np.int16).sum(axis=1) / samples**2
        result += part[..., None] * np.array(rgb(colour), dtype=float)
    return result


def save(array, path, **options):
    Image.fromarray(np.rint(array).astype(np.uint8)).save(path, **options)
    return path


def legend_of(scene, colours=COLOURS):
    return {colours[name]: name for name, _ in scene[2]}


def truth_of(scene):
    return Section.from_polygons([(name, np.asarray(corners)) for name, corners in scene[2]])


def outlines(section):
    return shapely.unary_union([region.polygon.boundary for region in section.regions])


def distance(section, truth):
    return shapely.hausdorff_distance(outlines(section), outlines(truth), densify=0.005)


def corners_of(section):
    return sum(len(region.polygon.exterior.coords) - 1 for region in section.regions)


def assert_conforming(section):
    """Valid and disjoint, no gaps, and a corner on a neighbour's outline is a corner of the neighbour too."""
    polygons = [region.polygon for region in section.regions]
    assert all(polygon.is_valid for polygon in polygons)
    total = math.fsum(polygon.area for polygon in polygons)
    assert section.outline.area == pytest.approx(total, rel=1e-12)
    corners = [{tuple(p) for p in shapely.get_coordinates(polygon)} for polygon in polygons]
    for i, mine in enumerate(corners):
        for j, polygon in enumerate(polygons):
            if i != j:
                near = {p for p in mine if polygon.distance(shapely.Point(p)) < 1e-6}
                assert near <= corners[j]
