"""Case files spoilt in their keys, numbers, units, words and nesting."""

from __future__ import annotations

import datetime
import json
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from typing import Any

from hypothesis import strategies as st

Document = dict[str, Any]

WORDS = (
    "", " ", "none", "unlimited", "0", "-1", "10 kPa", "-10 kPa", "10 kN/m3", "1e999 Pa", "1e-999 m",
    "nan m", "inf Pa",
    "10,5 kPa", "1.000,5 kPa", "12 furlong", "5 kPa/", "٣ m", "𝟑 m", "１０ kPa", "5 °", "5 µm", "1e308 GPa",
    "3 m3", "30 %", "1e5 %", "a" * 5000, "\u0000", "\u202egnp.noitces", "🪨", "é" * 80, "soil", "rock", "random",
    "\\", "'", '"', "{", "[red]x[/red]", "%s{0}", "../section.png", "../../../../../../etc/passwd",
    "/etc/shadow", "/dev/zero", "/dev/stdin",
    "/proc/self/mem", ".", "..", "/", "~", "section.png", "slices", "heights.asc", "heights.npz", "heights.tif",
    "section.msh", "section4.msh", "section.vtk", "section.vtu", "section.inp", "box.msh", "box.stl",
    "box-binary.stl",
    "box.vtk", "rock.toml", "case.toml", "scan.vti", "n/\u0000o.png", "x" * 300 + ".png", "#ffffff", "#12",
    "transparent",
    "slope", "ground", "laboratory", "calibration", "triaxial-compression", "brazilian", "mohr_coulomb",
    "flat_joint",
)  # fmt: skip
NUMBERS = (
    0, -1, 1, 2, 3, 10**9, 2**31, 2**63, -(2**63), 10**30, 10**400, 0.0, -0.0, 1e-320, 1e-9, 0.5, 1e9,
    1e22, 1e300,
    math.nan, math.inf, -math.inf, True, False,
)  # fmt: skip
OTHERS: tuple[Any, ...] = (
    [], {}, [[]], [{}], [1, 2], ["10 m", "2 m"], [[0, 0], [1, 1]], [[0, 0], [10, 0], [10, 5]], [math.nan,
    0], {"a": 1},
    datetime.date(1979, 5, 27), datetime.time(7, 32), datetime.datetime(1979, 5, 27, 7, 32), [10**400],
    ["a", "a"],
)  # fmt: skip

KEYS = ("a", "", "material", "section", "source", "workflow", "particles", "ä", "a.b", "\u0000", "é" * 200,
"file",
        "law", "names", "-1", "999999999999999999999", "7" * 5000)  # fmt: skip
FACTORS = (0.0, -1.0, 0.01, 0.1, 0.3, 0.5, 0.8, 1.001, 1.5, 2.0, 3.0, 10.0, 100.0)
OPERATIONS = (
    "value",
    "value",
    "value",
    "value",
    "scale",
    "unit",
    "delete",
    "rename",
    "add",
    "twice",
    "swap",
    "wrap",
    "deep",
)
MILD = ("nudge",) * 8 + ("scale", "value", "delete", "add", "twice", "swap", "turn")
"""Changes after which most cases can still be read."""


def spoilt(
    seeds: list[Document], operations: Sequence[str] = OPERATIONS
) -> st.SearchStrategy[tuple[int, str]]:
    """The number of one of `seeds`, and it with up to four changes as TOML."""
    values = st.one_of(
        st.sampled_from(WORDS),
        st.sampled_from(NUMBERS),
        st.sampled_from(OTHERS),
        st.floats(),
        st.integers(),
        st.text(max_size=12),
    )
    change = st.tuples(
        st.sampled_from(operations),
        st.integers(0, 10**6),
        st.integers(0, 10**6),
        values,
        st.sampled_from(KEYS),
    )
    few = st.one_of(change.map(lambda one: [one]), st.lists(change, min_size=1, max_size=4))
    return st.builds(
        lambda number, changes: (number, toml(_changed(seeds[number], changes))),
        st.integers(0, len(seeds) - 1),
        few,
    )


def _changed(seed: Document, changes: list[tuple[str, int, int, Any, str]]) -> Document:
    document = deepcopy(seed)
    for operation, first, second, value, key in changes:
        places = _places(document)
        if not places:
            return document
        _CHANGES[operation](places, first, second, deepcopy(value), key)
    return document


Place = tuple[Any, Any]


def _places(value: Any) -> list[Place]:
    """Every entry of a document as its holder and its key, those of tables first."""
    found: list[Place] = []
    holders = [value]
    while holders:
        holder = holders.pop()
        keys = list(holder) if isinstance(holder, dict) else range(len(holder))
        for key in keys:
            found.append((holder, key))
            if isinstance(holder[key], dict | list):
                holders.append(holder[key])
    return found


def _value(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    holder, name = places[first % len(places)]
    holder[name] = value


def _scale(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    """A number or the number of a quantity, by a power of ten."""
    holder, name = places[first % len(places)]
    found, power = holder[name], second % 40 - 20
    if isinstance(found, str) and found[:1].isdigit():
        number, _, unit = found.partition(" ")
        holder[name] = f"{number}e{power} {unit}"
    elif isinstance(found, int | float) and not isinstance(found, bool):
        holder[name] = found * 10**power if power > 0 else -found


def _nudge(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    """A number, or the number of a quantity, among all numbers of the document, times a small factor."""
    numbers = [(holder, name) for holder, name in places if _number(holder[name]) is not None]
    if not numbers:
        return
    holder, name = numbers[first % len(numbers)]
    found, factor = holder[name], FACTORS[second % len(FACTORS)]
    number = _number(found)
    assert number is not None
    if isinstance(found, str):
        holder[name] = f"{number * factor:.6g} {found.partition(' ')[2]}"
    else:
        holder[name] = round(number * factor) if isinstance(found, int) else number * factor


def _number(found: Any) -> float | None:
    """The number of a value, 0 as a coordinate 1 so that it can be moved; None of what has none."""
    if isinstance(found, bool):
        return None
    if isinstance(found, str):
        text = found.partition(" ")[0]
        try:
            return float(text)
        except ValueError:
            return None
    if isinstance(found, int | float) and abs(found) < 1e300:
        return float(found) or 1.0
    return None


def _turn(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    """A word by another word of the document: a material, a side, a kind, a name."""
    words = [(holder, name) for holder, name in places if isinstance(holder[name], str)]
    if words:
        holder, name = words[first % len(words)]
        other, at = words[second % len(words)]
        holder[name] = other[at]


def _unit(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    holder, name = places[first % len(places)]
    if isinstance(holder[name], str):
        units = (
            "",
            "m",
            "kPa",
            "Pa",
            "deg",
            "g",
            "kN/m3",
            "mPa",
            "KPA",
            "kg",
            "µm",
            "m/px",
            "%",
            "t/m2",
            "psf",
            "°",
            "grad",
        )
        holder[name] = f"{holder[name].partition(' ')[0]} {units[second % len(units)]}"


def _delete(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    holder, name = places[first % len(places)]
    del holder[name]


def _rename(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    holder, name = places[first % len(places)]
    if isinstance(holder, dict):
        other = places[second % len(places)][1]
        holder[other if isinstance(other, str) and second % 2 else key] = holder.pop(name)


def _add(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    holder, _ = places[first % len(places)]
    if isinstance(holder, dict):
        other = places[second % len(places)][1]
        holder[other if isinstance(other, str) and second % 3 else key] = value
    else:
        holder.insert(second % (len(holder) + 1), value)


def _twice(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    holder, name = places[first % len(places)]
    if isinstance(holder, list):
        holder.append(deepcopy(holder[name]))
    else:
        holder[f"{name}2"] = deepcopy(holder[name])


def _swap(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    (a, i), (b, j) = places[first % len(places)], places[second % len(places)]
    one, two = deepcopy(a[i]), deepcopy(b[j])
    a[i], b[j] = two, one


def _wrap(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    holder, name = places[first % len(places)]
    holder[name] = [holder[name]] if second % 2 else {key: holder[name]}


def _deep(places: list[Place], first: int, second: int, value: Any, key: str) -> None:
    holder, name = places[first % len(places)]
    for _ in range((5, 30, 200)[second % 3]):
        value = [value] if second % 2 else {"a": value}
    holder[name] = value


_CHANGES: Mapping[str, Callable[[list[Place], int, int, Any, str], None]] = {
    "value": _value, "scale": _scale, "unit": _unit, "delete": _delete, "rename": _rename, "add": _add,
    "twice": _twice, "swap": _swap, "wrap": _wrap, "deep": _deep, "nudge": _nudge, "turn": _turn,
}  # fmt: skip


def toml(document: Document) -> str:
    """A document as TOML, each top-level entry on its line."""
    return "".join(f"{_text(key)} = {_toml(value)}\n" for key, value in document.items())


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else {"inf": "inf", "-inf": "-inf"}.get(repr(value), "nan")
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{_text(key)} = {_toml(inner)}' for key, inner in value.items())}}}"
    return str(value) if isinstance(value, int) else value.isoformat()


def _text(text: str) -> str:
    """A basic string; what JSON would write as two surrogates stands as it is."""
    return (
        "".join(json.dumps(c)[1:-1] if ord(c) < 0x80 else c for c in text)
        .replace("\x7f", "\\u007f")
        .join('""')
    )


def documents(texts: list[str]) -> list[Document]:
    """The parsed texts."""
    return [tomllib.loads(text) for text in texts]


def spoilt_text(seeds: list[bytes]) -> st.SearchStrategy[bytes]:
    """Bytes of one of `seeds`, cut, repeated, turned and mixed with others."""
    edit = st.tuples(
        st.sampled_from(("cut", "drop", "insert", "flip", "repeat", "line", "token")), st.integers(0,
        10**7), st.integers(0, 10**7),
        st.one_of(st.binary(max_size=8), st.sampled_from(_PIECES)),
    )  # fmt: skip
    return st.builds(
        lambda number, edits: _edited(seeds[number], edits),
        st.integers(0, len(seeds) - 1),
        st.lists(edit, min_size=1, max_size=4),
    )


_PIECES = (
    b"\x00", b"\xff\xfe", b"\xef\xbb\xbf", b"\n", b"\r\n", b"nan", b"inf", b"-1", b"1e999",
    b"99999999999999999999", b"\xc3\x28", b"[[", b"]]", b"=",
    b'"""', b"#", b"0", b"1e308", b"-0", b"2147483648", b"$", b"<", b">", b"&", b"4294967295", b"1_000",
    b"0x1f", b"\t" * 50,
)  # fmt: skip


def _edited(content: bytes, edits: list[tuple[str, int, int, bytes]]) -> bytes:
    for kind, first, second, piece in edits:
        size = max(len(content), 1)
        at, to = sorted((first % size, (first + second % 200) % size))
        if kind == "cut":
            content = content[: first % size]
        elif kind == "drop":
            content = content[:at] + content[to:]
        elif kind == "insert":
            content = content[:at] + piece + content[at:]
        elif kind == "flip":
            content = (
                content[:at] + bytes([content[at] ^ (1 << second % 8)]) + content[at + 1 :]
                if content
                else b""
            )
        elif kind == "repeat":
            content = content[:to] + content[at:]
        elif kind == "line":
            lines = content.split(b"\n")
            lines.insert(second % (len(lines) + 1), lines[first % len(lines)])
            content = b"\n".join(lines)
        else:
            words = content.split(b" ")
            words[first % len(words)] = piece
            content = b" ".join(words)
    return content
