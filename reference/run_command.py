"""``python -m reference run NAME``: run a group of problems and hold every figure to its bound."""

from __future__ import annotations

import argparse
import sys
from types import ModuleType

from .problems import (
    arrays,
    cantilever,
    caving,
    cutting,
    cutting_clay,
    cutting_energy,
    dice2d,
    dice2d_cavern,
    dice2d_slope,
    disc_friction,
    energy_account,
    fewbody,
    fuzzing,
    granular,
    ground,
    ground_bodies,
    ground_joints,
    ground_meshes,
    ground_terrain,
    interruptions,
    laboratory_convergence,
    laboratory_dice2d,
    laboratory_elastic,
    laboratory_granite,
    laboratory_granite_3d,
    laboratory_laws,
    laboratory_step,
    laboratory_tests,
    lattice,
    long_memory,
    long_work,
    order,
    oscillator,
    published_slopes,
    rock_calibration,
    runout,
    runout_columns,
    stability,
    timestep,
    trapdoor,
    trubal,
    tunnels,
    tunnels_spalling,
)
from .results_file import store_rows

HELP = "run a group of problems, print every figure beside its bound, store the rows; exit status 0 if all are good"

PROBLEMS: dict[str, ModuleType] = {
    "arrays": arrays,
    "cantilever": cantilever,
    "caving": caving,
    "cutting": cutting,
    "cutting-clay": cutting_clay,
    "cutting-energy": cutting_energy,
    "dice2d": dice2d,
    "disc-friction": disc_friction,
    "dice2d-cavern": dice2d_cavern,
    "dice2d-slope": dice2d_slope,
    "energy-account": energy_account,
    "fewbody": fewbody,
    "fuzzing": fuzzing,
    "granular": granular,
    "ground": ground,
    "ground-bodies": ground_bodies,
    "ground-joints": ground_joints,
    "ground-meshes": ground_meshes,
    "ground-terrain": ground_terrain,
    "interruptions": interruptions,
    "laboratory-convergence": laboratory_convergence,
    "laboratory-dice2d": laboratory_dice2d,
    "laboratory-elastic": laboratory_elastic,
    "laboratory-granite": laboratory_granite,
    "laboratory-granite-3d": laboratory_granite_3d,
    "laboratory-laws": laboratory_laws,
    "laboratory-step": laboratory_step,
    "laboratory-tests": laboratory_tests,
    "lattice": lattice,
    "long-memory": long_memory,
    "long-work": long_work,
    "order": order,
    "oscillator": oscillator,
    "rocks": rock_calibration,
    "slopes": published_slopes,
    "runout": runout,
    "runout-columns": runout_columns,
    "stability": stability,
    "timestep": timestep,
    "trapdoor": trapdoor,
    "trubal": trubal,
    "tunnels": tunnels,
    "tunnels-spalling": tunnels_spalling,
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The name of the group."""
    parser.add_argument("name", choices=sorted(PROBLEMS))


def main(arguments: argparse.Namespace) -> int:
    """Run a group; 0 only where every figure is within its bound."""
    rows = PROBLEMS[arguments.name].run()
    for row in rows:
        error, bound = 100.0 * row.error, 100.0 * row.bound
        print(
            f"{'good' if row.good else 'MISS':4s} {row.name:28s} {row.quantity:44s} {row.value:11.5g} "
            f"expected {row.expected:11.5g} error {error:+.3f} % bound {bound:g} % {row.seconds:.1f} s"
        )
    stored = [
        {
            **row._asdict(),
            "error_percent": 100.0 * row.error,
            "bound_percent": 100.0 * row.bound,
            "good": row.good,
        }
        for row in rows
    ]
    # the benchmark of the same name keeps its rows under its own
    name = "slopes-bounds" if arguments.name == "slopes" else arguments.name
    path = store_rows(name, stored, "python -m reference " + " ".join(sys.argv[1:]))
    print(f"stored in {path}")
    return 0 if all(row.good for row in rows) else 1
