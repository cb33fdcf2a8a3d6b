"""Tell mixed edge pixels from colours in their own right.

A drawing program blends the two colours that meet in a pixel in the ratio of the areas they cover, so a mixed
pixel lies on the straight line between them in colour space. The ratio later places the edge in the pixel.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from geodem.builders.image_pixels import Pixels

_HALF_OPAQUE = 128
_COLOURS = 256**3
_AT_A_TIME = 1_000_000
"""Pixels that are looked at together: a large picture with them all would fill the memory."""


def blended(pixels: Pixels, rows: NDArray[np.int64], columns: NDArray[np.int64]) -> NDArray[np.float64]:
    """Colours multiplied by their opacity, and the opacity, shape (..., 4), 0 to 255; these mix linearly."""
    opacity = pixels.opacity[rows, columns].astype(float)
    colour = pixels.colour[rows, columns] * (opacity / 255.0)[..., None]
    return np.concatenate([colour, opacity[..., None]], axis=-1)


def as_numbers(colour: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Each colour (..., 3) as one number, in the order of red, green and blue."""
    packed = np.zeros(colour.shape[:-1], dtype=np.int32)
    for channel in range(3):
        packed = packed * 256 + colour[..., channel]
    return packed


def as_colours(numbers: NDArray[np.int32]) -> NDArray[np.int32]:
    """The colours (..., 3) of `as_numbers`."""
    return np.stack([numbers >> 16, (numbers >> 8) & 255, numbers & 255], axis=-1)


def nearest(
    pixels: Pixels, rgb: NDArray[np.int64], tolerance: float
) -> tuple[NDArray[np.int16], NDArray[np.bool_]]:
    """Nearest listed colour of every pixel (transparent is the last), and whether it is that near."""
    packed = as_numbers(pixels.colour)
    # a table of all colours there are: sorting the pixels of a large picture takes a gigabyte
    there = np.zeros(_COLOURS, dtype=bool)
    there[packed] = True
    values = np.flatnonzero(there).astype(np.int32)
    best = np.zeros(_COLOURS, dtype=np.int16)
    near = np.zeros(_COLOURS, dtype=bool)
    for k in range(0, len(values), _AT_A_TIME):
        some = values[k : k + _AT_A_TIME]
        colours = as_colours(some)
        distance = np.full(len(some), np.inf)
        for index, listed in enumerate(rgb[:-1]):
            here = np.linalg.norm(colours - listed, axis=1)
            best[some[here < distance]] = index
            distance = np.minimum(distance, here)
        near[some] = distance <= tolerance
    classes = best[packed]
    sure = near[packed]
    clear = pixels.opacity < _HALF_OPAQUE
    classes[clear] = len(rgb) - 1
    sure[clear] = pixels.opacity[clear] <= 2
    return classes, sure


def thin_rims(
    classes: NDArray[np.int16], sure: NDArray[np.bool_], rgb: NDArray[np.int64], tolerance: float, rim: int
) -> NDArray[np.bool_]:
    """Pixels that have a listed colour only because two others mix to it.

    A rim is thinner than ``rim`` pixels and runs, for at least half of its pixels, between two listed colours
    whose mixture it may be. A thin seam of any other colour, or inside one material, is no rim.
    """
    from scipy import ndimage

    result = np.zeros_like(sure)
    count = len(rgb) - 1
    shown = [bool((sure & (classes == k)).any()) for k in range(count)]
    near: dict[int, NDArray[np.bool_]] = {}
    for middle in range(count):
        pairs = []
        for a, b in combinations([k for k in range(count) if k != middle and shown[k]], 2):
            along = (rgb[b] - rgb[a]).astype(float)
            part = float((rgb[middle] - rgb[a]) @ along / (along @ along))
            if 0.08 < part < 0.92 and np.linalg.norm(rgb[a] + part * along - rgb[middle]) <= tolerance + 6.0:
                pairs.append((a, b))
        mask = sure & (classes == middle)
        if not pairs or not mask.any():
            continue
        core = ndimage.binary_opening(mask, np.ones((rim, rim), dtype=bool))
        thin = mask & ~ndimage.binary_dilation(core, np.ones((3, 3), dtype=bool))
        between = np.zeros_like(mask)
        for a, b in pairs:
            for k in (a, b):
                if k not in near:
                    near[k] = ndimage.binary_dilation(sure & (classes == k), np.ones((5, 5), dtype=bool))
            between |= near[a] & near[b]
        numbered, number = ndimage.label(thin, np.ones((3, 3), dtype=bool))
        total = np.bincount(numbered.ravel(), minlength=number + 1)
        mixed = np.bincount(numbered[between], minlength=number + 1)
        chosen = mixed >= 0.5 * total
        chosen[0] = False
        result |= chosen[numbered]
    return result


def resolve(
    pixels: Pixels,
    rgb: NDArray[np.int64],
    classes: NDArray[np.int16],
    sure: NDArray[np.bool_],
    decided: NDArray[np.bool_],
    tolerance: float,
    reach: int,
    lossy: bool,
) -> NDArray[np.bool_]:
    """Give mixed pixels to the prevailing colour, in place, and return those that no mixture explains."""
    from scipy import ndimage

    leftover = ~decided
    for radius in range(1, reach + 1):
        # only what has a known colour near it can be a mixture
        rows, columns = np.nonzero(leftover & ndimage.maximum_filter(sure, 2 * radius + 1, mode="nearest"))
        if len(rows) == 0:
            continue
        choice, residual, boxed = _best_pair(pixels, rgb, classes, sure, rows, columns, radius)
        # a blend in linear light leaves the straight line, but each channel stays between the two colours
        explained = (residual <= tolerance) | (boxed & (radius == 1 or lossy))
        classes[rows[explained], columns[explained]] = choice[explained]
        leftover[rows[explained], columns[explained]] = False
    return leftover


def best_guess(
    pixels: Pixels,
    rgb: NDArray[np.int64],
    classes: NDArray[np.int16],
    sure: NDArray[np.bool_],
    leftover: NDArray[np.bool_],
    reach: int,
) -> NDArray[np.bool_]:
    """Give noisy pixels near an edge to the more likely side, in place; where that was possible."""
    done = np.zeros_like(leftover)
    rows, columns = np.nonzero(leftover)
    if len(rows):
        choice, residual, _ = _best_pair(pixels, rgb, classes, sure, rows, columns, reach)
        found = np.isfinite(residual)
        classes[rows[found], columns[found]] = choice[found]
        done[rows[found], columns[found]] = True
    return done


def _best_pair(
    pixels: Pixels,
    rgb: NDArray[np.int64],
    classes: NDArray[np.int16],
    sure: NDArray[np.bool_],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    radius: int,
) -> tuple[NDArray[np.int16], NDArray[np.float64], NDArray[np.bool_]]:
    """Of the colours near each pixel the pair that mixes best to it: prevailing one, residual, boxed."""
    parts = [
        _best_pair_of(
            pixels, rgb, classes, sure, rows[k : k + _AT_A_TIME], columns[k : k + _AT_A_TIME], radius
        )
        for k in range(0, len(rows), _AT_A_TIME)
    ]
    choice, residual, boxed = (np.concatenate(found) for found in zip(*parts, strict=True))
    return choice, residual, boxed


def _best_pair_of(
    pixels: Pixels,
    rgb: NDArray[np.int64],
    classes: NDArray[np.int16],
    sure: NDArray[np.bool_],
    rows: NDArray[np.int64],
    columns: NDArray[np.int64],
    radius: int,
) -> tuple[NDArray[np.int16], NDArray[np.float64], NDArray[np.bool_]]:
    """`_best_pair` of not too many pixels."""
    height, width = sure.shape
    palette = np.c_[rgb.astype(float), np.full(len(rgb), 255.0)]
    palette[-1] = 0.0
    near = np.zeros((len(rgb), len(rows)), dtype=bool)
    for down in range(-radius, radius + 1):
        for right in range(-radius, radius + 1):
            r = np.clip(rows + down, 0, height - 1)
            c = np.clip(columns + right, 0, width - 1)
            known = sure[r, c]
            near[classes[r, c][known], np.flatnonzero(known)] = True
    colour = blended(pixels, rows, columns)
    choice = np.zeros(len(rows), dtype=np.int16)
    residual = np.full(len(rows), np.inf)
    boxed = np.zeros(len(rows), dtype=bool)
    for a, b in combinations(np.flatnonzero(near.any(axis=1)).tolist(), 2):
        both = np.flatnonzero(near[a] & near[b])
        if len(both) == 0:
            continue
        along = palette[b] - palette[a]
        here = colour[both]
        part = np.clip((here - palette[a]) @ along / (along @ along), 0.0, 1.0)
        off = np.linalg.norm(here - palette[a] - part[:, None] * along, axis=1)
        low, high = np.minimum(palette[a], palette[b]) - 10.0, np.maximum(palette[a], palette[b]) + 10.0
        better = off < residual[both]
        chosen = both[better]
        residual[chosen] = off[better]
        choice[chosen] = np.where(part[better] >= 0.5, b, a)
        boxed[chosen] = ((here[better] >= low) & (here[better] <= high)).all(axis=1)
    return choice, residual, boxed


def fill_from_nearest(classes: NDArray[np.int16], unknown: NDArray[np.bool_]) -> None:
    """Give unknown pixels the colour of the nearest known one, in place."""
    from scipy import ndimage

    if unknown.any() and not unknown.all():
        rows, columns = ndimage.distance_transform_edt(unknown, return_distances=False, return_indices=True)
        classes[unknown] = classes[rows[unknown], columns[unknown]]


def absorb_speckles(classes: NDArray[np.int16], owners: NDArray[np.int16], smallest: int) -> None:
    """Give connected pieces below ``smallest`` pixels to what lies next to them, in place."""
    from skimage.measure import label

    numbered = label(owners[classes], background=-1, connectivity=2)
    small = np.bincount(numbered.ravel()) < smallest
    fill_from_nearest(classes, small[numbered])


def part_diagonals(classes: NDArray[np.int16], owners: NDArray[np.int16]) -> None:
    """Repaint pixels until no two pixels of one material touch only at a corner, in place.

    Outlines would touch there. The material with fewer pixels is the one joined, since it is the thin one.
    """
    size = np.bincount(owners[classes].ravel(), minlength=int(owners.max()) + 1)
    for _ in range(50):
        labels = owners[classes]
        upper_left, upper_right = labels[:-1, :-1], labels[:-1, 1:]
        lower_left, lower_right = labels[1:, :-1], labels[1:, 1:]
        falling = (upper_left == lower_right) & (upper_left != upper_right) & (upper_left != lower_left)
        rising = (upper_right == lower_left) & (upper_right != upper_left) & (upper_right != lower_right)
        rows, columns = np.nonzero(falling | rising)
        if len(rows) == 0:
            return
        for r, c in zip(rows.tolist(), columns.tolist(), strict=True):
            block = owners[classes[r : r + 2, c : c + 2]]
            falls = block[0, 0] == block[1, 1] and block[0, 0] not in (block[0, 1], block[1, 0])
            rises = block[0, 1] == block[1, 0] and block[0, 1] not in (block[0, 0], block[1, 1])
            if falls and (not rises or size[block[0, 0]] <= size[block[0, 1]]):
                classes[r, c + 1] = classes[r, c]
            elif rises:
                classes[r, c] = classes[r, c + 1]
