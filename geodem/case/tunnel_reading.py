"""A tunnel case from its text; every error of the file at once."""

from __future__ import annotations

from pathlib import Path

from geodem.case.data import SectionOptions, Surcharge
from geodem.case.head import read_head
from geodem.case.loading import read_surcharges
from geodem.case.material import check_names, read_materials
from geodem.case.reading import check_spacing, used_materials
from geodem.case.section import Coordinates, positive, read_section
from geodem.case.table import Table, listed, nearest
from geodem.case.tunnel import TunnelCase
from geodem.case.tunnel_stages import read_stages
from geodem.case.tunnel_supports import read_bolts, read_excavations, read_linings
from geodem.tunnelling.plan import INCREMENTS, METHODS, DepthStress, UniformStress

KEYS = (
    "workflow", "title", "allow_implausible", "particles", "spacing", "wall_spacing", "seed", "increments",
    "ground_reaction", "section", "boundary", "loads", "initial_stress", "excavation", "lining", "bolt", "stage",
    "stability", "material",
)  # fmt: skip
SIDES = ("left", "right", "bottom", "top")
SUPPORTS = ("free", "roller", "fixed", "far")
DEFAULT_PARTICLES = 4000
DEFAULT_TOLERANCE = 0.01
_FEW, _MANY = 300, 1_000_000
MANY_INCREMENTS = 1000
_STRESS_EXAMPLE = '[initial_stress] with k0 = 0.5, or with horizontal = "10 MPa" and vertical = "10 MPa"'


def parse_tunnel(text: str, folder: Path) -> TunnelCase:
    """Read a tunnel case from its text.

    Parameters
    ----------
    text : str
        TOML.
    folder : pathlib.Path
        What relative paths in it are relative to.

    Raises
    ------
    InputError
        The text is no TOML, or a case of another workflow.
    InputErrors
        All that is wrong in it, in its order. Whether openings and bolts lie in the ground is seen when it is built.
    """
    head = read_head(text, folder, "tunnel", KEYS, example="Tunnel in marl")
    top = head.top
    particles, spacing, wall = _resolution(top)
    seed = head.seed()
    increments = top.integer("increments", smallest=4, remedy="Write a whole number such as 20.")
    if increments is not None and increments > MANY_INCREMENTS:
        top.findings.implausible(
            "increments", "so many take days", "Tunnels need 10 to 100.", value=increments
        )
    if "increments" not in top:
        top.findings.default("increments", str(INCREMENTS), why="in which all of the forces are relaxed")
    defined = top.content.get("material")
    names = tuple(defined) if isinstance(defined, dict) else ()
    section, coordinates = read_section(top, folder, names)
    materials = read_materials(top)
    check_names(top.findings, used_materials(head.document), names, materials)
    if section is not None and spacing is not None:
        check_spacing(top.findings, section, spacing)
    initial = _initial(top)
    boundary = _boundary(top, initial)
    surcharge = _surcharge(top, coordinates, section)
    excavations = read_excavations(top, coordinates)
    linings = read_linings(top, tuple(e.name for e in excavations))
    bolts = read_bolts(top, coordinates, tuple(e.name for e in excavations))
    stages = read_stages(top, excavations, linings, bolts)
    methods, tolerance = _stability(top, bool(surcharge), isinstance(initial, DepthStress))
    reaction = _reaction(top, bool(linings or bolts))
    common = head.close()
    # every None below has been reported
    assert section is not None
    assert initial is not None
    return TunnelCase(
        particles=particles, spacing=spacing, wall_spacing=wall, seed=seed, increments=increments or INCREMENTS,
        ground_reaction=reaction, section=section, boundary=boundary, surcharge=surcharge, initial=initial,
        excavations=excavations, linings=linings, bolts=bolts, stages=stages, methods=methods, tolerance=tolerance,
        materials=materials, **common,
    )  # fmt: skip


def _resolution(top: Table) -> tuple[int | None, float | None, float | None]:
    particles = top.integer("particles", smallest=3, remedy="Write a whole number such as 4000.")
    spacing = top.quantity("spacing", "length", check=positive)
    wall = top.quantity("wall_spacing", "length", check=positive)
    if "particles" in top and "spacing" in top:
        top.error("spacing", "particles and spacing are both given", "Keep one of them; the other follows.")
    elif "particles" not in top and "spacing" not in top:
        particles = DEFAULT_PARTICLES
        top.findings.default("particles", str(particles))
    if "wall_spacing" not in top:
        top.findings.default(
            "wall_spacing", "about 80 particles around an opening at 4000", why="closest at the walls"
        )
    if particles is not None and not _FEW <= particles <= _MANY:
        problem = (
            "so few particles show no yielded zone" if particles < _FEW else "so many particles take days"
        )
        top.findings.implausible("particles", problem, "Tunnels need 2500 to 20000.", value=particles)
    return particles, spacing, wall


def _initial(top: Table) -> UniformStress | DepthStress | None:
    if "initial_stress" not in top:
        top.missing(
            "initial_stress", f"The stress before anything is dug decides all. Add {_STRESS_EXAMPLE}."
        )
        return None
    table = top.sub("initial_stress", ("k0", "horizontal", "vertical", "shear"), example=_STRESS_EXAMPLE)
    if table is None:
        return None
    if "k0" in table:
        for key in ("horizontal", "vertical", "shear"):
            if key in table:
                table.error(key, "k0 gives the stress by depth", f"Remove {key}, or remove k0.")
        value = table.quantity("k0", "dimensionless", check=positive)
        if value is not None and not 0.1 <= value <= 5.0:
            table.findings.implausible(
                table.at("k0"), "ground has 0.3 to 3", "It is horizontal over vertical stress.",
                value=table.content["k0"],
            )  # fmt: skip
        return None if value is None else DepthStress(value)
    for key in ("horizontal", "vertical"):
        if key not in table:
            table.missing(key, f"Write {_STRESS_EXAMPLE}.")
    horizontal = table.quantity("horizontal", "stress", check=_compression)
    vertical = table.quantity("vertical", "stress", check=_compression)
    shear = table.quantity("shear", "stress")
    if horizontal is None or vertical is None:
        return None
    table.findings.notices.append(
        "initial_stress: the same everywhere; the weight of the ground around the opening is left out."
    )
    return UniformStress(horizontal, vertical, shear or 0.0)


def _compression(value: float) -> tuple[str, str] | None:
    if value >= 0.0:
        return None
    return "this would be tension: compression is positive here", "Give it without the sign."


def _boundary(top: Table, initial: UniformStress | DepthStress | None) -> dict[str, str]:
    example = '[boundary] with left = "roller", right = "roller", bottom = "fixed"'
    sides = dict.fromkeys(SIDES, "free")
    uniform = isinstance(initial, UniformStress)
    if "boundary" not in top:
        top.missing("boundary", f'Add {example}; around a deep tunnel all four may be "far".')
        return sides
    table = top.sub("boundary", SIDES, example=example)
    if table is None:
        return sides
    for side in SIDES:
        sides[side] = table.choice(side, SUPPORTS, default="free") or "free"
    far = [side for side, support in sides.items() if support == "far"]
    if far and initial is not None and not uniform:
        table.error(
            far[0], "springs of the far ground go with a uniform stress; k0 has a surface above",
            'Write "roller" at the sides and "fixed" at the bottom.',
        )  # fmt: skip
    if not uniform and sides["bottom"] not in ("fixed", "roller"):
        table.findings.error(table.at("bottom"), "nothing carries the weight", 'Write bottom = "fixed".')
    if uniform and all(support in ("free", "roller") for support in sides.values()):
        held = [side for side, support in sides.items() if support == "roller"]
        if not ({"left", "right"} & set(held) and {"bottom", "top"} & set(held)):
            top.findings.error(
                "boundary", "nothing holds the ground in place",
                'Write "far" on the sides where the ground goes on, "roller" on lines of symmetry.',
            )  # fmt: skip
    return sides


def _surcharge(top: Table, coordinates: Coordinates, section: SectionOptions | None) -> tuple[Surcharge, ...]:
    table = top.sub("loads", ("surcharge",), example="[loads]")
    return () if table is None else read_surcharges(table, coordinates, section)


def _stability(top: Table, loaded: bool, weighty: bool) -> tuple[tuple[str, ...], float]:
    example = '[stability] with methods = ["strength-reduction"]'
    table = top.sub("stability", ("methods", "tolerance"), example=example)
    if table is None:
        top.findings.default("stability", "no factor", why="the stages alone are run")
        return (), DEFAULT_TOLERANCE
    tolerance = table.quantity("tolerance", "dimensionless", check=_tolerance)
    if "tolerance" not in table:
        table.findings.default(table.at("tolerance"), str(DEFAULT_TOLERANCE))
    found: list[str] = []
    if "methods" not in table:
        table.missing("methods", f"Write {example}. Known: {listed(METHODS)}.")
    for index, value in enumerate(table.items("methods", example='["strength-reduction"]')):
        place = f"{table.at('methods')}[{index}]"
        if value not in METHODS:
            hint = nearest(value, METHODS) if isinstance(value, str) else ""
            table.findings.error(place, "unknown method", f"{hint}Known: {listed(METHODS)}.", value=value)
        elif value == "load-increase" and not loaded:
            table.findings.error(place, "there is no load to increase", "Add [loads] with a surcharge.")
        elif value == "gravity-increase" and not weighty:
            table.findings.error(place, "a uniform stress has no gravity to increase", "Give k0 instead.")
        elif value not in found:
            found.append(value)
    return tuple(found), tolerance or DEFAULT_TOLERANCE


def _tolerance(value: float) -> tuple[str, str] | None:
    if 1e-3 <= value <= 0.2:
        return None
    return "the tolerance lies between 0.001 and 0.2", "It is the width of [stable, failed] over the factor."


def _reaction(top: Table, supported: bool) -> bool:
    if "ground_reaction" not in top:
        if supported:
            top.findings.default(
                "ground_reaction", "true", why="the same digging is run without supports, too"
            )
        return supported
    value = top.content["ground_reaction"]
    if not isinstance(value, bool):
        top.error("ground_reaction", "true or false is needed here", "Write ground_reaction = true.")
        return False
    return value and supported
