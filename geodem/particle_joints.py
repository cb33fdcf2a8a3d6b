"""Which listed pairs lie across a joint: marked at every search, before they can touch as particles do.

What is crossed at the start is known from the assembly. Pairs that meet later, because the sides slide, are told by the
side of the joint on which each particle was at the start. Both go by where the particles were at the start, so the
closure of a joint is the same whichever particles face each other, and a plane joint stays plane however far it slides.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .kernels.adapters import joint_columns
from .kernels.motion import TOTAL_FRICTION

if TYPE_CHECKING:
    from .particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

PARTING = 1.1
"""Distance at which two particles cease to act on each other through a joint over that at which they begin."""


def mark_joints(s: ParticleSimulation) -> None:
    """Mark new pairs across joints, and let act on each other what is near enough."""
    joints, p, place = s.assembly.joints, s.pairs, s.layout.place
    if joints is None or place is None:
        return
    first, second = s.arrays.ids[p.a], s.arrays.ids[p.b]
    history = p.history
    new = np.flatnonzero(history[:, place] == 0.0)
    chosen, face, upward, area = _across(s, first[new], second[new])
    if len(chosen):
        _mark(s, new[chosen], face, upward, area)
    d = s.dimension
    kind = history[:, place]
    across = np.flatnonzero(kind != 0.0)
    apart = s.now[p.b[across], :d] - s.now[p.a[across], :d]
    radii = s.assembly.radii
    near = np.sqrt((apart**2).sum(axis=1)) / (radii[first[across]] + radii[second[across]])
    acts = (kind[across] > 0.0) & (near <= PARTING * joints.reach)
    acts |= (near <= joints.reach) | (p.bond[across] > 0)
    acts &= history[across, place + 2 + d] > 0.0
    begins, ends = across[acts & (kind[across] < 0.0)], across[~acts & (kind[across] > 0.0)]
    law = slice(place + joint_columns(d), place + joint_columns(d) + len(s.layout.joint))
    history[begins, law] = 0.0
    if s.layout.stored is not None:
        # what a pair brings in or takes away stands in the account as friction
        stored = s.layout.stored
        s.sums[0, TOTAL_FRICTION] += float(history[ends, stored].sum())
        history[np.concatenate([begins, ends]), stored : stored + (14 if d == 3 else 7)] = 0.0
        closure = history[begins, place + 1 + d] - _along(history[begins], place, apart_of(s, begins))
        history[begins, stored + 6] = closure
    history[begins, place] *= -1.0
    history[ends, place] *= -1.0
    p.touching[begins] = 1
    p.touching[ends] = 0


def apart_of(s: ParticleSimulation, pairs: NDArray[np.int64]) -> Floats:
    """Ways (k, d) [m] from a to b of listed pairs."""
    d = s.dimension
    return np.asarray(s.now[s.pairs.b[pairs], :d] - s.now[s.pairs.a[pairs], :d])


def joint_pairs(s: ParticleSimulation) -> NDArray[np.int64]:
    """Where in the list the pairs stand that act on each other through a joint."""
    if s.layout.place is None:
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero(s.pairs.history[:, s.layout.place] > 0.0)


def joint_values(s: ParticleSimulation, pairs: NDArray[np.int64]) -> dict[str, Floats]:
    """Of listed pairs across joints: normal (k, d), overlap, distance along it, area, intact, and their parameters.

    Parameters stand under the names of the law's, its history under the names of that.
    """
    joints, place, d = s.assembly.joints, s.layout.place, s.dimension
    assert joints is not None
    assert place is not None
    history = s.pairs.history[pairs]
    distance = _along(history, place, apart_of(s, pairs))
    number = s.pairs.bond[pairs]
    law = s.features.joint()
    assert law is not None
    row = np.abs(history[:, place]).astype(np.int64) - 1
    found = dict(zip(law.PARAMETERS._fields, s.joint_table[row].T, strict=True))
    found |= {
        "normal": history[:, place + 1 : place + 1 + d], "distance": distance,
        "overlap": history[:, place + 1 + d] - distance, "area": history[:, place + 2 + d],
        "intact": (number > 0).astype(float),
        "scale": np.where(number > 0, s.bond_scale[np.maximum(number - 1, 0)], 1.0),
    }  # fmt: skip
    begin = place + joint_columns(d)
    return found | {name: history[:, begin + k] for k, name in enumerate(s.layout.joint)}


def open_joints(s: ParticleSimulation) -> NDArray[np.bool_]:
    """Which listed pairs (p,) act on each other through a joint that is broken and open there."""
    found = np.zeros(s.pairs.pairs, dtype=bool)
    which = joint_pairs(s)
    if len(which):
        known = joint_values(s, which)
        found[which] = (known["intact"] == 0.0) & (known["overlap"] + known["dilated"] < 0.0)
    return found


def joint_forces(s: ParticleSimulation, pairs: NDArray[np.int64]) -> Floats:
    """Forces (k, d) [N] of joints on the first of listed pairs, as of the last step."""
    law = s.features.joint()
    if law is None or not len(pairs):
        return np.zeros((len(pairs), s.dimension))
    known = joint_values(s, pairs)
    normal = known["normal"]
    closure = known["overlap"] + known["dilated"]
    pressed = np.where((known["intact"] > 0.0) | (closure > 0.0), closure, 0.0)
    size = known["normal_stiffness"] * known["area"] * pressed
    if s.dimension == 3:
        shear = np.stack([known[f"shear_{axis}"] for axis in "xyz"], axis=1)
    else:
        shear = known["shear_x"][:, None] * np.stack([-normal[:, 1], normal[:, 0]], axis=1)
    return np.asarray(shear - size[:, None] * normal)


def bond_table(s: ParticleSimulation) -> Floats:
    """The table of bonds as the loops want it: rows of joints follow those of pairs of materials."""
    if s.features.joint_law is None:
        return s.bond_table
    rows = len(s.assembly.material_names) ** 2
    width = max(s.bond_table.shape[1], s.joint_table.shape[1])
    found = np.zeros((rows + len(s.joint_table), width))
    found[: len(s.bond_table), : s.bond_table.shape[1]] = s.bond_table
    found[rows:, : s.joint_table.shape[1]] = s.joint_table
    return found


def _along(history: Floats, place: int, apart: Floats) -> Floats:
    return np.asarray((apart * history[:, place + 1 : place + 1 + apart.shape[1]]).sum(axis=1))


def _across(
    s: ParticleSimulation, first: NDArray[np.int64], second: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_], Floats]:
    """Those of pairs that lie across a joint; its face, whether the first is below it, and the area."""
    joints = s.assembly.joints
    assert joints is not None
    n = s.assembly.particles
    keys = joints.pairs[:, 0].astype(np.int64) * n + joints.pairs[:, 1]
    order = np.argsort(keys)
    wanted = first * n + second
    at = np.minimum(np.searchsorted(keys[order], wanted), max(len(keys) - 1, 0))
    known = keys[order][at] == wanted if len(keys) else np.zeros(len(wanted), dtype=bool)
    crossed = order[at[known]] if len(keys) else np.empty(0, dtype=np.int64)
    face = np.full(len(wanted), -1, dtype=np.int64)
    area = np.zeros(len(wanted))
    face[known], area[known] = np.abs(joints.face[crossed]) - 1, joints.area[crossed]
    upward = np.zeros(len(wanted), dtype=bool)
    upward[known] = joints.face[crossed] > 0
    near = np.zeros(n, dtype=bool)
    near[joints.side_particle] = True
    rest = np.flatnonzero(near[first] & near[second] & ~known)
    if len(rest):
        met, below = _sides(s, first[rest], second[rest])
        found = rest[met != 0]
        face[found] = np.abs(met[met != 0]) - 1
        upward[found] = below[met != 0]
        size = np.minimum(s.assembly.radii[first[found]], s.assembly.radii[second[found]])
        area[found] = joints.per_size[face[found]] * size ** (s.dimension - 1)
    chosen = np.flatnonzero(face >= 0)
    return chosen, face[chosen], upward[chosen], area[chosen]


def _sides(
    s: ParticleSimulation, first: NDArray[np.int64], second: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """1 + face between the two of every pair, 0 where both are on one side; whether the first is below it.

    Of several joints between them, the one with the lowest number; the face is that nearest to the particle below.
    """
    from scipy.sparse import csr_matrix

    joints = s.assembly.joints
    assert joints is not None
    shape = (s.assembly.particles, int(joints.side_joint.max(initial=0)) + 1)
    sides = csr_matrix((joints.side_face, (joints.side_particle, joints.side_joint)), shape=shape)
    of_first, of_second = sides[first], sides[second]
    met = np.zeros(len(first), dtype=np.int64)
    below = np.zeros(len(first), dtype=bool)
    unlike = of_first.sign().multiply(of_second.sign()).tocoo()
    apart = unlike.data < 0
    pair, joint = unlike.row[apart].astype(np.int64), unlike.col[apart].astype(np.int64)
    order = np.lexsort((joint, pair))
    pair, joint = pair[order], joint[order]
    keep = np.concatenate([[True], pair[1:] != pair[:-1]]) if len(pair) else np.zeros(0, dtype=bool)
    pair, joint = pair[keep], joint[keep]
    if not len(pair):
        return met, below
    one = np.asarray(of_first[pair, joint]).ravel().astype(np.int64)
    other = np.asarray(of_second[pair, joint]).ravel().astype(np.int64)
    met[pair] = np.abs(np.where(one < 0, one, other))
    below[pair] = one < 0
    return met, below


def _mark(
    s: ParticleSimulation,
    pairs: NDArray[np.int64],
    face: NDArray[np.int64],
    upward: NDArray[np.bool_],
    area: Floats,
) -> None:
    joints, place, d = s.assembly.joints, s.layout.place, s.dimension
    assert joints is not None
    assert place is not None
    history = s.pairs.history
    first, second = s.arrays.ids[s.pairs.a[pairs]], s.arrays.ids[s.pairs.b[pairs]]
    normal = np.where(upward, 1.0, -1.0)[:, None] * joints.normal[face]
    start = s.assembly.positions
    history[pairs, place] = -(1.0 + joints.material[face])
    history[pairs, place + 1 : place + 1 + d] = normal
    history[pairs, place + 1 + d] = ((start[second] - start[first]) * normal).sum(axis=1)
    history[pairs, place + 2 + d] = area
