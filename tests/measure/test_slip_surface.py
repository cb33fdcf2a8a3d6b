"""The traced slip surface against circles and planes that the displacement fields were made from."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from geodem.measure.failure import describe_failure
from geodem.measure.slip_surface import interpolated, moving_mass, shear_band_distance

OUTLINE = np.array([[20.0, 20], [84, 20], [84, 40], [67.5, 40], [43.5, 28], [20, 28]])  # 2:1, 12 m high
CENTRE, RADIUS = np.array([48.0, 58.0]), 30.5


def mesh(spacing, seed=1):
    """Random points at about one spacing in the slope, more along its outline; triangles inside only."""
    from shapely import Polygon, contains_xy

    rng = np.random.default_rng(seed)
    edge = [
        a + (b - a) * t
        for a, b in zip(OUTLINE, np.roll(OUTLINE, -1, axis=0), strict=True)
        for t in np.arange(0.0, 1.0, spacing / np.linalg.norm(b - a))[:, None]
    ]
    x, y = np.meshgrid(np.arange(20, 84, spacing), np.arange(20, 40, spacing * 0.866))
    x[::2] += 0.5 * spacing
    inner = np.column_stack([x.ravel(), y.ravel()]) + rng.uniform(-0.2, 0.2, (x.size, 2)) * spacing
    ground = Polygon(OUTLINE)
    inner = inner[contains_xy(ground.buffer(-0.6 * spacing), inner[:, 0], inner[:, 1])]
    positions = np.concatenate([np.array(edge), inner])
    triangles = Delaunay(positions).simplices.astype(np.int32)
    middle = positions[triangles].mean(axis=1)
    triangles = triangles[contains_xy(ground, middle[:, 0], middle[:, 1])]
    return positions, triangles


def rotation(positions, *, band, noise=0.0, seed=2):
    """A segment that rotates as a rigid body over a shear band of the given half-width [m]."""
    arm = positions - CENTRE
    distance = np.hypot(arm[:, 0], arm[:, 1])
    share = 0.5 * (1.0 - np.tanh((distance - RADIUS) / band))
    angle = -0.02
    displacement = share[:, None] * angle * np.column_stack([-arm[:, 1], arm[:, 0]])
    displacement += noise * np.random.default_rng(seed).normal(size=displacement.shape)
    strain = abs(angle) * RADIUS / (2.0 * band) / np.cosh((distance - RADIUS) / band) ** 2
    return displacement, strain


def segment_area():
    """The circle's share of the ground, by geometry alone."""
    from shapely import Point, Polygon

    return Point(CENTRE).buffer(RADIUS, quad_segs=720).intersection(Polygon(OUTLINE)).area


@pytest.mark.parametrize("spacing", [1.5, 0.8])
@pytest.mark.parametrize("band_in_spacings", [0.1, 1.5])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_circle_within_one_spacing(spacing, band_in_spacings, noise):
    positions, triangles = mesh(spacing)
    displacement, strain = rotation(positions, band=band_in_spacings * spacing, noise=noise)
    failure = describe_failure(positions, triangles, displacement, strain)
    line = failure.slip_surface
    off = np.abs(np.hypot(*(line - CENTRE).T) - RADIUS)
    assert off.max() < spacing
    assert off.mean() < 0.35 * spacing
    length = np.hypot(*np.diff(line, axis=0).T).sum()
    assert abs(failure.moving_area - segment_area()) < 0.3 * spacing * length
    assert failure.band_distance < spacing


def test_surface_runs_from_crest_to_toe_and_ends_on_the_ground():
    from shapely import LineString, Point, Polygon

    positions, triangles = mesh(0.8)
    displacement, strain = rotation(positions, band=0.8)
    line = moving_mass(positions, triangles, displacement, strain).slip_surface
    assert line[0, 1] > line[-1, 1]
    outline = Polygon(OUTLINE).exterior
    assert outline.distance(Point(line[0])) < 1e-9
    assert outline.distance(Point(line[-1])) < 1e-9
    assert LineString(line).is_simple
    step = np.hypot(*np.diff(line, axis=0).T)
    assert step.max() < 0.8


def test_orientation_does_not_depend_on_which_way_the_slope_faces():
    positions, triangles = mesh(1.5)
    displacement, strain = rotation(positions, band=1.0)
    mirror = np.array([-1.0, 1.0])
    line = moving_mass(positions, triangles, displacement, strain).slip_surface
    mirrored = moving_mass(positions * mirror, triangles, displacement * mirror, strain).slip_surface
    np.testing.assert_allclose(mirrored, line * mirror, atol=1e-12)


def test_only_the_largest_mass_counts_and_islands_leave_no_trace():
    positions, triangles = mesh(0.8)
    displacement, strain = rotation(positions, band=0.8)
    plain = moving_mass(positions, triangles, displacement, strain)
    elsewhere = np.hypot(*(positions - [80.0, 38.0]).T) < 2.0
    island = np.hypot(*(positions - [55.0, 31.0]).T) < 1.0
    assert elsewhere.any()
    assert (island & plain.moving).any()
    displacement[elsewhere] = [0.5, 0.0]
    displacement[island] = 0.0
    found = moving_mass(positions, triangles, displacement, strain)
    assert not found.moving[elsewhere].any()
    assert np.abs(np.hypot(*(found.slip_surface - CENTRE).T) - RADIUS).max() < 0.3
    assert np.linalg.norm(found.slip_surface[[0, -1]] - plain.slip_surface[[0, -1]], axis=1).max() < 0.3


def test_small_slide_is_found_though_most_particles_stay():
    positions, triangles = mesh(0.8)
    sliding = (positions[:, 1] > 36.0) & (positions[:, 0] < 63.0)  # about one particle in a hundred
    assert 0.002 < sliding.mean() < 0.02
    found = moving_mass(positions, triangles, np.where(sliding[:, None], [-0.1, -0.05], 0.0))
    assert np.array_equal(found.moving, sliding)


@pytest.mark.parametrize(
    ("field", "strain"),
    [
        (lambda p: np.zeros_like(p), 1.0),
        (lambda p: 1e-12 * p, 1.0),
        (lambda p: 1e-3 * (p - p.min(axis=0)), 0.0),  # elastic: displaced, nothing sheared
    ],
)
def test_nothing_moves(field, strain):
    positions, triangles = mesh(1.5)
    failure = describe_failure(positions, triangles, field(positions), np.full(len(positions), strain))
    assert failure.slip_surface.shape == (0, 2)
    assert not failure.moving.any()
    assert failure.moving_area == 0.0
    assert np.isnan(failure.band_distance)


def test_one_body_that_moves_as_a_whole_has_no_slip_surface():
    positions, triangles = mesh(1.5)
    found = moving_mass(positions, triangles, np.full_like(positions, 0.1))
    assert found.moving.all()
    assert len(found.slip_surface) == 0
    x, y = OUTLINE.T  # shoelace formula
    assert found.area == pytest.approx(0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)), rel=1e-9)


def test_band_distance_measures_an_offset():
    positions, triangles = mesh(0.8)
    displacement, _ = rotation(positions, band=0.8)
    line = moving_mass(positions, triangles, displacement).slip_surface
    distance = np.hypot(*(positions - CENTRE).T)
    shifted = np.exp(-(((distance - RADIUS + 1.6) / 0.8) ** 2))  # a ridge 1.6 m inside the circle
    assert shear_band_distance(positions, triangles, shifted, line) == pytest.approx(1.6, abs=0.4)


def test_failure_keeps_its_own_copies():
    positions, triangles = mesh(1.5)
    displacement, strain = rotation(positions, band=1.0)
    failure = describe_failure(positions, triangles, displacement, strain)
    kept = failure.displacement.copy()
    displacement[:] = 0.0
    np.testing.assert_array_equal(failure.displacement, kept)


def test_interpolation_is_exact_for_a_linear_field():
    """On graded triangles, at particles, on edges and inside; zero outside."""
    rng = np.random.default_rng(4)
    positions = np.concatenate([rng.random((300, 2)), 0.5 + 0.01 * rng.random((300, 2))])
    triangles = Delaunay(positions).simplices
    values = 3.0 + 2.0 * positions[:, 0] - 7.0 * positions[:, 1]
    middle = positions[triangles].mean(axis=1)
    edges = 0.5 * (positions[triangles[:, 0]] + positions[triangles[:, 1]])
    inside = np.concatenate([middle, edges, positions])
    found = interpolated(positions, triangles, values, inside)
    assert np.allclose(found, 3.0 + 2.0 * inside[:, 0] - 7.0 * inside[:, 1], atol=1e-9)
    assert interpolated(positions, triangles, values, np.array([[-1.0, 0.5], [2.0, 2.0]])).tolist() == [
        0.0,
        0.0,
    ]
