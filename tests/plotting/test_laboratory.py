"""Pictures of the laboratory from made-up tests, whose numbers are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.orders import FinishedTest, TestOrder
from geodem.laboratory.record import Cracks, TestRecord
from geodem.laboratory.specimen import make_specimen
from geodem.laboratory.summary import Spread, group_tests, material_properties, summarise_envelope
from geodem.plotting import laboratory_charts as charts
from geodem.plotting import laboratory_sections as parts
from geodem.plotting.laboratory_specimen import specimen_chart
from geodem.plotting.laboratory_wording import named, property_lines, quantity_of, spread
from geodem.plotting.theme import style

ROCK = BondedMaterial.rock(
    density=2600.0, effective_modulus=60e9, stiffness_ratio=2.5, tensile_strength=10e6, shear_strength=40e6,
    friction_angle=0.6,
)  # fmt: skip
COHESION, FRICTION = 25e6, math.radians(45.0)
SLOPE = (1.0 + math.sin(FRICTION)) / (1.0 - math.sin(FRICTION))


def made_up(kind: str, stress: float, seed: int, dimension: int = 2) -> FinishedTest:
    """A test whose strength is on a Mohr-Coulomb line, a little more for a higher seed."""
    arguments = {
        "dimension": dimension, "width": 0.05, "height": 0.1, "across": 8.0, "seed": seed, "shape": "prism",
        "packing": "triangular" if dimension == 2 else "fcc",
    }  # fmt: skip
    specimen = make_specimen(**arguments)
    rng = np.random.default_rng(seed)
    strength = 2.0 * COHESION * math.sqrt(SLOPE) + SLOPE * stress if kind != "direct-tension" else 9e6
    strength *= 1.0 + 0.02 * (seed - 1)
    strain = np.linspace(0.0, 0.004, 80)
    way = strength * np.minimum(strain / 0.003, 1.0) * (1.0 - 300.0 * np.clip(strain - 0.003, 0.0, None))
    d = dimension
    count = 20
    direction = rng.normal(size=(count, d))
    direction /= np.sqrt((direction**2).sum(axis=1, keepdims=True))
    cracks = Cracks(
        rng.uniform(0.0, 1.0, (count, d)) * specimen.size, rng.integers(1, 3, count), direction,
        np.full(count, specimen.diameter), np.linspace(0.5, 1.0, count) * strength,
    )  # fmt: skip
    curves = {
        "steps": np.arange(80.0), "axial_strain": strain, "gauge_axial": strain, "gauge_lateral": -0.25 * strain,
        "axial_stress": np.maximum(way, stress), "tension_cracks": np.arange(80.0),
        "shear_cracks": np.arange(80.0) // 4, "unbalanced_ratio": np.full(80, 1e-3),
    }  # fmt: skip
    numbers = {
        "young_modulus": 50e9, "poisson_ratio": 0.25, "peak_strain": 0.003, "confinement": stress,
        "crack_initiation_stress": 0.4 * strength, "crack_damage_stress": 0.8 * strength,
    }  # fmt: skip
    record = TestRecord(
        kind, strength, True, "the load has fallen to 70% of its peak", curves, numbers, cracks, specimen.positions,
        1e-4 * specimen.positions, 1000, 1.0, seed,
    )  # fmt: skip
    return FinishedTest(TestOrder(kind, arguments, ROCK, stress), record, specimen.radii, specimen.size, 0.1)


def all_tests(dimension: int = 2) -> list[FinishedTest]:
    kinds = [("uniaxial-compression", 0.0), ("direct-tension", 0.0), ("triaxial-compression", 10e6)]
    return [made_up(kind, stress, seed, dimension) for kind, stress in kinds for seed in (1, 2, 3)]


def test_properties_are_means_with_their_scatter():
    groups = group_tests(all_tests())
    envelope = summarise_envelope(groups)
    found = {entry.key: entry.spread for entry in material_properties(groups, envelope)}
    ucs = 2.0 * COHESION * math.sqrt(SLOPE)
    # strengths 1, 1.02 and 1.04 times: mean 1.02, standard deviation 0.02
    strength = found["uniaxial_compressive_strength_Pa"]
    assert strength.mean == pytest.approx(1.02 * ucs)
    assert strength.deviation == pytest.approx(0.02 * ucs)
    assert found["strength_ratio"] == pytest.approx(Spread(ucs / 9e6, 0.0, 3), abs=1e-12)
    assert envelope is not None
    assert envelope.whole.friction_angle == pytest.approx(
        math.asin((1.02 * SLOPE - 1.0) / (1.02 * SLOPE + 1.0))
    )
    assert groups[0].typical.order.seed == 2


def test_one_specimen_has_no_scatter():
    groups = group_tests([made_up("uniaxial-compression", 0.0, 1)])
    (strength,) = (
        p for p in material_properties(groups, None) if p.key == "uniaxial_compressive_strength_Pa"
    )
    assert math.isnan(strength.spread.deviation)
    assert "±" not in parts.shown(strength.spread, "stress")
    assert summarise_envelope(groups) is None


def test_charts_show_what_they_are_given():
    groups = group_tests(all_tests())
    envelope = summarise_envelope(groups)
    assert envelope is not None
    with style():
        curves = charts.curves_chart([groups[0], groups[2]])
        (axes,) = curves.axes
        assert [text.get_text() for text in curves.axes[0].get_legend().get_texts()] == [
            "unconfined",
            "10 MPa",
        ]
        tops = {line.get_ydata().max() for line in axes.lines if len(line.get_ydata()) == 80}
        assert max(tops) == pytest.approx(1e-6 * max(t.record.strength for t in groups[2].tests), rel=0.02)
        circles = charts.envelope_chart(envelope, 9e6).axes[0]
        # the circle of an unconfined test begins at no stress, that of tension ends there
        spans = [
            (line.get_xdata().min(), line.get_xdata().max())
            for line in circles.lines
            if len(line.get_xdata()) == 181
        ]
        assert min(low for low, _ in spans) == pytest.approx(-9.0)
        assert any(low == pytest.approx(0.0, abs=1e-9) for low, high in spans if high > 1.0)
        cracking = charts.cracking_chart(groups[0])
        assert any("crack initiation" in text.get_text() for text in cracking.axes[0].texts)


def test_specimens_show_particles_and_cracks():
    test = made_up("uniaxial-compression", 0.0, 1)
    with style():
        figure = specimen_chart(test, "title")
    axes = figure.axes[0]
    discs, *lines = axes.collections
    assert len(discs.get_offsets()) == len(test.radii)
    assert sum(len(each.get_segments()) for each in lines) == 20
    # a crack lies across the line that joined its particles
    mode = test.record.cracks.mode[0]
    ends = lines[mode - 1].get_segments()[0]
    assert (ends[1] - ends[0]) @ test.record.cracks.direction[0] == pytest.approx(0.0, abs=1e-12)
    assert ends.mean(axis=0) == pytest.approx(1e3 * test.record.cracks.place[0])


def test_figures_of_spheres():
    pytest.importorskip("pyvista")
    groups = group_tests(all_tests(3))
    pictures = parts.make_figures(groups[:1], None)
    assert "specimen-uniaxial-compression-2" in pictures
    assert len(pictures["specimen-uniaxial-compression-2"].png) > 20_000


def test_words():
    test = made_up("triaxial-compression", 10e6, 2)
    assert named(test.order) == "triaxial-compression at 10 MPa, specimen 2"
    assert test.order.name == "triaxial-compression-10MPa-2"
    assert quantity_of("friction_angle_rad") == "angle"
    lines = property_lines(
        {
            "friction_angle_rad": {
                "name": "friction angle", "mean": math.radians(45.0), "standard_deviation": math.radians(1.234),
                "specimens": 3,
            }
        }
    )  # fmt: skip
    assert lines == ["Friction angle 45 deg ± 1.2 deg (3 specimens)"]
    assert spread(8.94e6, 820e3, "stress") == "8.94 MPa ± 0.82 MPa"
