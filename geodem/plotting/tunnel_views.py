"""What the report of a tunnel draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.plotting.views import Floats, ReportView


@dataclass(frozen=True)
class LiningView:
    """A lining: points of its axis in order (k, 2) [m], thrust [N/m] and moment [N] where they stand."""

    name: str
    axis: Floats
    thickness: float
    thrust: Floats
    thrust_at: Floats
    moment: Floats
    moment_at: Floats


@dataclass(frozen=True)
class BoltView:
    """Bolts: bars (b, 2, 2) [m], and per piece its middle (p, 2) [m] and force of one bolt [N]."""

    name: str
    bars: Floats
    at: Floats
    force: Floats
    yield_force: float


@dataclass(frozen=True)
class FailureView:
    """Plastic shear strain (n,) and displacement (n, 2) of the lowest failed state of a search."""

    kind: str
    factor: float
    strain: Floats
    displacement: Floats


@dataclass(frozen=True)
class TunnelView:
    """The ground as it stands at the end of a run.

    Attributes
    ----------
    ground : ReportView
        Before anything is dug, for materials, supports and loads.
    positions, triangles : (n, 2) [m], (m, 3)
        Of the standing ground.
    displacement : (n, 2) [m]
    strain, yielded : (n,)
        Plastic shear strain [-]; share of a particle that has yielded [-].
    openings : sequence of (name, outline (k, 2) [m])
    principal : (3,) [Pa]
        Initial horizontal, vertical and shear stress, compression positive, where it is uniform; else k0.
    rows, reaction : sequences of dict
        Increments of the run and of the same digging without supports, SI.
    """

    ground: ReportView
    positions: Floats
    triangles: NDArray[np.integer]
    displacement: Floats
    strain: Floats
    yielded: Floats
    openings: Sequence[tuple[str, Floats]]
    stress: Mapping[str, float]
    rows: Sequence[Mapping[str, Any]] = ()
    reaction: Sequence[Mapping[str, Any]] = ()
    linings: Sequence[LiningView] = ()
    bolts: Sequence[BoltView] = ()
    failures: Sequence[FailureView] = ()
    collapse: Mapping[str, Any] | None = None
    window: tuple[float, float, float, float] = field(default=(0.0, 0.0, 1.0, 1.0))
