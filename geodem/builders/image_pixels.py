"""Read a picture file into plain colours, whatever way it stores them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.errors import InputError

# Formats whose decoders need nothing but pillow; a vector format would start another program.
_FORMATS = ("PNG", "BMP", "JPEG", "GIF", "TIFF", "WEBP")
# MPO: what pillow calls a JPEG with a second picture inside, as telephones store it
_LOSSY_FORMATS = ("JPEG", "MPO", "WEBP")
_LARGEST = 20_000_000
_SMALLEST_SIDE = 4
TOO_LARGE = (
    f"the picture has more than {_LARGEST // 10**6} million pixels",
    "Reduce it; 2000 pixels a side are ample.",
)
"""Problem and remedy."""


class Pixels(NamedTuple):
    """A picture as it is seen: rows from the top, columns from the left.

    Parameters
    ----------
    colour : ndarray of uint8, shape (rows, columns, 3)
        Red, green and blue, not multiplied by the opacity.
    opacity : ndarray of uint8, shape (rows, columns)
        0 transparent, 255 opaque.
    lossy : bool
        Whether the file format changes colours near edges.
    """

    colour: NDArray[np.uint8]
    opacity: NDArray[np.uint8]
    lossy: bool


def read_pixels(path: Path, place: str) -> Pixels:
    """Read a picture of any depth, palette, transparency and orientation.

    Parameters
    ----------
    path : Path
        PNG, BMP, JPEG, GIF, TIFF or WebP file.
    place : str
        Key of the case file that the errors name.

    Returns
    -------
    Pixels
        16-bit values are rounded to 8 bits, the EXIF orientation is applied, and of several frames the first
        counts.

    Raises
    ------
    InputError
        The file is missing, cannot be read, is no picture, or is too small or too large.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError

    shown = str(path)
    if not path.exists():
        raise InputError(
            place, "the file does not exist", "Give a path relative to the case file.", value=shown
        )
    if path.is_dir():
        raise InputError(place, "this is a folder", "Give the picture file itself.", value=shown)
    try:
        with Image.open(path, formats=_FORMATS) as stored:
            columns, rows = stored.size
            if min(columns, rows) < _SMALLEST_SIDE:
                raise InputError(
                    place,
                    f"the picture has {columns} x {rows} pixels, too few to trace",
                    "Draw it with at least 200 pixels over the height of the ground.",
                    value=shown,
                )
            if columns * rows > _LARGEST:
                raise InputError(
                    place,
                    f"the picture has {columns} x {rows} pixels, more than {_LARGEST}",
                    TOO_LARGE[1],
                    value=shown,
                )
            lossy = stored.format in _LOSSY_FORMATS
            red_green_blue_alpha = np.asarray(_eight_bit(ImageOps.exif_transpose(stored)))
    except UnidentifiedImageError as error:
        raise InputError(
            place, "the file is not a picture that can be read", "Give a PNG, BMP or JPEG file.", value=shown
        ) from error
    except Image.DecompressionBombError as error:
        raise InputError(place, *TOO_LARGE, value=shown) from error
    except (OSError, SyntaxError, EOFError) as error:
        raise InputError(
            place, f"the picture is damaged ({error})", "Save it again as PNG.", value=shown
        ) from error
    return Pixels(red_green_blue_alpha[..., :3], red_green_blue_alpha[..., 3], lossy)


def _eight_bit(image: Any) -> Any:
    """The picture in red, green, blue and opacity of 8 bits each."""
    from PIL import Image

    if image.mode == "F" or image.mode.startswith("I"):
        deep = np.asarray(image).astype(float)
        transparent = image.info.get("transparency")
        # 257 = 65535 / 255; a float picture holds either 0..1 or 0..255
        if image.mode != "F":
            grey = deep / 257.0
        else:
            grey = deep * (255.0 if deep.size and deep.max() <= 1.0 else 1.0)
        levels = np.clip(np.rint(grey), 0, 255).astype(np.uint8)
        opacity = np.full_like(levels, 255)
        if isinstance(transparent, int):
            opacity[deep == transparent] = 0
        return Image.fromarray(np.dstack([levels, levels, levels, opacity]), "RGBA")
    return image.convert("RGBA")
