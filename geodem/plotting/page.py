"""The frame of the report: style sheet, and the few kinds of blocks that it is set from.

Everything that is not made here goes through `text`, so that nothing in a case file can become markup.
"""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from geodem.plotting.stylesheet import STYLE


def text(value: object) -> str:
    """Any value as harmless text."""
    return html.escape(str(value), quote=True)


def table(
    header: Sequence[str], rows: Iterable[Sequence[object]], *, numbers: Iterable[int] = (), kind: str = ""
) -> str:
    """A table; the columns in `numbers` are set to the right. Entries of class `Markup` are not escaped."""
    right = set(numbers)

    def cell(tag: str, place: int, value: object) -> str:
        scope = ' scope="col"' if tag == "th" else ""
        side = ' class="n"' if place in right else ""
        return f"<{tag}{scope}{side}>{value if isinstance(value, Markup) else text(value)}</{tag}>"

    head = "".join(cell("th", place, name) for place, name in enumerate(header))
    body = "\n".join(
        "<tr>" + "".join(cell("td", place, value) for place, value in enumerate(row)) + "</tr>"
        for row in rows
    )
    named = f' class="{kind}"' if kind else ""
    return (
        f'<div class="scroll"><table{named}><thead><tr>{head}</tr></thead>\n'
        f"<tbody>\n{body}\n</tbody></table></div>"
    )


def pairs(rows: Iterable[tuple[object, object]]) -> str:
    """Names and values, one pair a line."""
    body = "".join(
        f"<div><dt>{text(name)}</dt><dd>{value if isinstance(value, Markup) else text(value)}</dd></div>"
        for name, value in rows
    )
    return f'<dl class="pairs">{body}</dl>'


def figure(
    picture: bytes, caption: str, *, alternative: str, kind: str = "image/png", wide: bool = True
) -> str:
    """A picture inside the page itself, with its caption (escaped)."""
    data = base64.b64encode(picture).decode("ascii")
    return (
        f'<figure class="{"wide" if wide else "half"}"><div class="paper">'
        f'<img alt="{text(alternative)}" src="data:{kind};base64,{data}"></div>'
        f"<figcaption>{text(caption)}</figcaption></figure>"
    )


def bullets(items: Iterable[object]) -> str:
    """A plain list."""
    return "<ul>" + "".join(f"<li>{text(item)}</li>" for item in items) + "</ul>"


def section(anchor: str, title: str, *blocks: str) -> str:
    """A part of the page that the contents line leads to."""
    body = "\n".join(block for block in blocks if block)
    return f'<section id="{anchor}">\n<h2>{text(title)}</h2>\n{body}\n</section>'


class Markup(str):
    """Text that is markup already and made here."""

    __slots__ = ()


def toml(source: str) -> str:
    """A case file with tables, keys and comments told apart."""
    lines = []
    for line in source.splitlines():
        code, comment = _split_comment(line)
        stripped = code.strip()
        if stripped.startswith("["):
            shown = f'<b class="t">{text(code)}</b>'
        elif "=" in code:
            key, _, value = code.partition("=")
            shown = f'<span class="k">{text(key)}</span>={text(value)}'
        else:
            shown = text(code)
        lines.append(shown + (f'<span class="c">{text(comment)}</span>' if comment else ""))
    return '<pre class="case">' + "\n".join(lines) + "</pre>"


def document(title: str, contents: Mapping[str, str], body: str) -> str:
    """The whole page."""
    links = " ".join(f'<a href="#{anchor}">{text(name)}</a>' for anchor, name in contents.items())
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta name="color-scheme" content="light dark">\n'
        f"<title>{text(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f'<nav aria-label="Contents">{links}</nav>\n<main>\n{body}\n</main>\n</body>\n</html>\n'
    )


def scale_bar(
    value: float, bounds: tuple[float, float], *, band: tuple[float, float] | None, strong: bool
) -> Any:
    """One row of the comparison: a mark at `value` between `bounds`, the bracket as a band behind it."""
    low, high = bounds
    wide, tall = 260.0, 22.0

    def place(at: float) -> float:
        return 8.0 + (wide - 16.0) * (at - low) / (high - low)

    shapes = [f'<line x1="0" x2="{wide:g}" y1="{tall / 2:g}" y2="{tall / 2:g}" class="axis"/>']
    if band is not None:
        left = place(band[0])
        width = max(place(band[1]) - left, 1.5)
        shapes.append(f'<rect x="{left:.1f}" width="{width:.1f}" y="0" height="{tall:g}" class="band"/>')
    radius, name = (5.5, "ours") if strong else (4.5, "theirs")
    shapes.append(f'<circle cx="{place(value):.1f}" cy="{tall / 2:g}" r="{radius}" class="{name}"/>')
    return Markup(
        f'<svg class="scale" viewBox="0 0 {wide:g} {tall:g}" aria-hidden="true">{"".join(shapes)}</svg>'
    )


def _split_comment(line: str) -> tuple[str, str]:
    quote = ""
    for place, letter in enumerate(line):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter == "#":
            return line[:place], line[place:]
    return line, ""
