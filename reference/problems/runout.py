"""Failed ground handed over to discs, and its run-out: `python -m reference run runout`.

What the hand-over keeps, on slopes that a strength reduction brought to failure; the friction of discs in biaxial
compression against the residual angle that was asked for; and columns on level ground, handed over like failed slopes,
whose run-out is known: G. Lube, H. Huppert, R. Sparks and A. Freundt (2005), Collapses of two-dimensional granular
columns, Phys. Rev. E 72:041301: (r - r0)/r0 = 1.2 a for a below 1.8, whatever the grains.
"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import numpy as np

from geodem.analysis import Analysis
from geodem.builders.random_packing import random_packing
from geodem.building import make_model, make_particles, make_section
from geodem.case import parse_case
from geodem.measure.deposit import main_body
from geodem.particle_simulation import ParticleSimulation
from geodem.preparation.compaction import compact
from geodem.preparation.grains import Grains
from geodem.runout.flow import Flow
from geodem.runout.friction import SHEAR_STIFFNESS, disc_friction
from geodem.runout.handing import HandOver, hand_over
from geodem.runout.source import failed_source, released_velocity
from geodem.state import State

from .rows import Row, at_most, relative

SLOPE = """
workflow = "slope"
title = "{name}"
particles = 1500
methods = ["strength-reduction"]
tolerance = 0.02
seed = 1
[section]
length_unit = "m"
regions = [{regions}]
[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
[material.upper]
law = "mohr_coulomb"
density = "1900 kg/m3"
cohesion = "5 kPa"
friction_angle = "{phi} deg"
dilation_angle = "{phi} deg"
young_modulus = "30 MPa"
poisson_ratio = 0.3
{more}
"""
LOWER = """[material.lower]
law = "mohr_coulomb"
density = "2150 kg/m3"
cohesion = "3 kPa"
friction_angle = "24 deg"
dilation_angle = "24 deg"
young_modulus = "60 MPa"
poisson_ratio = 0.3
"""
CASES: dict[str, dict[str, Any]] = {
    "45 deg slope, one material": {
        "regions": '{material = "upper", polygon = [[0,0],[60,0],[60,10],[35,10],[20,25],[0,25]]}',
        "phi": 26, "more": "",
    },
    "45 deg slope, two materials": {
        "regions": '{material = "upper", polygon = [[0,0],[60,0],[60,10],[35,10],[20,25],[0,25]]},'
        '{material = "lower", polygon = [[0,0],[60,0],[60,10],[35,10],[30,15],[0,15]]}',
        "phi": 22, "more": LOWER,
    },
    "vertical cut facing left": {
        "regions": '{material = "upper", polygon = [[0,0],[40,0],[40,14],[18,14],[18,6],[0,6]]}',
        "phi": 20, "more": "",
    },
}  # fmt: skip
DISCS = 1000
EXACT, JUMP = 1e-10, 0.01

ANGLES = (15.0, 20.0, 25.0, 30.0)
SEEDS = (11, 12, 13)
ASPECTS, COLUMN_ANGLE = (0.6, 1.0, 1.6), 28.0
FEW = 1.5  # [deg] between the angle asked for and the mean of three fresh packings


def handed(name: str, start: str) -> HandOver:
    """The hand-over of one of the slopes."""
    text = SLOPE
    for key, value in {"name": name, **CASES[name]}.items():
        text = text.replace(f"{{{key}}}", str(value))
    case = parse_case(text, Path("."))
    analysis = Analysis(case)
    analysis.build()
    analysis.search()
    model, failed = analysis.model, analysis.records["strength-reduction"].failed
    assert model is not None
    assert failed is not None
    densities = [case.materials[material].density for material in model.material_names]
    source = failed_source(model, failed.state, densities)
    if start == "failing":
        energy = failed.energy.damping + failed.energy.kinetic
        velocity = released_velocity(model, failed.state, densities, source.moving, energy)
        source = failed_source(model, failed.state, densities, velocity=velocity)
    friction = [disc_friction(math.radians(20.0))] * len(model.material_names)
    return hand_over(source, friction, discs=DISCS, beyond=4.0, young_modulus=30e6, seed=1)


def hand_over_rows() -> list[Row]:
    """What is kept."""
    rows = []
    for name in CASES:
        begun = time.perf_counter()
        hand = handed(name, "failing")
        seconds = time.perf_counter() - begun
        label = f"hand-over, {name}"
        for entry in hand.conserved:
            energy = "energy" in entry.name
            if energy and entry.name != "energy":
                continue
            bound = JUMP if energy else EXACT
            what = "total energy" if energy else entry.name
            rows.append(
                Row(label, f"{what} [{entry.unit}]", entry.after, entry.before, entry.error, bound, seconds,
                    "the model of stress-carrying particles")
            )  # fmt: skip
        elastic = next(entry for entry in hand.conserved if entry.name == "elastic energy")
        rows.append(
            Row(label, "elastic energy over that of the model", elastic.after / elastic.before, 1.0,
                elastic.after / elastic.before - 1.0, 1.0, seconds, "stiffness of discs by the modulus of the ground")
        )  # fmt: skip
    return rows


def residual_angle(angle: float, seed: int) -> float:
    """Friction angle [deg] at large strain of fresh discs that are to have `angle` [deg]; lengths in mean diameters."""
    friction = disc_friction(math.radians(angle))
    stiffness = 1000.0  # over the confining stress
    contact = {
        "normal_stiffness": stiffness, "shear_stiffness": SHEAR_STIFFNESS * stiffness,
        "friction_coefficient": friction.sliding, "rolling_friction": friction.rolling,
    }  # fmt: skip
    side = math.sqrt(900 * math.pi * 0.26 / 0.80)
    loose = random_packing(
        2, box=(side / 1.35, 1.35 * side), solid_fraction=0.80, radius=2.0 / 3.0, size_ratio=2.0, seed=seed
    )
    grains = Grains(1.0, contact, contact_law="linear_rolling")
    dense = compact(loose, grains, pressure=1.0, friction=0.0, local_damping=0.5, tolerance=1e-3)
    s = ParticleSimulation(
        grains.assembly(dense.positions, dense.radii, cell=dense.cell), local_damping=0.1, orientation=False
    )
    rate = 2e-3
    s.set_target_stress(np.array([-1.0, math.nan]), largest_rate=10.0 * rate)
    s.set_strain_rate(np.array([[math.nan, 0.0], [0.0, -rate]]))
    sines = []
    while s.time * rate < 0.4:
        s.run(200)
        if s.time * rate > 0.2:
            stress = s.stress()
            sines.append((stress[0, 0] - stress[1, 1]) / -(stress[0, 0] + stress[1, 1]))
    return math.degrees(math.asin(float(np.mean(sines))))


def friction_rows() -> list[Row]:
    """Residual angles of fresh packings."""
    rows = []
    for angle in ANGLES:
        begun = time.perf_counter()
        found = [residual_angle(angle, seed) for seed in SEEDS]
        seconds = time.perf_counter() - begun
        off = float(np.mean(found)) - angle
        rows += [
            Row("friction of discs", f"residual angle [deg], {angle:g} deg asked for, error in degrees over {FEW:g}",
                float(np.mean(found)), angle, off / FEW, 1.0, seconds, f"mean of seeds {SEEDS[0]} to {SEEDS[-1]}"),
            at_most("friction of discs", f"range of the seeds [deg], {angle:g} deg asked for, at most",
                    float(np.ptp(found)), 3.0, seconds, ""),
        ]  # fmt: skip
    return rows


def column_run_out(aspect: float, angle: float, seed: int) -> float:
    """(r - r0)/r0 of a column of half width 10 m on level ground, both sides in the mean."""
    half, foot, far = 10.0, 2.0, 25.0
    high = foot + aspect * half
    corners = [
        [-half - far, 0], [half + far, 0], [half + far, foot], [half, foot], [half, high], [-half, high],
        [-half, foot], [-half - far, foot],
    ]  # fmt: skip
    text = SLOPE.replace("{regions}", f'{{material = "upper", polygon = {corners}}}')
    for key, value in {"name": "column", "phi": 25, "more": ""}.items():
        text = text.replace(f"{{{key}}}", str(value))
    case = parse_case(text, Path("."))
    model = make_model(case, make_particles(case, make_section(case), particles=1500))
    state = State.at_rest(model)
    # what stands on the ground has failed, and has hardly moved
    state.displacement[model.positions[:, 1] > foot + 1e-6] = (1e-4, 0.0)
    state.stress[:, 3] = 1e-3
    source = failed_source(model, state, [1900.0])
    hand = hand_over(
        source, [disc_friction(math.radians(angle))], discs=1000, beyond=6.0 * aspect * half, young_modulus=30e6,
        seed=seed,
    )  # fmt: skip
    flow = Flow.of(hand)
    while not (flow.at_rest or flow.too_long):
        flow.advance()
    own = flow.moving
    places, radii = flow.simulation.positions[own], flow.simulation.assembly.radii[own]
    body = main_body(places, radii)
    right, left = (places[:, 0] + radii)[body].max(), (radii - places[:, 0])[body].max()
    return float(0.5 * (right + left) / half - 1.0)


def column_rows() -> list[Row]:
    """Run-out of columns over their aspect ratio."""
    rows = []
    for aspect in ASPECTS:
        begun = time.perf_counter()
        found = column_run_out(aspect, COLUMN_ANGLE, 1)
        rows.append(
            relative("column handed over", f"run-out over r0, a = {aspect:g}, residual angle {COLUMN_ANGLE:g} deg",
                     found, 1.2 * aspect, 0.25, time.perf_counter() - begun, "Lube et al. 2005: 1.2 a")
        )  # fmt: skip
    return rows


def run() -> list[Row]:
    """What the hand-over keeps; friction and columns are groups of their own."""
    return hand_over_rows()
