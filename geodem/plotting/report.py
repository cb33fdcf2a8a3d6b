"""The report of a run: one HTML file that needs nothing else, in the order in which an engineer reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from geodem.errors import InputError
from geodem.io.files import cannot_write, write_whole
from geodem.plotting import answer, charts, page, scenes, sections
from geodem.plotting.theme import png, style, svg
from geodem.plotting.views import MethodView, ReportView
from geodem.plotting.wording import found

__all__ = ["MethodView", "ReportView", "make_figures", "write_report"]

SHORT = {"strength-reduction": "strength", "gravity-increase": "gravity"}
"""How the files of a method's figures begin."""

FIGURES = ("failure", "displacement", "shear-strain", "bracket", "history")


def write_report(
    path: Path | str,
    result: Mapping[str, Any],
    view: ReportView,
    *,
    figures_folder: Path | str | None = None,
) -> dict[str, bytes]:
    """Write the report and, as files of their own, its figures.

    Parameters
    ----------
    path : path
        The HTML file; replaced whole or not at all.
    result : dict
        What result.json holds, and where known "neighbours" (method, factor, centre, radius, surface, notes)
        or "neighbours_why", "notices", "warnings", "reference" (factor, source),
        "energy", "settings", "command".
    view : ReportView
    figures_folder : path, optional
        Default: ``figures`` beside the report.

    Returns
    -------
    dict of str to bytes
        PNG figures by name, as written to ``figures_folder/NAME.png``.

    Raises
    ------
    InputError
        The folder cannot be written to, or the disk is full; an older report then still stands.
    """
    path = Path(path)
    folder = path.parent / "figures" if figures_folder is None else Path(figures_folder)
    pictures = make_figures(view, result)
    content = _page(result, view, pictures)
    for name, picture in pictures.items():
        write_whole(folder / f"{name}.png", picture.png)
    _remove_stale(folder, pictures)
    write_whole(path, content)
    return {name: picture.png for name, picture in pictures.items()}


def make_figures(view: ReportView, result: Mapping[str, Any]) -> dict[str, sections.Picture]:
    """All figures of a report by name; a figure without data is left out."""
    pictures: dict[str, sections.Picture] = {}
    neighbours: Sequence[Mapping[str, Any]] = result.get("neighbours") or ()
    width = 7.7 if view.image_path is None else 5.6  # beside its source a picture is half as wide
    with style():
        pictures["particles"] = sections.Picture(png(scenes.particles_scene(view, width=width)))
        for method in view.methods:
            name = SHORT.get(method.kind, method.kind)
            failure = method.failure
            if failure is not None:
                # circles of limit equilibrium belong to the factor of safety, not to a load factor
                beside = neighbours if method.kind == "strength-reduction" else ()
                figure, scale = scenes.failure_scene(view, failure, beside)
                pictures[f"{name}-failure"] = sections.Picture(png(figure), scale=scale)
                pictures[f"{name}-displacement"] = sections.Picture(
                    png(scenes.displacement_scene(view, failure))
                )
                pictures[f"{name}-shear-strain"] = sections.Picture(png(scenes.strain_scene(view, failure)))
            if method.trials:
                chart = charts.bracket_chart(method)
                pictures[f"{name}-bracket"] = sections.Picture(png(chart), svg=svg(chart))
            if any(len(history[2]) for history in method.histories):
                chart = charts.history_chart(method)
                pictures[f"{name}-history"] = sections.Picture(png(chart), svg=svg(chart))
    return pictures


def _page(result: Mapping[str, Any], view: ReportView, pictures: Mapping[str, sections.Picture]) -> str:
    source = None
    trouble = ""
    if view.image_path is not None:
        try:
            source = scenes.source_picture(view.image_path)
        except InputError as error:  # a report without the picture is worth more than none
            trouble = str(error)
    parts = [
        ("answer", "Answer", answer.answer(result, view)),
        ("failure", "Failure", sections.failure(view, pictures, SHORT)),
        ("bracket", "Trials", sections.bracket(view, pictures, SHORT)),
        ("section", "Section and particles", sections.ground(result, view, pictures, source, trouble)),
        ("materials", "Materials", sections.materials(view)),
        ("energy", "Energy", sections.energy(result)),
        ("run", "Run", sections.run(result)),
        ("case", "Case file", sections.case(view)),
        ("reading", "How to read this", sections.reading(result)),
    ]
    present = [(anchor, name, body) for anchor, name, body in parts if body]
    entry = answer.factors(result, view)
    headline = " ".join(found(entry[0])) if entry else "no factor"
    return page.document(
        f"{view.title}: {headline}",
        {anchor: name for anchor, name, _ in present},
        "\n".join(body for *_, body in present),
    )


def _remove_stale(folder: Path, pictures: Mapping[str, Any]) -> None:
    """Take away figures that an earlier run left under our names and this one does not make."""
    for short in SHORT.values():
        for figure in FIGURES:
            name = f"{short}-{figure}"
            if name not in pictures:
                try:
                    (folder / f"{name}.png").unlink(missing_ok=True)
                except OSError as error:
                    raise cannot_write(folder / f"{name}.png", error) from error
