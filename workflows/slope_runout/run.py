"""The workflow from Python: a slope fails and runs out; the hand-over and the deposit are held to expected.toml."""

from __future__ import annotations

import math
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

import geodem

HERE = Path(__file__).resolve().parent


def judged(result: dict[str, Any], expected: dict[str, Any]) -> list[tuple[str, float, bool]]:
    """Every figure, and whether it is as it must be."""
    rows = []
    for row in result["hand_over"]["conserved"]:
        if "energy" not in row["name"]:
            rows.append(
                (f"hand-over, {row['name']}", row["error"], row["error"] <= expected["hand_over"]["exact"])
            )
    jump = result["hand_over"]["energy_jump"]
    rows.append(("hand-over, energy", jump, jump <= expected["hand_over"]["energy"]))
    flow, deposit = expected["flow"], result["deposit"]
    for name in ("angle_of_reach_deg", "travel_angle_deg"):
        angle = deposit[name]
        rows.append((name, angle, flow["residual_deg"] <= angle <= flow["slope_deg"]))
    profile = np.array(deposit["profile_m"])
    steep = abs(math.degrees(math.atan(np.polyfit(*profile.T, 1)[0])))
    rows.append(("mean slope of the deposit [deg]", steep, steep <= flow["lies_deg"]))
    rows.append(("run-out [m]", deposit["run_out_m"], deposit["run_out_m"] > 0.0))
    rows.append(("at rest", float(result["flow"]["at_rest"]), bool(result["flow"]["at_rest"])))
    return rows


def main(out: str = "slope_runout-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where everything is as expected, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    rows = judged(result, expected)
    for name, value, good in rows:
        print(f"{name}: {value:.4g} {'' if good else 'NOT AS EXPECTED'}")
    print(f"Report: {out}/report.html")
    return 0 if all(good for *_, good in rows) else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
