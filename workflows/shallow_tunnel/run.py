"""The workflow from Python: an unlined tunnel to its collapse, checked against expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import geodem

HERE = Path(__file__).resolve().parent


def main(out: str = "shallow_tunnel-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where the factor of safety is the expected one, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    good = result["collapse"] is None
    for entry in result["factors"]:
        wanted = expected.get(entry["kind"])
        print(f"{entry['kind']}: {entry['value']:.4g} ({entry['stable']:.4g} to {entry['failed']:.4g})")
        if wanted is not None:
            within = wanted["quick" if quickly else "within"]
            difference = entry["value"] / wanted["value"] - 1.0
            good &= abs(difference) <= within
            print(f"  for {wanted['value']:g}: {100 * difference:+.2f} % (bound {100 * within:g} %)")
    print(f"Report: {out}/report.html")
    return 0 if good else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
