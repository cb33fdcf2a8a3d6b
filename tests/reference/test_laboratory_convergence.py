"""Small forms of `reference run laboratory-convergence` and `laboratory-laws`, and that wrong figures are told."""

from __future__ import annotations

import math

import pytest

from geodem.laboratory.rig import Rig
from geodem.laboratory.specimen import make_specimen
from reference.pages_laboratory import laws_table
from reference.problems import laboratory_convergence as convergence
from reference.problems import laboratory_laws as laws
from reference.problems.laboratory_points import Answer, Mean, measure, measure_all

FEW = (1, 2, 3, 4, 5, 6)


def answer(strength: float) -> Answer:
    return Answer(strength, 25e9, 3e-3, 0.4, 0.8, 0.2, 0.01, True, 200, 1000, 0.1)


def test_half_the_step_at_twice_the_steps_is_the_same_rate():
    asked = convergence.rates("sandstone")
    count = len(convergence.SEEDS)
    normal = next(p for p in asked if p.pace == convergence.PACE)
    slow, fine = asked[-2 * count], asked[-count]
    assert slow.pace == fine.pace == 2.0 * normal.pace
    # strain per time is strain per step over the step
    assert fine.time_share * fine.pace == pytest.approx(normal.time_share * normal.pace, rel=1e-15)
    assert slow.time_share == normal.time_share
    rigs = [
        Rig(make_specimen(2, across=10, seed=1), p.material, time_share=p.time_share) for p in (normal, fine)
    ]
    assert rigs[1].simulation.time_step == pytest.approx(0.5 * rigs[0].simulation.time_step, rel=1e-12)


def test_rate_and_step_of_a_small_specimen():
    def asked(pace: float, share: float) -> list:
        return [
            convergence.point("sandstone", "compression", 10.0, seed, pace=pace, time_share=share)
            for seed in FEW
        ]

    normal, fast, fine = asked(340.0, 0.7), asked(40.0, 0.7), asked(680.0, 0.35)
    answers = measure_all(normal + fast + fine, processes=1)
    assert all(a.failed for a in answers.values())
    # inertia carries part of a fast load
    assert convergence.paired(answers, fast, normal).value > 1.1
    step = convergence.paired(answers, fine, normal)
    assert abs(step.value - 1.0) < max(0.02, 3.0 * step.error)


def test_rounding_changes_a_peak_and_nothing_before_it():
    points = [convergence.point("sandstone", "tension", 10.0, 1, grain=1.0 + 1e-12 * k) for k in (0, 1)]
    first, second = (measure(p) for p in points)
    assert second.strength == pytest.approx(first.strength, rel=0.02)
    assert second.young == first.young


def test_figures_off_their_bounds_are_told():
    even = {p: answer(50e6 if p.kind != "confined" else 100e6) for p in convergence.points()}
    # one value for all would have no scatter, which is no fault
    assert all(row.good for row in convergence.figures(even))
    assert len(convergence.draw(even)) > 10_000
    slow = {
        p: a._replace(strength=0.95 * a.strength) if p.pace == 680.0 and p.time_share == 0.7 else a
        for p, a in even.items()
    }
    bad = [row.quantity for row in convergence.figures(slow) if not row.good]
    assert len(bad) == 2
    assert all("half the rate" in quantity for quantity in bad)
    coarse = {p: a._replace(strength=1.1 * a.strength) if p.across == 15.0 else a for p, a in even.items()}
    bad = [(row.name, row.quantity) for row in convergence.figures(coarse) if not row.good]
    assert len(bad) == 4
    assert all("15 across" in name and "strength" in quantity for name, quantity in bad)


def test_without_moments_the_strength_ratio_rises():
    # the known defect of bonds that count their moments, and what takes it away
    def ratio(law: laws.Law) -> float:
        return Mean.of(laws.characterise((law, seed, 10.0, 2)).ratio for seed in (1, 2)).value

    whole, none = ratio(laws.rock(3.0, 30.0, 1.0)), ratio(laws.SANDSTONE)
    assert 2.5 < whole < 6.0
    assert none > 1.5 * whole


def test_laws_are_what_their_labels_say():
    assert len({laws.key(law) for law in laws.LAWS}) == len(laws.LAWS)
    for law in laws.LAWS:
        law.material.check()
        bond = law.material.bond
        assert bond["shear_strength"] == pytest.approx(law.ratio * laws.STRENGTH)
        assert bond["friction_coefficient"] == pytest.approx(math.tan(math.radians(law.angle)))
        assert law.label.split(",")[0].replace(" ", "_") == law.material.bond_law
        assert f"range {law.material.bonding_range:g}" in law.label
        if "beta" in law.label:
            beta = float(law.label.split("beta ")[1].split(",")[0])
            assert law.material.with_bond().bond.get("moment_contribution", 1.0) == beta


def test_a_law_off_its_bounds_is_told():
    def figures(law: laws.Law, seed: int) -> laws.Figures:
        ratio = 4.4 if "beta 1" in law.label else 26.0 if law is laws.GRANITE else 4.9 if law is laws.SOFT else 12.0
        angle = math.radians(56.0 if law is laws.GRANITE else 24.0 if law is laws.SOFT else 40.0)
        return laws.Figures(
            25e9, 0.2, 5e6, ratio * 5e6, ratio + 0.01 * seed, angle, 20.0, 1.2, 0.4, 0.8, 0.2, 0.01, 1.0
        )

    asked = laws.points()
    told = [figures(law, seed) for law, seed, *_ in asked]
    assert all(row.good for row in laws.rows(laws.tabulate(asked, told)))
    told = [f._replace(ductility=1.7, damage=0.95) for f in told]
    bad = [row.quantity for row in laws.rows(laws.tabulate(asked, told)) if not row.good]
    assert len(bad) == 4
    weak = [f._replace(ratio=min(f.ratio, 15.0), friction=math.radians(30.0)) for f in told]
    bad = [row.quantity for row in laws.rows(laws.tabulate(asked, weak)) if not row.good]
    assert len(bad) == 4 + 3


def test_the_table_of_laws_has_a_line_a_law():
    asked = laws.points()
    told = [laws.Figures(24e9, 0.2, 4e6, 40e6, 10.0, 0.7, 20.0, 1.2, 0.4, 0.8, 0.2, 0.01, 1.0) for _ in asked]
    text = laws_table(laws.stored(laws.tabulate(asked, told)))
    lines = text.strip().splitlines()
    assert len(lines) == 2 + len(laws.LAWS)
    assert len({line.count("|") for line in lines}) == 1
    assert "| 0.8 | 0.2 | 0.5 | 10 +- 0 | 40 | 20 | 1.2 | 0.4 | 0.8 | 20 | 1 | 3 |" in lines[2]
