"""Extremes of stress-carrying particles; part of `python -m reference run stability`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import geodem
from geodem.model import Model

from .stability_trial import Clock, Trial, ending, trial

CLAY: dict[str, float] = {
    "density": 2000.0,
    "young_modulus": 1e8,
    "poisson_ratio": 0.3,
    "cohesion": 20e3,
    "friction_angle": math.radians(20.0),
    "dilation_angle": math.radians(20.0),
    "tensile_strength": math.inf,
}
PARTICLES = 250


def bank(size: float = 1.0, *, under: dict[str, float] | None = None, **changed: float) -> Model:
    """A 2:1 bank 5 m high times `size`, of one material, or of two where `under` changes the lower."""
    outline = [(0.0, 0.0), (25.0, 0.0), (25.0, 10.0), (15.0, 10.0), (5.0, 5.0), (0.0, 5.0)]
    base = [(0.0, 0.0), (25.0, 0.0), (25.0, 5.0), (5.0, 5.0), (0.0, 5.0)]
    regions = [("clay", (size * np.array(outline)).tolist())]
    properties = {"clay": geodem.GroundProperties.of(**_properties(changed))}
    if under is not None:
        regions.append(("base", (size * np.array(base)).tolist()))
        properties["base"] = geodem.GroundProperties.of(**_properties({**changed, **under}))
    section = geodem.Section.from_polygons(regions)
    sides = {"left": "roller", "right": "roller", "bottom": "fixed"}
    return geodem.build_ground(geodem.fill_section(section, particles=PARTICLES), properties, boundary=sides)


def _properties(changed: dict[str, float]) -> dict[str, Any]:
    values = {**CLAY, **changed}
    return {"density": values.pop("density"), **values}


def factor(model: Model) -> float:
    """Factor of safety by strength reduction."""
    value = geodem.Search(geodem.Simulation(model), geodem.StrengthReduction(), tolerance=0.02).run().value
    return math.nan if value is None else float(value)


def _spread(models: list[Model]) -> tuple[float, str]:
    with ending() as stopped:
        factors = [factor(model) for model in models]
    if stopped.message is not None:
        return math.inf, stopped.message
    return max(factors) / min(factors) - 1.0, "factors " + ", ".join(f"{value:.3f}" for value in factors)


def scales() -> list[Trial]:
    """What must not change the factor: the size, with the cohesion in proportion; nu; E; ratios of E."""
    clock, found = Clock(), []
    sizes = [bank(size, cohesion=20e3 * size, young_modulus=1e8 * size) for size in (1e-3, 1.0, 1e4)]
    stiff = [bank(poisson_ratio=nu) for nu in (0.3, 0.49, 0.4999)]
    ratios = [bank(under={"young_modulus": 1e8 * ratio}) for ratio in (1.0, 1e3, 1e6)]
    for name, models, limit, source in (
        (
            "sections of 25 mm to 250 km, cohesion in proportion",
            sizes,
            0.005,
            "the factor has no length in it",
        ),
        (
            "Poisson's ratio 0.3 to 0.4999",
            stiff,
            0.05,
            "the factor does not depend on elasticity; brackets of 2 %",
        ),
        (
            "young moduli by 1 to 1e6 over one another",
            ratios,
            0.05,
            "the factor does not depend on elasticity; brackets of 2 %",
        ),
    ):
        value, seen = _spread(models)
        found.append(
            trial(
                f"stress-carrying: {name}",
                "largest factor over the least, less one",
                value,
                limit,
                len(models),
                clock.read(),
                source,
                seen,
            )
        )
    return found


def extremes(steps: int = 2000) -> list[Trial]:
    """Strengths from nothing to beyond all use: finite numbers, or a message."""
    clock, lost, count, messages = Clock(), 0, 0, []
    for cohesion in (0.0, 1.0, 1e12):
        for friction in (0.0, 1e-6, 45.0, 89.0):
            for tension in (0.0, math.inf):
                for nu in (0.0, 0.4999):
                    count += 1
                    angle = math.radians(friction)
                    with ending() as stopped:
                        simulation = geodem.Simulation(
                            bank(
                                cohesion=cohesion,
                                friction_angle=angle,
                                dilation_angle=angle,
                                tensile_strength=tension,
                                poisson_ratio=nu,
                            )
                        )
                        measures = simulation.run(steps)
                        finite = all(np.isfinite(array).all() for array in simulation.state.arrays().values())
                        lost += int(not (finite and math.isfinite(measures.unbalanced_ratio)))
                    if stopped.message is not None:
                        messages.append(stopped.message)
    return [
        trial(
            "stress-carrying: cohesion 0 to 1e12 Pa, friction 0 to 89 deg, tension 0 or none, nu 0 or 0.4999",
            f"states after {steps} steps with numbers that are none, and no message",
            lost,
            0.0,
            count,
            clock.read(),
            "finite or stopped",
            f"{len(messages)} stopped" + (f": {messages[0][:150]}" if messages else ""),
        )
    ]


PARTS = (scales, extremes)
