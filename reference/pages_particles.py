"""What discs and spheres are held to: the part of docs/verification.md that is made from their results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from reference.pages_tables import Row, number, table


class Group(NamedTuple):
    """A file of results, and how it stands on the page."""

    name: str
    title: str
    text: str


GROUPS = (
    Group(
        "fewbody",
        "One and two spheres",
        "Impacts, sliding, rolling and bouncing against closed forms. Rolling resistance and adhesion after Derjaguin, "
        "Muller and Toporov are laws that geodem does not have.",
    ),
    Group("oscillator", "Period and energy of an oscillator", "The leap-frog has closed forms of its own."),
    Group(
        "energy-account",
        "Energy account",
        "A million steps at 0.1 of the critical one: friction, damping, dashpots, breaking bonds, moving walls.",
    ),
    Group("lattice", "Lattices and a beam, solved as networks and strained by the engine", ""),
    Group("cantilever", "Cantilever of bonded spheres, by the engine", ""),
    Group("timestep", "Critical time step of regular packings", ""),
    Group(
        "arrays",
        "Regular arrays at failure in a periodic cell",
        "Hexagonal discs and face-centred spheres, compressed at constant stress across until all inclined contacts "
        "slide: the peak of the stress ratio. In plane strain the spheres are kept from spinning, as the formula has "
        "it; free to spin, half of the contacts end up rolling and the ratios at a friction of 0.3 are 4.60 and 1.80.",
    ),
    Group(
        "trubal",
        "TRUBAL's triaxial tests: Rowe's face-centred packings, random spheres",
        "Octagonal prisms of 403 spheres (Cundall's) and 1672 (Rowe's own) between platens, in a membrane: constant "
        "forces on the outer spheres of the large layers, whose rotations are fixed. The peaks that they are held to "
        "are those of Cui and O'Sullivan's finite sample: a simulation too, of a part of a cylinder that is periodic "
        "around its axis, in a membrane that follows its spheres. Ours differ in both: 5 % are let. With contacts a "
        "thousand times softer, as in the text (r 20), peaks are 2 % lower. What Rowe measured is only in a figure of "
        "the text and is not drawn.\n\n![Stress ratio against axial strain](pictures/trubal_rowe.png)\n\n"
        "The random assembly: 150 spheres in a periodic cell, compacted to six contacts each, loaded until they fail, "
        "unloaded, loaded again. The text gives neither material nor lateral stress of it, and its curve only as a "
        "figure: what is held to bounds is what that curve shows. It is unloaded once the stress has fallen by 3 %; so "
        "few spheres harden again later, so that peaks of the second loading lie up to 27 % above those of the first, "
        "while back at the strain of unloading the stress is the same within 5 %.\n\n"
        "![Axial stress against axial strain](pictures/trubal_random.png)",
    ),
    Group(
        "granular",
        "Granular flow: columns, silo, hopper",
        "Trends, with the bounds of trends. Columns of a few thousand grains collapse on a floor of held grains; in 2D "
        "beside a smooth wall, over three seeds, in 3D all around, over two. Grains fall into a square silo eight "
        "grains wide, and its floor sinks by one grain, so that friction is mobilised: to nine tenths along the walls, "
        "to seven at the foot, where the stress lies above that of saturation. A box sixteen grains wide drains "
        "through round holes.\n\n![Run-out, stress with depth, rate of flow](pictures/granular_flow.png)",
    ),
    Group(
        "runout",
        "Failed ground handed over to discs",
        "Slopes that a strength reduction brought to failure are handed over to a thousand discs, moving as they fail "
        "with the energy that the search took out as damping. Differences are over the value; of centres over the "
        "height of what moves, of momenta over those of the same mass moving as one with the same kinetic energy, of "
        "energies over the energy above the lowest point of what moves. The friction of contacts comes from the "
        "table that is checked below.",
    ),
    Group(
        "disc-friction",
        "Friction of the discs that run out",
        "The friction of contacts comes from a table of residual angles: fresh packings of 900 discs are sheared to "
        "40 % in biaxial compression, three for each angle that is asked for, and the mean of the second half is their "
        "residual angle.",
    ),
    Group(
        "runout-columns",
        "Columns handed over and let go",
        "Columns on level ground are handed over to discs as failed slopes are, both sides collapse, and the mean of "
        "the two fronts is the run-out. Experiments found 1.2 a, over the half width, whatever the grains, for aspect "
        "ratios a below 1.8; a front of few discs ends where the last one lies that hangs together with the others.",
    ),
    Group(
        "trapdoor",
        "Trapdoor under dry discs",
        "A door in a rough floor sinks under discs with the friction of the table above, four packings each. It "
        "sinks by 3 to 4 % of its width, slowly enough for the inertial number below. The stiffness of contacts is "
        "500 rho g H, the time step 0.7 of the critical one; local damping 0.1, dashpots along contacts only. Limit"
        " analysis with associated flow gives the least pressure that may be, Terzaghi's silo with K = 1 more; the "
        "minimum is held to lie between them, a tenth outside allowed. Dense discs bear more than their residual "
        "angle at first, and the edges of the door carry discs that rest on both sides of them, so fewer discs "
        "across the door give lower pressures. One packing differs from the next by more than the bounds at 30 deg;"
        " only the mean of several tells much.\n\n![Pressure by the movement of the door](pictures/trapdoor.png)",
    ),
)


def particle_sections(read: Callable[[str], Any], header: Callable[[Any], str], not_run: str) -> list[str]:
    """Texts of all groups; `read` gives what is stored under a name, `header` its origin."""
    return ["## Discs and spheres\n", *group_sections(GROUPS, read, header, not_run)]


def group_sections(
    groups: Sequence[Group], read: Callable[[str], Any], header: Callable[[Any], str], not_run: str
) -> list[str]:
    """Texts of groups, each with its figures."""
    parts = []
    for group in groups:
        parts.append(f"### {group.title}\n")
        if group.text:
            parts.append(group.text + "\n")
        stored = read(group.name)
        if not stored.rows:
            parts.append(
                not_run.format(name=group.name, command=f"python -m reference run {group.name}") + "\n"
            )
        else:
            parts += [header(stored), figures(stored.rows)]
    return parts


def figures(rows: Sequence[Row]) -> str:
    """Every figure beside what is expected of it."""
    lines = [_line(row) for row in rows]
    good = sum(bool(row["good"]) for row in rows)
    head = ["problem", "quantity", "computed", "expected", "error [%]", "bound [%]", "within", "source"]
    return f"{good} of {len(rows)} figures lie within their bounds.\n\n" + table(head, lines)


def _line(row: Mapping[str, Any]) -> list[str]:
    return [
        str(row["name"]),
        str(row["quantity"]),
        number(row["value"]),
        number(row["expected"]),
        f"{row['error_percent']:+.2g}",
        number(row["bound_percent"], 3),
        "yes" if row["good"] else "**no**",
        str(row.get("source", "")),
    ]
