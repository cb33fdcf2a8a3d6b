"""The workflow from Python: three bonded firs break; discs, pieces and fall are held to expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import geodem
from geodem.io.frame_reading import frame_paths, read_frame

HERE = Path(__file__).resolve().parent


def main(out: str = "bonded_trees-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything is as expected, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    frames = [read_frame(path) for path in frame_paths(Path(out) / "frames")]
    first, last = frames[0], frames[-1]
    kept = len(last.radii) / len(first.radii)
    fallen = float(last.positions[:, 1].mean() / first.positions[:, 1].mean())
    pieces, single = result["fragments"]["pieces"], result["fragments"]["single_particles"]
    share = single / result["particles"]
    # the quick form fills the picture anew with about as many
    discs = expected["picture"]["discs"]
    as_many = abs(result["particles"] - discs) <= (0.01 * discs if quickly else 0)
    rows = [
        ("discs", float(result["particles"]), as_many),
        ("share of the discs that are there in the end", kept, kept >= expected["mass"]["share"]),
        ("pieces larger than a disc", float(pieces), pieces > expected["pieces"]["more_than"]),
        ("share of the discs that are alone", share, share < expected["pieces"]["single_below"]),
        ("mean height after over before", fallen, fallen < expected["fall"]["lower_than"]),
    ]
    for name, value, good in rows:
        print(f"{name}: {value:.4g} {'' if good else 'NOT AS EXPECTED'}")
    print(f"Report: {out}/report.html")
    return 0 if all(good for *_, good in rows) else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
