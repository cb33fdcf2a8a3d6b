"""Grey pictures or stacks of slices cut into classes by their brightness, and touching grains told apart.

Thresholds are those of Otsu, N. (1979), IEEE Trans. Systems, Man, Cybernetics 9:62-66 and, for several classes, Liao,
P.-S. et al. (2001), J. Inf. Sci. Eng. 17:713-727; touching grains are parted by the watershed of the distance to
their edge. All of it is scikit-image's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geodem.builders.grid_body import GridBody, cell_sides, grid_body
from geodem.builders.image_pixels import read_pixels
from geodem.errors import InputError

Floats = NDArray[np.float64]
Integers = NDArray[np.int32]

LEAST_CONTRAST = 0.02
"""Of brightest minus darkest, 1 being black to white; below it a picture shows nothing."""
# multi-Otsu tries every combination of levels
LEVELS = 128
MOST_CLASSES = 5
TINTS = np.array([[31, 119, 180], [255, 187, 40], [44, 160, 44], [214, 39, 40], [148, 103, 189]])


@dataclass(frozen=True)
class Segmentation:
    """Classes of a grey picture or stack.

    Attributes
    ----------
    grey : (rows, columns) or (slices, rows, columns) float32
        Brightness, 0 black to 1 white, after smoothing.
    thresholds : tuple of float
        Between the classes, ascending.
    labels : like `grey`, int16
        0 for the darkest class, and so on.
    grains : like `grey`, int32
        Number of the grain, -1 for none.
    separability : float
        Variance between the classes over the whole variance of brightness, 0 to 1 [-].
    """

    grey: NDArray[np.float32]
    thresholds: tuple[float, ...]
    labels: NDArray[np.int16]
    grains: Integers
    separability: float

    @property
    def classes(self) -> int:
        """Number of classes."""
        return len(self.thresholds) + 1

    def picture(self, slice_number: int = 0) -> NDArray[np.uint8]:
        """The picture, or one slice, with the classes tinted and the edges of the grains drawn; (rows, columns, 3)."""
        from skimage.segmentation import find_boundaries

        grey, labels, grains = self.grey, self.labels, self.grains
        if grey.ndim == 3:
            grey, labels, grains = grey[slice_number], labels[slice_number], grains[slice_number]
        tint = TINTS[labels % len(TINTS)]
        shown = 0.65 * 255.0 * grey[..., None] + 0.35 * tint
        # edges of classes where no grains are told apart
        edges = find_boundaries(np.where(grains >= 0, grains + self.classes, labels), mode="inner")
        shown[edges & (grains >= 0)] = (20, 20, 20)
        return np.asarray(np.clip(shown, 0, 255), dtype=np.uint8)

    def body(
        self,
        spacing: float | Sequence[float] | None,
        materials: Sequence[str | None],
        *,
        origin: float | Sequence[float] = 0.0,
    ) -> GridBody:
        """The classes as a body.

        Parameters
        ----------
        spacing : float or (d,) float [m]
            Side or sides (x, y, z) of a pixel or voxel.
        materials : sequence of str or None
            Of every class, from the darkest on; None where there is nothing, as in voids.
        origin : float or (d,) float [m]
            Lowest corner.

        Raises
        ------
        InputError
            Another number of materials than classes, or a pixel without size.
        """
        if len(materials) != self.classes:
            raise InputError(
                "segmentation, materials", f"there are {self.classes} classes", "Give a name or None for each.",
                value=list(materials),
            )  # fmt: skip
        sides = cell_sides(spacing, self.grey.ndim, "segmentation, spacing")
        names = tuple(dict.fromkeys(name for name in materials if name is not None))
        number = np.array([-1 if name is None else names.index(name) for name in materials])
        return grid_body(
            upright(number[self.labels]), names, sides, origin=origin, grains=upright(self.grains),
            place="segmentation",
        )  # fmt: skip


def upright(picture: NDArray[np.integer]) -> NDArray[np.integer]:
    """Rows from the top and columns, or slices of them from the lowest up, as x, y and z from the lowest corner up."""
    if picture.ndim == 2:
        return np.ascontiguousarray(picture[::-1].T)
    return np.ascontiguousarray(picture[:, ::-1].transpose(2, 1, 0))


def segment(
    source: str | Path | NDArray[np.generic],
    *,
    classes: int = 2,
    thresholds: Sequence[float] | None = None,
    lighting: float | None = None,
    smoothing: float = 0.0,
    smallest: int = 0,
    grains: int | None = None,
    apart: float | None = None,
) -> Segmentation:
    """Cut a picture or a stack of slices into classes of brightness.

    Parameters
    ----------
    source : str, Path or array
        Picture file, or brightness (rows, columns) or (slices, rows, columns): bytes, 16-bit numbers, or floats
        from 0 to 1.
    classes : int
        Number of classes, 2 to 5, between which thresholds are found.
    thresholds : sequence of float, optional
        Instead: brightness between the classes, 0 black to 1 white, ascending.
    lighting : float, optional
        Uneven lighting is taken out first: brightness varies about its mean over this distance [px].
    smoothing : float
        Standard deviation [px] of a Gaussian filter before anything else; 0: none.
    smallest : int
        Pieces of fewer pixels or voxels go to the class that surrounds them.
    grains : int, optional
        Class whose pieces are grains or blocks, told apart; none where it is left out.
    apart : float, optional
        Touching grains whose middles are at least this far apart [px] are parted by a watershed; left out: only
        pieces that do not touch are told apart.

    Raises
    ------
    InputError
        A file that cannot be read, a picture without contrast, thresholds out of order, a number that cannot be.
    """
    grey = _filtered(_grey(source), lighting, smoothing)
    low, high = float(grey.min()), float(grey.max())
    if high - low < LEAST_CONTRAST:
        raise InputError(
            "segment", f"the picture has no contrast: its brightness goes from {low:.3f} to {high:.3f}",
            "Give one that shows the materials as different greys, from 0 black to 1 white.",
        )  # fmt: skip
    cuts = _thresholds(grey, classes, thresholds, low, high)
    labels = np.digitize(grey, cuts).astype(np.int16)
    if smallest > 1:
        labels = _without_specks(labels, smallest, len(cuts) + 1)
    return Segmentation(
        grey=grey.astype(np.float32),
        thresholds=cuts,
        labels=labels,
        grains=_grains(labels, grains, apart, len(cuts) + 1),
        separability=_separability(grey, labels),
    )


def _grey(source: str | Path | NDArray[np.generic]) -> Floats:
    if isinstance(source, str | Path):
        pixels = read_pixels(Path(source), "segment")
        return luminance(pixels.colour, 255.0)
    given = np.asarray(source)
    if given.ndim not in (2, 3) or given.size == 0 or given.dtype.kind not in "uif":
        raise InputError(
            "segment", f"this is neither a picture nor a stack of slices (shape {given.shape})",
            "Give an array (rows, columns) or (slices, rows, columns) of brightness.",
        )  # fmt: skip
    full = float(np.iinfo(given.dtype).max) if given.dtype.kind in "ui" else 1.0
    grey = given / full
    if not (np.isfinite(grey).all() and grey.min() >= 0.0 and grey.max() <= 1.0):
        raise InputError(
            "segment", "the brightness is not between 0 and 1 everywhere", "Scale the array.",
            value=[float(np.nanmin(grey)), float(np.nanmax(grey))],
        )  # fmt: skip
    return np.asarray(grey, dtype=np.float64)


def luminance(colour: NDArray[Any], full: float) -> Floats:
    """Brightness 0 to 1 of red, green and blue (..., 3) up to `full`, as of ITU-R BT.601."""
    grey = np.zeros(colour.shape[:-1])
    # one colour after the other: a large picture as numbers of eight bytes fills the memory
    for channel, weight in enumerate((0.299, 0.587, 0.114)):
        grey += weight / full * colour[..., channel]
    return grey


def _filtered(grey: Floats, lighting: float | None, smoothing: float) -> Floats:
    from scipy import ndimage

    if lighting is not None:
        if not (np.isfinite(lighting) and lighting > 0.0):
            raise InputError("segment, lighting", "this is not a positive number", "Give px.", value=lighting)
        _refuse_beyond(grey, "lighting", lighting)
        light = ndimage.gaussian_filter(grey, lighting, mode="reflect")
        grey = np.clip(grey - light + grey.mean(), 0.0, 1.0)
    if not (np.isfinite(smoothing) and smoothing >= 0.0):
        raise InputError("segment, smoothing", "this is not a number from 0", "Give px.", value=smoothing)
    _refuse_beyond(grey, "smoothing", smoothing)
    if smoothing > 0.0:
        grey = ndimage.gaussian_filter(grey, smoothing, mode="nearest")
    return grey


def _refuse_beyond(grey: NDArray[np.generic], key: str, pixels: float) -> None:
    """A distance is one within the picture."""
    if pixels > max(grey.shape):
        raise InputError(
            f"segment, {key}", f"this is more than the {max(grey.shape)} px of the picture", "Give fewer px.",
            value=pixels,
        )  # fmt: skip


def _thresholds(
    grey: Floats, classes: int, given: Sequence[float] | None, low: float, high: float
) -> tuple[float, ...]:
    if given is None:
        from skimage.filters import threshold_multiotsu, threshold_otsu

        if not 2 <= classes <= MOST_CLASSES:
            raise InputError("segment, classes", f"this is not 2 to {MOST_CLASSES}", "Give 2.", value=classes)
        if classes == 2:
            return (float(threshold_otsu(grey.ravel())),)
        try:
            found = threshold_multiotsu(grey, classes=classes, nbins=LEVELS)
        except ValueError as error:
            raise InputError(
                "segment, classes", "the picture has fewer different greys", "Give fewer.", value=classes
            ) from error
        return tuple(float(cut) for cut in found)
    cuts = np.asarray(given, dtype=np.float64).ravel()
    if len(cuts) == 0 or not np.isfinite(cuts).all() or (np.diff(cuts) <= 0.0).any():
        raise InputError(
            "segment, thresholds", "these do not grow", "Give them from dark to light, as [0.3, 0.6].",
            value=list(given),
        )  # fmt: skip
    if cuts[0] <= low or cuts[-1] > high:
        raise InputError(
            "segment, thresholds", f"one lies outside the picture's brightness, {low:.3f} to {high:.3f}",
            "Give numbers between these; 0 is black and 1 white.", value=list(given),
        )  # fmt: skip
    return tuple(cuts.tolist())


def _without_specks(labels: NDArray[np.int16], smallest: int, classes: int) -> NDArray[np.int16]:
    """Small pieces take the class of the nearest cell outside any."""
    from scipy import ndimage

    specks = np.zeros(labels.shape, dtype=bool)
    for number in range(classes):
        pieces, count = ndimage.label(labels == number)
        small = np.bincount(pieces.ravel(), minlength=count + 1) < smallest
        small[0] = False
        specks |= small[pieces]
    if specks.all():
        raise InputError(
            "segment, smallest", "every piece is smaller", "Give fewer pixels, or smooth the picture.",
            value=smallest,
        )  # fmt: skip
    nearest = ndimage.distance_transform_edt(specks, return_distances=False, return_indices=True)
    return np.asarray(labels[tuple(nearest)])


def _grains(labels: NDArray[np.int16], number: int | None, apart: float | None, classes: int) -> Integers:
    from scipy import ndimage

    grains = np.full(labels.shape, -1, dtype=np.int32)
    if number is None:
        return grains
    if not 0 <= number < classes:
        raise InputError(
            "segment, grains", f"the classes are 0 to {classes - 1}, dark to light", "Name one.", value=number
        )
    mask = labels == number
    pieces, _ = ndimage.label(mask)
    if apart is not None:
        from skimage.feature import peak_local_max
        from skimage.segmentation import watershed

        if not (np.isfinite(apart) and apart >= 1.0):
            raise InputError("segment, apart", "this is not a number from 1", "Give px.", value=apart)
        _refuse_beyond(labels, "apart", apart)
        # smoothed, so that a rough edge does not make two middles of one
        depth = ndimage.gaussian_filter(ndimage.distance_transform_edt(mask), 0.15 * apart)
        peaks = peak_local_max(
            depth, min_distance=max(1, round(0.5 * apart)), labels=pieces, exclude_border=False
        )
        seeds = np.zeros(labels.shape, dtype=np.int32)
        seeds[tuple(peaks.T)] = np.arange(1, len(peaks) + 1)
        # a piece without a middle of its own is a grain all the same
        lost = np.setdiff1d(np.unique(pieces[mask]), np.unique(pieces[seeds > 0]))
        pieces = np.where(np.isin(pieces, lost), pieces + len(peaks), watershed(-depth, seeds, mask=mask))
    grains[mask] = np.unique(pieces[mask], return_inverse=True)[1]
    return grains


def _separability(grey: Floats, labels: NDArray[np.int16]) -> float:
    count = np.bincount(labels.ravel())
    mean = np.bincount(labels.ravel(), grey.ravel()) / np.maximum(count, 1)
    between = float((count * (mean - grey.mean()) ** 2).sum() / grey.size)
    return between / float(grey.var())
