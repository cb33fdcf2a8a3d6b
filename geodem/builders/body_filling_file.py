"""Fillings of bodies on disk, to be made once and used often: NumPy archives of plain arrays."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import IO

import numpy as np

from geodem.builders.body_filling import BodyFilling
from geodem.errors import InputError

FORMAT = 1
"""Version of the file; raised when its meaning changes."""
KIND = "geodem body filling"


def save_filling(filling: BodyFilling, path: str | Path) -> Path:
    """Write a filling to a .npz file, whole or not at all.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        The name does not end in .npz, or its folder does not exist.
    OSError
        The file cannot be written; what stood there is untouched.
    """
    target = Path(path)
    if target.suffix != ".npz" or not target.parent.is_dir():
        raise InputError(
            "save_filling", "this is no .npz file in a folder that exists", "Mend the path.", value=str(path)
        )
    # as every unfinished file of a run is called, so that one that is left is known and taken away
    draft = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        with draft.open("wb") as stream:
            _write(stream, filling)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(draft, target)
    except BaseException:
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)
        raise
    return target


def _write(stream: IO[bytes], filling: BodyFilling) -> None:
    np.savez_compressed(
        stream,
        kind=np.array(KIND),
        format=np.array(FORMAT),
        positions=filling.positions,
        radii=filling.radii,
        material=filling.material,
        materials=np.array(filling.materials, dtype=np.str_),
        sources=filling.sources,
        solid_fraction=np.array(filling.solid_fraction),
        arrangement=np.array(filling.arrangement),
        group=filling.group,
        remarks=np.array(filling.remarks, dtype=np.str_),
    )


def load_filling(path: str | Path) -> BodyFilling:
    """Read what `save_filling` wrote; only numbers and text are read, nothing is executed.

    Raises
    ------
    InputError
        No such file, another kind of file or version, or arrays that do not fit together.
    """
    source = Path(path)
    if not source.is_file():
        raise InputError("load_filling", "there is no such file", "Mend the path.", value=str(path))
    try:
        with np.load(source, allow_pickle=False) as archive:
            held = {name: np.asarray(archive[name]) for name in archive.files}
    # NumPy, zipfile and zlib each have errors of their own for a damaged file
    except Exception as error:
        raise InputError(
            "load_filling", f"the file is damaged or another kind ({error})", "Make the filling anew.",
            value=str(path),
        ) from error  # fmt: skip
    if str(held.get("kind", "")) != KIND:
        raise InputError("load_filling", "this is no filling", "Give one of save_filling.", value=str(path))
    form = str(held.get("format", "none"))
    if form != str(FORMAT):
        raise InputError(
            "load_filling", f"the file has the format {form}, this version reads {FORMAT}",
            "Make the filling anew.", value=str(path),
        )  # fmt: skip
    _refuse_misfits(held, str(path))
    return BodyFilling(
        positions=held["positions"],
        radii=held["radii"],
        material=held["material"],
        materials=tuple(held["materials"].tolist()),
        sources=held["sources"],
        solid_fraction=float(held["solid_fraction"]),
        arrangement=str(held["arrangement"]),
        group=held["group"],
        remarks=tuple(held["remarks"].tolist()),
    )


def _refuse_misfits(held: dict[str, np.ndarray], shown: str) -> None:
    """Arrays that are missing, of another type or length, or name materials that there are not."""
    kinds = {
        "positions": np.float64, "radii": np.float64, "sources": np.float64, "solid_fraction": np.float64,
        "material": np.int32, "group": np.int32,
    }  # fmt: skip
    wrong = [name for name, kind in kinds.items() if name not in held or held[name].dtype != kind]
    wrong += [
        name
        for name, axes in (("materials", 1), ("arrangement", 0), ("remarks", 1))
        if name not in held or held[name].ndim != axes
    ]
    if "solid_fraction" in held and held["solid_fraction"].ndim:
        wrong.append("solid_fraction")
    if not wrong:
        count = len(held["radii"]) if held["radii"].ndim == 1 else -1
        if held["positions"].shape not in ((count, 2), (count, 3)):
            wrong.append("positions")
        wrong += [name for name in ("material", "group") if held[name].shape != (count,)]
        if held["sources"].shape != held["materials"].shape:
            wrong.append("sources")
        number = held["material"]
        if count > 0 and not (number.min() >= 0 and number.max() < len(held["materials"])):
            wrong.append("material")
    if wrong:
        raise InputError(
            "load_filling", f"the file's {', '.join(dict.fromkeys(wrong))} does not fit", "Make the filling anew.",
            value=shown,
        )  # fmt: skip
