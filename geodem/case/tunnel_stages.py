"""The stages of a tunnel case, and whether they can follow each other."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from geodem.case.table import Table, listed, nearest
from geodem.case.tunnel import BoltPattern, Excavation
from geodem.tunnelling.plan import Lining, Stage

KEYS = ("name", "excavate", "install", "excavation", "relax", "pressure")
_EXAMPLE = '{excavate = "tunnel", relax = 0.4}'


@dataclass
class _Site:
    """What stands so far."""

    dug: list[str] = field(default_factory=list)
    installed: list[str] = field(default_factory=list)
    relaxed: dict[str, float] = field(default_factory=dict)
    mistaken: frozenset[str] = frozenset()  # supports that could not be read, which has been told


def read_stages(
    top: Table,
    excavations: Sequence[Excavation],
    linings: Sequence[Lining],
    bolts: Sequence[BoltPattern],
) -> tuple[Stage, ...]:
    """The stages in their order."""
    names = tuple(entry.name for entry in excavations)
    walls = {entry.name: entry.opening for entry in linings}
    supports: dict[str, str | None] = {**walls, **{entry.name: entry.excavation for entry in bolts}}
    for name in set(names) & set(supports):
        top.findings.error("stage", f"{name!r} is the name of an excavation and of a support", "Rename one.")
    if "stage" not in top:
        top.missing("stage", f"Add [[stage]] as in {_EXAMPLE}, then one with relax = 1.")
        return ()
    site = _Site(mistaken=_named_in(top, "lining") | _named_in(top, "bolt"))
    stages = []
    for number, row in enumerate(top.rows("stage", KEYS, example=_EXAMPLE)):
        stage = _stage(row, number, names, supports, site)
        if stage is not None:
            stages.append(stage)
    for name in names:
        if name not in site.dug:
            top.findings.error(
                "stage", f"no stage excavates {name!r}", f'Write excavate = "{name}", or remove it.'
            )
    for name in supports:
        if name not in site.installed:
            top.findings.error(
                "stage", f"no stage installs {name!r}", f'Write install = "{name}", or remove it.'
            )
    left = [name for name in site.dug if site.relaxed[name] < 1.0]
    if left and not top.findings.errors:
        top.findings.questions.append(
            f"The last stage leaves forces on the wall of {listed(left)}: relax = 1 would take them away."
        )
    return tuple(stages)


def _stage(
    row: Table, number: int, names: tuple[str, ...], supports: dict[str, str | None], site: _Site
) -> Stage | None:
    before = len(row.findings.errors)
    title = row.text("name", remedy='Write name = "top heading".') or f"stage {number + 1}"
    excavate = _named(row, "excavate", names, "excavation")
    for name in excavate:
        if name in site.dug:
            row.error("excavate", f"{name!r} is out already", "Excavate it once.")
        else:
            site.dug.append(name)
            site.relaxed[name] = 0.0
    install = _named(row, "install", tuple(supports), "lining or bolt", site.mistaken)
    for name in install:
        wall = supports[name]
        if wall is not None and wall not in site.dug:
            row.error(
                "install", f"{name!r} stands on the wall of {wall!r}, which is not excavated yet",
                "Put this stage after the one that excavates it.",
            )  # fmt: skip
        elif wall is None and not site.dug:
            row.error("install", f"nothing is excavated where {name!r} could begin", "Excavate first.")
        if name in site.installed:
            row.error("install", f"{name!r} stands already", "Install it once.")
        site.installed.append(name)
    opening = _opening(row, names, site)
    relax = row.quantity("relax", "dimensionless", check=_share)
    pressure = row.quantity("pressure", "stress", check=_not_negative)
    if (relax is not None or pressure is not None) and not site.dug:
        row.findings.error(row.place, "nothing is excavated that could be relaxed", "Excavate first.")
    for name in [opening] if opening is not None else site.dug:
        if relax is not None and relax < site.relaxed.get(name, 0.0):
            row.error(
                "relax", f"the forces of {name!r} are relaxed by {site.relaxed[name]:g} already; they do not come back",
                "Let relax grow from stage to stage.",
            )  # fmt: skip
        elif relax is not None:
            site.relaxed[name] = relax
    if not (excavate or row.content.get("install") or relax is not None or pressure is not None):
        row.findings.error(row.place, "nothing happens in this stage", f"Write for instance {_EXAMPLE}.")
    if len(row.findings.errors) > before:
        return None
    return Stage(title, excavate, install, opening, relax, pressure)


def _named_in(top: Table, key: str) -> frozenset[str]:
    """Names of the tables of a list, whatever else is wrong with them."""
    content = top.content.get(key)
    rows = content if isinstance(content, list) else [content]
    names = [row.get("name") for row in rows if isinstance(row, dict)]
    return frozenset(name for name in names if isinstance(name, str))


def _named(
    row: Table, key: str, known: tuple[str, ...], what: str, mistaken: Collection[str] = ()
) -> tuple[str, ...]:
    """A name or a list of names; nothing is said of those in `mistaken`."""
    value = row.content.get(key)
    if value is None:
        return ()
    found = []
    for name in [value] if isinstance(value, str) else row.items(key, example='"tunnel"'):
        if isinstance(name, str) and name in known:
            found.append(name)
        elif not (isinstance(name, str) and name in mistaken):
            hint = nearest(name, known) if isinstance(name, str) else ""
            row.error(key, f"there is no such {what}", f"{hint}Known: {listed(known)}.")
    return tuple(found)


def _opening(row: Table, names: tuple[str, ...], site: _Site) -> str | None:
    if "excavation" not in row:
        return None
    found = _named(row, "excavation", names, "excavation")
    if found and found[0] not in site.dug:
        row.error(
            "excavation", f"{found[0]!r} is not excavated yet", "Put this stage after the one that does."
        )
        return None
    return found[0] if found else None


def _share(value: float) -> tuple[str, str] | None:
    if 0.0 <= value <= 1.0:
        return None
    return "a share of the forces lies between 0 and 1", "Write relax = 0.4; 1 takes all of them away."


def _not_negative(value: float) -> tuple[str, str] | None:
    return None if value >= 0.0 else ("the pressure would pull at the wall", "Give it without the sign.")
