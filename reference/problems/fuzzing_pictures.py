"""Pictures and archives of arrays of all sorts, whole and broken."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from hypothesis import strategies as st
from PIL import Image, ImageDraw

MODES = ("1", "L", "LA", "P", "RGB", "RGBA", "CMYK", "I;16", "I", "F", "YCbCr")
ENDINGS = {
    "png": "PNG",
    "bmp": "BMP",
    "gif": "GIF",
    "tif": "TIFF",
    "jpg": "JPEG",
    "webp": "WEBP",
    "ppm": "PPM",
}
SIDES = (60, 40, 90, 120, 24, 16, 1, 2, 3, 4, 5, 7)
LARGE = ((20_000, 20_000), (65_000, 1), (1, 65_000), (9_000, 5_000), (4_400, 4_400))
"""Sizes beyond what is read, and large ones that are."""


class Spec(NamedTuple):
    """How a picture is made and spoilt."""

    mode: str
    ending: str
    size: tuple[int, int]
    drawing: int
    seed: int
    spoil: str
    at: int
    reader: int


_SIZES = st.one_of(
    st.tuples(st.sampled_from(SIDES[:6]), st.sampled_from(SIDES[:6])),
    st.tuples(st.sampled_from(SIDES), st.sampled_from(SIDES)),
    st.tuples(st.integers(20, 150), st.integers(20, 150)),
)
SPECS = st.builds(
    Spec, st.sampled_from(MODES), st.sampled_from(tuple(ENDINGS)), _SIZES, st.integers(0, 5),
    st.integers(0, 10**6),
    st.sampled_from(("none", "none", "none", "cut", "flip", "bytes", "ending", "large")), st.integers(0, 10**7),
    st.integers(0, 3),
)  # fmt: skip


def write(folder: Path, spec: Spec) -> Path:
    """The file of a picture; where a format cannot hold the mode it is written as RGB."""
    path = folder / f"picture.{spec.ending}"
    if spec.spoil == "large":
        columns, rows = LARGE[spec.at % len(LARGE)]
        Image.new("1", (columns, rows)).save(folder / "picture.png", optimize=False)
        return folder / "picture.png"
    picture = _draw(spec)
    buffer = io.BytesIO()
    try:
        picture.save(buffer, ENDINGS[spec.ending])
    except (OSError, ValueError, KeyError):
        buffer = io.BytesIO()
        picture.convert("RGB").save(buffer, ENDINGS[spec.ending])
    content = buffer.getvalue()
    at = spec.at % len(content)
    if spec.spoil == "cut":
        content = content[:at]
    elif spec.spoil == "flip":
        content = content[:at] + bytes([content[at] ^ (1 << spec.seed % 8)]) + content[at + 1 :]
    elif spec.spoil == "bytes":
        content = content[:at] + np.random.default_rng(spec.seed).bytes(20) + content[at + 20 :]
    elif spec.spoil == "ending":
        path = folder / ("picture.jpg" if spec.ending != "jpg" else "picture.tif")
    path.write_bytes(content)
    return path


def _draw(spec: Spec) -> Image.Image:
    """Ground of two colours under a sky, one colour, noise, islands, or lines."""
    columns, rows = spec.size
    rng = np.random.default_rng(spec.seed)
    picture = Image.new("RGBA", (columns, rows), "#8c6d31ff")
    pen = ImageDraw.Draw(picture)
    if spec.drawing == 0:
        pen.rectangle([0, 0, columns // 2, rows // 2], fill="#ffffffff")
        pen.rectangle([0, rows // 2 + 1, columns, rows // 2 + 3], fill="#d62728ff")
    elif spec.drawing == 1:
        picture = Image.fromarray(rng.integers(0, 256, (rows, columns, 4), dtype=np.uint8), "RGBA")
    elif spec.drawing == 2:
        for _ in range(6):
            x, y = float(rng.integers(0, columns)), float(rng.integers(0, rows))
            fill = ("#d62728ff", "#ffffffff", "#8c6d3180", "#00000000")[rng.integers(4)]
            across, down = float(rng.integers(1, columns + 1)), float(rng.integers(1, rows + 1))
            pen.ellipse([x, y, x + across, y + down], fill=fill)
    elif spec.drawing == 3:
        colours = np.array([[140, 109, 49, 255], [214, 39, 40, 255], [255, 255, 255, 255]], dtype=np.uint8)
        picture = Image.fromarray(colours[rng.integers(0, 3, (rows, columns))], "RGBA")
    elif spec.drawing == 4:
        pen.line([0, 0, columns, rows], fill="#d62728ff", width=1 + spec.seed % 4)
    if spec.mode in ("I;16", "I", "F"):
        grey = (
            np.asarray(picture.convert("L")).astype(float) * {"I;16": 257.0, "I": 5e4, "F": 1e-3}[spec.mode]
        )
        if spec.mode == "F" and spec.seed % 3 == 0:
            grey[0, 0] = (np.nan, np.inf, -1e30)[spec.at % 3]
        kind = {"I;16": np.uint16, "I": np.int32, "F": np.float32}[spec.mode]
        return Image.fromarray(grey.astype(kind))
    if spec.mode == "P":
        return picture.convert("RGB").quantize(max(2, spec.seed % 8))
    return (
        picture.convert("RGB").convert(spec.mode)
        if spec.mode in ("CMYK", "YCbCr")
        else picture.convert(spec.mode)
    )


_SHAPES = ((), (1,), (2,), (3,), (2, 2), (3, 2), (4, 5), (2, 2, 2), (0,), (0, 3))
_KINDS = ("f8", "f4", "i8", "u1", "c16", "U3", "?", "M8[s]", "S2")
_NAMES = ("x", "y", "z", "elevation", "dx", "dy", "xmin", "ymin", "xmax", "a")
ARCHIVES = st.dictionaries(
    st.sampled_from(_NAMES),
    st.tuples(st.sampled_from(_SHAPES), st.sampled_from(_KINDS), st.integers(0, 5)),
    max_size=6,
)
"""What an archive holds: shape, kind and sort of the values of each name."""


def archive(held: dict[str, tuple[tuple[int, ...], str, int]]) -> bytes:
    """Bytes of such an archive."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **{name: _array(*entry) for name, entry in held.items()})
    return buffer.getvalue()


def _array(shape: tuple[int, ...], kind: str, sort: int) -> Any:
    size = int(np.prod(shape, dtype=int))
    values = np.arange(size, dtype=float) * (1.0, -1.0, 1e300, 1e-300, 1.0, 1.0)[sort]
    if sort == 4 and size:
        values[-1] = np.nan
    if kind in ("U3", "S2"):
        return np.full(shape, "abc").astype(kind)
    with np.errstate(all="ignore"):
        return values.astype("i8" if kind == "M8[s]" else kind).astype(kind).reshape(shape)
