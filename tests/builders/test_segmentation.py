"""Pictures cut by brightness: thresholds and pieces beside scikit-image's, touching discs told apart."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image
from skimage import data
from skimage.filters import threshold_multiotsu, threshold_otsu
from skimage.measure import label

from geodem.builders.fill_body import fill_body
from geodem.builders.segmentation import segment
from geodem.errors import InputError

# middles and radii [px]; the first three touch one after the other
DISCS = [((40, 40), 20), ((76, 40), 20), ((110, 52), 18), ((40, 110), 24), ((110, 115), 22)]


@pytest.fixture(scope="module")
def grains():
    """Light discs on dark ground with noise, rows down."""
    y, x = np.mgrid[:150, :150] + 0.5
    light = np.zeros((150, 150), dtype=bool)
    for (a, b), radius in DISCS:
        light |= np.hypot(x - a, y - b) < radius
    noise = np.random.default_rng(5).normal(0.0, 0.03, light.shape)
    return np.clip(np.where(light, 0.75, 0.25) + noise, 0.0, 1.0), light


def test_two_and_three_classes_are_those_of_otsu(grains):
    grey, light = grains
    cut = segment(grey)
    assert cut.thresholds[0] == pytest.approx(threshold_otsu(grey), rel=1e-12)
    assert ((cut.labels == 1) == light).all()
    assert cut.separability > 0.95
    third = np.where(light, grey, np.where(np.arange(150) < 75, grey, grey - 0.2)).clip(0.0, 1.0)
    found = segment(third, classes=3)
    assert found.thresholds == pytest.approx(threshold_multiotsu(third, classes=3, nbins=128))
    assert sorted(np.unique(found.labels)) == [0, 1, 2]


def test_touching_grains_are_parted_by_a_watershed(grains):
    grey, light = grains
    joined = segment(grey, grains=1)
    parted = segment(grey, grains=1, apart=24.0)
    assert joined.grains.max() + 1 == label(light, connectivity=1).max() == 3
    assert parted.grains.max() + 1 == len(DISCS)
    assert ((parted.grains >= 0) == light).all()
    for (a, b), radius in DISCS:
        own = parted.grains == parted.grains[b, a]
        assert own.sum() == pytest.approx(np.pi * radius**2, rel=0.06)


def test_specks_go_to_what_surrounds_them(grains):
    grey, light = grains
    spoiled = grey.copy()
    spoiled[5:8, 5:8] = 0.8
    spoiled[38:41, 38:41] = 0.2
    assert ((segment(spoiled).labels == 1) != light).any()
    assert ((segment(spoiled, smallest=10).labels == 1) == light).all()


def test_uneven_light_is_taken_out(grains):
    grey, light = grains
    slanted = np.clip(0.6 * grey + np.linspace(0.0, 0.4, 150)[None, :], 0.0, 1.0)
    plain = ((segment(slanted).labels == 1) == light).mean()
    assert plain < 0.9
    assert ((segment(slanted, lighting=35.0).labels == 1) == light).mean() > 0.97


def test_files_bytes_and_floats_are_the_same_picture(grains, tmp_path):
    bytes_ = (grains[0] * 255.0).round().astype(np.uint8)
    Image.fromarray(bytes_).save(tmp_path / "grains.png")
    one, two, three = (segment(source) for source in (tmp_path / "grains.png", bytes_, bytes_ / 255.0))
    assert one.thresholds == pytest.approx(two.thresholds, abs=1e-6)
    assert (one.labels == two.labels).all()
    assert (two.labels == three.labels).all()


def test_the_picture_shows_classes_and_edges(grains):
    cut = segment(grains[0], grains=1, apart=24.0)
    shown = cut.picture()
    assert shown.shape == (150, 150, 3)
    dark = (shown == 20).all(axis=2)
    assert 200 < dark.sum() < 1500
    assert (cut.grains[dark] >= 0).all()


def test_bricks_are_blocks_in_mortar():
    """86 bricks, whole and cut: counted by scikit-image in its own picture."""
    cut = segment(data.brick(), smoothing=1.0, smallest=80, grains=0)
    assert cut.grains.max() + 1 == label(cut.labels == 0, connectivity=1).max() == 86
    body = cut.body(2e-3, ("brick", "mortar"))
    filling = fill_body(body, particles=20_000, arrangement="hexagonal")
    for share, pixels in zip(filling.shares, np.bincount(cut.labels.ravel()), strict=True):
        assert share.source == pytest.approx(pixels * 4e-6, rel=1e-12)
        assert share.represented == pytest.approx(share.source, rel=0.005)
    assert len(np.unique(filling.group[filling.material == 0])) == 86
    assert (filling.group[filling.material == 1] == -1).all()


def test_gravel_is_stones_in_voids():
    cut = segment(data.gravel(), lighting=20.0, smoothing=1.0, smallest=40, grains=1, apart=12.0)
    body = cut.body(0.5e-3, (None, "stone"))
    assert body.materials == ("stone",)
    # stones of a size: the middle half differs by less than four in area
    area = np.bincount(cut.grains[cut.grains >= 0])
    low, high = np.percentile(area, [25, 75])
    assert 400 < len(area) < 800
    assert high / low < 4.0
    filling = fill_body(body, particles=10_000, arrangement="hexagonal")
    assert filling.shares[0].represented == pytest.approx(body.sizes[0], rel=0.005)


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"thresholds": [0.6, 0.4]}, "do not grow"),
        ({"thresholds": []}, "do not grow"),
        ({"thresholds": [0.4, 0.4]}, "do not grow"),
        ({"thresholds": [1.5]}, "outside the picture's brightness"),
        ({"classes": 1}, "not 2 to 5"),
        ({"classes": 9}, "not 2 to 5"),
        ({"smoothing": -1.0}, "not a number from 0"),
        ({"lighting": 0.0}, "not a positive number"),
        ({"grains": 2}, "classes are 0 to 1"),
        ({"grains": 1, "apart": 0.5}, "not a number from 1"),
        ({"smallest": 10**6}, "every piece is smaller"),
        # filters as wide as that would fill the memory
        ({"smoothing": 1e9}, "more than the [0-9]+ px of the picture"),
        ({"lighting": 1e300}, "more than the [0-9]+ px of the picture"),
        ({"grains": 1, "apart": 1e9}, "more than the [0-9]+ px of the picture"),
    ],
)
def test_what_cannot_be_cut_is_refused(grains, options, problem):
    with pytest.raises(InputError, match=problem):
        segment(grains[0], **options)


def test_pictures_without_contrast_or_of_another_kind_are_refused(grains, tmp_path):
    with pytest.raises(InputError, match="no contrast"):
        segment(np.full((20, 20), 77, dtype=np.uint8))
    with pytest.raises(InputError, match="neither a picture nor a stack"):
        segment(np.zeros(5))
    with pytest.raises(InputError, match="not between 0 and 1"):
        segment(np.array([[0.0, 3.0]]))
    with pytest.raises(InputError, match="does not exist"):
        segment(tmp_path / "absent.png")
    with pytest.raises(InputError, match="there are 2 classes"):
        segment(grains[0]).body(1.0, ("stone",))
    with pytest.raises(InputError, match="segmentation, spacing"):
        segment(grains[0]).body(None, ("stone", None))
