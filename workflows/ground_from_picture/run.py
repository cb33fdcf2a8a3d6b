"""The workflow from Python: the particles of a drawing, their areas and masses checked against expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import geodem

HERE = Path(__file__).resolve().parent


def main(out: str = "ground_from_picture-result", quickly: bool = False) -> int:
    """Make the particles; returns 0 where areas and masses are those of the drawing, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    wrong = 0
    for row in result["materials"]:
        area = expected["areas"][row["name"]]
        mass = area * row["density_kg_m3"]
        area_off, mass_off = row["represented_size"] / area - 1.0, row["mass"] / mass - 1.0
        print(
            f"{row['name']}: {row['particles']} discs, area {100 * area_off:+.2f} %, mass {100 * mass_off:+.2f} %"
        )
        wrong += abs(area_off) > expected["areas"]["within"] * (3.0 if quickly else 1.0)
        wrong += abs(mass_off) > expected["masses"]["within"]
    print(f"Report: {out}/report.html")
    return 0 if wrong == 0 else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
