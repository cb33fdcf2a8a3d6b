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
