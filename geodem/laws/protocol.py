"""What a law of contacts or bonds promises, read from its module and checked.

The loops know a law only through this: the names of its functions' arguments say what it needs, the names of
its history what is kept for it between steps.
"""

from __future__ import annotations

import ast
import difflib
import dis
import inspect
import math
import types
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import ModuleType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from .._jit import function_source
from ..errors import InputError, InputErrors

MENU = {
    "overlap": "pressed where positive; of a bond: distance at bonding - distance [m]",
    "approach": "increment of overlap; the whole overlap at the birth of a contact [m]",
    "slip_x": "increment of the tangential displacement of b against a [m]",
    "slip_y": "the same [m]; 0 in 2D",
    "slip_z": "the same [m]; 0 in 2D",
    "twist": "increment of the rotation of b against a about the normal [rad]; 0 in 2D",
    "bend_x": "increment of the rotation of b against a across the normal [rad]; in 2D that in the plane",
    "bend_y": "the same [rad]; 0 in 2D",
    "bend_z": "the same [rad]; 0 in 2D",
    "radius_a": "[m]",
    "radius_b": "[m]; huge for a wall",
    "distance": "of the centres [m]",
    "mass_a": "[kg]",
    "mass_b": "[kg]; huge for a wall",
    "time_step": "[s]",
    "scale": "strength factor of this bond [-]; bonds only",
    "normal_x": "component of the unit vector from a to b [-]",
    "normal_y": "the same [-]",
    "normal_z": "the same [-]; 0 in 2D",
    "rotation_a_x": "increment of the rotation of a in space [rad]; 0 in 2D",
    "rotation_a_y": "the same [rad]; 0 in 2D",
    "rotation_a_z": "the same [rad]",
    "rotation_b_x": "increment of the rotation of b in space [rad]; 0 in 2D",
    "rotation_b_y": "the same [rad]; 0 in 2D",
    "rotation_b_z": "the same [rad]",
    "closing": "increment of overlap by the velocity, also at the birth of a contact [m]",
    "breaking": "utilisation at which bonds break, infinite on the way to an equilibrium [-]; bonds only",
}
"""What a law may ask for, beside its parameters and its history."""

JOINT_MENU = {
    "area": "of the joint's face that the pair stands for [m2]; in 2D per metre of depth [m]",
    "intact": "1 while the face is bonded, else 0 [-]",
}
"""What a law of joints may ask for as well. Its normal is that of the joint."""

IN_SPACE = tuple(MENU)[-11:]
"""Those of them that `force` alone may ask for; a law that does is computed pair by pair."""

_STATIC = ("radius_a", "radius_b", "distance")
_MASSES = ("mass_a", "mass_b")
# function -> what it may ask for beside the parameters; True: the history as well
_ASKS: dict[str, tuple[tuple[str, ...], bool]] = {
    "force": (tuple(MENU), True),
    "viscous": (tuple(name for name in MENU if name != "scale" and name not in IN_SPACE), True),
    "energy": (("overlap", *_STATIC, *_MASSES), True),
    "stiffness": (("overlap", *_STATIC, *_MASSES), False),
    "reach": (("radius_a", "radius_b"), False),
    "bonded": (_STATIC, False),
}

_BOTH = (
    "NAME", "PARAMETERS", "DIMENSIONS", "SCALAR", "TANGENTIAL", "AXIAL", "MOMENT",
    "force", "energy", "stiffness", "combine", "against_rigid", "check",
)  # fmt: skip
_BONDS = ("REPLACES_CONTACT", "bonded")
_OF_MATERIALS = ("combine", "against_rigid")

Floats = NDArray[np.float64]


def argument_names(function: Callable[..., Any]) -> tuple[str, ...]:
    """Names of a law function's arguments, in order."""
    return tuple(inspect.signature(function).parameters)


def history_arguments(law: ModuleType) -> tuple[str, ...]:
    """Names by which a law's functions take and return its history: SCALAR, TANGENTIAL (x, y, z each), AXIAL."""
    vectors = (f"{name}_{axis}" for name in law.TANGENTIAL for axis in "xyz")
    return (*law.SCALAR, *vectors, *law.AXIAL)


def history_names(law: ModuleType, dimension: int) -> tuple[str, ...]:
    """Names of the history that is kept between steps, in order, a part of `history_arguments`.

    In 2D of a tangential vector only the component x, and nothing axial; what is not kept is 0.
    """
    if dimension == 3:
        return history_arguments(law)
    return (*law.SCALAR, *(f"{name}_x" for name in law.TANGENTIAL))


def constants(law: ModuleType, dimension: int) -> dict[str, bool | int | float]:
    """Module constants that a law's functions use, for the kernel's module; ``SPHERES`` = (dimension == 3)."""
    functions = [getattr(law, function) for function in _ASKS if hasattr(law, function)]
    names = {name for function in functions for name in _globals(function)}
    found = {name: getattr(law, name) for name in sorted(names) if name.isupper()}
    if "SPHERES" in found:
        found["SPHERES"] = dimension == 3
    return found


def sources(law: ModuleType, functions: Iterable[str]) -> dict[str, str]:
    """Texts of a law's functions and of those of its module that they call, by name, callees first.

    What the law lacks is left out.
    """
    found: dict[str, str] = {}

    def collect(name: str) -> None:
        function = getattr(law, name, None)
        if (
            name in found
            or not isinstance(function, types.FunctionType)
            or function.__module__ != law.__name__
        ):
            return
        for called in function.__code__.co_names:
            collect(called)
        found[name] = function_source(function)

    for name in functions:
        collect(name)
    return found


def in_dimension(function: Callable[..., Any], dimension: int) -> Callable[..., Any]:
    """A law's plain function with the constant ``SPHERES`` set to ``dimension == 3``, as in a kernel's module."""
    return types.FunctionType(
        function.__code__,
        {**function.__globals__, "SPHERES": dimension == 3},
        function.__name__,
        function.__defaults__,
    )


def make_parameters(law: ModuleType, given: Mapping[str, float], place: str) -> Any:
    """A law's parameter tuple from what a user gives.

    Parameters
    ----------
    law : module
        One of `geodem.laws.CONTACT_LAWS` or `geodem.laws.BOND_LAWS`.
    given : mapping of str to float
        Values in SI by parameter name.
    place : str
        Dotted key that the values stand under, for messages.

    Raises
    ------
    InputError
        A name that the law does not know, one that is missing, or a value out of range; several at once are
        raised as `geodem.errors.InputErrors`.
    """
    known: tuple[str, ...] = law.PARAMETERS._fields
    found: list[InputError] = []
    for name in given:
        if name not in known:
            near = difflib.get_close_matches(name.lower().replace("-", "_"), known, n=1, cutoff=0.5)
            hint = f'Did you mean "{near[0]}"? ' if near else ""
            problem = f'law "{law.NAME}" has no parameter of this name'
            found.append(InputError(_join(place, name), problem, f"{hint}It takes {_listed(known)}"))
    missing = [name for name in known if name not in given and name not in law.PARAMETERS._field_defaults]
    for name in missing:
        found.append(
            InputError(_join(place, name), f'law "{law.NAME}" needs it', "Give a number in SI units")
        )
    values: dict[str, float] = {}
    for name in known:
        if name in given:
            number = _number(given[name])
            if number is None:
                problem = "must be a number"
                remedy = "Give a number in SI units"
                found.append(InputError(_join(place, name), problem, remedy, value=given[name]))
            else:
                values[name] = number
    # what is missing or no number stands as 1 here, so that the other values are looked at as well
    parameters = law.PARAMETERS(**{name: 1.0 for name in known if name not in law.PARAMETERS._field_defaults})
    for field, problem, remedy in law.check(parameters._replace(**values)):
        if field in values:
            found.append(InputError(_join(place, field), problem, remedy, value=values[field]))
    if found:
        raise found[0] if len(found) == 1 else InputErrors(found)
    return parameters._replace(**values)


def check_law(law: ModuleType, kind: Literal["contact", "bond", "joint"]) -> None:
    """Check that a module offers what a law must.

    Raises
    ------
    InputError
        Names the law, the function or constant, and what is wrong with it.
    """
    name = getattr(law, "NAME", law.__name__)
    place = f"{kind} law {name}"
    offers = (*_BOTH, *(_BONDS if kind == "bond" else ()))
    if kind == "joint":
        offers = (*(offer for offer in _BOTH if offer not in _OF_MATERIALS), "starts_bonded", "LASTING")
    if getattr(law, "VISCOUS", False):
        offers = (*offers, "viscous")
    missing = [offer for offer in offers if not hasattr(law, offer)]
    if missing:
        raise InputError(place, f"does not offer {_listed(missing)}", "See docs/how-to/add-a-law.md")
    if not law.DIMENSIONS or not set(law.DIMENSIONS) <= {2, 3}:
        raise InputError(f"{place}: DIMENSIONS", "must name 2, 3 or both", "For example (2, 3)")
    history = history_arguments(law)
    parameters: tuple[str, ...] = law.PARAMETERS._fields
    twice = [word for word in (*parameters, *history) if (*parameters, *history, *MENU).count(word) > 1]
    if twice:
        problem = f"{_listed(dict.fromkeys(twice))} stands for two things"
        raise InputError(place, problem, "Give parameters and history names that the menu does not have")
    if kind == "contact" and law.TANGENTIAL and law.TANGENTIAL[0] != "shear":
        remedy = 'The first is "shear", the elastic shear force on a [N], which a broken bond hands over'
        raise InputError(f"{place}: TANGENTIAL", "does not begin with the shear force", remedy)
    for function, (menu, with_history) in _ASKS.items():
        if hasattr(law, function):
            allowed = (*parameters, *menu, *(history if with_history else ()))
            if kind == "joint":
                allowed = (*(word for word in allowed if word not in IN_SPACE), *JOINT_MENU)
            if kind == "contact":
                allowed = tuple(word for word in allowed if word not in ("scale", "breaking"))
            _check_arguments(f"{place}: {function}", getattr(law, function), allowed)
            _check_globals(f"{place}: {function}", law, getattr(law, function))
    moments = 4 if law.MOMENT else 0
    returned = {
        "force": 4 + moments + len(history) + (0 if kind == "contact" else 2),
        "viscous": 4,
        "stiffness": 4,
        "bonded": len(history),
    }
    for function, count in returned.items():
        if hasattr(law, function):
            _check_return(f"{place}: {function}", getattr(law, function), count)


def _check_arguments(place: str, function: Callable[..., Any], allowed: Sequence[str]) -> None:
    for name in argument_names(function):
        if name not in allowed:
            near = difflib.get_close_matches(name, allowed, n=1, cutoff=0.5)
            hint = f'Did you mean "{near[0]}"? ' if near else ""
            raise InputError(place, f'asks for "{name}"', f"{hint}It may ask for {_listed(allowed)}")


def _globals(function: Callable[..., Any]) -> list[str]:
    """Names that a function takes from its module, in order."""
    found = (step.argval for step in dis.get_instructions(function) if step.opname == "LOAD_GLOBAL")
    return list(dict.fromkeys(found))


def _check_globals(place: str, law: ModuleType, function: Callable[..., Any]) -> None:
    """Its text is joined into a generated module, where nothing else of the law's file is known."""
    for name in _globals(function):
        found = getattr(law, name, None)
        constant = name.isupper() and isinstance(found, bool | int | float)
        own = isinstance(found, types.FunctionType) and found.__module__ == law.__name__
        if not constant and not own and name not in ("math", "abs"):
            remedy = (
                "It may use math, abs, its arguments, and numbers in CAPITALS and functions of its own module"
            )
            raise InputError(place, f'uses "{name}"', remedy)


def _check_return(place: str, function: Callable[..., Any], count: int) -> None:
    """One return at the end, of a flat tuple: a loop over many pairs at once knows no early return."""
    tree = ast.parse(function_source(function))
    returns = [node for node in ast.walk(tree) if isinstance(node, ast.Return)]
    body = tree.body[0].body if isinstance(tree.body[0], ast.FunctionDef) else []
    if len(returns) != 1 or not body or body[-1] is not returns[0]:
        raise InputError(
            place, "returns at several places", "Return once, at the end; choose with a if c else b"
        )
    answer = returns[0].value
    if not isinstance(answer, ast.Tuple) or len(answer.elts) != count:
        found = len(answer.elts) if isinstance(answer, ast.Tuple) else "no tuple"
        raise InputError(
            place, f"must return a flat tuple of {count}", "See docs/how-to/add-a-law.md", value=found
        )


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _join(place: str, name: str) -> str:
    return f"{place}.{name}" if place else name


def _listed(words: Iterable[str]) -> str:
    return ", ".join(f'"{word}"' for word in words) or "none"
