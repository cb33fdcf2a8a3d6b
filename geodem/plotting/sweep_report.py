"""The report of a sweep: its table, charts of it, and a picture of each run; links lead to the runs' own reports."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geodem.io.files import write_whole
from geodem.kinds import KINDS
from geodem.plotting import page, sections
from geodem.plotting.laboratory_report import write_figures
from geodem.plotting.page import Markup, text
from geodem.plotting.sections import Picture
from geodem.plotting.sweep_charts import named, shown, sweep_chart
from geodem.plotting.theme import png, style

CHARTS = 8
"""Columns of which a chart is drawn."""

PICTURES = 12
"""Runs of which a picture is shown, spread over the sweep."""

_WIDE = 640
"""Pixels across a picture of a run."""

_HELD_BACK = frozenset(
    {"runs", "columns", "parameters", "of", "total", "finished", "failed", "identity", "sources_digest"}
)


def write_sweep_report(path: Path, result: Mapping[str, Any], case_text: str) -> None:
    """Write the report of a sweep and, into ``figures`` beside it, its charts.

    Parameters
    ----------
    path : pathlib.Path
        The HTML file, in the folder of the sweep; replaced whole or not at all.
    result : dict
        What result.json holds.
    case_text : str

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    charts = make_charts(result)
    content = [
        ("answer", "Answer", _answer(result)),
        ("charts", "Charts", _charts(result, charts)),
        ("table", "Runs", page.section("table", "Runs", _table(result))),
        ("pictures", "Pictures", _pictures(result, path.parent)),
        ("run", "Run", sections.run({key: value for key, value in result.items() if key not in _HELD_BACK})),
        ("case", "Case file", page.section("case", "Case file", page.toml(case_text))),
    ]
    present = [(anchor, name, body) for anchor, name, body in content if body]
    html = page.document(
        f"{result['title']}: sweep",
        {anchor: name for anchor, name, _ in present},
        "\n".join(body for *_, body in present),
    )
    write_figures(path.parent / "figures", {name: Picture(content, None) for name, content in charts.items()})
    write_whole(path, html)


def make_charts(result: Mapping[str, Any]) -> dict[str, bytes]:
    """PNGs by name: one for each of the first columns that has numbers."""
    found: dict[str, bytes] = {}
    with style():
        for column in range(len(result["columns"])):
            figure = sweep_chart(result, column) if len(found) < CHARTS else None
            if figure is not None:
                found[f"chart-{column + 1}"] = png(figure)
    return found


def headline(result: Mapping[str, Any]) -> str:
    """How many runs are done, and how many failed."""
    failed = f", {result['failed']} failed" if result["failed"] else ""
    return f"{result['finished']} of {result['total']} runs finished{failed}"


def answer(result: Mapping[str, Any]) -> list[tuple[str, str]]:
    """How many runs are done, in bold, and the range of every column."""
    lines = [(headline(result), "")]
    for k, name in enumerate(result["columns"]):
        rows = [row for row in result["runs"] if isinstance(row["values"][k], int | float)]
        if not rows:
            continue
        low, high = (end(rows, key=lambda row: row["values"][k]) for end in (min, max))
        ends = [f"{shown(row['values'][k])} ({row['told']})" for row in (low, high)]
        lines.append(("", f"  {name}: " + " to ".join(dict.fromkeys(ends))))
    return lines


def _answer(result: Mapping[str, Any]) -> str:
    varied = ", ".join(named(entry) for entry in result["parameters"])
    blocks = [
        f'<header id="answer">\n<p class="case-title">{text(result["title"])}</p>',
        f"<h1>{text(headline(result))}</h1>",
        f"<p>Varied: {text(varied)}. Every run is a case of the kind {text(result['of'])} and has a folder of its own, "
        "with its case, its report and all that such a run leaves.</p>",
    ]
    if result["warnings"]:
        listed = page.bullets(result["warnings"])
        blocks.append(f'<div class="note"><p><strong>Remarks</strong></p>{listed}</div>')
    return "\n".join([*blocks, "</header>"])


def _charts(result: Mapping[str, Any], charts: Mapping[str, bytes]) -> str:
    figures = []
    for name, content in charts.items():
        column = result["columns"][int(name.rpartition("-")[2]) - 1]
        caption = f"{column}; a point is a run, runs that did not finish are not shown."
        figures.append(page.figure(content, caption, alternative=f"{column} over what was varied"))
    return page.section("charts", "Charts", *figures) if figures else ""


def _table(result: Mapping[str, Any]) -> str:
    header = ["run", *map(named, result["parameters"]), *result["columns"], "status", "run time [s]"]
    rows = []
    for row in result["runs"]:
        link: object = row["number"]
        if row["status"] == "done":
            link = Markup(f'<a href="{text(row["folder"])}/report.html">{row["number"]}</a>')
        values = [shown(value) for value in (*row["parameters"], *row["values"])]
        rows.append([link, *values, row["status"], f"{row['seconds']:.3g}" if row["seconds"] else ""])
    right = [k for k in range(len(header)) if k != len(header) - 2]
    return page.table(header, rows, numbers=right)


def _pictures(result: Mapping[str, Any], folder: Path) -> str:
    done = [row for row in result["runs"] if row["status"] == "done"]
    count = min(PICTURES, len(done))
    chosen = [done[round(k * (len(done) - 1) / max(count - 1, 1))] for k in range(count)]
    figures = []
    for row in chosen:
        picture = _picture(folder / row["folder"] / "figures", KINDS[result["of"]].picture)
        if picture is not None:
            caption = f"Run {row['number']}: {row['told']}"
            figures.append(page.figure(picture, caption, alternative=caption, wide=False))
    if not figures:
        return ""
    return page.section("pictures", "Pictures", f'<div class="grid">{"".join(figures)}</div>')


def _picture(folder: Path, pattern: str) -> bytes | None:
    """The figure of a run that its kind shows, or else the first one, made smaller; None where it has none."""
    from PIL import Image

    for path in (*sorted(folder.glob(pattern)), *sorted(folder.glob("*.png"))):
        try:
            with Image.open(path) as image:
                small = image.convert("RGB")
        except OSError:
            continue
        small.thumbnail((_WIDE, _WIDE))
        buffer = io.BytesIO()
        small.save(buffer, format="PNG", optimize=True)
        return buffer.getvalue()
    return None
