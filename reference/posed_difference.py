"""How far two runs of one posed scene differ."""

from __future__ import annotations

import numpy as np

from .posed import Floats, Posed, Trajectory

QUANTITIES = (
    "positions", "velocities", "spins", "forces", "torques", "pair_shear", "wall_forces", "broken",
)  # fmt: skip

ROUNDING = 1e-9
"""Share of its natural size up to which a quantity counts as zero: spins beside speed over radius, and the like."""


def differences(one: Trajectory, other: Trajectory, posed: Posed) -> dict[str, float]:
    """Largest |difference| over largest |value|, over all frames, of each quantity that is posed to be compared.

    A quantity that is zero but for rounding is held against its natural size. The difference is infinite where the
    two do not speak of the same steps, pairs or broken bonds, and where a number is not finite.
    """
    found = {}
    for name in posed.quantities:
        if name == "broken":
            found[name] = 0.0 if one.broken == other.broken else np.inf
        elif name == "pair_shear":
            found[name] = _pairs_apart(one, other)
        else:
            found[name] = _apart(one, other, name, posed)
    return found


def _apart(one: Trajectory, other: Trajectory, name: str, posed: Posed) -> float:
    first, second = getattr(one, name), getattr(other, name)
    if not np.array_equal(one.steps, other.steps) or first is None or second is None:
        return np.inf
    if name not in ("positions", "velocities", "spins") and one.lag != other.lag:
        return np.inf
    if first.shape != second.shape:
        return np.inf
    if name in ("forces", "torques"):
        # a code that holds a freedom need not tell what holds it
        held = posed.assembly.held
        d = posed.assembly.dimension
        free = np.ones(first.shape[1:], dtype=bool)
        part = held[:, :d] if name == "forces" else held[:, d:]
        axes = part.shape[1]
        free[:, :axes] = ~part
        if name == "torques" and axes == 1:
            free[:] = ~part
        first, second = np.where(free, first, 0.0), np.where(free, second, 0.0)
    return _ratio(first, second, _natural(one, name, posed))


def _natural(one: Trajectory, name: str, posed: Posed) -> float:
    """Size that a quantity would have if it mattered."""
    radius = float(posed.assembly.radii.max())
    speed, force = float(np.abs(one.velocities).max()), float(np.abs(np.nan_to_num(one.forces)).max())
    return {
        "spins": speed / radius,
        "torques": force * radius,
        "velocities": radius / posed.time_step * 1e-6,
    }.get(name, force if name != "positions" else radius)


def _ratio(first: Floats, second: Floats, natural: float) -> float:
    if not (np.isfinite(first).all() and np.isfinite(second).all()):
        return np.inf
    size = max(float(np.abs(first).max(initial=0.0)), float(np.abs(second).max(initial=0.0)))
    apart = float(np.abs(first - second).max(initial=0.0))
    if size <= ROUNDING * natural:
        size = natural
    return apart / size if apart > 0.0 else 0.0


def _pairs_apart(one: Trajectory, other: Trajectory) -> float:
    first, second = one.pair_forces, other.pair_forces
    if first is None or second is None or one.lag != other.lag:
        return np.inf
    if not (np.array_equal(first.frame, second.frame) and np.array_equal(first.pairs, second.pairs)):
        return np.inf
    force = float(np.abs(np.nan_to_num(one.forces)).max(initial=0.0))
    return _ratio(first.shear, second.shear, force)


def good(found: dict[str, float], bound: float) -> bool:
    """Whether something was compared and nothing differs by more than the bound."""
    return bool(found) and all(value <= bound for value in found.values())
