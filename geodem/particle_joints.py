"""Which listed pairs lie across a joint: marked at every search, before they can touch as particles do.

What is crossed at the start is known from the assembly. Pairs that meet later, because the sides slide, are told by the
side of the joint on which each particle was at the start. Both go by where the particles were at the start, so the
closure of a joint is the same whichever particles face each other, and a plane joint stays plane however far it slides.
"""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .kernels.adapters import joint_columns
from .kernels.motion import TOTAL_FRICTION
from .laws.protocol import history_names, make_parameters
from .measure.contact_forces import law_forces
from .particle_layout import UNBREAKABLE

if TYPE_CHECKING:
    from .particle_reading import ParticleReading
    from .particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

PARTING = 1.01
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
    if len(joints.untouched):
        # whatever else is near a bolt does not touch it
        other = np.flatnonzero(history[:, place] == 0.0)
        bolt = np.isin(s.assembly.material, joints.untouched)
        history[other[bolt[first[other]] | bolt[second[other]]], place] = -1.0
    kind = history[:, place]
    across = np.flatnonzero(kind != 0.0)
    apart = s.now[p.b[across], :d] - s.now[p.a[across], :d]
    radii = s.assembly.radii
    near = np.sqrt((apart**2).sum(axis=1)) / (radii[first[across]] + radii[second[across]])
    lasting = np.array([law.LASTING for law in s.features.joints()])
    stays = lasting[s.joint_table[np.abs(kind[across]).astype(np.int64) - 1, 0].astype(np.int64)]
    acts = (kind[across] > 0.0) & ((near <= PARTING * joints.reach) | stays)
    acts |= (near <= joints.reach) | (p.bond[across] > 0)
    acts &= history[across, place + 2 + d] > 0.0
    begins, ends = across[acts & (kind[across] < 0.0)], across[~acts & (kind[across] > 0.0)]
    law = slice(place + joint_columns(d), place + joint_columns(d) + s.layout.joint)
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


def apart_of(s: ParticleReading, pairs: NDArray[np.int64]) -> Floats:
    """Ways (k, d) [m] from a to b of listed pairs."""
    d = s.dimension
    return np.asarray(s.now[s.pairs.b[pairs], :d] - s.now[s.pairs.a[pairs], :d])


def joint_pairs(s: ParticleReading) -> NDArray[np.int64]:
    """Where in the list the pairs stand that act on each other through a joint."""
    if s.layout.place is None:
        return np.empty(0, dtype=np.int64)
    return np.flatnonzero(s.pairs.history[:, s.layout.place] > 0.0)


def joint_values(s: ParticleReading, pairs: NDArray[np.int64]) -> dict[str, Floats]:
    """Of listed pairs across joints: normal (k, d), overlap, distance along it, area, intact, scale, number of law."""
    place, d = s.layout.place, s.dimension
    assert place is not None
    history = s.pairs.history[pairs]
    distance = _along(history, place, apart_of(s, pairs))
    number = s.pairs.bond[pairs]
    row = np.abs(history[:, place]).astype(np.int64) - 1
    return {
        "normal": history[:, place + 1 : place + 1 + d], "distance": distance,
        "overlap": history[:, place + 1 + d] - distance, "area": history[:, place + 2 + d],
        "intact": (number > 0).astype(float),
        "scale": np.where(number > 0, s.bond_scale[np.maximum(number - 1, 0)], 1.0),
        "law": s.joint_table[row, 0],
    }  # fmt: skip


def law_values(
    s: ParticleReading, law: ModuleType, pairs: NDArray[np.int64]
) -> tuple[Floats, dict[str, Floats]]:
    """Parameters (k, q) and remembered values of pairs that have this law."""
    place = s.layout.place
    assert place is not None
    history = s.pairs.history[pairs]
    row = np.abs(history[:, place]).astype(np.int64) - 1
    begin = place + joint_columns(s.dimension)
    names = history_names(law, s.dimension)
    kept = {name: history[:, begin + k] for k, name in enumerate(names)}
    return s.joint_table[row, 1 : 1 + len(law.PARAMETERS._fields)], kept


def open_joints(s: ParticleReading) -> NDArray[np.bool_]:
    """Which listed pairs (p,) lie across a joint that is broken and open there, or across a broken link."""
    found = np.zeros(s.pairs.pairs, dtype=bool)
    which = joint_pairs(s)
    if not len(which):
        return found
    known = joint_values(s, which)
    for number, law in enumerate(s.features.joints()):
        own = known["law"] == number
        _, kept = law_values(s, law, which[own])
        gone = known["intact"][own] == 0.0
        if not law.LASTING:
            gone &= known["overlap"][own] + kept["dilated"] < 0.0
        found[which[own]] = gone
    return found


def joint_forces(s: ParticleReading, pairs: NDArray[np.int64]) -> Floats:
    """Forces (k, d) [N] of joints on the first of listed pairs, as of the last step."""
    found = np.zeros((len(pairs), s.dimension))
    if not len(pairs):
        return found
    known = joint_values(s, pairs)
    for number, law in enumerate(s.features.joints()):
        own = known["law"] == number
        parameters, kept = law_values(s, law, pairs[own])
        given = {name: known[name][own] for name in ("overlap", "area", "intact", "scale")}
        normal = known["normal"][own]
        values = law_forces(law, s.dimension, parameters, given | kept)
        if s.dimension == 3:
            shear = values[:, 1:]
        else:
            shear = values[:, 1:2] * np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        found[own] = shear - values[:, :1] * normal
    return found


def set_joint(s: ParticleSimulation, material: str, **parameters: float) -> None:
    """Change parameters of a material of joints or bolts from now on.

    Raises
    ------
    InputError
        No such material or parameter, or a value out of range.
    """
    joints = s.assembly.joints
    names = () if joints is None else joints.names
    if material not in names:
        problem = "there is no such material of joints"
        raise InputError("material", problem, f"Known: {', '.join(names) or 'none'}", value=material)
    row = s.joint_table[names.index(material)]
    law = s.features.joints()[int(row[0])]
    fields = law.PARAMETERS._fields
    now = dict(zip(fields, np.where(row[1:] >= UNBREAKABLE, np.inf, row[1:]).tolist(), strict=False))
    changed = make_parameters(law, now | parameters, f"joint material {material!r}")
    row[1 : 1 + len(fields)] = np.minimum(changed, UNBREAKABLE)


def bond_table(s: ParticleSimulation) -> Floats:
    """The table of bonds as the loops want it: rows of joints follow those of pairs of materials."""
    if not s.features.joint_laws:
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
