"""Particles of a section: number, lines, areas, angles, thin regions, and what is refused."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
import shapely

from geodem.builders.particles import Particles, fill_section, hilbert_index
from geodem.builders.section import Region, Section
from geodem.errors import InputError

SLOPE = [[20, 20], [84, 20], [84, 40], [67.5, 40], [43, 27.75], [20, 27.75]]
SEAM = [[20, 26.5], [84, 26.5], [84, 27], [20, 27]]


def slope(*more: tuple[str, object]) -> Section:
    return Section.from_polygons([("soil", SLOPE), *more])


def with_circle(segments: int) -> Section:
    angle = 2.0 * np.pi * np.arange(segments) / segments
    hole = np.column_stack([np.cos(angle), np.sin(angle)])
    square = [(-10, -10), (10, -10), (10, 10), (-10, 10)]
    return Section((Region("rock", shapely.Polygon(square, [hole])),))


LENS = np.column_stack(
    [
        50.0 + 15.0 * np.cos(np.linspace(0, 2 * np.pi, 120)[:-1]),
        24.0 + np.sin(np.linspace(0, 2 * np.pi, 120)[:-1]),
    ]
)

# name, section, options, whether it has straight sides only, smallest of its own corners [deg]
CASES = {
    "slope": (slope(), {"particles": 2500}, True, 90.0),
    "slope by spacing": (slope(), {"spacing": 0.7}, True, 90.0),
    "hexagonal": (slope(), {"particles": 2500, "packing": "hexagonal"}, True, 90.0),
    "mirrored": (
        Section.from_polygons([("soil", [[-x, y] for x, y in SLOPE])]), {"particles": 1500}, True, 90.0,
    ),
    "far from the origin": (
        Section.from_polygons(
            [
                ("soil", [[x + 5.1e5, y + 4.2e6] for x, y in SLOPE]),
                ("seam", [[510020, 4200022], [510084, 4200028.3], [510084, 4200028.9], [510020, 4200022.5]]),
            ]
        ),
        {"particles": 3000},
        True,
        80.0,
    ),
    "seam": (slope(("seam", SEAM)), {"particles": 5000}, True, 90.0),
    "inclined seam, three layers": (
        slope(("seam", [[20, 22], [84, 28.3], [84, 28.9], [20, 22.5]])),
        {"particles": 5000, "layers": 3},
        True,
        80.0,
    ),
    "hexagonal seam": (slope(("seam", SEAM)), {"particles": 5000, "packing": "hexagonal"}, True, 90.0),
    "round hole": (with_circle(64), {"particles": 2000}, False, 90.0),
    "round hole, hexagonal": (with_circle(64), {"particles": 2000, "packing": "hexagonal"}, False, 90.0),
    "corner of 20 degrees": (
        Section.from_polygons([("soil", [[0, 0], [40, 0], [40, 14.559]])]), {"particles": 1500}, True, 20.0,
    ),
    "curved lens": (slope(("lens", LENS)), {"particles": 3000}, False, 90.0),
    "two pieces": (
        Section.from_polygons(
            [("a", [[0, 0], [10, 0], [10, 9], [0, 9]]), ("b", [[20, 0], [30, 0], [30, 8], [20, 8]])]
        ),
        {"particles": 1000},
        True,
        90.0,
    ),
    "spacings of 1 to 12": (
        slope(), {"particles": 4000, "refine": [(shapely.Point(43, 27.75), 0.06)]}, True, 90.0,
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def filled() -> dict[str, Particles]:
    return {name: fill_section(section, **options) for name, (section, options, *_) in CASES.items()}


def corners_of(particles: Particles) -> np.ndarray:
    return particles.positions[particles.triangles]


def area_of(particles: Particles) -> np.ndarray:
    p = corners_of(particles)
    u, v = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    return 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def angles_of(particles: Particles) -> np.ndarray:
    """All angles [deg], shape (m, 3), by the law of cosines."""
    p = corners_of(particles)
    a, b, c = (np.linalg.norm(p[:, i] - p[:, j], axis=1) for i, j in ((1, 2), (2, 0), (0, 1)))
    cosines = [
        (b**2 + c**2 - a**2) / (2 * b * c),
        (c**2 + a**2 - b**2) / (2 * c * a),
        (a**2 + b**2 - c**2) / (2 * a * b),
    ]
    return np.degrees(np.arccos(np.clip(np.stack(cosines, axis=1), -1.0, 1.0)))  # fmt: skip


def edges_of(triangles: np.ndarray) -> dict[tuple[int, int], list[int]]:
    """Triangles at each edge."""
    found: dict[tuple[int, int], list[int]] = {}
    for index, corners in enumerate(triangles.tolist()):
        for i, j in itertools.combinations(sorted(corners), 2):
            found.setdefault((i, j), []).append(index)
    return found


@pytest.mark.parametrize("name", CASES)
def test_number_of_particles_is_met(filled: dict[str, Particles], name: str) -> None:
    wanted = CASES[name][1].get("particles")
    count = len(filled[name].positions)
    if wanted is None:
        # an equilateral pattern has 2 / (sqrt(3) h^2) per area, and a half more at each place of its outline
        section, options, *_ = CASES[name]
        h = options["spacing"]
        wanted = section.outline.area * 2 / (np.sqrt(3) * h**2) + 0.5 * section.outline.length / h + 1
    assert abs(count - wanted) <= 0.02 * wanted


@pytest.mark.parametrize("name", CASES)
def test_triangles_of_each_material_fill_its_polygon(filled: dict[str, Particles], name: str) -> None:
    section, _, straight, _ = CASES[name]
    particles = filled[name]
    area = area_of(particles)
    assert area.min() > 0.0
    assert particles.materials == section.materials
    for index, material in enumerate(section.materials):
        filled_area = area[particles.triangle_material == index].sum()
        assert filled_area == pytest.approx(section.area(material), rel=1e-9 if straight else 1e-2)
    # chords cut off a part of a small hole or lens; of the whole section it is less than 0.1 %
    assert area.sum() == pytest.approx(section.outline.area, rel=1e-9 if straight else 1e-3)


@pytest.mark.parametrize("name", CASES)
def test_each_triangle_lies_in_a_region_of_its_material(filled: dict[str, Particles], name: str) -> None:
    section, _, straight, _ = CASES[name]
    particles = filled[name]
    centre = corners_of(particles).mean(axis=1)
    for index, material in enumerate(section.materials):
        ground = shapely.union_all([part.polygon for part in section.regions if part.material == material])
        if not straight:
            ground = ground.buffer(0.05 * particles.spacing)
        here = centre[particles.triangle_material == index]
        assert shapely.contains_xy(ground, here[:, 0], here[:, 1]).all()


@pytest.mark.parametrize("name", CASES)
def test_corners_of_the_section_are_particles(filled: dict[str, Particles], name: str) -> None:
    section, _, straight, _ = CASES[name]
    polygons = [part.polygon for part in section.regions]
    if not straight:
        polygons = [shapely.Polygon(polygons[0].exterior)]
    wanted = {tuple(xy) for polygon in polygons for xy in shapely.get_coordinates(polygon).tolist()}
    assert wanted <= {tuple(xy) for xy in filled[name].positions.tolist()}


@pytest.mark.parametrize("name", CASES)
def test_boundary_edges_enclose_the_ground_on_their_left(filled: dict[str, Particles], name: str) -> None:
    section = CASES[name][0]
    particles = filled[name]
    a, b = (
        particles.positions[particles.boundary_edges[:, 0]],
        particles.positions[particles.boundary_edges[:, 1]],
    )
    # every boundary particle is entered as often as it is left
    assert np.array_equal(np.sort(particles.boundary_edges[:, 0]), np.sort(particles.boundary_edges[:, 1]))
    # Green: the area to the left of a closed path
    shift = a.mean(axis=0)
    (x0, y0), (x1, y1) = (a - shift).T, (b - shift).T
    assert 0.5 * (x0 * y1 - x1 * y0).sum() == pytest.approx(area_of(particles).sum(), rel=1e-9)
    # beyond the arc over the edge of a curve, and within the sharpest corner
    off = 0.1 * np.column_stack([a[:, 1] - b[:, 1], b[:, 0] - a[:, 0]])
    left = 0.5 * (a + b) + off
    assert shapely.contains_xy(section.outline, left[:, 0], left[:, 1]).all()
    single = sum(len(near) == 1 for near in edges_of(particles.triangles).values())
    assert single == len(particles.boundary_edges)


@pytest.mark.parametrize("name", CASES)
def test_no_slivers(filled: dict[str, Particles], name: str) -> None:
    smallest = angles_of(filled[name]).min(axis=1)
    # a corner of the section itself cannot be wider than it is
    assert smallest.min() >= min(20.0, CASES[name][3] - 3.0)
    assert np.percentile(smallest, 1) >= 29.0


@pytest.mark.parametrize("name", ["slope", "corner of 20 degrees", "round hole"])
def test_random_packing_is_irregular(filled: dict[str, Particles], name: str) -> None:
    particles = filled[name]
    inner = np.ones(len(particles.positions), dtype=bool)
    inner[particles.boundary_edges] = False
    neighbours = np.bincount(particles.triangles.ravel(), minlength=len(inner))[inner]
    assert neighbours.mean() == pytest.approx(6.0, abs=0.12)
    # a lattice has nothing but six
    assert 0.4 < (neighbours == 6).mean() < 0.7
    # hexagonal order of the bonds, averaged over all particles: 1 in a lattice, 1/sqrt(3 n) without any order
    p = corners_of(particles)
    bonds = (np.roll(p, 1, axis=1) - p).reshape(-1, 2)
    order = np.abs(np.exp(6j * np.arctan2(bonds[:, 1], bonds[:, 0])).mean())
    assert order < 0.15


def test_hexagonal_packing_is_a_lattice_inside(filled: dict[str, Particles]) -> None:
    smallest = angles_of(filled["hexagonal"]).min(axis=1)
    assert np.median(smallest) == pytest.approx(60.0, abs=1e-6)


@pytest.mark.parametrize("packing", ["random", "hexagonal"])
def test_seam_has_two_rows_of_triangles(packing: str) -> None:
    particles = fill_section(slope(("seam", SEAM)), spacing=0.8, packing=packing)
    seam = particles.triangles[particles.triangle_material == 1]
    y = particles.positions[:, 1]
    levels = np.unique(y[np.unique(seam)])
    assert levels == pytest.approx([26.5, 26.75, 27.0], abs=1e-12)
    low, high = np.isclose(y, 26.5), np.isclose(y, 27.0)
    # no triangle reaches from face to face
    assert not (low[seam].any(axis=1) & high[seam].any(axis=1)).any()
    for face in (low, high):
        on_face = np.sort(particles.positions[face, 0])
        assert np.diff(on_face) == pytest.approx(0.25, rel=1e-9)
    assert any(
        "seam: 0.5 m thick, spacing refined from 0.8 m to 0.25 m" in line for line in particles.messages
    )


def test_refinement_grows_by_the_grading() -> None:
    tip, fine, grading = np.array([43.0, 27.75]), 0.06, 0.2
    particles = fill_section(slope(), spacing=1.0, refine=[(shapely.Point(tip), fine)], grading=grading)
    size = np.sqrt(area_of(particles) * 4 / np.sqrt(3))
    distance = np.linalg.norm(corners_of(particles).mean(axis=1) - tip, axis=1)
    wanted = np.minimum(1.0, fine + grading * distance)
    for near, far in itertools.pairwise([0.0, 0.5, 1.5, 4.0, 50.0]):
        ring = (distance >= near) & (distance < far)
        assert np.median(size[ring] / wanted[ring]) == pytest.approx(1.0, abs=0.12)


def test_corner_where_a_closed_line_begins_is_kept() -> None:
    # a square whose sides are many short ones: of all of its corners one is where the closed line begins
    t = np.arange(0.0, 1.0, 0.1)
    sides = [
        (1.0 + t, 1.0 + 0.0 * t),
        (2.0 + 0.0 * t, 1.0 + t),
        (2.0 - t, 2.0 + 0.0 * t),
        (1.0 + 0.0 * t, 2.0 - t),
    ]
    square = np.concatenate([np.column_stack(side) for side in sides])
    around = shapely.Polygon([(0, 0), (4, 0), (4, 4), (0, 4)], [square])
    section = Section((Region("soil", around), Region("block", shapely.Polygon(square))))
    found = fill_section(section, particles=400)
    corners = found.positions[found.triangles]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    assert area[found.triangle_material == 1].sum() == pytest.approx(1.0, rel=1e-9)


def test_given_points_are_particles() -> None:
    points = [(50.0, 31.25), (60.0, 36.25), (50.0, 25.0), (75.0, 40.0)]
    particles = fill_section(slope(), particles=1500, points=points)
    for point in points:
        assert np.linalg.norm(particles.positions - point, axis=1).min() < 1e-9


def test_same_seed_same_bits_other_seed_other_packing() -> None:
    first, again, other = (
        fill_section(slope(("seam", SEAM)), particles=3000, seed=seed) for seed in (7, 7, 8)
    )
    assert first.positions.tobytes() == again.positions.tobytes()
    assert first.triangles.tobytes() == again.triangles.tobytes()
    assert first.boundary_edges.tobytes() == again.boundary_edges.tobytes()
    assert first.positions.tobytes() != other.positions.tobytes()


def test_hilbert_curve_steps_to_the_next_cell() -> None:
    x, y = np.meshgrid(np.arange(16.0), np.arange(16.0))
    points = np.column_stack([x.ravel(), y.ravel()])
    # their square is cut into 2^20 parts: points of a grid of 2^k fall into cells of their own at every level
    walk = points[np.argsort(hilbert_index(points * (15.9999 / 15.0)))]
    steps = np.abs(np.diff(walk, axis=0)).sum(axis=1)
    assert (steps == 1.0).all()


def test_noise_of_a_line_does_not_refine() -> None:
    x = np.linspace(0, 60, 600)
    rough = 10 + 2 * np.sin(x / 6) + 0.01 * np.random.default_rng(1).standard_normal(600)
    particles = fill_section(
        Section.from_polygons([("soil", [*zip(x, rough, strict=True), (60, 0), (0, 0)])]), spacing=0.8
    )
    p = corners_of(particles)
    assert np.linalg.norm(p - np.roll(p, 1, axis=1), axis=2).min() > 0.3 * 0.8


@pytest.mark.parametrize(
    ("section", "options", "words"),
    [
        (
            slope(("seam", SEAM)),
            {"spacing": 0.8, "thin": "refuse"},
            ["'seam'", "0.5 m thick", "0.8 m", "0.25 m"],
        ),
        (
            slope(("seam", [[20, 26], [84, 26], [84, 26.02], [20, 26.02]])),
            {"particles": 2000},
            ["'seam'", "0.02 m", "at least"],
        ),
        (Section(()), {"particles": 1000}, ["no ground"]),
        (slope(), {"spacing": 30.0}, ["larger than the section"]),
        (slope(), {"spacing": 1e-5}, ["memory"]),
        (slope(), {"particles": 10**12}, ["memory"]),
        (slope(), {"particles": 5}, ["at least"]),
        (slope(), {}, ["particles = 5000"]),
        (slope(), {"particles": 100, "spacing": 1.0}, ["not both"]),
        (slope(), {"spacing": float("nan")}, ["positive"]),
        (slope(), {"spacing": 1.0, "points": [(0.0, 0.0)]}, ["points[0]", "outside"]),
        (slope(), {"spacing": 1.0, "packing": "square"}, ["packing", "hexagonal"]),
        (slope(), {"spacing": 1.0, "layers": 0}, ["layers"]),
        (slope(), {"spacing": 1.0, "refine": [(shapely.Point(50, 25), -0.1)]}, ["refine[0]"]),
    ],
)  # fmt: skip
def test_refused(section: Section, options: dict, words: list[str]) -> None:
    with pytest.raises(InputError) as error:
        fill_section(section, **options)
    for word in words:
        assert word in str(error.value)


def test_number_asked_for_in_an_error_is_enough() -> None:
    section = slope(("seam", [[20, 26], [84, 26], [84, 26.1], [20, 26.1]]))
    with pytest.raises(InputError, match="at least") as error:
        fill_section(section, particles=1000)
    needed = error.value.needed
    assert abs(len(fill_section(section, particles=needed).positions) - needed) <= 0.02 * needed


def test_spacing_grows_faster_where_a_seam_leaves_few_particles() -> None:
    section = slope(("seam", SEAM))
    particles = fill_section(section, particles=2500)
    even = np.sqrt(section.outline.area * 2 / np.sqrt(3) / 2500)
    assert particles.spacing < 1.6 * even
    assert len(particles.positions) == pytest.approx(2500, rel=0.02)
    assert angles_of(particles).min() >= 20.0
    assert any("away from refined places" in line for line in particles.messages)
    # a given grading is kept, whatever it costs
    assert fill_section(section, particles=2500, grading=0.25).spacing > 1.6 * even


def test_a_refined_place_that_takes_too_much_is_told_before_it_is_filled():
    """Area / (sqrt(3)/2 spacing^2) particles: 1e18 of them would be placed first and counted then."""
    box = shapely.box(40, 24, 50, 26)
    with pytest.raises(InputError, match=r"refine\[0\].*more than the free memory"):
        fill_section(slope(), particles=1000, refine=[(box, 1e-8)])
    with pytest.raises(InputError, match=r"a refined place alone needs about (\d+)") as caught:
        fill_section(slope(), particles=1000, refine=[(box, 0.02)])
    needed = int(caught.value.problem.split()[-1])
    assert needed == pytest.approx(20.0 / (0.5 * 3**0.5 * 0.02**2), rel=0.01)
