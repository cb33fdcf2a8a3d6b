"""The report of a case of ground: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geodem.io.files import write_whole
from geodem.plotting import page, sections
from geodem.plotting.ground_wording import SIGN, contact_rows, cost_rows, headline, material_rows, size_line
from geodem.plotting.laboratory_report import write_figures
from geodem.plotting.page import text
from geodem.plotting.scene_wording import scene_rows
from geodem.plotting.sections import Picture

CAPTIONS = {
    "scene": "The ground with what is in it and what holds it: circles are rollers, triangles fixed particles.",
    "particles": "The particles, by material. A particle is of the material at its centre.",
    "inside": "The same without the half that is nearer to you.",
    "surfaces": "Boundaries that the source names, with the number of their facets: what walls and loads can act on.",
    "cut": "The photograph, the brightness at which it was cut, what came of it, and the particles.",
}
_HELD_BACK = frozenset(
    {"materials", "scene", "contacts", "cost", "steps", "surfaces", "source", "bounds_m", "solid_fraction", "grains",
     "smallest_radius_m", "largest_radius_m", "identity", "sources_digest"}
)  # fmt: skip


def write_ground_report(
    path: Path, result: Mapping[str, Any], pictures: Mapping[str, bytes], case_text: str
) -> None:
    """Write the report and, into ``figures`` beside it, its figures.

    Parameters
    ----------
    path : pathlib.Path
        The HTML file; replaced whole or not at all.
    result : dict
        What result.json holds.
    pictures : dict of str to bytes
        PNGs of `geodem.plotting.ground_pictures.ground_pictures`.
    case_text : str

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    content = [
        ("answer", "Answer", _answer(result)),
        ("pictures", "Pictures", _pictures(result, pictures)),
        ("contacts", "Contacts", _contacts(result)),
        ("scene", "Bonds, joints, sides", _scene(result)),
        ("surfaces", "Boundaries", _surfaces(result)),
        (
            "run",
            "Run",
            sections.run({key: value for key, value in result.items() if key not in _HELD_BACK}),
        ),
        ("case", "Case file", page.section("case", "Case file", page.toml(case_text)) if case_text else ""),
    ]
    present = [(anchor, name, body) for anchor, name, body in content if body]
    html = page.document(
        f"{result['title']}: ground",
        {anchor: name for anchor, name, _ in present},
        "\n".join(body for *_, body in present),
    )
    write_figures(
        path.parent / "figures", {name: Picture(content, None) for name, content in pictures.items()}
    )
    write_whole(path, html)


def _answer(result: Mapping[str, Any]) -> str:
    header, rows = material_rows(result)
    source = result["source"]
    blocks = [
        f'<header id="answer">\n<p class="case-title">{text(result["title"])}</p>',
        f"<h1>{text(headline(result))}</h1>",
        page.table(header, rows, numbers=range(1, len(header))),
        f"<p>From {text(': '.join(part for part in (source['kind'], ', '.join(source['files'])) if part))}. "
        f"{text(size_line(result))}.</p>",
        f'<p class="static">{text(SIGN)}</p>',
    ]
    if result["warnings"]:
        listed = page.bullets(result["warnings"])
        blocks.append(f'<div class="note"><p><strong>Remarks</strong></p>{listed}</div>')
    return "\n".join([*blocks, "</header>"])


def _pictures(result: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    figures = [
        page.figure(content, CAPTIONS[name], alternative=f"{name} of {result['title']}")
        for name, content in pictures.items()
    ]
    return page.section("pictures", "Pictures", *figures) if figures else ""


def _contacts(result: Mapping[str, Any]) -> str:
    return page.section(
        "contacts", "Contacts and cost", page.pairs(contact_rows(result)),
        "<h3>What a run of them takes</h3>", page.pairs(cost_rows(result)),
    )  # fmt: skip


def _scene(result: Mapping[str, Any]) -> str:
    if "scene" not in result:
        return ""
    return page.section("scene", "Bonds, joints, sides", page.pairs(scene_rows(result["scene"])))


def _surfaces(result: Mapping[str, Any]) -> str:
    flat = result["dimension"] == 2
    header = ("boundary", "segments" if flat else "triangles", "length [m]" if flat else "area [m2]")
    rows = [(row["name"], f"{row['facets']:,}", f"{row['size']:.5g}") for row in result["surfaces"]]
    return page.section("surfaces", "Boundaries", page.table(header, rows, numbers=(1, 2))) if rows else ""
