"""Bodies of pixels and voxels against what was drawn, and input that cannot be one."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from geodem.builders.fill_body import fill_body
from geodem.builders.grid_body import grid_body
from geodem.builders.grid_sources import grid_from_image, grid_from_slices, grid_from_vtk, read_slices
from geodem.builders.segmentation import segment
from geodem.errors import InputError

SOIL, ROCK = (0x8C, 0x6D, 0x31), (0x7F, 0x8C, 0x99)
LEGEND = {"#8c6d31": "soil", "#7f8c99": "rock"}


def picture(path, pixels):
    Image.fromarray(np.asarray(pixels, dtype=np.uint8)).save(path)
    return path


@pytest.fixture
def corner(tmp_path):
    """40 x 30 pixels of soil on white, with rock in the lower left corner."""
    pixels = np.full((30, 40, 3), 255)
    pixels[5:] = SOIL
    pixels[20:, :15] = ROCK
    return picture(tmp_path / "corner.png", pixels)


def test_a_drawing_with_a_legend_stands_upright(corner):
    body = grid_from_image(corner, scale=0.5, legend=LEGEND, origin=(100.0, 10.0))
    assert body.materials == ("soil", "rock")
    assert body.sizes == pytest.approx([(25 * 40 - 150) * 0.25, 150 * 0.25], rel=1e-12)
    assert body.bounds == pytest.approx(np.array([[100.0, 10.0], [120.0, 25.0]]))
    points = np.array(
        [(100.1, 10.1), (119.9, 10.1), (100.1, 24.9), (110.0, 20.0), (99.9, 12.0), (110.0, 25.1)]
    )
    assert body.material_at(points).tolist() == [1, 0, -1, 0, -1, -1]


def test_one_disc_a_pixel_stands_where_dice2d_puts_it(tmp_path):
    """Zhao (2015), table 2.9: radius 10, x = 10 + 20 (j - 1), y = 20 n - 10 - 20 (i - 1), rows i from the top."""
    rows = 30
    tree = np.abs(np.arange(41)[None, :] - 20) <= np.arange(rows)[:, None] * 0.6
    tree[24:] = np.abs(np.arange(41) - 20) <= 2
    path = picture(tmp_path / "tree.png", np.where(tree[..., None], SOIL, (255, 255, 255)))
    filling = fill_body(grid_from_image(path, scale=20.0, legend={"#8c6d31": "tree"}), arrangement="pixel")
    i, j = np.nonzero(tree)
    expected = np.column_stack([10 + 20 * j, 20 * rows - 10 - 20 * i])
    assert filling.particles == tree.sum()
    assert sorted(filling.positions.round(9).tolist()) == sorted(expected.astype(float).tolist())
    assert (filling.radii == 10.0).all()


@pytest.mark.parametrize("kind", ["folder", "pages"])
def test_slices_are_stacked_upwards_in_the_order_of_their_numbers(tmp_path, kind):
    """Slice k of 12 is rock but for k pixels of soil at the left of its first row."""
    stack = []
    for number in range(12):
        pixels = np.full((6, 14, 3), ROCK, dtype=np.uint8)
        pixels[0, :number] = SOIL
        stack.append(pixels)
    source = tmp_path / "slices"
    if kind == "folder":
        source.mkdir()
        for number, pixels in enumerate(stack):
            picture(source / f"cut{number}.png", pixels)
    else:
        import tifffile

        source = tmp_path / "slices.tif"
        tifffile.imwrite(source, np.stack(stack), photometric="rgb")
    body = grid_from_slices(source, voxel=(0.1, 0.2, 0.5), legend=LEGEND)
    assert body.labels.shape == (14, 6, 12)
    soil = body.materials.index("soil")
    assert (body.labels[:, 5] == soil).sum(axis=0).tolist() == list(range(12))
    assert not (body.labels[:, :5] == soil).any()
    assert body.sizes[soil] == pytest.approx(66 * 0.01, rel=1e-12)
    assert body.bounds[1] == pytest.approx([1.4, 1.2, 6.0])
    # above the top row of slice 11, at its left
    assert body.material_at(np.array([(0.05, 1.1, 5.75), (1.15, 1.1, 5.75), (0.05, 0.9, 5.75)])).tolist() == [
        soil, 1 - soil, 1 - soil,
    ]  # fmt: skip


def test_grey_slices_are_cut_by_brightness(tmp_path):
    import tifffile

    stack = np.zeros((5, 8, 9), dtype=np.uint16)
    stack[2:, :, 4:] = 40_000
    tifffile.imwrite(tmp_path / "grey.tif", stack, photometric="minisblack")
    read = read_slices(tmp_path / "grey.tif")
    assert read.dtype == np.uint16
    body = segment(read).body(0.1, (None, "stone"))
    assert body.sizes == pytest.approx([3 * 8 * 5 * 1e-3], rel=1e-12)
    assert body.material_at(np.array([(0.85, 0.4, 0.45), (0.05, 0.4, 0.45), (0.85, 0.4, 0.05)])).tolist() == [
        0, -1, -1,
    ]  # fmt: skip


@pytest.mark.parametrize("at", ["cells", "points"])
def test_image_data_of_vtk_keeps_its_places(tmp_path, at):
    import pyvista

    image = pyvista.ImageData(dimensions=(4, 3, 3), spacing=(1.0, 2.0, 3.0), origin=(10.0, 20.0, 30.0))
    if at == "cells":
        image.cell_data["density"] = np.arange(12.0)
    else:
        image.point_data["density"] = np.arange(36.0)
    image.save(tmp_path / "grid.vti")
    count = 12 if at == "cells" else 36
    body = grid_from_vtk(tmp_path / "grid.vti", thresholds=[3.0, 9.0], materials=("soft", None, "hard"))
    assert body.sizes == pytest.approx([3 * 6.0, (count - 9) * 6.0])
    # what VTK itself finds at the middles of cells, or at its points
    places = np.array(image.cell_centers().points if at == "cells" else image.points)
    assert body.material_at(places).tolist() == [0] * 3 + [-1] * 6 + [1] * (count - 9)
    low = np.array([10.0, 20.0, 30.0]) - (0.0 if at == "cells" else np.array([0.5, 1.0, 1.5]))
    assert body.bounds[0] == pytest.approx(low)


def test_the_channels_of_pyvista_are_a_body_of_two_materials():
    from pathlib import Path

    import pyvista
    from pyvista import examples

    path = Path(examples.__file__).with_name("channels.vti")
    body = grid_from_vtk(path, thresholds=[0.5], materials=("plain", "channel"))
    counted = pyvista.read(path).threshold(0.5, scalars="facies").n_cells
    assert body.sizes == pytest.approx([250 * 250 * 100 - counted, counted])
    assert body.bounds.tolist() == [[0.0, 0.0, 0.0], [250.0, 250.0, 100.0]]
    part = body.crop((50, 60, 10), (150, 100, 30))
    assert part.labels.shape == (100, 40, 20)
    assert part.sizes.sum() == 100 * 40 * 20
    places = part.bounds[0] + np.random.default_rng(1).random((100, 3)) * (100, 40, 20)
    assert (part.material_at(places) == body.material_at(places)).all()


def test_every_piece_of_a_material_can_be_a_grain():
    labels = np.array([[0, 0, 1, 0], [1, 1, 1, 0], [0, 1, 0, 0]])
    body = grid_body(labels, ["stone", "mortar"], 1.0).with_grains("stone")
    assert body.grain_number == 3
    assert (body.grains >= 0).tolist() == (labels == 0).tolist()
    assert body.grains[0, 0] == body.grains[0, 1] != body.grains[0, 3]
    assert body.grains[0, 3] == body.grains[1, 3] == body.grains[2, 2]
    part = body.crop((0.0, 2.0), (3.0, 4.0))
    assert part.grain_number == 1
    assert body.group_at(np.array([(2.5, 0.5), (0.5, 2.5), (9.0, 9.0)])).tolist() == [
        body.grains[2, 0],
        -1,
        -1,
    ]


def test_materials_without_cells_are_left_out_and_told():
    body = grid_body(np.array([[0, 2]]), ["soil", "clay", "rock"], 1.0)
    assert body.materials == ("soil", "rock")
    assert body.labels.tolist() == [[0, 1]]
    assert body.remarks == ("No cell is of clay.",)


@pytest.mark.parametrize(
    ("labels", "options", "problem"),
    [
        ([[0, 1]], {"spacing": 0.0}, "2 positive lengths"),
        ([[0, 1]], {"spacing": (1.0, -1.0)}, "2 positive lengths"),
        ([[0, 1]], {"spacing": None}, "2 positive lengths"),
        ([[0, 2]], {}, "labels go from -1 to 1"),
        ([[-1, -1]], {}, "no cell has a material"),
        ([0, 1], {}, "not a grid"),
        ([[0.5, 1.0]], {}, "not a grid"),
        ([[0, 1]], {"grains": [[0]]}, "the shape"),
        ([[0, 1]], {"origin": np.nan}, "not a finite place"),
    ],
)
def test_arrays_that_are_no_body_are_refused(labels, options, problem):
    with pytest.raises(InputError, match=problem):
        grid_body(np.array(labels), ["soil", "rock"], options.pop("spacing", 1.0), **options)


def test_files_that_are_no_slices_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such file or folder"):
        read_slices(tmp_path / "absent")
    folder = tmp_path / "slices"
    folder.mkdir()
    picture(folder / "a1.png", np.zeros((6, 6)))
    with pytest.raises(InputError, match="holds 1 pictures"):
        read_slices(folder)
    picture(folder / "a2.png", np.zeros((6, 8)))
    with pytest.raises(InputError, match="8 x 6 pixels, the first one 6 x 6"):
        read_slices(folder)
    with pytest.raises(InputError, match="neither a folder nor a TIFF"):
        read_slices(folder / "a1.png")
    (tmp_path / "broken.tif").write_bytes(b"no tiff at all")
    with pytest.raises(InputError, match="damaged"):
        read_slices(tmp_path / "broken.tif")


@pytest.mark.parametrize("voxel", [None, -0.1, (0.1, 0.1), (0.1, 0.1, 0.0)])
def test_slices_need_the_size_of_a_voxel(tmp_path, voxel):
    with pytest.raises(InputError, match="slices, voxel"):
        grid_from_slices(tmp_path, voxel=voxel, legend=LEGEND)


def test_colours_of_slices_that_nobody_listed_are_refused(tmp_path):
    for number in range(2):
        picture(tmp_path / f"{number}.png", np.full((6, 6, 3), (250, 20, 200)))
    with pytest.raises(InputError, match="#fa14c8, which is not listed"):
        grid_from_slices(tmp_path, voxel=0.1, legend=LEGEND)


def test_files_that_are_no_image_data_are_refused(tmp_path):
    import pyvista

    def read(path, **options):
        return grid_from_vtk(path, **{"thresholds": [0.5], "materials": ("a", "b"), **options})

    image = pyvista.ImageData(dimensions=(3, 3, 3))
    image.cell_data["one"] = np.arange(8.0)
    image.cell_data["other"] = np.arange(8.0)
    image.save(tmp_path / "two.vti")
    pyvista.Sphere().save(tmp_path / "sphere.vtk")
    with pytest.raises(InputError, match="no such file"):
        read(tmp_path / "absent.vti")
    with pytest.raises(InputError, match="no such array"):
        read(tmp_path / "two.vti")
    with pytest.raises(InputError, match="do not grow"):
        read(tmp_path / "two.vti", scalars="one", thresholds=[2.0, 1.0])
    with pytest.raises(InputError, match="part 2 materials"):
        read(tmp_path / "two.vti", scalars="one", materials=("a",))
    content = (tmp_path / "two.vti").read_bytes()
    (tmp_path / "cut.vti").write_bytes(content[: len(content) // 3])
    with pytest.raises(InputError, match="the file is damaged"):
        read(tmp_path / "cut.vti")
    with pytest.raises(InputError, match="holds PolyData"):
        read(tmp_path / "sphere.vtk")
    with pytest.raises(InputError, match=r"no \.vti or \.vtk"):
        read(picture(tmp_path / "a.png", np.zeros((6, 6))))


def test_a_file_that_ends_the_process_that_reads_it_is_refused(tmp_path):
    """4294967295 compressed blocks: VTK asks for the memory, and aborts."""
    import pyvista

    image = pyvista.ImageData(dimensions=(30, 30, 30))
    image.cell_data["one"] = np.arange(29.0**3)
    image.save(tmp_path / "grid.vti")
    content = (tmp_path / "grid.vti").read_bytes()
    assert content.count(b"BgAAAACA") == 1  # 6 blocks of 32768 bytes
    (tmp_path / "grid.vti").write_bytes(content.replace(b"BgAAAACA", b"/////wCA"))
    with pytest.raises(InputError, match="the file is damaged"):
        grid_from_vtk(tmp_path / "grid.vti", thresholds=[0.5], materials=("a", "b"))


def test_a_picture_that_is_absent_or_has_no_scale_is_refused(corner, tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        grid_from_image(tmp_path / "absent.png", scale=1.0, legend=LEGEND)
    with pytest.raises(InputError, match="grid, scale"):
        grid_from_image(corner, scale=-1.0, legend=LEGEND)
    # of which areas are infinite or nothing
    for scale in (1e200, 1e-200):
        with pytest.raises(InputError, match="Check the unit"):
            grid_from_image(corner, scale=scale, legend=LEGEND)
