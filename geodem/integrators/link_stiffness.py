"""Stiffness and damping of many links from the law of contacts or bonds."""

from __future__ import annotations

from functools import cache
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from .._jit import compile_kernel
from ..laws.protocol import argument_names, constants, in_dimension, sources

Floats = NDArray[np.float64]

COMPILED_FROM = 20_000
"""Links from which on the law is compiled into a loop: fewer are done before a compiler has looked at it."""

SIZES = ("radius_a", "radius_b", "distance", "overlap", "mass_a", "mass_b")


def law_stiffness(
    law: ModuleType,
    dimension: int,
    parameters: Floats,
    *,
    radius_a: Floats,
    radius_b: Floats,
    distance: Floats,
    overlap: Floats,
    mass_a: Floats | None = None,
    mass_b: Floats | None = None,
) -> Floats:
    """kn, ks [N/m], k_twist, k_bend [N m/rad] of every link (p, 4).

    Parameters
    ----------
    law : module
        One of `geodem.laws.CONTACT_LAWS` or `geodem.laws.BOND_LAWS`.
    dimension : int
        2 or 3.
    parameters : (p, k) or (1, k)
        In the order of ``law.PARAMETERS``; one row for all links that are alike.
    radius_a, radius_b, distance, overlap : (p,) [m]
    mass_a, mass_b : (p,) [kg], optional
        Only some laws ask for them.
    """
    parameters = np.asarray(parameters, dtype=np.float64)
    # a law that does not ask for masses is given something of the right length
    given = (radius_a, radius_b, distance, overlap, radius_a if mass_a is None else mass_a,
             radius_b if mass_b is None else mass_b)  # fmt: skip
    sizes = [np.asarray(values, dtype=np.float64) for values in given]
    count = len(sizes[0])
    if mass_a is None or mass_b is None:
        assert not {"mass_a", "mass_b"} & set(argument_names(law.stiffness)), f"{law.NAME} asks for masses"
    if count >= COMPILED_FROM:
        found = np.empty((count, 4))
        _kernel(law, dimension).of_links(
            np.ascontiguousarray(parameters), *(np.ascontiguousarray(values) for values in sizes), found
        )
        return found
    parameters = np.broadcast_to(parameters, (count, parameters.shape[1]))
    columns = dict(zip(law.PARAMETERS._fields, parameters.T, strict=True))
    columns |= dict(zip(SIZES, sizes, strict=True))
    wanted = [columns[name].tolist() for name in argument_names(law.stiffness)]
    function = in_dimension(law.stiffness, dimension)
    rows = [function(*values) for values in zip(*wanted, strict=True)]
    return np.array(rows, dtype=float).reshape(count, 4)


MOVING = {"approach": 1.0, "closing": 1.0, "slip_x": 1.0, "friction_coefficient": 1e30}
"""One metre a step along the normal and across it, and nothing slides."""


def law_damping(law: ModuleType, dimension: int, parameters: Floats, **sizes: Floats) -> Floats:
    """cn, cs [N s/m] of the dashpots of every link, and two zeros (p, 4); arguments as in `law_stiffness`.

    A dashpot's force is the part that doubles where the same way is gone in half the time.
    """
    count = len(sizes["overlap"])
    given = np.broadcast_to(np.asarray(parameters, dtype=float), (count, np.shape(parameters)[1]))
    columns = {**dict(zip(law.PARAMETERS._fields, given.T, strict=True)), **sizes}
    columns |= {name: np.full(count, value) for name, value in MOVING.items()}
    function = law.viscous if law.VISCOUS else law.force
    plain = in_dimension(function, dimension)
    found = np.zeros((2, count, 4))
    for half, time_step in enumerate((1.0, 0.5)):
        columns["time_step"] = np.full(count, time_step)
        wanted = [columns.get(name, np.zeros(count)).tolist() for name in argument_names(function)]
        for link, values in enumerate(zip(*wanted, strict=True)):
            found[half, link, :2] = plain(*values)[:2]
    return np.asarray(found[1] - found[0])


@cache
def _kernel(law: ModuleType, dimension: int) -> ModuleType:
    """The law's function and a loop over links that feeds it."""
    asked = [
        f"{name}[i]" if name in SIZES else f"parameters[k, {law.PARAMETERS._fields.index(name)}]"
        for name in argument_names(law.stiffness)
    ]
    loop = f"""\
@njit(cache=True, error_model='numpy')
def of_links(parameters, {", ".join(SIZES)}, found):
    for i in range(len(found)):
        k = min(i, len(parameters) - 1)
        found[i, 0], found[i, 1], found[i, 2], found[i, 3] = stiffness({", ".join(asked)})
"""
    texts = [*sources(law, ["stiffness"]).values(), loop]
    return compile_kernel([], constants(law, dimension), parallel=False, texts=texts)
