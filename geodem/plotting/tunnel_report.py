"""The report of a tunnel: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from geodem.io.files import write_whole
from geodem.plotting import page, sections
from geodem.plotting import tunnel_wording as words
from geodem.plotting.laboratory_report import write_figures
from geodem.plotting.page import text
from geodem.plotting.sections import Picture
from geodem.plotting.tunnel_pictures import tunnel_pictures
from geodem.plotting.tunnel_views import TunnelView

CAPTIONS = {
    "reaction": "Mean pressure on the wall against its mean convergence. The ground's curve falls as the forces of "
    "the excavated ground are relaxed; a lining, installed on the way, rises from there. Where it bears all, both "
    "are in equilibrium.",
    "yielded": "Plastic shear strain since the digging began. Inside the dashed line the ground has yielded.",
    "displacement": "Size and direction of the displacement since the digging began.",
    "lining": "Thrust (compression drawn into the ground) and moment around the lining, per metre of tunnel.",
    "failure": "Plastic shear strain of the lowest trial that did not come to rest: how it would fail.",
}
ROWS_SHOWN = 24
_HELD_BACK = frozenset(
    {"excavations", "stages", "ground_reaction", "linings", "bolts", "collapse", "reaction_collapse", "identity",
     "sources_digest", "ground_reaction_supported", "quick"}
)  # fmt: skip


def write_tunnel_report(path: Path, result: Mapping[str, Any], view: TunnelView, case_text: str) -> None:
    """Write the report and, into ``figures`` beside it, its figures.

    Parameters
    ----------
    path : pathlib.Path
        The HTML file; replaced whole or not at all.
    result : dict
        What result.json holds.
    view : TunnelView
    case_text : str

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    pictures = tunnel_pictures(view)
    content = [
        ("answer", "Answer", _answer(result)),
        ("pictures", "Pictures", _pictures(result, pictures)),
        ("reaction", "Ground reaction", _reaction(result)),
        ("supports", "Supports", _supports(result)),
        ("factors", "Factors", _factors(result)),
        ("reading", "How to read it", _reading(result)),
        (
            "run",
            "Run",
            sections.run({key: value for key, value in result.items() if key not in _HELD_BACK}),
        ),
        ("case", "Case file", page.section("case", "Case file", page.toml(case_text)) if case_text else ""),
    ]
    present = [(anchor, name, body) for anchor, name, body in content if body]
    html = page.document(
        f"{result['title']}: tunnel",
        {anchor: name for anchor, name, _ in present},
        "\n".join(body for *_, body in present),
    )
    write_figures(path.parent / "figures", {name: Picture(content) for name, content in pictures.items()})
    write_whole(path, html)


def _answer(result: Mapping[str, Any]) -> str:
    lines = words.answer(result)
    head = lines[0][0] if lines else "Nothing was dug"
    told = [f"<p><strong>{text(strong)}</strong>{text(plain)}</p>" for strong, plain in lines]
    blocks = [
        f'<header id="answer">\n<p class="case-title">{text(result["title"])}</p>',
        f"<h1>{text(head)}</h1>",
        *told,
        f'<p class="static">{text(result["kind_of_result"])}</p>',
    ]
    if result["warnings"]:
        listed = page.bullets(result["warnings"])
        blocks.append(f'<div class="note"><p><strong>Remarks</strong></p>{listed}</div>')
    return "\n".join([*blocks, "</header>"])


def _pictures(result: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    figures = [
        page.figure(content, CAPTIONS[name.split("-")[0]], alternative=f"{name} of {result['title']}")
        for name, content in pictures.items()
    ]
    return page.section("pictures", "Pictures", *figures)


def _reaction(result: Mapping[str, Any]) -> str:
    header = (
        "stage", "excavation", "relaxed [%]", "pressure [kPa]", "mean convergence [mm]", "crown [mm]", "width [mm]",
        "yielded [radii]", "lining [kPa]",
    )  # fmt: skip
    blocks = ["<h3>The run</h3>", page.table(header, _rows(result["stages"]), numbers=range(2, 9))]
    if result["ground_reaction"] != result["stages"]:
        blocks += [
            "<h3>The same without supports</h3>",
            page.table(header, _rows(result["ground_reaction"]), numbers=range(2, 9)),
        ]
        found = result.get("reaction_collapse")
        if found:
            blocks.append(
                f"<p>Without supports {text(found['excavation'])} does not stand beyond "
                f"{100.0 * found['relaxed_stable']:.3g} % of relaxation.</p>"
            )
    return page.section("reaction", "Ground reaction", *blocks)


def _rows(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    step = max(1, -(-len(rows) // ROWS_SHOWN))
    chosen = sorted({*range(0, len(rows), step), len(rows) - 1})
    return [
        (
            row["stage"], row["excavation"], f"{100.0 * row['relaxed']:.1f}", f"{row['pressure_Pa'] / 1e3:.5g}",
            f"{1e3 * row['mean_convergence_m']:.4g}", f"{1e3 * row['crown_m']:.4g}", f"{1e3 * row['horizontal_m']:.4g}",
            f"{row['plastic_radius_ratio']:.4g}", f"{row['lining_pressure_Pa'] / 1e3:.4g}",
        )
        for row in (rows[k] for k in chosen if k >= 0)
    ]  # fmt: skip


def _supports(result: Mapping[str, Any]) -> str:
    blocks = []
    if result["linings"]:
        header = (
            "lining",
            "thrust [kN/m]",
            "moment [kN m/m]",
            "compression [MPa]",
            "tension [MPa]",
            "used [%]",
        )
        rows = [
            (
                row["name"],
                f"{row['smallest_thrust_N_per_m'] / 1e3:.4g} to {row['largest_thrust_N_per_m'] / 1e3:.4g}",
                f"{row['largest_moment_Nm_per_m'] / 1e3:.4g}", f"{row['largest_compression_Pa'] / 1e6:.4g}",
                f"{row['largest_tension_Pa'] / 1e6:.4g}",
                "" if row["compressive_utilisation"] is None else f"{100.0 * row['compressive_utilisation']:.3g}",
            )
            for row in result["linings"]
        ]  # fmt: skip
        blocks.append(page.table(header, rows, numbers=range(1, 6)))
    if result["bolts"]:
        header = ("bolts", "number", "largest force [kN]", "yield force [kN]", "pieces yielded", "slipping")
        rows = [
            (
                row["name"], str(row["bolts"]), f"{row['largest_force_N'] / 1e3:.4g}",
                f"{row['yield_force_N'] / 1e3:.4g}", f"{row['yielded_pieces']} of {row['pieces']}",
                str(row["slipping_grout_pieces"]),
            )
            for row in result["bolts"]
        ]  # fmt: skip
        blocks.append(page.table(header, rows, numbers=range(1, 6)))
    return page.section("supports", "Supports", *blocks) if blocks else ""


def _factors(result: Mapping[str, Any]) -> str:
    blocks = []
    for entry in result["factors"]:
        strong, plain = words.factor_line(entry)
        rows = [
            (f"{t['factor']:.5g}", t["verdict"], t["criterion"], f"{t['steps']:,}") for t in entry["trials"]
        ]
        blocks += [
            f"<p><strong>{text(strong)}</strong>{text(plain)} {text(entry['meaning'].capitalize())}.</p>",
            page.table(("factor", "verdict", "rule that decided", "steps"), rows, numbers=(0, 3)),
        ]
    return page.section("factors", "Factors", *blocks) if blocks else ""


def _reading(result: Mapping[str, Any]) -> str:
    items = [
        "Relaxed: share of the forces of the excavated ground that is gone. What stands in for the face, which in the "
        "ground carries the rest, is for you to choose.",
        "Mean convergence: area that the opening lost, over the length of its wall.",
        "Yielded ground in radii: root of one plus the yielded area over that of the opening. All that has yielded "
        "since the digging began counts, weak ground at the surface too: see the picture.",
        "A lining is a thin elastic ring on the wall, joined to the ground without slip. Its weight is left out.",
        "Bolts stand for one bolt every spacing along the tunnel; they yield at their force.",
        "Strength reduction takes the strength of the ground alone; supports keep theirs.",
    ]
    supported = bool(result["linings"] or result["bolts"])
    return page.section("reading", "How to read it", page.bullets(items if supported else [*items[:3]]))
