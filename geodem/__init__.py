"""geodem: factor of safety and failure of the ground by particle models.

A case file to its result::

    >>> import geodem
    >>> result = geodem.run_case("workflows/slope_from_picture", "out", quickly=True)  # doctest: +SKIP

The same in code, from geometry to the factor of safety of a 5 m bank of soft clay:

    >>> from math import inf
    >>> bank = geodem.Section.from_polygons([("clay", [(0, 0), (25, 0), (25, 8), (15, 8), (10, 3), (0, 3)])])
    >>> strength = {"cohesion": 19e3, "friction_angle": 0.0, "dilation_angle": 0.0, "tensile_strength": inf}
    >>> clay = geodem.GroundProperties.of(1800.0, young_modulus=10e6, poisson_ratio=0.3, **strength)
    >>> sides = {"left": "roller", "right": "roller", "bottom": "fixed"}
    >>> model = geodem.build_ground(geodem.fill_section(bank, particles=400), {"clay": clay}, boundary=sides)
    >>> search = geodem.Search(geodem.Simulation(model), geodem.StrengthReduction(), tolerance=0.02)
    >>> print(f"{search.run().value:.1f}")
    1.2

Discs that fall, touch and come to rest (true motion; `particle_statics` finds rest without it):

    >>> from geodem.boundaries.walls import plane
    >>> from geodem.builders.assembly_builder import AssemblyBuilder
    >>> build = AssemblyBuilder(2, gravity=(0.0, -10.0))
    >>> spring = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
    >>> build.add_material("grain", density=2000.0, contact=spring)
    >>> ids = build.add_particles([(0.0, 0.1), (0.0, 0.35)], 0.1, "grain")
    >>> build.add_wall(plane("floor", (0.0, 0.0), (0.0, 1.0)))
    >>> motion = geodem.ParticleSimulation(build.build(), local_damping=0.5)
    >>> motion.run(2000)
    >>> print(f"{motion.wall_force('floor')[1]:.0f} N/m")
    -1257 N/m

SI units throughout, angles in radians; text with units is for case files. Names are loaded when first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ._version import __version__

_PLACES = {
    "Analysis": "analysis",
    "Case": "case",
    "Criteria": "stability.criteria",
    "GravityIncrease": "stability.methods",
    "GroundProperties": "builders.ground",
    "InputError": "errors",
    "Model": "model",
    "ParticleSimulation": "particle_simulation",
    "Particles": "builders.particles",
    "Region": "builders.section",
    "Search": "stability.search",
    "Section": "builders.section",
    "Simulation": "simulation",
    "StoppedError": "errors",
    "StrengthReduction": "stability.methods",
    "Surcharge": "builders.ground",
    "build_ground": "builders.ground",
    "check_case": "checking",
    "fill_section": "builders.particles",
    "load_case": "case",
    "redraw": "workflow",
    "resume_case": "workflow",
    "run_case": "workflow",
    "section_from_image": "builders.from_image",
}

__all__ = [
    "Analysis",
    "Case",
    "Criteria",
    "GravityIncrease",
    "GroundProperties",
    "InputError",
    "Model",
    "ParticleSimulation",
    "Particles",
    "Region",
    "Search",
    "Section",
    "Simulation",
    "StoppedError",
    "StrengthReduction",
    "Surcharge",
    "__version__",
    "build_ground",
    "check_case",
    "fill_section",
    "load_case",
    "redraw",
    "resume_case",
    "run_case",
    "section_from_image",
]


def __getattr__(name: str) -> Any:
    """Load a public name when it is first used (PEP 562), so that importing geodem costs nothing."""
    if name not in _PLACES:
        raise AttributeError(f"module 'geodem' has no attribute {name!r}")
    value = getattr(import_module(f".{_PLACES[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


if TYPE_CHECKING:
    from .analysis import Analysis
    from .builders.from_image import section_from_image
    from .builders.ground import GroundProperties, Surcharge, build_ground
    from .builders.particles import Particles, fill_section
    from .builders.section import Region, Section
    from .case import Case, load_case
    from .checking import check_case
    from .errors import InputError, StoppedError
    from .model import Model
    from .particle_simulation import ParticleSimulation
    from .simulation import Simulation
    from .stability.criteria import Criteria
    from .stability.methods import GravityIncrease, StrengthReduction
    from .stability.search import Search
    from .workflow import redraw, resume_case, run_case
