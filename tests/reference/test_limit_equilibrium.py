"""Limit equilibrium against published factors and closed forms.

Published bands are widened by 0.5 %: the spread among programs of the same method on the same problem.
"""

import numpy as np
import pytest
import shapely

from reference.limit_equilibrium import Ground, NotASlopeError, Soil, Surcharge, bishop, search, spencer
from reference.noncircular import search_blocks


def one_soil(outline, cohesion, friction, unit_weight, **loads):
    """Ground of one soil; kPa, degrees, kN/m3."""
    soil = Soil(1e3 * unit_weight, 1e3 * cohesion, np.radians(friction))
    return Ground([("soil", [outline])], {"soil": soil}, **loads)


def face(degrees, height, before, behind, below):
    """Outline of a slope whose toe is the origin."""
    run = 0.0 if degrees == 90 else height / np.tan(np.radians(degrees))
    return [
        (-before, -below),
        (-before, 0.0),
        (0.0, 0.0),
        (run, height),
        (run + behind, height),
        (run + behind, -below),
    ]


ACADS_1A = one_soil([(20, 20), (70, 20), (70, 35), (50, 35), (30, 25), (20, 25)], 3, 19.6, 20)
ARAI_TAGYO = one_soil([(0, 0), (0, 15), (18, 15), (48, 35), (66, 35), (66, 0)], 41.65, 15, 18.82)
YAMAGAMI_UETA = one_soil([(-10, -5), (-10, 0), (0, 0), (10, 5), (25, 5), (25, -5)], 9.8, 10, 17.64)
ACADS_1C_REGIONS = [
    ("1", [[(30, 25), (50, 35), (80, 35), (80, 31), (54, 31), (50, 29), (40, 27)]]),
    ("2", [[(40, 27), (50, 29), (54, 31), (80, 31), (80, 24), (52, 24)]]),
    ("3", [[(10, 20), (10, 25), (30, 25), (40, 27), (52, 24), (80, 24), (80, 20)]]),
]
ACADS_1C_SOILS = {
    "1": Soil(19.5e3, 0.0, np.radians(38)),
    "2": Soil(19.5e3, 5.3e3, np.radians(23)),
    "3": Soil(19.5e3, 7.2e3, np.radians(20)),
}
ACADS_1C = Ground(ACADS_1C_REGIONS, ACADS_1C_SOILS)
ACADS_3A = Ground(
    [
        ("soil", [[(20, 27), (20, 27.75), (43, 27.75), (67.5, 40), (84, 40), (84, 27)]]),
        ("seam", [[(20, 26.5), (84, 26.5), (84, 27), (20, 27)]]),
        ("soil", [[(20, 20), (84, 20), (84, 26.5), (20, 26.5)]]),
    ],
    {"soil": Soil(18.84e3, 28.5e3, np.radians(20)), "seam": Soil(18.84e3, 0.0, np.radians(10))},
)


# Bands: verification manuals of published programs, for ACADS 1(a) and 1(c) (Giam & Donald 1989), Arai &
# Tagyo (1985) example 1 and the slope of Yamagami & Ueta (1988).
@pytest.mark.parametrize(
    ("ground", "method", "low", "high"),
    [
        (ACADS_1A, "bishop", 0.987, 0.988),
        (ACADS_1A, "spencer", 0.984, 0.987),
        (ACADS_1C, "bishop", 1.403, 1.414),
        (ACADS_1C, "spencer", 1.372, 1.375),
        (ARAI_TAGYO, "bishop", 1.404, 1.417),
        (ARAI_TAGYO, "spencer", 1.401, 1.401),
        (YAMAGAMI_UETA, "bishop", 1.342, 1.348),
    ],
)
def test_published_slopes(ground, method, low, high):
    assert 0.995 * low <= search(ground, method).factor <= 1.005 * high


def test_published_weak_seam():
    # ACADS 3(a): Spencer on a non-circular surface 1.258 (a published program), others 1.248 to 1.261.
    block = search_blocks(ACADS_3A)
    assert block.factor == pytest.approx(1.258, rel=0.005)
    run = block.surface[1:3]
    assert np.all((run[:, 1] > 26.4) & (run[:, 1] < 27.0)), "the block slides in the seam"
    # No circle can follow the seam.
    assert search(ACADS_3A, "spencer").factor > 1.15 * block.factor


# Taylor (1937): the critical stability number gamma H / c of slip circles in clay, phi = 0.
@pytest.mark.parametrize(
    ("degrees", "below", "number"),
    [(90, 10, 3.83), (45, 10, 5.64), (45, 150, 5.52)],
    ids=["vertical cut", "45 degrees, base one height down", "45 degrees, deep base"],
)
def test_clay_has_taylors_numbers(degrees, below, number):
    wide = 30 if below < 100 else 200
    clay = one_soil(face(degrees, 10.0, wide, wide, below), 1.0, 0.0, 1.0)
    answer = search(clay, "bishop", composite=False)
    # c = 1 kPa, gamma H = 10 kPa: the number is 10 times the factor.
    assert 10.0 * answer.factor == pytest.approx(number, rel=0.005)
    # Moments about the centre alone give the factor: Spencer's method on the same circle says the same.
    same = spencer(clay, (*answer.centre, answer.radius))
    assert same.factor == pytest.approx(answer.factor, rel=1e-6)


def test_circle_in_clay_with_earthquake_in_closed_form():
    acceleration = 0.2
    outline = face(30, 10.0, 30, 30, 20)
    clay = one_soil(outline, 40.0, 0.0, 19.0, horizontal_acceleration=acceleration)
    x, y, radius = 5.0, 15.0, 19.0
    disc = shapely.Point(x, y).buffer(radius, quad_segs=4000)
    mass = shapely.Polygon(outline).intersection(disc)
    toe, crest = x - np.sqrt(radius**2 - y**2), x + np.sqrt(radius**2 - (10.0 - y) ** 2)
    angle = np.arcsin((crest - x) / radius) - np.arcsin((toe - x) / radius)
    centroid = mass.centroid
    weight = 19.0 * mass.area
    expected = (
        40.0 * radius**2 * angle / (weight * (centroid.x - x) + acceleration * weight * (y - centroid.y))
    )
    assert bishop(clay, (x, y, radius), slices=200).factor == pytest.approx(expected, rel=1e-3)


def test_plane_block_stands_at_the_height_of_culmann():
    # Hc = 4 c sin(b) cos(phi) / (gamma (1 - cos(b - phi))) = 22.39 m; the plane dips (b + phi) / 2.
    slope, phi, cohesion, unit_weight = np.radians(60), np.radians(30), 20.0, 20.0
    height = 4 * cohesion * np.sin(slope) * np.cos(phi) / (unit_weight * (1 - np.cos(slope - phi)))
    assert height == pytest.approx(22.39, abs=0.005)
    ground = one_soil(face(60, height, 10, 40, 10), cohesion, 30, unit_weight)
    answer = spencer(ground, [(0.0, 0.0), (height, height)])
    assert answer.factor == pytest.approx(1.0, rel=1e-4)


def test_plane_block_with_earthquake_and_surcharge():
    # F = (c L + (V cos a - T sin a) tan(phi)) / (V sin a + T cos a), V down, T out of the slope.
    ground = one_soil(
        face(60, 12.0, 10, 40, 10),
        30.0,
        25,
        19.0,
        horizontal_acceleration=0.15,
        surcharges=[Surcharge((8.0, 12.0), (10.0, 12.0), 50e3)],
    )
    weight = 19.0 * 0.5 * 12.0 * (12.0 - 12.0 / np.tan(np.radians(60)))
    vertical, horizontal, slope = weight + 50.0 * 2.0, 0.15 * weight, np.radians(45)
    along = vertical * np.sin(slope) + horizontal * np.cos(slope)
    across = vertical * np.cos(slope) - horizontal * np.sin(slope)
    expected = (30.0 * 12.0 * np.sqrt(2.0) + across * np.tan(np.radians(25))) / along
    assert spencer(ground, [(0.0, 0.0), (12.0, 12.0)]).factor == pytest.approx(expected, rel=1e-4)


def test_block_with_a_dry_tension_crack():
    # Priest (1993): plane dipping 30 degrees from the toe, crack 15 m deep; weight 8239.3 kN/m, F = 1.1456.
    ground = one_soil([(-20, -20), (-20, 0), (0, 0), (17, 30), (60, 30), (60, -20)], 20.0, 30.0, 25.0)
    answer = spencer(ground, [(0.0, 0.0), (25.981, 15.0)])
    assert answer.factor == pytest.approx(1.1456, rel=1e-3)


def test_long_slope_tends_to_the_infinite_one():
    # c / (gamma z sin b cos b) + tan(phi) / tan(b) = 1.0215 for c 5, gamma 18, z 3, b 30, phi 25.
    length, rise = 3000.0, 3000.0 * np.tan(np.radians(30))
    ground = one_soil([(0, -50), (0, 0), (length, rise), (length, -50)], 5.0, 25.0, 18.0)
    tangent = np.tan(np.radians(30))
    surface = [
        (0.0, 0.0),
        (5.0, 5.0 * tangent - 3.0),
        (length - 3.0, rise - 3.0 * tangent - 3.0),
        (length, rise),
    ]
    # The ends, 3 m of 3000 m, add about as much.
    assert spencer(ground, surface, slices=400).factor == pytest.approx(1.0215, rel=0.004)


def test_cohesionless_slope_is_told_to_be_surficial():
    answer = search(one_soil(face(26.565, 10.0, 10, 20, 10), 0.0, 30.0, 18.0), "bishop")
    # tan(30) / tan(26.565) = 1.1547; a mass of the least thickness is a little stronger.
    assert 1.1547 <= answer.factor < 1.165
    assert any("Surficial" in note and "1.155" in note for note in answer.notes)


@pytest.mark.parametrize("ground", [ACADS_1C, ACADS_1A], ids=["layers", "one soil"])
def test_mirrored_section_has_the_same_factor(ground):
    here, there = search(ground, "bishop"), search(ground.mirrored(), "bishop")
    assert there.factor == pytest.approx(here.factor, rel=1e-9)
    assert there.centre[0] == pytest.approx(-here.centre[0], rel=1e-6)
    np.testing.assert_allclose(there.surface[::-1, 0], -here.surface[:, 0], atol=1e-6)
    assert np.all(np.diff(there.surface[:, 0]) > 0.0)
    circle = (*there.centre, there.radius)
    assert bishop(ground.mirrored(), circle).factor == pytest.approx(here.factor, rel=1e-5)


@pytest.mark.parametrize("method", [bishop, spencer])
def test_slices_converge(method):
    circle = (34.46, 42.5, 18.1)
    coarse, middle, fine, finest = (method(ACADS_1C, circle, slices=n).factor for n in (25, 50, 100, 800))
    assert abs(middle - finest) < 0.5 * abs(coarse - finest)
    assert abs(fine - finest) < 0.5 * abs(middle - finest)
    assert middle == pytest.approx(finest, rel=5e-4)


def test_layers_are_weighed_exactly():
    # Weight of each layer over a circle, from polygons cut by shapely; the soils differ in weight alone.
    weights = {"1": 20e3, "2": 17e3, "3": 22e3}
    ground = Ground(ACADS_1C_REGIONS, {name: Soil(weights[name], 1e3, 0.3) for name in weights})
    chords = np.linspace(32.0, 52.0, 41)
    level = 45.0 - np.sqrt(20.0**2 - (chords - 36.0) ** 2)
    # Slices that end at all vertices of the section, but not where the chords cross a layer.
    edges = np.unique(
        np.concatenate([chords, ground.breaks()[(ground.breaks() > 32) & (ground.breaks() < 52)]])
    )
    below = np.interp(edges, chords, level)
    polygon = shapely.Polygon([(32, 99), *zip(edges, below, strict=True), (52, 99)])
    expected = sum(
        weights[name] * shapely.Polygon(rings[0]).intersection(polygon).area
        for name, rings in ACADS_1C_REGIONS
    )
    total = ground.slices(edges[None, :], below[None, :]).weight.sum()
    assert total == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("degrees", [30, 90])
def test_even_pressure_all_over_clay_changes_nothing(degrees):
    # Pressure normal to toe, face and crest alike adds an even stress, to which phi = 0 is blind.
    outline = face(degrees, 8.0, 20, 20, 12)
    circle = (2.0, 11.0, 13.0)
    bare = one_soil(outline, 40.0, 0.0, 19.0)
    pieces = [Surcharge(outline[i], outline[i + 1], 60e3) for i in (1, 2, 3)]
    pressed = one_soil(outline, 40.0, 0.0, 19.0, surcharges=pieces)
    for ground in (pressed, pressed.mirrored()):
        about = circle if ground is pressed else (-circle[0], *circle[1:])
        assert bishop(ground, about, slices=400).factor == pytest.approx(
            bishop(bare, circle, slices=400).factor, rel=2e-4
        )


def test_circle_below_the_section_follows_its_underside():
    # Rock at toe level under a 2:1 slope (c 10, phi 20, gamma 20, H 10): 1.380 from charts, within 2 %.
    ground = one_soil([(0, 0), (20, 10), (32, 10), (32, 0)], 10, 20, 20)
    answer = search(ground, "bishop")
    assert answer.factor == pytest.approx(1.380, rel=0.02)
    assert answer.surface[:, 1].min() >= 0.0
    assert answer.factor <= search(ground, "bishop", composite=False).factor + 1e-4


def test_steep_end_of_the_section_is_no_failure():
    # The sides of the section are cuts through the ground, not its surface: only the slope may slide.
    answer = search(one_soil(face(30, 10.0, 30, 30, 60), 5.0, 20.0, 20.0), "bishop")
    assert -15.0 < answer.surface[0, 0] < 5.0


@pytest.mark.parametrize(
    ("rings", "why"),
    [
        ([[(0, 0), (0, 10), (50, 10), (50, 0)]], "level"),
        ([[(0, 0), (0, 10), (20, 20), (80, 20), (80, 0)], [(50, 5), (55, 5), (55, 10), (50, 10)]], "opening"),
        ([[(0, 0), (0, 10), (30, 10), (25, 20), (60, 20), (60, 0)]], "overhang"),
    ],
    ids=["level ground", "tunnel", "overhang"],
)
def test_no_slope_is_refused(rings, why):
    with pytest.raises(NotASlopeError, match=why):
        search(Ground([("soil", rings)], {"soil": Soil(2e4, 1e4, 0.3)}))


def test_pieces_are_refused():
    two = [("soil", [[(0, 0), (0, 5), (9, 9), (9, 0)]]), ("soil", [[(12, 0), (12, 5), (20, 9), (20, 0)]])]
    with pytest.raises(NotASlopeError, match="pieces"):
        Ground(two, {"soil": Soil(2e4, 1e4, 0.3)})
