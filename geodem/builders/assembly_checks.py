"""What is looked at before an assembly is handed over: numbers, particles in one another, walls, bonds."""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.assembly import Assembly, Cell, Wall
from geodem.builders.close_pairs import close_pairs, distances
from geodem.builders.interactions import law_numbers
from geodem.errors import InputError, InputErrors
from geodem.laws.protocol import MENU, history_arguments

Floats = NDArray[np.float64]
Pairs = NDArray[np.int64]

DEEPEST_OVERLAP = 0.5
"""Largest overlap over the smaller radius: above it particles lie in one another by mistake."""
LONGEST_BOND = 2.0
"""Largest distance of bonded particles over the sum of their radii."""
# relative difference of two stiffnesses that is rounding
ROUNDING = 1e-9


def raise_all(errors: Sequence[InputError]) -> None:
    """Raise one error as it is, several together, none not at all."""
    single = [
        one for error in errors for one in (error.errors if isinstance(error, InputErrors) else [error])
    ]
    if len(single) == 1:
        raise single[0]
    if single:
        raise InputErrors(single)


def as_numbers(what: str, values: Any, shape: tuple[int, ...], unit: str) -> Floats:
    """Float64 array of that shape, one value or row repeated where fewer are given; or `InputError`."""
    try:
        given = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(what, "these are not numbers", f"Give numbers in {unit}.", value=values) from None
    try:
        return np.array(np.broadcast_to(given, shape))
    except ValueError:
        raise InputError(
            what,
            f"an array of shape {given.shape} does not fit {shape}",
            f"Give one {'number' if len(shape) == 1 else 'row'} for all, or {shape[0]} of them, in {unit}.",
        ) from None


def bad_entries(
    what: str, values: Floats, first: int, unit: str, *, positive: bool = False, item: str = "particle"
) -> list[InputError]:
    """An error that names the first entry which is not finite (or not positive) and counts the others."""
    wrong: Any = ~np.isfinite(values)
    if positive:
        wrong |= ~(values > 0.0)
    if values.ndim > 1:
        wrong = wrong.any(axis=1)
    found = np.flatnonzero(wrong)
    if not len(found):
        return []
    more = f" ({len(found) - 1} more like it)" if len(found) > 1 else ""
    return [
        InputError(
            f"{what} of {item} {first + found[0]}",
            f"this is not {'a positive' if positive else 'a finite'} number{more}",
            f"Give {'positive ' if positive else 'finite '}numbers in {unit}.",
            value=values[found[0]].tolist(),
        )
    ]


def chosen(place: str, ids: Any, particles: int) -> NDArray[np.int64]:
    """Particle numbers from an int, a range, an array of numbers or a mask; or `InputError`."""
    numbers = np.atleast_1d(np.asarray(ids))
    if numbers.dtype == bool:
        if numbers.shape != (particles,):
            raise InputError(
                place,
                f"a mask of {numbers.size} does not fit {particles} particles",
                "Give one per particle.",
            )
        return np.flatnonzero(numbers)
    if numbers.size == 0:
        return np.empty(0, dtype=np.int64)
    if numbers.ndim != 1 or not np.issubdtype(numbers.dtype, np.integer):
        raise InputError(
            place, "these are not particle numbers", "Give the range that add_particles returned.", value=ids
        )
    outside = numbers[(numbers < 0) | (numbers >= particles)]
    if len(outside):
        raise InputError(
            place,
            f"there is no such particle: they are numbered 0 to {particles - 1}",
            "Give the range that add_particles returned.",
            value=int(outside[0]),
        )
    return numbers.astype(np.int64)


def refuse_bad_bonds(
    pairs: Pairs, positions: Floats, radii: Floats, earlier: Pairs, cell: Cell | None = None
) -> None:
    """Raise for bonds of a particle with itself, made twice, or much longer than the particles are wide."""
    errors = []
    itself = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
    if len(itself):
        errors.append(
            InputError(
                f"bond {itself[0]}",
                f"particle {pairs[itself[0], 0]} is bonded to itself{_more(itself)}",
                "Give two different particles.",
            )
        )
    keys = pair_keys(pairs, len(radii))
    _, kept = np.unique(keys, return_index=True)
    again = np.isin(keys, pair_keys(earlier, len(radii)))
    again |= ~np.isin(np.arange(len(pairs)), kept)
    twice = np.flatnonzero(again)
    if len(twice):
        a, b = pairs[twice[0]]
        errors.append(
            InputError(
                f"bond {twice[0]}",
                f"particles {a} and {b} are bonded already{_more(twice)}",
                "Bond every pair once.",
            )
        )
    length = distances(positions, pairs, cell) / (radii[pairs[:, 0]] + radii[pairs[:, 1]])
    far = np.flatnonzero(length > LONGEST_BOND)
    if len(far):
        worst = far[np.argmax(length[far])]
        a, b = pairs[worst]
        errors.append(
            InputError(
                f"bond {worst}",
                f"particles {a} and {b} are {length[worst]:.3g} times the sum of their radii apart{_more(far)}",
                f"Bond neighbours: at most {LONGEST_BOND:g} times.",
            )
        )
    raise_all(errors)


def pair_keys(pairs: Pairs, particles: int) -> NDArray[np.int64]:
    """One number for every pair, whichever particle comes first."""
    return np.asarray(pairs.min(axis=1) * particles + pairs.max(axis=1))


def _more(found: NDArray[np.int64]) -> str:
    return f" ({len(found) - 1} more like it)" if len(found) > 1 else ""


def deep_overlaps(
    positions: Floats, radii: Floats, excepted: Pairs, cell: Cell | None = None
) -> list[InputError]:
    """Particles that lie in one another by more than `DEEPEST_OVERLAP` of the smaller radius.

    Parameters
    ----------
    positions, radii : (n, d), (n,) [m]
    excepted : (p, 2) int
        Pairs that may: bonds measure their overlap from where they were made.
    """
    pairs, distance = close_pairs(
        positions, radii, lambda a, b: a + b - DEEPEST_OVERLAP * np.minimum(a, b) * (1.0 + 1e-9), cell
    )
    if len(excepted) and len(pairs):
        new = ~np.isin(pair_keys(pairs, len(radii)), pair_keys(excepted, len(radii)))
        pairs, distance = pairs[new], distance[new]
    if not len(pairs):
        return []
    a, b = pairs[:, 0], pairs[:, 1]
    depth = (radii[a] + radii[b] - distance) / np.minimum(radii[a], radii[b])
    worst = int(np.argmax(depth))
    middle = 0.5 * (positions[a[worst]] + positions[b[worst]])
    where = ", ".join(f"{value:.6g}" for value in middle)
    count = f"{len(pairs)} pairs of particles lie" if len(pairs) > 1 else "a pair of particles lies"
    return [
        InputError(
            "particles",
            f"{count} in one another by more than {DEEPEST_OVERLAP:g} of the smaller radius; the worst are "
            f"{a[worst]} and {b[worst]} at ({where}) m with {depth[worst]:.3g}",
            "Place them apart (geodem.builders.packings), or make them smaller.",
        )
    ]


def behind_planes(wall: Wall, positions: Floats, radii: Floats) -> list[InputError]:
    """Particles behind the planes of a wall, or in them by more than `DEEPEST_OVERLAP` of the radius."""
    errors = []
    for point, normal in wall.planes:
        depth = 1.0 - (positions - point) @ normal / radii
        behind = np.flatnonzero(depth > DEEPEST_OVERLAP * (1.0 + 1e-9))
        if len(behind):
            worst = int(behind[np.argmax(depth[behind])])
            where = ", ".join(f"{value:.6g}" for value in positions[worst])
            count = f"{len(behind)} particles are" if len(behind) > 1 else "a particle is"
            errors.append(
                InputError(
                    f"wall {wall.name!r}",
                    f"{count} behind its plane or deep in it; the worst is particle {worst} at ({where}) m",
                    "Move the plane, turn its normal towards the particles, or take them out.",
                )
            )
    return errors


def energy_of_breaking(contact_law: ModuleType, bond_law: ModuleType, assembly: Assembly) -> list[InputError]:
    """Bonds softer than the contact that takes over when they break, which would create energy.

    In compression the contact meets the same overlap with its own normal stiffness, and takes the shear force
    over, up to friction. With r = kn contact / kn bond and q = ks contact / ks bond the energy cannot grow if
    r <= 1 and mu^2 r^2 (1/q - 1) kn bond / ks bond <= 1 - r (the shear energy F^2 / (2 ks) at the friction
    limit F = mu kn u against the normal energy given up).
    """
    d, count = assembly.dimension, len(assembly.material_names)
    material = assembly.material[assembly.bonds].astype(np.int64)
    keys = material[:, 0] * count + material[:, 1]
    length = distances(assembly.positions, assembly.bonds.astype(np.int64), assembly.cell)
    size = assembly.radii[assembly.bonds]
    errors, seen = [], set()
    if assembly.joints is not None:
        # a bonded face hands nothing over
        joined = pair_keys(assembly.bonds.astype(np.int64), assembly.particles)
        crossed = pair_keys(assembly.joints.pairs.astype(np.int64), assembly.particles)
        keys = np.where(np.isin(joined, crossed), -1, keys)
    for key in np.unique(keys[keys >= 0]):
        first, second = divmod(int(key), count)
        if (max(first, second), min(first, second)) in seen:
            continue
        group = np.flatnonzero(keys == key)
        contact = contact_law.PARAMETERS(*assembly.contact_table[key])
        bond = bond_law.PARAMETERS(*assembly.bond_table[key])
        extremes = {int(group[np.argmin(v[group])]) for v in (size[:, 0], size[:, 1], length)}
        extremes |= {int(group[np.argmax(v[group])]) for v in (size[:, 0], size[:, 1], length)}
        for one in sorted(extremes):
            menu = {
                "radius_a": size[one, 0],
                "radius_b": size[one, 1],
                "distance": length[one],
                "overlap": 0.0,
            }
            kn, ks, *_ = law_numbers(contact_law, "stiffness", d, contact._asdict() | menu)
            bond_kn, bond_ks, *_ = law_numbers(bond_law, "stiffness", d, bond._asdict() | menu)
            friction = _friction(contact_law, d, contact._asdict() | menu)
            problem = _gain(kn, ks, bond_kn, bond_ks, friction)
            if problem:
                names = assembly.material_names
                seen.add((max(first, second), min(first, second)))
                errors.append(
                    InputError(
                        f"bond of {names[first]!r} and {names[second]!r}",
                        f"{problem}: a bond that breaks in compression would create energy "
                        f"(bond {one}, particles {assembly.bonds[one, 0]} and {assembly.bonds[one, 1]})",
                        "Give bond and contact the same stiffness, or the bond the larger normal stiffness.",
                    )
                )
                break
    return errors


def _friction(law: ModuleType, dimension: int, menu: dict[str, float]) -> float:
    """Largest shear over normal force that the contact law bears at an overlap of a thousandth of a radius."""
    calm = dict.fromkeys((*MENU, *history_arguments(law)), 0.0) | {
        "time_step": 1.0,
        "mass_a": 1.0,
        "mass_b": 1.0,
    }
    pressed = {"overlap": 1e-3 * min(menu["radius_a"], menu["radius_b"])}
    sheared = {f"{law.TANGENTIAL[0]}_x": 1e30} if law.TANGENTIAL else {}
    normal, shear, *_ = law_numbers(law, "force", dimension, calm | menu | pressed | sheared)
    return float(shear / normal) if normal > 0.0 else np.inf


def _gain(kn: float, ks: float, bond_kn: float, bond_ks: float, friction: float) -> str:
    """What makes the energy grow when a contact takes over from a bond; empty where nothing does."""
    if kn > bond_kn * (1.0 + ROUNDING):
        return f"the bond's normal stiffness {bond_kn:.4g} N/m is below the contact's {kn:.4g} N/m"
    if kn <= 0.0 or ks <= 0.0 or bond_ks <= 0.0 or ks >= bond_ks * (1.0 - ROUNDING):
        return ""
    ratio = kn / bond_kn
    gained = (friction * ratio) ** 2 * (bond_ks / ks - 1.0) * bond_kn / bond_ks
    if gained > 1.0 - ratio + ROUNDING:
        return f"the contact's shear stiffness {ks:.4g} N/m is below the bond's {bond_ks:.4g} N/m"
    return ""
