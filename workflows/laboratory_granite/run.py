"""The workflow from Python: a granite in the laboratory, its properties checked against expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import geodem

HERE = Path(__file__).resolve().parent


def main(out: str = "laboratory_granite-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where all properties are the expected ones, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    good = True
    for key, wanted in expected.items():
        found = result["properties"][key]["mean"]
        within = wanted["quick" if quickly else "within"]
        difference = found / wanted["value"] - 1.0
        good &= abs(difference) <= within
        print(
            f"{key}: {found:.4g}, for {wanted['value']:.4g}: {100 * difference:+.1f} % (bound {100 * within:.0f} %)"
        )
    print(f"Report: {out}/report.html")
    return 0 if good else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
