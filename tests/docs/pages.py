"""What the tests of the documentation share: its pages, their links, snippets and tables."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
DOCS = ROOT / "docs"

LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")


def pages() -> list[Path]:
    """Every page of Markdown that a reader meets."""
    return [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted(DOCS.rglob("*.md"))]


def prose(text: str) -> str:
    """A page without its blocks of code, whose brackets are no links."""
    without_fences = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
    return re.sub(r"^(?: {4}|\t).*$", "", without_fences, flags=re.M)


def snippet(page: Path, language: str) -> str:
    """The one fenced block of that language."""
    found = re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    assert len(found) == 1, f"{page}: {len(found)} blocks of {language}"
    return str(found[0])


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, as Markdown's table of contents makes them."""
    from markdown.extensions.toc import slugify

    headings = re.findall(r"^#+ (.*)$", prose(page.read_text(encoding="utf-8")), flags=re.M)
    return {slugify(heading, "-") for heading in headings}


def tables(page: Path) -> dict[str, list[list[str]]]:
    """Rows of cells by heading; the header and its rule are left out."""
    found: dict[str, list[list[str]]] = {}
    heading = ""
    header = False
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            heading = line.lstrip("# ")
        if not line.startswith("|"):
            header = True
            continue
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        if header or set(line) <= set("|- "):
            header = False
            continue
        found.setdefault(heading, []).append([cell.strip("| ") for cell in cells])
    return found
