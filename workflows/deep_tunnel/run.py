"""The workflow from Python: a lined and an unlined round tunnel, checked against the closed form in expected.toml."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import geodem

HERE = Path(__file__).resolve().parent


def main(out: str = "deep_tunnel-result", quickly: bool = False) -> int:
    """Run the case; returns 0 where every figure is the expected one, else 1."""
    expected = tomllib.loads((HERE / "expected.toml").read_text())
    result = geodem.run_case(HERE, out, quickly=quickly)
    tunnel, unlined = result["excavations"]["tunnel"], result["ground_reaction"][-1]
    shell = result["linings"][0]
    found = {
        "unlined_convergence_m": unlined["mean_convergence_m"],
        "unlined_plastic_radius_ratio": unlined["plastic_radius_ratio"],
        "lining_pressure_Pa": tunnel["lining_pressure_Pa"],
        "mean_convergence_m": tunnel["mean_convergence_m"],
        "thrust_N_per_m": 0.5 * (shell["smallest_thrust_N_per_m"] + shell["largest_thrust_N_per_m"]),
    }
    good = True
    for key, wanted in expected.items():
        within = wanted["quick" if quickly else "within"]
        difference = found[key] / wanted["value"] - 1.0
        good &= abs(difference) <= within
        print(
            f"{key}: {found[key]:.5g}, closed form {wanted['value']:.5g}: {100 * difference:+.2f} % "
            f"(bound {100 * within:g} %)"
        )
    print(f"Report: {out}/report.html")
    return 0 if good else 1


if __name__ == "__main__":
    arguments = [argument for argument in sys.argv[1:] if argument != "--quick"]
    sys.exit(main(*arguments, quickly="--quick" in sys.argv))
