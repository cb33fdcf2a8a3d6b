"""History files: units in the header, every record on disk at once, resumable."""

import errno
import math
import os
import resource

import numpy as np
import pytest

from geodem.errors import InputError
from geodem.io.files import write_whole
from geodem.io.history import COLUMNS, HistoryWriter, cut_history, read_history, write_history


def test_round_trip_keeps_every_bit(tmp_path):
    rng = np.random.default_rng(1)
    rows = [(int(10 * k), 1.0 + rng.random(), 10.0 ** -rng.uniform(0, 8), rng.random()) for k in range(50)]
    with HistoryWriter(tmp_path / "history.csv") as history:
        for row in rows:
            history.write(*row)
    read = read_history(tmp_path / "history.csv")
    assert list(read) == list(COLUMNS)
    np.testing.assert_array_equal(np.column_stack(list(read.values())), np.array(rows))


def test_header_names_every_unit(tmp_path):
    HistoryWriter(tmp_path / "history.csv").close()
    assert (tmp_path / "history.csv").read_text() == (
        "step [-],factor [-],unbalanced force ratio [-],mean displacement [m]\n"
    )
    with pytest.raises(ValueError, match="without a unit"):
        HistoryWriter(tmp_path / "history.csv", ["step"])


def test_records_are_on_disk_before_the_file_is_closed(tmp_path):
    history = HistoryWriter(tmp_path / "history.csv")
    history.write(1, 1.1, 1e-3, 0.25)
    assert read_history(tmp_path / "history.csv")["mean displacement [m]"].tolist() == [0.25]
    history.close()
    history.close()
    with pytest.raises(ValueError, match="closed"):
        history.write(2, 1.1, 1e-4, 0.25)


def test_numpy_numbers_and_text(tmp_path):
    columns = ("method [-]", "step [-]", "factor [-]")
    with HistoryWriter(tmp_path / "history.csv", columns) as history:
        history.write("gravity-increase, coarse", np.int64(3), np.float64(0.1))
    read = read_history(tmp_path / "history.csv")
    assert read["method [-]"].tolist() == ["gravity-increase, coarse"]
    assert read["step [-]"].tolist() == [3.0]
    assert read["factor [-]"].tolist() == [0.1]


def test_append_goes_on_and_cuts_off_an_unfinished_line(tmp_path):
    path = tmp_path / "history.csv"
    with HistoryWriter(path) as history:
        history.write(1, 1.0, 0.1, 0.0)
    with path.open("a") as stream:
        stream.write("2,1.0,0.0")
    assert len(read_history(path)["step [-]"]) == 1
    with HistoryWriter(path, append=True) as history:
        history.write(2, 1.0, 0.05, 0.5)
    assert read_history(path)["mean displacement [m]"].tolist() == [0.0, 0.5]


def test_without_append_the_file_begins_anew(tmp_path):
    path = tmp_path / "history.csv"
    for _ in range(2):
        with HistoryWriter(path) as history:
            history.write(1, 1.0, 0.1, 0.0)
    assert len(read_history(path)["step [-]"]) == 1


def test_append_where_there_is_no_file_or_an_empty_one(tmp_path):
    (tmp_path / "empty.csv").touch()
    for name in ("none.csv", "empty.csv"):
        with HistoryWriter(tmp_path / name, append=True) as history:
            history.write(1, 1.0, 0.1, 0.0)
        assert read_history(tmp_path / name)["factor [-]"].tolist() == [1.0]


def test_append_to_other_columns_is_refused(tmp_path):
    path = tmp_path / "history.csv"
    path.write_text("time [s],force [N]\n0,1\n")
    with pytest.raises(InputError, match="time"):
        HistoryWriter(path, append=True)
    assert path.read_text() == "time [s],force [N]\n0,1\n"


@pytest.mark.parametrize(
    ("content", "word"), [(None, "cannot be read"), ("", "empty"), ("a [m],b [m]\n1,2\n3\n", "line 3")]
)
def test_files_that_cannot_be_read(tmp_path, content, word):
    path = tmp_path / "history.csv"
    if content is not None:
        path.write_text(content)
    with pytest.raises(InputError, match=word):
        read_history(path)


def test_a_full_disk_while_writing(tmp_path):
    history = HistoryWriter(tmp_path / "history.csv")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, hard))
    try:
        history.write(1, 1.0, 0.1, 0.0)
        with pytest.raises(InputError, match="--out"):
            history.write(2, 1.0, 0.1, 2.0 / 3.0)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert read_history(tmp_path / "history.csv")["step [-]"].tolist() == [1.0]


@pytest.mark.parametrize(
    ("number", "word"),
    [
        (errno.ENOSPC, "disk is full"),
        (errno.EROFS, "read-only"),
        (errno.EACCES, "not permitted"),
        (errno.EIO, "cannot be written"),
    ],
)
def test_what_the_system_refuses_is_named_and_nothing_is_left(tmp_path, monkeypatch, number, word):
    (tmp_path / "report.html").write_text("old")

    def refuse(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(InputError, match=word) as caught:
        write_whole(tmp_path / "report.html", "new")
    assert "--out" in caught.value.remedy
    assert (tmp_path / "report.html").read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]


def test_folders_are_made_and_files_in_the_way_are_named(tmp_path):
    write_whole(tmp_path / "a" / "b" / "c.txt", "x")
    assert (tmp_path / "a" / "b" / "c.txt").read_text() == "x"
    with pytest.raises(InputError, match="not a folder"):
        write_whole(tmp_path / "a" / "b" / "c.txt" / "d.txt", "x")
    with pytest.raises(InputError, match="folder has the name"):
        write_whole(tmp_path / "a" / "b", "x")


def test_later_records_are_cut_off_and_the_others_kept_to_the_letter(tmp_path):
    path = tmp_path / "history.csv"
    write_history(path, ["step [-]", "name, of a wall [-]"], [(0, "a"), (20, 'b,"c"'), (40, "d")])
    before = path.read_text().splitlines(keepends=True)
    assert cut_history(path, 40) == 40.0
    assert path.read_text() == "".join(before)
    assert cut_history(path, 39) == 20.0
    assert path.read_text() == "".join(before[:3])
    assert cut_history(path, -1) == -math.inf
    assert path.read_text() == before[0]
    with pytest.raises(InputError, match="cannot be read"):
        cut_history(tmp_path / "none.csv", 0)
