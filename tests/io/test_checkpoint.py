"""Checkpoints: the same bits back, and never a damaged one read as a good one."""

from __future__ import annotations

import os
import pickle

import h5py
import numpy as np
import pytest

from geodem.errors import InputError
from geodem.io.checkpoint import read_checkpoint, write_checkpoint

TREE = {
    "version": "1",
    "none": None,
    "trials": [{"factor": 1.25, "history": [[50, 1e-3, 0.1 + 0.2]]}],
    "state": {"stress": np.arange(12.0).reshape(3, 4) / 7.0, "held": np.array([[True, False]]), "steps": 3},
    "empty": np.zeros((0, 2)),
}


def test_everything_comes_back_with_the_same_bits(tmp_path):
    write_checkpoint(tmp_path / "c.h5", TREE)
    back = read_checkpoint(tmp_path / "c.h5")
    assert back["trials"] == TREE["trials"]
    assert back["none"] is None
    assert back["state"]["stress"].tobytes() == TREE["state"]["stress"].tobytes()
    assert back["state"]["held"].dtype == bool
    assert back["state"]["steps"] == 3
    assert back["empty"].shape == (0, 2)


def test_truncated_file_is_refused(tmp_path):
    path = tmp_path / "c.h5"
    write_checkpoint(path, TREE)
    data = path.read_bytes()
    for length in (0, 100, len(data) // 2, len(data) - 1):
        path.write_bytes(data[:length])
        with pytest.raises(InputError, match=r"damaged|changed|not a checkpoint"):
            read_checkpoint(path)


def test_one_changed_number_is_refused(tmp_path):
    path = tmp_path / "c.h5"
    write_checkpoint(path, TREE)
    with h5py.File(path, "r+") as file:
        file["state/stress"][1, 1] += 1e-15
    with pytest.raises(InputError, match="checksum"):
        read_checkpoint(path)


def test_other_format_version_is_refused(tmp_path):
    path = tmp_path / "c.h5"
    write_checkpoint(path, TREE)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 999
    with pytest.raises(InputError, match="format 999"):
        read_checkpoint(path)


def test_a_pickle_is_not_executed(tmp_path):
    class Evil:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "pwned"),)

    (tmp_path / "c.h5").write_bytes(pickle.dumps(Evil()))
    with pytest.raises(InputError):
        read_checkpoint(tmp_path / "c.h5")
    assert not (tmp_path / "pwned").exists()


def test_missing_file_names_the_remedy(tmp_path):
    with pytest.raises(InputError, match="geodem run"):
        read_checkpoint(tmp_path / "none.h5")


def test_a_failed_write_keeps_the_old_one(tmp_path):
    path = tmp_path / "c.h5"
    write_checkpoint(path, TREE)
    with pytest.raises(TypeError):
        write_checkpoint(path, {"bad": object()})
    assert read_checkpoint(path)["version"] == "1"


@pytest.mark.parametrize(
    "kind", ["soft", "external", "loop", "objects", "words", "promise", "virtual", "raw"]
)
def test_what_points_elsewhere_or_is_no_number_is_refused(kind, tmp_path):
    """HDF5 can hold links, objects and arrays that are promised only; with a checksum that fits, as one could make."""
    path, other = tmp_path / "c.h5", tmp_path / "other.h5"
    write_checkpoint(path, TREE)
    write_checkpoint(other, TREE)
    with h5py.File(path, "r+") as file:
        if kind == "soft":
            file["more"] = h5py.SoftLink("/state/stress")
        elif kind == "external":
            file["more"] = h5py.ExternalLink(str(other), "/state/stress")
        elif kind == "loop":
            file["state/loop"] = file["state"]
        elif kind == "objects":
            file.create_dataset("more", data=[file["state"].ref], dtype=h5py.ref_dtype)
        elif kind == "words":
            file.create_dataset("more", data=["import os"], dtype=h5py.string_dtype())
        elif kind == "promise":
            file.create_dataset("more", shape=(10**12,), chunks=(1000,), dtype=float)
        elif kind == "virtual":
            layout = h5py.VirtualLayout(shape=(3, 4), dtype=float)
            layout[:] = h5py.VirtualSource(str(other), "/state/stress", shape=(3, 4))
            file.create_virtual_dataset("more", layout)
        else:
            (tmp_path / "raw").write_bytes(bytes(80))
            file.create_dataset("more", shape=(10,), dtype=float, external=[(str(tmp_path / "raw"), 0, 80)])
    with pytest.raises(InputError, match="damaged or cut off"):
        read_checkpoint(path)
