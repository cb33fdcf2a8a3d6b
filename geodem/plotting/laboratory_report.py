"""The report of a laboratory case: one HTML file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from geodem.io.files import cannot_write, write_whole
from geodem.laboratory.orders import FinishedTest
from geodem.laboratory.summary import Property, group_tests, material_properties, summarise_envelope
from geodem.plotting import laboratory_sections as parts
from geodem.plotting import page, sections, wording
from geodem.plotting.laboratory_wording import deviation_shown, rounded
from geodem.plotting.page import text
from geodem.units import show


def write_laboratory_report(
    path: Path, result: Mapping[str, Any], tests: Sequence[FinishedTest], case_text: str
) -> None:
    """Write the report and, into ``figures`` beside it, its figures.

    Parameters
    ----------
    path : pathlib.Path
        The HTML file; replaced whole or not at all.
    result : dict
        What result.json holds.
    tests : sequence of FinishedTest
    case_text : str

    Raises
    ------
    InputError
        The folder cannot be written to.
    """
    groups = group_tests(tests)
    envelope = None if result.get("envelope") is None else summarise_envelope(groups)
    properties = material_properties(groups, envelope)
    pictures = parts.make_figures(groups, envelope)
    content = [
        ("answer", "Answer", _answer(result, properties)),
        ("tests", "Tests", page.section("tests", "Tests", parts.tests_table(groups)) if groups else ""),
        ("curves", "Curves", parts.curves_section(groups, pictures) if groups else ""),
        ("envelope", "Envelope", parts.envelope_section(envelope, pictures)),
        ("specimens", "Specimens", parts.specimens_section(groups, pictures) if groups else ""),
        ("material", "Material", _material(result)),
        ("run", "Run", run_section(result)),
        ("case", "Case file", page.section("case", "Case file", page.toml(case_text)) if case_text else ""),
    ]
    present = [(anchor, name, body) for anchor, name, body in content if body]
    html = page.document(
        f"{result['title']}: laboratory",
        {anchor: name for anchor, name, _ in present},
        "\n".join(body for *_, body in present),
    )
    write_figures(path.parent / "figures", pictures)
    write_whole(path, html)


HELD_BACK = frozenset(
    {
        "cracks", "envelope", "properties", "tests", "material", "specimen", "compile_time_s", "test_time_s",
        "targets", "rounds", "missed", "fresh", "reached", "narrow", "material_file",
    }
)  # fmt: skip
"""What the report tells elsewhere than among its run's numbers."""


def run_section(result: Mapping[str, Any]) -> str:
    """What the run cost: times in all processes, side by side, may add up to more than it took."""
    times = {"testing, all processes": "test_time_s", "compiling, all processes": "compile_time_s"}
    settings = {name: wording.seconds(result[key]) for name, key in times.items() if key in result}
    return sections.run({k: v for k, v in result.items() if k not in HELD_BACK} | {"settings": settings})


def write_figures(folder: Path, pictures: Mapping[str, sections.Picture]) -> None:
    """The figures as files, and none that an earlier run left."""
    for name, picture in pictures.items():
        write_whole(folder / f"{name}.png", picture.png)
    for stale in folder.glob("*.png"):
        if stale.stem not in pictures:
            try:
                stale.unlink()
            except OSError as error:
                raise cannot_write(stale, error) from error


def headline(properties: Sequence[Property]) -> tuple[str, str, str]:
    """What is found first: its name, the number with its unit, and how it scatters."""
    if not properties:
        return "No test is finished yet", "", ""
    chosen = next((entry for entry in properties if entry.key.endswith("strength_Pa")), properties[0])
    found = chosen.spread
    specimens = "1 specimen" if found.specimens == 1 else f"{found.specimens} specimens"
    how = f"over {specimens}"
    if found.specimens > 1:
        how = f"± {deviation_shown(found.mean, found.deviation, chosen.quantity)} {how}"
    return chosen.name, rounded(found.mean, chosen.quantity), how


def _answer(result: Mapping[str, Any], properties: Sequence[Property]) -> str:
    name, number, how = headline(properties)
    blocks = [
        f'<header id="answer">\n<p class="case-title">{text(result["title"])}</p>',
        f'<h1>{text(name[0].upper() + name[1:])} <span class="number">{text(number)}</span> '
        f'<span class="how">{text(how)}</span></h1>',
    ]
    if properties:
        blocks.append(parts.properties_table(properties))
    blocks.append(f'<p class="static">{text(parts.SIGN)}')
    if result["dimension"] == 2:
        blocks.append(text(parts.PLATE))
    blocks.append("</p>")
    warnings = result.get("warnings") or ()
    if warnings:
        blocks.append(f'<div class="note"><p><strong>Warnings</strong></p>{page.bullets(warnings)}</div>')
    return "\n".join([*blocks, "</header>"])


def _material(result: Mapping[str, Any]) -> str:
    material, specimen = result["material"], result["specimen"]
    rows = [
        ("law of the bonds", material["bond_law"]),
        ("law of the contacts", material["contact_law"]),
        ("density of the grains", show(material["density"], "density")),
        ("bonding range", f"{material['bonding_range']:g}"),
        *((f"bond: {_words(key)}", _parameter(key, value)) for key, value in material["bond"].items()),
        *((f"contact: {_words(key)}", _parameter(key, value)) for key, value in material["contact"].items()),
    ]
    if material["variation"]:
        scatter = f"{material['distribution']}, coefficient of variation {material['variation']:g}"
        rows.append(("scatter of the bonds' strengths", scatter))
    size = [f"{1e3 * value:.4g} mm" for value in specimen["size_m"]]
    cut = [
        ("packing", specimen["packing"]),
        ("shape", specimen["shape"]),
        ("size", " x ".join(size)),
        ("particles across", f"{specimen['across']:g}"),
        ("particles of one specimen", f"{result['particles']:,}"),
    ]
    return page.section(
        "material", "Material and specimen", page.pairs(rows), "<h3>Specimen</h3>", page.pairs(cut)
    )


def _words(key: str) -> str:
    return key.replace("_", " ")


def _parameter(key: str, value: float | None) -> str:
    if value is None:
        return "infinite"
    if key.endswith(("modulus", "_strength", "cohesion")):
        return rounded(value, "stress", 6)
    return f"{value:.6g}"
