"""The workflow from Python: factor of safety of a slope that was drawn, checked against expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import geodem

HERE = Path(__file__).resolve().parent


def main(out: str = "slope_from_picture-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where the factor of safety is the expected one, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())["strength-reduction"]
    result = geodem.run_case(HERE, out, quickly=quickly)
    found = result["factors"][0]["value"]
    difference = found / expected["factor"] - 1.0
    within = 0.06 if quickly else expected["within"]
    print(f"Factor of safety {found:.3f}, expected {expected['factor']:g}: {100.0 * difference:+.1f} %")
    print(f"Report: {out}/report.html")
    return 0 if abs(difference) <= within else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
