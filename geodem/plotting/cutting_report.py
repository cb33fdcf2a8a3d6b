"""The report of a cut: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geodem.io.files import write_whole
from geodem.plotting import cutting_wording as words
from geodem.plotting import page, sections
from geodem.plotting.laboratory_report import write_figures
from geodem.plotting.page import text
from geodem.plotting.sections import Picture

CAPTIONS = {
    "stages": "The cut at three moments. Pieces that nothing holds any more have colours of their own by turns, single "
    "grains are yellow.",
    "fragments": "The end: pieces by colour, cracks whose two sides are still near as short lines.",
    "forces": "Forces of the ground on the tool per metre of width: against its motion, and upwards.",
    "energy": "What became of the work. Damping takes what breaking bonds and colliding grains set free.",
    "sizes": "Share of the cut mass in pieces of at most a size, that of the disc of the same area.",
}
HELD_BACK = frozenset(
    {"tool", "forces", "chips", "energy", "cracks", "identity", "sources_digest", "bounds_m", "specific_energy_Pa",
     "work_per_way_N_per_m", "steps", "questions"}
)  # fmt: skip


def write_cutting_report(
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
        Of `geodem.plotting.cutting_pictures.cutting_pictures`.
    case_text : str

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    content = [
        ("answer", "Answer", _answer(result, pictures)),
        ("forces", "Forces", _forces(result, pictures)),
        ("chips", "Chips and cracks", _chips(result, pictures)),
        ("energy", "Energy", _energy(result, pictures)),
        ("tool", "Tool", page.section("tool", "Tool", page.pairs(words.tool_rows(result)))),
        ("run", "Run", sections.run({k: v for k, v in result.items() if k not in HELD_BACK})),
        ("case", "Case file", page.section("case", "Case file", page.toml(case_text)) if case_text else ""),
    ]
    present = [(anchor, name, body) for anchor, name, body in content if body]
    html = page.document(
        f"{result['title']}: cutting",
        {anchor: name for anchor, name, _ in present},
        "\n".join(body for *_, body in present),
    )
    write_figures(
        path.parent / "figures", {name: Picture(content, None) for name, content in pictures.items()}
    )
    write_whole(path, html)


def _figure(pictures: Mapping[str, bytes], name: str, result: Mapping[str, Any]) -> str:
    if name not in pictures:
        return ""
    return page.figure(pictures[name], CAPTIONS[name], alternative=f"{name} of {result['title']}")


def _answer(result: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    header = ("per metre of width", "mean of peaks", "largest peak", "mean", "standard deviation")
    blocks = [
        f'<header id="answer">\n<p class="case-title">{text(result["title"])}</p>',
        f"<h1>{text(words.headline(result))}</h1>",
        page.table(header, words.force_rows(result), numbers=range(1, 5)),
        f"<p>{text(words.face_line(result))}</p>",
    ]
    remarks = [*result["warnings"], *result["questions"]]
    if remarks:
        blocks.append(f'<div class="note"><p><strong>Remarks</strong></p>{page.bullets(remarks)}</div>')
    blocks.append(_figure(pictures, "stages", result))
    return "\n".join([*blocks, "</header>"])


def _forces(result: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    table = page.table(
        ("part of the tool", "cutting force, mean", "normal force, mean"),
        words.part_rows(result),
        numbers=(1, 2),
    )
    return page.section(
        "forces", "Forces", _figure(pictures, "forces", result), table, f"<p>{text(words.RATIO)}</p>",
        f"<p>Specific energy is the work of the tool after entry over depth times way: "
        f"{text(words.stress(result['specific_energy_Pa']))}.</p>",
    )  # fmt: skip


def _chips(result: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    return page.section(
        "chips", "Chips and cracks", _figure(pictures, "fragments", result), page.pairs(words.chip_rows(result)),
        page.pairs(words.crack_rows(result)), _figure(pictures, "sizes", result),
    )  # fmt: skip


def _energy(result: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    return page.section(
        "energy", "Energy", _figure(pictures, "energy", result), page.pairs(words.energy_rows(result))
    )
