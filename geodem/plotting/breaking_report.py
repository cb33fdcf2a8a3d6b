"""The report of a case of breaking ground: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geodem.io.files import write_whole
from geodem.plotting import breaking_wording as words
from geodem.plotting import page, sections
from geodem.plotting.breaking_pictures import Drawn
from geodem.plotting.laboratory_report import write_figures
from geodem.plotting.page import text
from geodem.plotting.sections import Picture

_HELD_BACK = frozenset(
    {
        "factors", "stages", "points", "cracks", "fragments", "walls", "energy", "materials", "bounds_m",
        "kind_of_result", "identity", "sources_digest", "digest", "particles_left", "bonds", "diameter_m",
    }
)  # fmt: skip


def write_breaking_report(
    path: Path, result: Mapping[str, Any], pictures: Mapping[str, Drawn], case_text: str
) -> None:
    """Write the report and, into ``figures`` beside it, its figures.

    Parameters
    ----------
    path : pathlib.Path
        The HTML file; replaced whole or not at all.
    result : dict
        What result.json holds.
    pictures : dict of str to Drawn
        Of `geodem.plotting.breaking_pictures.breaking_pictures`.
    case_text : str

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    content = [
        ("answer", "Answer", _answer(result)),
        ("pictures", "Pictures", _pictures(result, pictures)),
        ("stages", "Stages", _stages(result)),
        ("trials", "Trials", _trials(result)),
        ("cracks", "Cracks and pieces", _cracks(result)),
        ("measured", "Measured", _measured(result)),
        ("run", "Run", sections.run({k: v for k, v in result.items() if k not in _HELD_BACK})),
        ("case", "Case file", page.section("case", "Case file", page.toml(case_text))),
    ]
    present = [(anchor, name, body) for anchor, name, body in content if body]
    html = page.document(
        f"{result['title']}: breaking ground",
        {anchor: name for anchor, name, _ in present},
        "\n".join(body for *_, body in present),
    )
    figures = {name: Picture(drawn.png, None) for name, drawn in pictures.items()}
    write_figures(path.parent / "figures", figures)
    write_whole(path, html)


def _answer(result: Mapping[str, Any]) -> str:
    lines = words.answer(result)
    blocks = [
        f'<header id="answer">\n<p class="case-title">{text(result["title"])}</p>',
        f"<h1>{text(lines[0][0])}</h1>",
    ]
    told = [lines[0][1], *(f"{bold} {rest}" for bold, rest in lines[1:])]
    told += [failed for factor in result["factors"] if (failed := words.failure_words(factor))]
    blocks += [f"<p>{text(line)}</p>" for line in told if line]
    size = (
        f"{result['particles']:,} particles of {result['diameter_m']:.4g} m on average, {result['bonds']:,} bonds "
        f"({result['bond_law'] or 'none'})."
    )
    blocks.append(f"<p>{text(size)} {text(words.LIMITS)}</p>")
    if result["warnings"]:
        listed = page.bullets(result["warnings"])
        blocks.append(f'<div class="note"><p><strong>Remarks</strong></p>{listed}</div>')
    return "\n".join([*blocks, "</header>"])


def _pictures(result: Mapping[str, Any], pictures: Mapping[str, Drawn]) -> str:
    if not pictures:
        return ""
    blocks: list[str] = []
    for number in sorted({drawn.stage for drawn in pictures.values()}, key=lambda k: (k == 0, k)):
        if number:
            blocks.append(f"<h3>{text(result['stages'][number - 1]['name'])}</h3>")
        blocks += [
            page.figure(drawn.png, drawn.caption, alternative=f"{name} of {result['title']}")
            for name, drawn in pictures.items()
            if drawn.stage == number
        ]
    return page.section("pictures", "Pictures", *blocks)


def _stages(result: Mapping[str, Any]) -> str:
    header = ("stage", "kind", "time [s]", "steps", "new cracks, tension", "shear", "at rest")
    rows = [
        (
            row["name"], row["kind"], f"{row['time_s']:.4g}", f"{row['steps']:,}",
            f"{row['new_cracks']['tension']:,}", f"{row['new_cracks']['shear']:,}",
            {True: "yes", False: "no"}.get(row.get("at_rest"), ""),
        )
        for row in result["stages"]
    ]  # fmt: skip
    return page.section("stages", "Stages", page.table(header, rows, numbers=range(2, 6)))


def _trials(result: Mapping[str, Any]) -> str:
    blocks: list[str] = []
    for factor in result["factors"]:
        header, rows = words.trial_rows(factor)
        blocks.append(f"<h3>{text(words.factor_words(factor))}</h3><p>{text(words.meaning(factor))}</p>")
        blocks.append(page.table(header, rows, numbers=(0, 3, 4, 5), kind="trials"))
    return page.section("trials", "Trials", *blocks) if blocks else ""


def _cracks(result: Mapping[str, Any]) -> str:
    header = ("between", "bonds", "broken in tension", "in shear", "share broken [%]")
    rows = [
        (
            " and ".join(dict.fromkeys(row["materials"])), f"{row['bonds']:,}", f"{row['tension']:,}",
            f"{row['shear']:,}", f"{100.0 * row['share_broken']:.3g}",
        )
        for row in result["cracks"]["by_materials"]
    ]  # fmt: skip
    told = f"<p>{text(words.fragments_words(result))}</p>"
    return page.section(
        "cracks", "Cracks and pieces", told, page.table(header, rows, numbers=range(1, 5)) if rows else ""
    )


def _measured(result: Mapping[str, Any]) -> str:
    def shown(values: list[float | None]) -> str:
        return ", ".join("-" if value is None else f"{value:.4g}" for value in values)

    blocks: list[str] = []
    if result["points"]:
        header = ("point", "at [m]", "displacement since the start [m]", "since settled [m]")
        rows = [
            (p["name"], shown(p["at_m"]), shown(p["displacement_m"]), shown(p["since_settled_m"]))
            for p in result["points"]
        ]
        blocks.append(page.table(header, rows, numbers=(1, 2, 3)))
    if result["walls"]:
        unit = "N/m" if result["dimension"] == 2 else "N"
        forces = [(wall["name"], shown(wall["force_N"])) for wall in result["walls"]]
        blocks.append(page.table(("wall", f"force of the ground on it [{unit}]"), forces, numbers=(1,)))
    unit = "J/m" if result["dimension"] == 2 else "J"
    energy = {name: f"{value:.4g}" for name, value in result["energy"].items() if value}
    blocks.append(page.table(("energy", f"[{unit}], imbalance [-]"), list(energy.items()), numbers=(1,)))
    return page.section("measured", "Measured", *blocks)
