"""Adapters between the loops, which know geometry, and the laws, which name what they need.

A law asks for its arguments by name (see `geodem.laws`). The loops always call ``contact(...)`` or ``bond(...)``
with everything there is; the text written here picks out what the law of the scene asked for, and the compiler
drops the rest. In 2D the components y and z of a history are zero and not stored, and what turns about the normal
does not exist.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from types import ModuleType
from typing import NamedTuple

from .._jit import function_source
from ..laws.convention import FUNCTIONS as CONVENTION_FUNCTIONS
from ..laws.protocol import IN_SPACE, argument_names, history_arguments, history_names, sources
from .blocks import BESIDE_AFTER, BESIDE_SLOT, HISTORY_SLOT

FORWARD = ("overlap", "approach", "slip_x", "slip_y", "slip_z", "twist", "bend_x", "bend_y", "bend_z")
SIZES = ("radius_a", "radius_b", "distance")
MASSES = ("mass_a", "mass_b")
BODIES = (*MASSES, "time_step")
AXES = ("x", "y", "z")


class HistoryLayout(NamedTuple):
    """Columns of a pair's history.

    Attributes
    ----------
    contact, bond : tuple of str
        Names of the stored values, in the order of their columns; the contact's come first.
    offset : int or None
        Column of the distance at bonding - ra - rb; None where nothing is bonded.
    stored : int or None
        First column of the energy account; None where there is none.
    width : int
    joint : int
        How many numbers laws of joints remember, in the columns before `width`.
    place : int or None
        First column of what is kept of a joint, see `geodem.kernels.joints`; None where a scene has none.
    """

    contact: tuple[str, ...]
    bond: tuple[str, ...]
    offset: int | None
    stored: int | None
    width: int
    joint: int = 0
    place: int | None = None


def history_layout(
    contact: ModuleType,
    bond: ModuleType | None,
    *,
    dimension: int,
    energy: bool,
    shear: bool = True,
    joints: Sequence[ModuleType] = (),
) -> HistoryLayout:
    """Columns of the history of a scene's pairs; without `shear` the contact law stores no tangential history."""
    contact_names = history_names(contact, dimension)
    if not shear:
        dropped = tuple(f"{name}_{axis}" for name in contact.TANGENTIAL for axis in AXES)
        contact_names = tuple(name for name in contact_names if name not in dropped)
    bond_names = history_names(bond, dimension) if bond is not None else ()
    width = len(contact_names) + len(bond_names)
    offset = stored = None
    if bond is not None:
        offset, width = width, width + 1
    if energy:
        stored, width = width, width + (14 if dimension == 3 else 7)
    if not joints:
        return HistoryLayout(contact_names, bond_names, offset, stored, max(width, 1))
    kept = max(len(history_names(law, dimension)) for law in joints)
    place, width = width, width + joint_columns(dimension) + kept
    return HistoryLayout(contact_names, bond_names, offset, stored, width, kept, place)


def joint_columns(dimension: int) -> int:
    """Columns of a joint before what its law remembers."""
    return dimension + 3


def law_text(law: ModuleType, functions: Sequence[str], prefix: str) -> list[str]:
    """Sources of a law's functions and of those of its module that they call, each name with a prefix."""
    found = sources(law, functions)
    renamed = []
    for text in found.values():
        for name in found:
            text = re.sub(rf"\b{name}\(", f"{prefix}_{name}(", text)
        renamed.append(text)
    return renamed


def module_constants(*modules: ModuleType) -> dict[str, object]:
    """Constants, numbers and truths in capital letters, of modules that loops are defined in.

    Raises
    ------
    ValueError
        Two modules mean different things by one name.
    """
    constants: dict[str, object] = {}
    for module in modules:
        for name, value in vars(module).items():
            if re.fullmatch(r"[A-Z][A-Z0-9_]*", name) and isinstance(value, bool | int | float):
                if constants.get(name, value) != value:
                    raise ValueError(
                        f"{name} is {constants[name]} elsewhere and {value} in {module.__name__}"
                    )
                constants[name] = value
    return constants


def _function(name: str, arguments: Sequence[str], lines: Sequence[str]) -> str:
    return "\n".join([f"def {name}({', '.join(arguments)}):", *(f"    {line}" for line in lines)])


def _tuple(values: Sequence[str]) -> str:
    return "(" + "".join(f"{value}, " for value in values).rstrip() + ")" if values else "()"


def _call(
    law: ModuleType,
    name: str,
    prefix: str,
    fields: Sequence[str],
    history: Sequence[str],
    menu: Sequence[str],
) -> str:
    """Call of a law's function with the arguments that its signature names."""
    places = {field: f"parameters[{k}]" for k, field in enumerate(fields)}
    places |= {value: f"history[{k}]" for k, value in enumerate(history)}
    places |= {value: value for value in menu}
    places |= {value: f"space[{k}]" for k, value in enumerate(IN_SPACE)}
    wanted = argument_names(getattr(law, name))
    # a component that the dimension lacks is zero and not stored
    arguments = [places.get(argument, "0.0") for argument in wanted]
    return f"{prefix}_{name}({', '.join(arguments)})"


def _store(name: str, history: Sequence[str], first: int) -> list[str]:
    load = _function(
        f"load_{name}",
        ["history", "p"],
        [f"return {_tuple([f'history[p, {first + k}]' for k in range(len(history))])}"],
    )
    stores = [f"history[p, {first + k}] = values[{k}]" for k in range(len(history))]
    return [load, _function(f"store_{name}", ["history", "p", "values"], stores or ["pass"])]


def _lane(name: str, history: Sequence[str], first: int, *, beside: bool = False) -> list[str]:
    """A lane of a block as the law wants it, and its way from and to the history of a pair.

    With `beside` for a contact whose lane is shared with a bond: in rows of their own.
    """
    slots = [(BESIDE_SLOT if beside else HISTORY_SLOT) + k for k in range(len(history))]
    fours = 0 if beside else (HISTORY_SLOT + len(history)) // 4 * 4
    first_after = BESIDE_AFTER if beside else 0
    before = [
        f"block[{s // 4 * 4} * LANES + 4 * lane + {s % 4}]" if s < fours else f"block[{s} * LANES + lane]"
        for s in slots
    ]
    after = [f"block[AFTER + {first_after + k} * LANES + lane]" for k in range(len(history))]
    columns = [f"history[p, {first + k}]" for k in range(len(history))]
    gathered = [f"{lane} = {column}" for lane, column in zip(before, columns, strict=True)]
    scattered = [f"{column} = {row}" for row, column in zip(after, columns, strict=True)]
    pair = ["block", "lane", "history", "p"]
    return [
        _function(f"load_{name}_lane", ["block", "lane"], [f"return {_tuple(before)}"]),
        _function(
            f"store_{name}_lane",
            ["block", "lane", "values"],
            [f"{row} = values[{k}]" for k, row in enumerate(after)] or ["pass"],
        ),
        _function(f"gather_{name}", pair, gathered or ["pass"]),
        _function(f"scatter_{name}", pair, scattered or ["pass"]),
    ]


def _transport(name: str, law: ModuleType, history: Sequence[str], dimension: int) -> str:
    """Turn the tangential vectors with the contact's frame (3D), as the convention does."""
    arguments = ["values", "nx", "ny", "nz", "turn_x", "turn_y", "turn_z", "spin"]
    lines: list[str] = []
    result = {value: f"values[{k}]" for k, value in enumerate(history)}
    for vector in law.TANGENTIAL if dimension == 3 else ():
        if f"{vector}_x" not in result:
            continue
        names = [f"{vector}_{axis}" for axis in AXES]
        given = ", ".join([*(result[name] for name in names), *arguments[1:]])
        lines.append(f"{', '.join(names)} = transported({given})")
        result |= {name: name for name in names}
    return _function(
        f"transport_{name}", arguments, [*lines, f"return {_tuple([result[v] for v in history])}"]
    )


def _law_adapter(
    name: str, law: ModuleType, prefix: str, history: Sequence[str], menu: Sequence[str], extra: Sequence[str]
) -> str:
    fields = law.PARAMETERS._fields
    forces = ["normal", "shear_force_x", "shear_force_y", "shear_force_z"]
    moments = ["twist_moment", "bend_moment_x", "bend_moment_y", "bend_moment_z"]
    returned = history_arguments(law)
    targets = forces + (moments if law.MOMENT else []) + [f"new_{value}" for value in returned] + list(extra)
    lines = [f"{', '.join(targets)} = {_call(law, 'force', prefix, fields, history, menu)}"]
    values = [*forces, *(moments if law.MOMENT else ["0.0"] * 4)]
    values += [_tuple([f"new_{value}" for value in history]), *extra]
    lines.append(f"return {', '.join(values)}")
    return _function(name, ["parameters", *menu, "space", "history"], lines)


def _parameters_adapter(name: str, law: ModuleType) -> str:
    count = len(law.PARAMETERS._fields)
    return _function(name, ["table", "row"], [f"return {_tuple([f'table[row, {k}]' for k in range(count)])}"])


def contact_adapters(
    law: ModuleType, *, name: str, dimension: int, layout: HistoryLayout, viscous: bool
) -> tuple[list[str], list[str]]:
    """Texts of a contact law's functions and of the adapters between them and the loops.

    Parameters
    ----------
    name : str
        "contact" for pairs, "wall" for walls; functions are called ``contact``, ``load_contact`` and so on.
    """
    menu = (*FORWARD, *SIZES, *BODIES)
    wanted = [
        "force",
        "energy",
        *(["viscous"] if viscous else []),
        *(["reach"] if hasattr(law, "reach") else []),
    ]
    prefix = f"{name}_law"
    fields, history = law.PARAMETERS._fields, layout.contact
    adapters = [_parameters_adapter(f"{name}_parameters", law)]
    adapters.append(_law_adapter(name, law, prefix, history, menu, ()))
    quiet = "0.0, 0.0, 0.0, 0.0"
    call = _call(law, "viscous", prefix, fields, (), menu) if viscous else quiet
    rates = ("overlap", "approach", "slip_x", "slip_y", "slip_z", *SIZES, *BODIES)
    adapters.append(_function(f"{name}_viscous", ["parameters", *rates], [f"return {call}"]))
    energy = _call(law, "energy", prefix, fields, history, ("overlap", *SIZES, *MASSES))
    adapters.append(
        _function(
            f"{name}_energy",
            ["parameters", "overlap", *SIZES, *MASSES, "history"],
            [f"return {energy}"],
        )
    )
    reach = (
        _call(law, "reach", prefix, fields, (), ("radius_a", "radius_b")) if hasattr(law, "reach") else "0.0"
    )
    adapters.append(_function(f"{name}_reach", ["parameters", "radius_a", "radius_b"], [f"return {reach}"]))
    adapters += _store(name, history, 0)
    adapters += _lane(name, history, 0)
    adapters += _lane(f"beside_{name}", history, 0, beside=True)
    where = _tuple([f"(values[{k}] if touch else 0.0)" for k in range(len(history))])
    adapters.append(_function(f"{name}_where", ["touch", "values"], [f"return {where}"]))
    adapters.append(_function(f"no_{name}", [], [f"return {_tuple(['0.0'] * len(history))}"]))
    sheared = [
        {"shear_x": "shear_x", "shear_y": "shear_y", "shear_z": "shear_z"}.get(value, f"values[{k}]")
        for k, value in enumerate(history)
    ]
    adapters.append(
        _function("with_shear", ["values", *(f"shear_{a}" for a in AXES)], [f"return {_tuple(sheared)}"])
    )
    adapters.append(_transport(name, law, history, dimension))
    return law_text(law, wanted, prefix), adapters


def bond_adapters(
    law: ModuleType, *, dimension: int, layout: HistoryLayout, viscous: bool
) -> tuple[list[str], list[str]]:
    """Texts of a bond law's functions and of the adapters between them and the loops."""
    menu = (*FORWARD, *SIZES, *BODIES, "scale")
    wanted = ["force", "energy", *(["viscous"] if viscous else [])]
    fields, history = law.PARAMETERS._fields, layout.bond
    adapters = [_parameters_adapter("bond_parameters", law)]
    adapters.append(
        _law_adapter("bond", law, "bond_law", history, menu, ("tension_utilisation", "shear_utilisation"))
    )
    call = _call(law, "viscous", "bond_law", fields, (), menu) if viscous else "0.0, 0.0, 0.0, 0.0"
    rates = ("overlap", "approach", "slip_x", "slip_y", "slip_z", *SIZES, *BODIES)
    adapters.append(_function("bond_viscous", ["parameters", *rates], [f"return {call}"]))
    energy = _call(law, "energy", "bond_law", fields, history, ("overlap", *SIZES, *MASSES))
    adapters.append(
        _function(
            "bond_energy",
            ["parameters", "overlap", *SIZES, *MASSES, "history"],
            [f"return {energy}"],
        )
    )
    adapters += _store("bond", history, len(layout.contact))
    adapters += _lane("bond", history, len(layout.contact))
    adapters.append(_transport("bond", law, history, dimension))
    return law_text(law, wanted, "bond_law"), adapters


def joint_adapters(
    laws: Sequence[ModuleType], *, dimension: int, layout: HistoryLayout
) -> tuple[list[str], list[str]]:
    """Texts of the functions of laws of joints and of the adapters between them and the loops.

    The first of a pair's parameters is the number of its law.
    """
    assert layout.place is not None
    menu = ("overlap", "slip_x", "slip_y", "slip_z", "area", "intact", "scale")
    width = 1 + max(len(law.PARAMETERS._fields) for law in laws)
    columns = [f"remembered_{k}" for k in range(layout.joint)]
    row = _tuple([f"table[row, {k}]" for k in range(width)])
    adapters = [_function("joint_parameters", ["table", "row"], [f"return {row}"])]
    texts: list[str] = []
    for number, law in enumerate(laws):
        prefix, fields = f"joint_law_{number}", ("", *law.PARAMETERS._fields)
        history = history_names(law, dimension)
        texts += law_text(law, ["force", "energy"], prefix)
        returned = [f"new_{name}" for name in history_arguments(law)]
        targets = ["normal", "x", "y", "z", *returned, "tension", "cut"]
        kept = [f"new_{name}" for name in history] + ["0.0"] * (layout.joint - len(history))
        call = _call(law, "force", prefix, fields, history, menu)
        lines = [f"{', '.join(targets)} = {call}", f"return normal, x, y, z, {_tuple(kept)}, tension, cut"]
        adapters.append(_function(f"joint_{number}", ["parameters", *menu, "history"], lines))
        energy = _call(law, "energy", prefix, fields, history, ("overlap", "area", "intact"))
        arguments = ["parameters", "overlap", "area", "intact", "history"]
        adapters.append(_function(f"joint_energy_{number}", arguments, [f"return {energy}"]))
    for name, arguments in (
        ("joint", ["parameters", *menu, "history"]),
        ("joint_energy", ["parameters", "overlap", "area", "intact", "history"]),
    ):
        given = ", ".join(arguments)
        lines = []
        for number in range(len(laws) - 1):
            lines += [f"if parameters[0] == {number}.0:", f"    return {name}_{number}({given})"]
        adapters.append(_function(name, arguments, [*lines, f"return {name}_{len(laws) - 1}({given})"]))
    adapters += _store("joint", columns, layout.place + joint_columns(dimension))
    return texts, adapters


def convention_texts(convention: ModuleType) -> list[str]:
    """Texts of a convention's functions, callees first."""
    return [function_source(getattr(convention, name)) for name in CONVENTION_FUNCTIONS]


def no_bond_adapters() -> list[str]:
    """Stand-ins where a scene has no bonds: never called, but named in the loops."""
    names = [
        "bond_parameters",
        "bond",
        "bond_viscous",
        "bond_energy",
        "load_bond",
        "store_bond",
        "transport_bond",
    ]
    names += ["load_bond_lane", "store_bond_lane", "gather_bond", "scatter_bond"]
    return [f"{name} = None" for name in names]


def wall_adapters(
    law: ModuleType, *, dimension: int, layout: HistoryLayout, viscous: bool
) -> tuple[list[str], list[str]]:
    """Texts of the contact law's functions and of the adapters between them and the loops over walls."""
    functions, adapters = contact_adapters(
        law, name="wall", dimension=dimension, layout=layout, viscous=viscous
    )
    # who hands a shear force over is a pair
    return functions, [text for text in adapters if not text.startswith("def with_shear")]
