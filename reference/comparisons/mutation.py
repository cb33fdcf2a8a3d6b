"""Whether a comparison would see an error of one part in a million: laws and conventions with one formula changed.

A copy of a law's file in which one formula is a millionth larger takes the law's place, and all few-body scenes of
that law are run again beside the other code. Every scene must then be out of bounds under one of the changes at
least, and every change must be seen by one scene at least.
"""

from __future__ import annotations

import importlib.util
import inspect
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from geodem.laws import BOND_LAWS, CONTACT_LAWS
from geodem.laws.convention import CONVENTIONS

from ..backends import BACKENDS
from ..ours_posed import run_posed
from ..posed import Posed, Trajectory
from ..posed_difference import differences
from . import fewbody
from .comparison import Row

MILLIONTH = "1.000001"


class Mutation(NamedTuple):
    """One formula of a law or convention: what follows the place that a pattern finds becomes a millionth larger."""

    law: str
    what: str
    pattern: str
    occurrence: int = 0


MUTATIONS = (
    Mutation("elastic_frictional", "normal force", r"    normal = "),
    Mutation("elastic_frictional", "shear stiffness", r"    x = shear_x \+ "),
    Mutation("elastic_frictional", "friction", r"    limit = "),
    Mutation("hooke_stiffness", "normal force", r"    normal = "),
    Mutation("hooke_stiffness", "shear stiffness", r"    x = shear_x \+ "),
    Mutation("hooke_stiffness", "friction", r"    limit = "),
    Mutation("hooke", "stiffness", r"        16\.0 / 15\.0 \* root \* modulus\n        \* "),
    Mutation(
        "hooke", "damping", r"        4\.0 \* mass_a \* mass_b / \(mass_a \+ mass_b\) \* k\n        \* "
    ),
    Mutation("hooke", "friction", r"    limit = "),
    Mutation("hertz_history", "normal force", r"        2\.0 / 3\.0 \* "),
    Mutation("hertz_history", "damping", r"    share = "),
    Mutation("hertz_history", "shear stiffness", r"    return 2\.0 \* modulus \* root, "),
    Mutation("hertz_history", "friction", r"    limit = "),
    Mutation("cohesive_moments", "normal force", r"    normal = "),
    Mutation("cohesive_moments", "shear stiffness", r"    x = shear_x \+ "),
    Mutation("cohesive_moments", "bending stiffness", r"    bend_stiffness = "),
    Mutation("cohesive_moments", "twisting stiffness", r"    twist_stiffness = "),
    Mutation("jointed_cohesive", "normal force", r"    normal = "),
    Mutation("jointed_cohesive", "shear stiffness", r"    x = shear_x \+ "),
    Mutation("yade", "arms of the slip", r"    return \(radius_a \+ radius_b\) / distance, "),
    Mutation("yade", "arms at walls", r"    return 2\.0 \* radius / \(radius \+ distance\), "),
    Mutation("liggghts", "arms of the slip", r"    return 1\.0, "),
    Mutation("liggghts", "arms at walls", r"    return 1\.0, ", 1),
)
"""A law is named by its NAME, a convention by its own."""


@contextmanager
def mutated(mutation: Mutation) -> Iterator[ModuleType]:
    """The law or convention with one formula changed, in the place of the true one.

    Raises ValueError where the formula is not found: the law was written anew, and its mutations must be, too.
    """
    table = next(table for table in (CONTACT_LAWS, BOND_LAWS, CONVENTIONS) if mutation.law in table)
    law = table[mutation.law]
    text = inspect.getsource(law)
    places = list(re.finditer(mutation.pattern, text))
    if len(places) <= mutation.occurrence:
        raise ValueError(f"law {mutation.law!r} has no formula {mutation.pattern!r}")
    at = places[mutation.occurrence].end()
    changed = f"{text[:at]}{MILLIONTH} * {text[at:]}"
    name = f"{law.__name__}_mutated_{re.sub(r'[^a-z]', '_', mutation.what)}"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name.rsplit('.', 1)[-1]}.py"
        path.write_text(changed)
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
        table[mutation.law] = module
        try:
            yield module
        finally:
            table[mutation.law] = law
            del sys.modules[name]


def scenes_of(mutation: Mutation, code: str) -> list[Posed]:
    """Few-body scenes in which the formula could matter."""
    return [
        one
        for one in fewbody.posed(code)
        if mutation.law in (one.assembly.contact_law, one.assembly.bond_law, one.convention)
        and (one.assembly.bond_law is None or mutation.law in BOND_LAWS)
        and one.assembly.particles < 20
    ]


def seen(mutation: Mutation, scenes: Sequence[Posed], theirs: Sequence[Trajectory]) -> dict[str, float]:
    """Largest difference of every scene under a mutation, infinite where the two do not break alike."""
    with mutated(mutation):
        ours = run_posed(scenes)
    return {
        one.name: max(differences(mine, other, one).values())
        for one, mine, other in zip(scenes, ours, theirs, strict=True)
    }


def compare(codes: Sequence[str]) -> list[Row]:
    """A row for every mutation and for every scene: how far beyond its bound the least visible one is."""
    rows = []
    for code in codes:
        laws, bonds, convention = fewbody.OF_CODE[code]
        scenes = [one for one in fewbody.posed(code) if one.assembly.particles < 20]
        theirs = dict(zip((one.name for one in scenes), BACKENDS[code].run_posed(scenes), strict=True))
        largest = {one.name: 0.0 for one in scenes}
        for mutation in MUTATIONS:
            if mutation.law not in (*laws, *bonds, convention):
                continue
            own = scenes_of(mutation, code)
            found = seen(mutation, own, [theirs[one.name] for one in own])
            for name, difference in found.items():
                largest[name] = max(largest[name], difference)
            rows.append(_row(f"{mutation.law}: {mutation.what} a millionth larger", found, own, theirs, code))
        for one in scenes:
            rows.append(
                _row(f"{one.name}: most visible change", {one.name: largest[one.name]}, [one], theirs, code)
            )
    return rows


def _row(
    name: str, found: dict[str, float], scenes: Sequence[Posed], theirs: dict[str, Trajectory], code: str
) -> Row:
    """Good where the largest difference is out of the bound that a true comparison is held to."""
    worst = max(found.values())
    bound = min(one.bound for one in scenes)
    seen_by = sum(difference > one.bound for one, difference in zip(scenes, found.values(), strict=True))
    example = theirs[scenes[0].name]
    return Row(
        scene=name, code=code, version=example.version, law=example.law,
        quantity=f"seen by {seen_by} of {len(scenes)}, at most {worst:.1e}; bound over difference",
        difference=bound / worst if worst > 0.0 else float("inf"), bound=0.1, steps=fewbody.STEPS,
        particles=max(one.assembly.particles for one in scenes), seconds=0.0,
    )  # fmt: skip
