"""VTKHDF files are read back with VTK's own reader, the one that ParaView uses."""

import json
import resource

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.io.vtkhdf import write_series, write_vtkhdf

vtk_hdf = pytest.importorskip("vtkmodules.vtkIOHDF")
vtk_numpy = pytest.importorskip("vtkmodules.util.numpy_support")

POSITIONS = np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 1.5], [1.0, 3.0]])
TRIANGLES = np.array([[0, 1, 2], [1, 3, 2], [2, 3, 4]], dtype=np.int32)


def read(path):
    reader = vtk_hdf.vtkHDFReader()
    reader.SetFileName(str(path))
    assert reader.CanReadFile(str(path))
    reader.Update()
    return reader.GetOutput()


def array(data, name):
    found = data.GetArray(name)
    assert found is not None, name
    return vtk_numpy.vtk_to_numpy(found)


@pytest.mark.parametrize("time", [None, 1.375])
def test_vtk_reads_what_was_written(tmp_path, time):
    rng = np.random.default_rng(3)
    displacement, strain = rng.normal(size=(5, 2)), rng.random(5)
    stress = rng.normal(size=(3, 6))
    write_vtkhdf(
        tmp_path / "frame.vtkhdf",
        POSITIONS,
        TRIANGLES,
        point_data={
            "displacement [m]": displacement,
            "plastic shear strain [-]": strain,
            "moving": strain > 0.5,
        },
        cell_data={"material": np.array([0, 1, 1], dtype=np.int32), "stress [Pa]": stress},
        field_data={"factor [-]": 1.267, "method": "strength-reduction"},
        time=time,
    )
    grid = read(tmp_path / "frame.vtkhdf")
    points = vtk_numpy.vtk_to_numpy(grid.GetPoints().GetData())
    np.testing.assert_array_equal(points[:, :2], POSITIONS)
    np.testing.assert_array_equal(points[:, 2], 0.0)
    assert grid.GetNumberOfCells() == 3
    for cell in range(3):
        assert grid.GetCellType(cell) == 5
        ids = grid.GetCell(cell).GetPointIds()
        assert [ids.GetId(k) for k in range(3)] == TRIANGLES[cell].tolist()
    moved = array(grid.GetPointData(), "displacement [m]")
    np.testing.assert_array_equal(moved, np.column_stack([displacement, np.zeros(5)]))
    np.testing.assert_array_equal(array(grid.GetPointData(), "plastic shear strain [-]"), strain)
    np.testing.assert_array_equal(array(grid.GetPointData(), "moving"), strain > 0.5)
    np.testing.assert_array_equal(array(grid.GetCellData(), "material"), [0, 1, 1])
    np.testing.assert_array_equal(array(grid.GetCellData(), "stress [Pa]"), stress)
    np.testing.assert_array_equal(array(grid.GetFieldData(), "factor [-]"), [1.267])
    assert grid.GetFieldData().GetAbstractArray("method").GetValue(0) == "strength-reduction"
    if time is not None:
        np.testing.assert_array_equal(array(grid.GetFieldData(), "TimeValue"), [time])


def test_text_beyond_ascii_arrives(tmp_path):
    write_vtkhdf(tmp_path / "frame.vtkhdf", POSITIONS, field_data={"title": "Böschung φ = 20°"})
    grid = read(tmp_path / "frame.vtkhdf")
    assert grid.GetFieldData().GetAbstractArray("title").GetValue(0) == "Böschung φ = 20°"


def test_a_slash_in_a_unit_becomes_per(tmp_path):
    write_vtkhdf(tmp_path / "frame.vtkhdf", POSITIONS, point_data={"force [N/m]": np.arange(5.0)})
    data = read(tmp_path / "frame.vtkhdf").GetPointData()
    assert data.GetNumberOfArrays() == 1
    np.testing.assert_array_equal(array(data, "force [N per m]"), np.arange(5.0))


def test_series_names_frames_and_times(tmp_path):
    write_series(tmp_path / "run.vtkhdf.series", [("a.vtkhdf", 0), ("b.vtkhdf", 1.5)])
    assert json.loads((tmp_path / "run.vtkhdf.series").read_text()) == {
        "file-series-version": "1.0",
        "files": [{"name": "a.vtkhdf", "time": 0.0}, {"name": "b.vtkhdf", "time": 1.5}],
    }


def test_many_particles_in_three_dimensions(tmp_path):
    rng = np.random.default_rng(4)
    positions = rng.normal(size=(60_000, 3))
    cells = rng.integers(0, 60_000, (50_000, 4))
    write_vtkhdf(tmp_path / "big.vtkhdf", positions, cells, point_data={"speed [m s-1]": positions[:, 0]})
    grid = read(tmp_path / "big.vtkhdf")
    np.testing.assert_array_equal(vtk_numpy.vtk_to_numpy(grid.GetPoints().GetData()), positions)
    np.testing.assert_array_equal(
        vtk_numpy.vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4), cells
    )
    np.testing.assert_array_equal(array(grid.GetPointData(), "speed [m s-1]"), positions[:, 0])
    assert grid.GetCellType(0) == 10


def test_particles_without_triangles_are_vertices(tmp_path):
    write_vtkhdf(tmp_path / "dots.vtkhdf", POSITIONS)
    grid = read(tmp_path / "dots.vtkhdf")
    assert grid.GetNumberOfCells() == 5
    assert {grid.GetCellType(cell) for cell in range(5)} == {1}


def test_the_same_frame_gives_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        write_vtkhdf(tmp_path / name, POSITIONS, TRIANGLES, point_data={"u [m]": POSITIONS}, time=0.0)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"point_data": {"u [m]": np.zeros(4)}}, "5 rows"),
        ({"cell_data": {"s [Pa]": np.zeros(5)}}, "3 rows"),
        ({"point_data": {"": np.zeros(5)}}, "without a name"),
        ({"triangles": [[0, 1, 5]]}, "0..4"),
        ({"triangles": [[0, 1, 2, 3, 4]]}, "(m, 3)"),
    ],
)
def test_arrays_that_do_not_fit_are_refused_and_leave_no_file(tmp_path, arguments, word):
    with pytest.raises(ValueError) as caught:
        write_vtkhdf(tmp_path / "x.vtkhdf", POSITIONS, **{"triangles": TRIANGLES, **arguments})
    assert word in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_no_room_leaves_the_old_frame(tmp_path):
    path = tmp_path / "frame.vtkhdf"
    write_vtkhdf(path, POSITIONS, TRIANGLES)
    before = path.read_bytes()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
    try:
        with pytest.raises(InputError) as caught:
            write_vtkhdf(path, np.random.default_rng(5).normal(size=(5000, 2)))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert "--out" in str(caught.value)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["frame.vtkhdf"]


@pytest.mark.parametrize("count", [0, 2])
def test_lines(tmp_path, count):
    lines = np.array([[0, 1], [3, 2]])[:count]
    write_vtkhdf(tmp_path / "lines.vtkhdf", POSITIONS, lines, cell_data={"force [N]": np.arange(count) + 1.5})
    grid = read(tmp_path / "lines.vtkhdf")
    assert grid.GetNumberOfPoints() == 5
    assert grid.GetNumberOfCells() == count
    for cell in range(count):
        assert grid.GetCellType(cell) == 3
        ids = grid.GetCell(cell).GetPointIds()
        assert [ids.GetId(k) for k in range(2)] == lines[cell].tolist()
    assert array(grid.GetCellData(), "force [N]").tolist() == [1.5, 2.5][:count]
