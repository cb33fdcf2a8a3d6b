"""The report of a run-out: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geodem.io.files import write_whole
from geodem.plotting import page, sections
from geodem.plotting import runout_wording as words
from geodem.plotting.laboratory_report import write_figures
from geodem.plotting.page import text
from geodem.plotting.sections import Picture

CAPTIONS = {
    "before": "The failed mass as discs at the hand-over, the rigid ground of held discs below it, and the particles "
    "that the failure was found on.",
    "during": "On the way, after 20, 50, 80 and 97 % of the fall of the centre of gravity. Dashed: the surface before.",
    "after": "The deposit. The stripes lay upright before; the orange line goes from the crest of the mass to the "
    "front of the deposit.",
    "history": "Energy since the hand-over, potential energy above the lowest point of the mass, and the way downhill "
    "of front and centre of gravity.",
}
_HELD_BACK = frozenset(
    {"factors", "moved", "hand_over", "deposit", "flow", "identity", "sources_digest", "quick"}
)


def write_runout_report(
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
        PNGs of `geodem.plotting.runout_pictures.runout_pictures`.
    case_text : str

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    drawn = {
        name: page.figure(content, CAPTIONS[name], alternative=f"{name}: {result['title']}")
        for name, content in pictures.items()
    }
    run = {key: value for key, value in result.items() if key not in _HELD_BACK}
    content = [
        ("answer", "Answer", _answer(result)),
        ("flow", "Flow", page.section("flow", "Flow", *drawn.values())),
        ("deposit", "Deposit", page.section("deposit", "Deposit", page.pairs(words.deposit_rows(result)))),
        ("hand-over", "Hand-over", _hand_over(result)),
        ("run", "Run", sections.run(run)),
        ("case", "Case file", page.section("case", "Case file", page.toml(case_text))),
    ]
    html = page.document(
        f"{result['title']}: run-out",
        {anchor: name for anchor, name, _ in content},
        "\n".join(body for *_, body in content),
    )
    write_figures(path.parent / "figures", {name: Picture(image, None) for name, image in pictures.items()})
    write_whole(path, html)


def _answer(result: Mapping[str, Any]) -> str:
    blocks = [
        f'<header id="answer">\n<p class="case-title">{text(result["title"])}</p>',
        f"<h1>{text(words.headline(result))}</h1>",
        page.pairs(words.moved_rows(result)),
        f'<p class="static">{text(words.SIGN)}</p>',
    ]
    if result["warnings"]:
        listed = page.bullets(result["warnings"])
        blocks.append(f'<div class="note"><p><strong>Remarks</strong></p>{listed}</div>')
    return "\n".join([*blocks, "</header>"])


def _hand_over(result: Mapping[str, Any]) -> str:
    header, rows = words.conserved_rows(result)
    told = (
        "Differences are over the value itself; of centres over the height of what moves, of momenta over those of "
        "the same mass with the same kinetic energy moving as one, of energies over the energy before."
    )
    return page.section(
        "hand-over", "Hand-over", page.table(header, rows, numbers=(1, 2, 4)), f"<p>{text(told)}</p>"
    )
