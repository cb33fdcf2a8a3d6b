"""The plane of failure, against clouds of cracks around known planes."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.laboratory.failure_plane import failure_numbers, find_failure_plane
from geodem.laboratory.record import Cracks
from geodem.laboratory.specimen import make_specimen


def band(
    size: np.ndarray, angle: float, count: int, thickness: float, rng: np.random.Generator
) -> np.ndarray:
    """Points of a box (or none of others) around a plane through its middle, at an angle to the last axis."""
    normal = np.zeros(len(size))
    normal[0], normal[-1] = math.cos(angle), math.sin(angle)
    points = rng.uniform(0.0, 1.0, (400 * count, len(size))) * size
    off = (points - 0.5 * size) @ normal
    return points[np.abs(off) < 0.5 * thickness][:count]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("degrees", [5.0, 25.0, 60.0])
def test_a_band_among_cracks_everywhere_is_found(dimension, degrees):
    rng = np.random.default_rng(3)
    size = np.array([1.0, 1.0, 2.0] if dimension == 3 else [1.0, 2.0])
    particles = rng.uniform(0.0, 1.0, (4000, dimension)) * size
    inside = band(size, math.radians(degrees), 200, 0.06, rng)
    spread = rng.uniform(0.0, 1.0, (200, dimension)) * size
    places = np.concatenate([inside, spread])
    found = find_failure_plane(places, np.ones(len(places)), particles, 0.12)
    assert math.degrees(found.angle) == pytest.approx(degrees, abs=3.0)
    assert abs((found.centre - 0.5 * size) @ found.normal) < 0.03
    # half of the cracks are in it, and hardly anything else
    assert 0.35 < found.localisation < 0.55


def test_heavy_cracks_count_for_more():
    rng = np.random.default_rng(4)
    size = np.array([1.0, 2.0])
    particles = rng.uniform(0.0, 1.0, (4000, 2)) * size
    places = np.concatenate([band(size, 0.2, 100, 0.05, rng), band(size, 1.2, 100, 0.05, rng)])
    for heavy, angle in ((slice(0, 100), 0.2), (slice(100, 200), 1.2)):
        weights = np.ones(200)
        weights[heavy] = 3.0
        found = find_failure_plane(places, weights, particles, 0.1)
        assert found.angle == pytest.approx(angle, abs=0.1)


def test_cracks_everywhere_lie_along_no_plane():
    rng = np.random.default_rng(5)
    size = np.array([1.0, 2.0])
    particles = rng.uniform(0.0, 1.0, (4000, 2)) * size
    found = find_failure_plane(rng.uniform(0.0, 1.0, (1000, 2)) * size, np.ones(1000), particles, 0.12)
    assert found.localisation < 0.08


def test_only_cracks_from_the_peak_on_count_and_few_tell_nothing():
    specimen = make_specimen(2, width=1.0, across=40, packing="square")
    rng = np.random.default_rng(6)
    early = rng.uniform(0.0, 1.0, (300, 2)) * specimen.size
    late = band(specimen.size, math.radians(30.0), 60, 0.05, rng)
    stress = np.concatenate([np.linspace(0.0, 0.9, 300), np.linspace(1.0, 0.5, 60)])

    def cracks(places: np.ndarray, stress: np.ndarray) -> Cracks:
        count = len(places)
        return Cracks(places, np.ones(count, np.int64), np.zeros((count, 2)), np.ones(count), stress)

    numbers = failure_numbers(specimen, cracks(np.concatenate([early, late]), stress))
    assert math.degrees(numbers["failure_angle"]) == pytest.approx(30.0, abs=3.0)
    assert numbers["localisation"] > 0.7
    few = failure_numbers(specimen, cracks(late[:5], stress[300:305]))
    assert math.isnan(few["failure_angle"])
    assert math.isnan(failure_numbers(specimen, cracks(early[:0], stress[:0]))["localisation"])
