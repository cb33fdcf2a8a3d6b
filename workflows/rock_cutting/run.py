"""The workflow from Python: a tool cuts weak sandstone, checked against expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path
from typing import Any

import geodem

HERE = Path(__file__).resolve().parent


def at(result: dict[str, Any], place: str) -> float:
    """The number at a dotted place."""
    found: Any = result
    for key in place.split("."):
        found = found[key]
    return float(found)


def main(out: str = "rock_cutting-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything lies within its bounds, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text(encoding="utf-8"))
    result = geodem.run_case(HERE, out, quickly=quickly)
    good = True
    for place, wanted in expected.items():
        low, high = wanted["quick" if quickly else "within"]
        found = at(result, place)
        good &= low <= found <= high
        print(
            f"{place}: {found:.4g}, within {low:.4g} to {high:.4g}: {'good' if low <= found <= high else 'OFF'}"
        )
    print(f"Report: {out}/report.html")
    return 0 if good else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
