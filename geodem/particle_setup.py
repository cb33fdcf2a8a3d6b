"""From an assembly to the first state of a particle simulation: tables, features, pairs, time step, start of motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .assembly import Assembly
from .boundaries.cell import PeriodicCell
from .boundaries.wall_pairs import WallPairs, contact_sum
from .boundaries.wall_table import set_servo_gains
from .builders.assembly_checks import as_numbers
from .errors import InputError
from .kernels import motion
from .kernels.particle_kernel import Features
from .laws.convention import CONVENTIONS
from .neighbors import PairList, bond_pairs, rebuild
from .particle_layout import finite, wall_parameters
from .particle_network import contact_modulus, current_links, wall_normals

if TYPE_CHECKING:
    from .particle_simulation import ParticleSimulation

Floats = NDArray[np.float64]

SAFETY = 0.5
"""Share of the critical time step that is used where none is given: a collision then takes at least three steps."""

BUFFER_SHARE = 0.1
"""Buffer of the pair list over the mean radius."""


def refuse_damping(local: float, global_: float, stiffness: float) -> None:
    """Raise InputError for a damping out of range."""
    for name, value, most in (
        ("local_damping", local, 1.0),
        ("global_damping", global_, math.inf),
        ("stiffness_damping", stiffness, math.inf),
    ):
        if not (math.isfinite(value) and 0.0 <= value < most):
            bound = "0 to below 1" if most == 1.0 else "0 or more"
            raise InputError(name, "this damping is out of range", f"Give {bound}", value=value)


def refuse_convention(
    convention: str, dimension: int, energy: bool, global_damping: float, local: float
) -> None:
    """Raise InputError for a convention that does not exist, or that cannot stand for the scene."""
    if convention not in CONVENTIONS:
        raise InputError(
            "convention", "there is no such convention", f"Known: {', '.join(CONVENTIONS)}.", value=convention
        )
    if convention == "geodem":
        return
    reasons = []
    if dimension == 2:
        reasons.append(("it is made for spheres", "Give spheres, held in a plane where need be"))
    if energy:
        reasons.append(("the energy account is kept in geodem's own", "Leave energy out"))
    if global_damping > 0.0:
        reasons.append(("mass-proportional damping is geodem's own", "Leave global_damping out"))
    if local > 0.0 and not CONVENTIONS[convention].AT_MIDDLE:
        reasons.append(("that code has no local damping", "Leave local_damping out"))
    for problem, remedy in reasons:
        raise InputError("convention", problem, f"{remedy}, or take convention='geodem'", value=convention)


def choose_buffer(assembly: Assembly, given: float | None) -> float:
    """The given buffer or one from the radii [m]; raises InputError for none that is a distance."""
    buffer = BUFFER_SHARE * float(assembly.radii.mean()) if given is None else float(given)
    if not (math.isfinite(buffer) and buffer > 0.0):
        raise InputError("buffer", "this is no distance", "Give more than 0 m, or leave it out", value=given)
    if assembly.joints is not None:
        # what a joint crosses is listed although it does not touch
        reach = 2.0 * float(assembly.radii.max()) * (assembly.joints.reach - 1.0) * (1.0 + 1e-9)
        buffer = max(buffer, reach)
    return buffer


def joint_table(assembly: Assembly) -> Floats:
    """Parameters of the materials of joints (k, q)."""
    return np.zeros((1, 1)) if assembly.joints is None else finite(assembly.joints.table)


def start_cell(assembly: Assembly, buffer: float, sleep: object) -> PeriodicCell | None:
    """The periodic cell at the start; raises InputError where it is too thin or something in it sleeps."""
    if assembly.cell is None:
        return None
    if sleep is not None:
        raise InputError("sleep", "in a periodic cell nothing can be skipped", "Leave it out")
    cell = PeriodicCell.at_start(assembly.cell, 2.0 * float(assembly.radii.max()) + buffer)
    cell.settle()
    return cell


def parameter_tables(assembly: Assembly, beta: float) -> tuple[Floats, Floats, Floats]:
    """Parameters of contacts, bonds and contacts with walls, stiffness-proportional damping beta [s] added.

    Raises InputError where a law has no dashpots to add it to.
    """
    contact_table = finite(assembly.contact_table)
    bond_table = finite(assembly.bond_table) if assembly.bond_law is not None else np.zeros((1, 1))
    wall_table = wall_parameters(assembly) if assembly.walls else np.zeros((1, 1))
    if beta == 0.0:
        return contact_table, bond_table, wall_table
    contact, bond = Features(assembly.dimension, assembly.contact_law, assembly.bond_law).laws()
    tables = [(contact, contact_table), (contact, wall_table)]
    if bond is not None:
        tables.append((bond, bond_table))
    for law, table in tables:
        viscous = [k for k, name in enumerate(law.PARAMETERS._fields) if name.endswith("_viscosity")]
        if not viscous:
            raise InputError(
                "stiffness_damping", f"the law {law.NAME!r} has no dashpots",
                "Use global_damping or local_damping, or another law", value=beta,
            )  # fmt: skip
        if table.shape[1] == len(law.PARAMETERS._fields):
            table[:, viscous] += beta
    return contact_table, bond_table, wall_table


def scene_features(
    s: ParticleSimulation, *, energy: bool, orientation: bool, applied: bool, convention: str
) -> Features:
    """What the scene of a simulation has, so that nothing else is compiled in."""
    a = s.assembly
    contact, bond = Features(s.dimension, a.contact_law, a.bond_law).laws()
    fields = contact.PARAMETERS._fields
    tables = np.concatenate([s.table, s.wall_parameters]) if a.walls else s.table
    shear = _any_friction(fields, tables)
    d = s.dimension
    turns = not a.held[:, d:].all() or bool(a.spins.any())
    moment = contact.MOMENT or (bond is not None)
    return Features(
        dimension=d,
        contact_law=a.contact_law,
        bond_law=a.bond_law,
        materials=len(a.material_names),
        shear=shear or bond is not None,
        contact_viscous=bool(getattr(contact, "VISCOUS", False)) and _any_viscosity(fields, tables),
        bond_viscous=bond is not None
        and bool(getattr(bond, "VISCOUS", False))
        and _any_viscosity(bond.PARAMETERS._fields, s.bond_table),
        bonds_scaled=bond is not None and bool((a.bond_scale != 1.0).any()),
        rotation=turns and (shear or moment or bool(a.applied[:, d:].any()) or bool(a.spins.any())),
        orientation=orientation,
        gravity=bool(a.gravity.any()),
        applied=applied or bool(a.applied.any()),
        held=bool(a.held.any()),
        anchors=a.anchors is not None,
        walls=bool(a.walls),
        facets=any(len(wall.segments) or len(wall.triangles) for wall in a.walls),
        walls_turn=any(bool(np.any(wall.spin)) for wall in a.walls),
        local_damping=s.local_damping > 0.0,
        global_damping=s.global_damping > 0.0,
        energy=energy,
        sleep=s.sleep is not None,
        periodic=a.cell is not None,
        blocked=d == 3 and s.parallel and not energy,
        convention=convention,
        joint_laws=() if a.joints is None else a.joints.laws,
    )


def _any_friction(fields: tuple[str, ...], table: Floats) -> bool:
    """Some contact carries shear or moments: laws without a coefficient of friction always do."""
    columns = [k for k, name in enumerate(fields) if "friction" in name or name == "adhesion_shear"]
    return bool(table[:, columns].any()) if columns else True


def _any_viscosity(fields: tuple[str, ...], table: Floats) -> bool:
    """Some dashpot is there: a viscosity that is not zero, or a restitution below one."""
    columns = [k for k, name in enumerate(fields) if name.endswith("_viscosity")]
    bounce = [k for k, name in enumerate(fields) if name == "restitution"]
    return bool(table[:, columns].any()) or bool((table[:, bounce] < 1.0).any())


def first_pairs(s: ParticleSimulation) -> PairList:
    """Near and bonded pairs at the start; bonds carry nothing yet."""
    a, layout = s.assembly, s.layout
    common: dict[str, Any] = {
        "chunk": s.chunk, "buffer": s.buffer, "dimension": s.dimension, "history_width": layout.width,
        "cell": None if s.cell is None else s.cell.lattice(),
    }  # fmt: skip
    if a.bond_law is None or not len(a.bonds):
        return rebuild(s.now, s.arrays.ids, None, **common)
    assert layout.offset is not None
    apart = a.positions[a.bonds[:, 0]] - a.positions[a.bonds[:, 1]]
    distance = np.linalg.norm(apart if a.cell is None else a.cell.nearest(apart), axis=1)
    histories = np.zeros((len(a.bonds), len(layout.bond) + 1))
    histories[:, -1] = distance - a.radii[a.bonds].sum(axis=1)
    return bond_pairs(s.now, s.arrays.ids, a.bonds, histories, offset=len(layout.contact), **common)


def refuse_time_step(given: float | None) -> None:
    """Raise InputError for a time step that is no time."""
    if given is not None and not (math.isfinite(given) and given > 0.0):
        raise InputError("time_step", "this is no time", "Give seconds, more than 0", value=given)


def refuse_anchors(assembly: Assembly) -> None:
    """Raise InputError where a particle has several anchors."""
    if assembly.anchors is None:
        return
    anchored, springs = np.unique(assembly.anchors.particle, return_counts=True)
    if springs.max(initial=0) > 1:
        raise InputError(
            f"particle {int(anchored[np.argmax(springs)])}", "it has more than one anchor",
            "Give it one, or bond it to held particles",
        )  # fmt: skip


def choose_time_step(critical: float, given: float | None) -> float:
    """The given step or a safe one [s]; raises InputError for one that would explode, or where none follows."""
    if given is None:
        if not math.isfinite(critical):
            raise InputError(
                "time_step", "nothing in this scene has a stiffness, so no step follows from it",
                "Give one in seconds",
            )  # fmt: skip
        return SAFETY * critical
    if given > critical:
        raise InputError(
            "time_step", f"this is above the critical time step of {critical:.6g} s, so the motion would explode",
            f"Give {SAFETY * critical:.3g} s, or leave it out", value=given,
        )  # fmt: skip
    return float(given)


def choose_servo_gains(s: ParticleSimulation) -> None:
    """Gains of servos that were given none, from the stiffness of the contacts that touch their walls now.

    Of a cell's, from that of all pairs listed.
    """
    if s.cell is not None and s.cell.servo:
        s.cell.set_gain(contact_modulus(s), s.time_step)
    if any(wall.servo is not None and wall.servo.gain is None for wall in s.assembly.walls):
        links = current_links(s, walls_only=True)
        one = float(links.kn.max()) if len(links.kn) else float(s.table[:, 0].max())
        total = contact_sum(s.walls, s.wall_pairs, np.full(len(s.wall_pairs.particle), one))
        set_servo_gains(s.walls, s.assembly.walls, np.maximum(total, one), s.time_step)


def hand_over(
    s: ParticleSimulation, pairs: ArrayLike, wall: str | None, history: Mapping[str, ArrayLike]
) -> None:
    """See `ParticleSimulation.hand_over`."""
    if s.features.energy:
        raise InputError(
            "energy",
            "the account cannot know what another motion began with",
            "Leave energy out to hand over",
        )
    n, ids = s.assembly.particles, s.arrays.ids
    given = _particle_numbers(pairs, 2 if wall is None else 1, n)
    if wall is None:
        names = _pair_numbers(np.stack([ids[s.pairs.a], ids[s.pairs.b]], axis=1), n)
        at = _places(names, _pair_numbers(given, n), given)
        # a force on the other of the two is the opposite one; in 2D it is told along a direction that turns round too
        swapped = ids[s.pairs.a[at]] != given[:, 0]
        sign = np.where(swapped & (s.dimension == 3), -1.0, 1.0)
    else:
        w = s.wall_pairs
        own = np.flatnonzero(s.walls.body[w.primitive] == s.walls.index(wall))
        at = own[_places(ids[w.particle[own]], given[:, 0], given)]
        sign = np.ones(len(at))
        w.normal[at, : s.dimension] = wall_normals(s, w.particle[at].astype(np.int64), w.primitive[at])
    if len(np.unique(at)) < len(at):
        raise InputError("pairs", "some of them are there twice", "Give each of them once")
    listed: PairList | WallPairs = s.pairs if wall is None else s.wall_pairs
    law, _ = s.features.laws()
    stored = s.layout.contact
    found = []
    for name, values in history.items():
        columns = [
            k for k, word in enumerate(stored) if word in (name, f"{name}_x", f"{name}_y", f"{name}_z")
        ]
        if name not in (*law.TANGENTIAL, *law.SCALAR, *law.AXIAL) or not columns:
            known = ", ".join((*law.TANGENTIAL, *law.SCALAR, *law.AXIAL)) or "nothing"
            raise InputError(name, f"the law {law.NAME!r} does not remember this", f"It remembers {known}")
        shape = (len(at),) if len(columns) == 1 else (len(at), len(columns))
        numbers = as_numbers(name, values, shape, "numbers")
        if not np.isfinite(numbers).all():
            raise InputError(name, "some of these are not finite", "Give finite numbers in SI units")
        found.append((columns, numbers.reshape(len(at), -1), name in law.TANGENTIAL))
    for columns, numbers, turns in found:
        listed.history[np.ix_(at, np.array(columns))] = (sign[:, None] if turns else 1.0) * numbers
    listed.touching[at] = 1
    s.started = True
    s.lag = s.time_step


def _particle_numbers(given: ArrayLike, columns: int, particles: int) -> NDArray[np.int64]:
    """Particles (k, columns); raises InputError for what is none."""
    wanted = "two numbers a pair" if columns == 2 else "one number a particle"
    try:
        numbers = np.asarray(given)
    except ValueError:
        raise InputError("pairs", "these are not numbers of particles", f"Give {wanted}") from None
    if numbers.size == 0:
        return np.empty((0, columns), dtype=np.int64)
    if numbers.dtype.kind not in "iu" or numbers.ndim != columns or (columns == 2 and numbers.shape[1] != 2):
        raise InputError("pairs", "these are not numbers of particles", f"Give {wanted}")
    bad = numbers[(numbers < 0) | (numbers >= particles)]
    if len(bad):
        problem = f"there are particles 0 to {particles - 1}"
        raise InputError("pairs", problem, "Give numbers of particles", value=int(bad[0]))
    return np.asarray(numbers.reshape(-1, columns), dtype=np.int64)


def _pair_numbers(pairs: NDArray[np.int64], particles: int) -> NDArray[np.int64]:
    """One number (k,) for every pair (k, 2), whichever comes first."""
    return np.asarray(pairs.min(axis=1) * particles + pairs.max(axis=1), dtype=np.int64)


def _places(
    names: NDArray[np.int64], wanted: NDArray[np.int64], given: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Where among `names` the wanted ones are; `given` is for the message."""
    order = np.argsort(names)
    place = np.minimum(np.searchsorted(names[order], wanted), max(len(names) - 1, 0))
    found = names[order][place] == wanted if len(names) else np.zeros(len(wanted), dtype=bool)
    if not found.all():
        problem = "these are not near each other"
        raise InputError(
            "pairs", problem, "Give what touches", value=given[np.flatnonzero(~found)[0]].tolist()
        )
    return np.asarray(order[place])


def begin_account(s: ParticleSimulation) -> None:
    """What was there at the start of the motion; to be called after its first step, whose energies are those.

    Nothing has moved by then, so no work was done: what is stored is given as it is.
    """
    columns = [motion.KINETIC, motion.TOTAL_ELASTIC, motion.ANCHORED, motion.TOTAL_BROKEN]
    s.initial_energy = float(s.sums[:, columns].sum())
    s.sums[:, [motion.TOTAL_FRICTION, motion.TOTAL_VISCOUS]] = 0.0
