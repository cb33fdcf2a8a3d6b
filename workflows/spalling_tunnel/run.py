"""The workflow from Python: where the tunnel spalls, checked against expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np

import geodem

HERE = Path(__file__).resolve().parent


def crack_places(out: Path) -> np.ndarray:
    """Places (k, 2) [m] of all cracks, from the last frame."""
    last = sorted((out / "frames").glob("cracks-*.vtkhdf"))[-1]
    with h5py.File(last) as frame:
        return np.asarray(frame["VTKHDF/Points"])[:, :2]


def draw(out: Path, places: np.ndarray) -> None:
    """Picture cracks.png: the tunnel, its cracks, and how large Kirsch's hoop stress is around it."""
    from matplotlib.collections import EllipseCollection
    from matplotlib.figure import Figure

    last = sorted((out / "frames").glob("particles-*.vtkhdf"))[-1]
    with h5py.File(last) as frame:
        centres = np.asarray(frame["VTKHDF/Points"])[:, :2]
        name = next(key for key in frame["VTKHDF/PointData"] if key.startswith("radius"))
        sizes = 2.0 * np.asarray(frame["VTKHDF/PointData"][name])
    r, angle = np.hypot(*centres.T), np.arctan2(centres[:, 1], centres[:, 0])
    near = np.minimum(2.0 / r, 1.0)
    hoop = 82.5 * (1.0 + near**2) - 37.5 * (1.0 + 3.0 * near**4) * np.cos(2.0 * angle)
    figure = Figure(figsize=(7.0, 6.0), layout="constrained")
    axes = figure.subplots()
    axes.set(xlim=(-4.5, 4.5), ylim=(-4.5, 4.5), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    discs = EllipseCollection(
        sizes, sizes, np.zeros(len(sizes)), units="xy", offsets=centres, offset_transform=axes.transData, array=hoop,
        cmap="YlOrBr", clim=(0.0, 320.0), rasterized=True,
    )  # fmt: skip
    axes.add_collection(discs, autolim=False)
    axes.plot(
        *places.T, "x", color="#0b3c5d", markersize=7.0, markeredgewidth=1.8, label=f"{len(places)} cracks"
    )
    axes.legend(loc="upper right")
    figure.colorbar(discs, label="hoop stress of Kirsch before anything breaks [MPa]", shrink=0.8)
    figure.savefig(out / "cracks.png", dpi=130)


def main(out: str = f"{HERE.name}-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where the cracks are where expected.toml has them, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())["quick" if quickly else "cracks"]
    result = geodem.run_case(HERE, out, quickly=quickly)
    places = crack_places(Path(out))
    # from the vertical, where the hoop stress is largest
    away = np.degrees(np.arctan2(np.abs(places[:, 0]), np.abs(places[:, 1])))
    share = float((away < 45.0).mean()) if len(places) else 0.0
    found = {"count": float(len(places)), "share_at_roof_and_floor": share}
    draw(Path(out), places)
    wrong = 0
    for name, value in found.items():
        low, high = expected[name]
        good = low <= value <= high
        wrong += not good
        print(f"{name}: {value:g}; {'within' if good else 'NOT within'} {low:g} to {high:g}")
    print(f"{result['particles']} particles. Report: {out}/report.html, picture: {out}/cracks.png")
    return 0 if wrong == 0 else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
