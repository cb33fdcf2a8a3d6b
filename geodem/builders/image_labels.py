"""Say of every pixel of a picture which material it shows, edges and noise included."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.builders.image_pixels import Pixels, read_pixels
from geodem.errors import InputError

TRANSPARENT = "transparent"
# A colour that is neither listed nor a mixture may cover this share of the picture before it is refused.
_UNLISTED_SHARE = 5e-4
_OPAQUE = 128
_UNEVEN_SHARE = 0.01
_THINNEST_LOSSY = 2.5


class _Tolerances(NamedTuple):
    """Distances in 8-bit colour space, and sizes in pixels, for one kind of file."""

    sure: float  # from a listed colour
    mixture: float  # from the straight line between two listed colours
    rim: int  # widest rim of mixed pixels, plus one
    reach: int  # how far from a mixed pixel its two colours may be
    speckle: int  # smallest area that is kept


_EXACT = _Tolerances(sure=16.0, mixture=20.0, rim=3, reach=2, speckle=8)
# JPEG halves the resolution of colour and rings around edges: quality 75 leaves 20 to 40 levels there.
_LOSSY = _Tolerances(sure=48.0, mixture=60.0, rim=4, reach=3, speckle=16)


@dataclass(frozen=True)
class LabelImage:
    """What every pixel shows.

    Parameters
    ----------
    labels : ndarray of int16, shape (rows, columns)
        0 for background, k + 1 for ``materials[k]``; row 0 is the top row of the file.
    materials : tuple of str
        In the order of the legend.
    shares : dict of str to float
        Part of all pixels that each material covers, by whole pixels.
    classes : ndarray of int16, shape (rows, columns)
        Index into ``palette``: the listed colour that prevails in the pixel.
    palette : ndarray of float64, shape (colours, 4)
        Listed colours, red, green and blue multiplied by the opacity, and the opacity, 0 to 255 each.
    pixels : Pixels
        The picture itself.
    lossy : bool
        Whether the colours are noisy: a JPEG, or a PNG that was made from one.
    """

    labels: NDArray[np.int16]
    materials: tuple[str, ...]
    shares: dict[str, float]
    classes: NDArray[np.int16]
    palette: NDArray[np.float64]
    pixels: Pixels
    lossy: bool


def label_image(
    path: str | Path,
    *,
    legend: Mapping[str, str],
    background: Sequence[str] | None = None,
    picture: Path | None = None,
    place: str = "section",
) -> LabelImage:
    """Assign every pixel of a picture to a material or to the background.

    Parameters
    ----------
    path : str or Path
        Picture file.
    legend : mapping of str to str
        Material of each colour, for example ``{"#8c6d31": "soil"}``; several colours may mean one material.
    background : sequence of str, optional
        Colours that are not ground; left out: white, unless the legend lists it. Pixels of opacity below one
        half are always background.
    picture : Path, optional
        Where to write the picture that shows unlisted colours (PNG); left out: a new temporary folder.
    place : str
        Table of the case file that the errors name.

    Returns
    -------
    LabelImage
        Pixels that mix two colours at an edge go to the colour that prevails; specks of a few pixels go to
        what surrounds them.

    Raises
    ------
    InputError
        A file that cannot be read, a colour that cannot be read or stands for two things, a picture with a
        colour that is not listed, without a listed one, or without any ground.
    """
    rgb, owners, materials, keys = _palette(legend, background, place)
    pixels = read_pixels(Path(path), f"{place}.image")
    classes, unlisted, lossy = _classify(pixels, rgb, owners)
    if unlisted is not None:
        raise _unlisted_error(pixels, unlisted, rgb, owners, keys, picture, f"{place}.legend", str(path))

    labels = owners[classes]
    if not labels.any():
        raise InputError(
            f"{place}.image",
            "the whole picture is background",
            f"Look whether the legend colours ({', '.join(legend)}) are those of the picture.",
            value=str(path),
        )
    counts = np.bincount(classes.ravel(), minlength=len(owners))
    for index, key in enumerate(legend):
        if counts[index] == 0:
            raise InputError(
                f'{place}.legend."{key}"',
                "the picture does not show this colour, beyond specks of a few pixels",
                "Take the entry away or give the colour as it is in the picture.",
                value=legend[key],
            )
    if lossy:
        _refuse_thin_seams(labels, materials, f"{place}.image", str(path))
    per_label = np.bincount(labels.ravel(), minlength=len(materials) + 1) / labels.size
    shares = {name: float(per_label[k + 1]) for k, name in enumerate(materials)}
    palette = np.c_[rgb.astype(float), np.full(len(rgb), 255.0)]
    palette[-1] = 0.0
    return LabelImage(labels, materials, shares, classes, palette, pixels, lossy)


def _refuse_thin_seams(labels: NDArray[np.int16], materials: tuple[str, ...], place: str, path: str) -> None:
    """Refuse seams that the compression may have cut to pieces: a weak seam with holes is another problem."""
    from skimage.measure import perimeter_crofton

    for index, name in enumerate(materials):
        mask = np.pad(labels == index + 1, 1)
        # a strip's area is half its perimeter times its thickness
        thickness = 2.0 * float(mask.sum()) / float(perimeter_crofton(mask, directions=4))
        if thickness < _THINNEST_LOSSY:
            raise InputError(
                place,
                f"{name!r} is about {thickness:.1f} px thick, and compression as in a JPEG blurs what is "
                f"thinner than {_THINNEST_LOSSY:g} px",
                "Save the drawing as PNG, or draw it with more pixels.",
                value=path,
            )


def _palette(
    legend: Mapping[str, str], background: Sequence[str] | None, place: str
) -> tuple[NDArray[np.int64], NDArray[np.int16], tuple[str, ...], list[str]]:
    """Colours (legend, background, transparent last), the label of each, material names, colours as typed."""
    if not legend:
        raise InputError(
            f"{place}.legend", "no colour is listed", 'Give at least one, for example {"#8c6d31" = "soil"}.'
        )
    materials = tuple(dict.fromkeys(legend.values()))
    keys: list[str] = []
    colours: list[tuple[int, ...]] = []
    owners: list[int] = []
    for key, material in legend.items():
        keys.append(key)
        colours.append(parse_colour(key, f'{place}.legend."{key}"'))
        owners.append(materials.index(material) + 1)
    if background is None:
        background = [] if (255, 255, 255) in colours else ["#ffffff"]
    for key in background:
        if key != TRANSPARENT:
            keys.append(key)
            colours.append(parse_colour(key, f"{place}.background"))
            owners.append(0)
    for i, one in enumerate(colours):
        for j in range(i):
            if one == colours[j]:
                raise InputError(
                    f'{place}.legend."{keys[j]}"' if owners[j] else f"{place}.background",
                    f"the colour stands twice, as {keys[j]} and {keys[i]}",
                    "List every colour once.",
                )
    return (
        np.array([*colours, (0, 0, 0)], dtype=np.int64),
        np.array([*owners, 0], dtype=np.int16),
        materials,
        [*keys, TRANSPARENT],
    )


def parse_colour(text: str, place: str) -> tuple[int, ...]:
    """Red, green and blue of "#rrggbb", or `InputError`."""
    digits = text.strip().lstrip("#") if isinstance(text, str) else ""
    if re.fullmatch(r"[0-9a-fA-F]{3}", digits):
        digits = "".join(2 * digit for digit in digits)
    if not re.fullmatch(r"[0-9a-fA-F]{6}", digits):
        raise InputError(place, "this is not a colour", 'Write red, green and blue as "#rrggbb".', value=text)
    return tuple(int(digits[k : k + 2], 16) for k in (0, 2, 4))


def _classify(
    pixels: Pixels, rgb: NDArray[np.int64], owners: NDArray[np.int16]
) -> tuple[NDArray[np.int16], NDArray[np.bool_] | None, bool]:
    """Listed colour of every pixel; where an unlisted colour stands; whether the picture is noisy."""
    from geodem.builders import image_mixtures as mixtures

    lossy = pixels.lossy
    while True:
        wanted = _LOSSY if lossy else _EXACT
        apart = _smallest_distance(rgb[:-1])
        tolerances = wanted._replace(sure=min(wanted.sure, 0.35 * apart))
        classes, sure = mixtures.nearest(pixels, rgb, tolerances.sure)
        sure &= ~mixtures.thin_rims(classes, sure, rgb, tolerances.sure, tolerances.rim)
        decided = sure | (pixels.opacity < _OPAQUE)
        leftover = mixtures.resolve(
            pixels, rgb, classes, sure, decided, tolerances.mixture, tolerances.reach, lossy
        )
        unlisted = _blobs(pixels, leftover, tolerances.speckle, lossy)
        if unlisted is None:
            break
        if lossy or not _is_noise(pixels, classes, sure):
            return classes, unlisted, lossy
        lossy = True
    if lossy:
        leftover &= ~mixtures.best_guess(pixels, rgb, classes, sure, leftover, tolerances.reach)
    mixtures.fill_from_nearest(classes, leftover)
    mixtures.absorb_speckles(classes, owners, tolerances.speckle)
    mixtures.part_diagonals(classes, owners)
    return classes, None, lossy


def _smallest_distance(rgb: NDArray[np.int64]) -> float:
    if len(rgb) < 2:
        return 255.0
    difference = np.linalg.norm(rgb[:, None, :] - rgb[None, :, :], axis=2)
    return float(difference[np.triu_indices(len(rgb), 1)].min())


def _blobs(
    pixels: Pixels, leftover: NDArray[np.bool_], speckle: int, lossy: bool
) -> NDArray[np.bool_] | None:
    """Pixels of the most frequent colour that no listed colour explains, where there are too many of it."""
    from scipy import ndimage

    from geodem.builders import image_mixtures as mixtures

    candidates = leftover.copy()
    if lossy:
        # noise makes rims along edges: only what is thicker than they are is a colour of its own
        candidates = ndimage.binary_opening(candidates, np.ones((4, 4), dtype=bool))
    colours = mixtures.as_numbers(pixels.colour)
    for _ in range(16):
        if candidates.sum() <= max(_UNLISTED_SHARE * candidates.size, speckle):
            return None
        found, counts = np.unique(colours[candidates], return_counts=True)
        centre = mixtures.as_colours(found[np.argmax(counts)])
        squares = sum((pixels.colour[..., k].astype(np.int32) - centre[k]) ** 2 for k in range(3))
        alike = candidates & (squares <= 40**2)
        numbered, number = ndimage.label(alike, np.ones((3, 3), dtype=bool))
        large = np.bincount(numbered.ravel(), minlength=number + 1) >= speckle
        large[0] = False
        blobs: NDArray[np.bool_] = large[numbered]
        if blobs.sum() > max(_UNLISTED_SHARE * blobs.size, speckle):
            return blobs
        candidates &= ~alike
    return None


def _is_noise(pixels: Pixels, classes: NDArray[np.int16], sure: NDArray[np.bool_]) -> bool:
    """Whether plain areas are uneven, as in a picture that once was a JPEG; drawn ones are not."""
    uneven = 0
    for index in np.unique(classes[sure]):
        colours = pixels.colour[sure & (classes == index) & (pixels.opacity == 255)].astype(np.int16)
        if len(colours):
            found, counts = np.unique(colours, axis=0, return_counts=True)
            uneven += int((np.abs(colours - found[np.argmax(counts)]).max(axis=1) > 1).sum())
    return uneven > _UNEVEN_SHARE * classes.size


def _unlisted_error(
    pixels: Pixels,
    where: NDArray[np.bool_],
    rgb: NDArray[np.int64],
    owners: NDArray[np.int16],
    keys: list[str],
    picture: Path | None,
    place: str,
    path: str,
) -> InputError:
    from PIL import Image

    from geodem.builders import image_mixtures as mixtures

    found, counts = np.unique(mixtures.as_numbers(pixels.colour[where]), return_counts=True)
    colour = mixtures.as_colours(found[np.argmax(counts)]).astype(np.int64)
    shown = "#{:02x}{:02x}{:02x}".format(*colour.tolist())
    listed = np.flatnonzero(owners > 0)
    nearest = keys[listed[np.argmin(np.linalg.norm(rgb[listed] - colour, axis=1))]]
    rows, columns = np.nonzero(where)

    faded = (pixels.colour.sum(axis=2, dtype=np.float32) * np.float32(0.1) + 178.0).astype(np.uint8)
    marked = np.dstack([faded] * 3)
    marked[where] = (255, 0, 255)
    target = picture or Path(tempfile.mkdtemp(prefix="geodem-")) / "unlisted-colour.png"
    target.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(marked).save(target, format="PNG")
    share = f"on {100 * where.mean():.2f} % of its pixels"
    spot = f"near column {int(np.median(columns))}, row {int(np.median(rows))}"
    # the last one stands for what is transparent, and has no colour
    if (rgb[:-1] == colour).all(axis=1).any():
        # a wedge that ends: between the colours beside it, it might as well be their blend
        problem = (
            f"the colour {shown} is thinner than a pixel {share} ({spot}), where it cannot be told from a blend of "
            "the colours beside it"
        )
        remedy = "Draw it with more pixels, or end it blunt; the places are magenta in the picture."
    else:
        problem = (
            f"the picture shows the colour {shown}, which is not listed, {share} ({spot}; the nearest legend colour "
            f"is {nearest})"
        )
        remedy = (
            f'Add "{shown}" to the legend or the background, or paint it over; it is magenta in the picture.'
        )
    return InputError(
        place,
        problem,
        remedy,
        value=path,
        picture=target,
    )
