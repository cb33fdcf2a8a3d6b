"""The workflow from Python: the gravity factor, checked against expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import geodem

HERE = Path(__file__).resolve().parent


def main(out: str = f"{HERE.name}-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where every factor lies where expected.toml has it, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())["quick" if quickly else "factors"]
    result = geodem.run_case(HERE, out, quickly=quickly)
    wrong = 0
    for factor in result["factors"]:
        told = f"{factor['kind']}: stands at {factor['stable']}, failed at {factor['failed']}"
        if factor["kind"] not in expected:
            print(told)
            continue
        low, high = expected[factor["kind"]]
        found = factor["value"]
        good = found is not None and low <= found <= high
        wrong += not good
        print(f"{told}; {'within' if good else 'NOT within'} {low} to {high}")
    print(f"Report: {out}/report.html")
    return 0 if wrong == 0 else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
