"""Files of a tunnel run beside its report: history and frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .io.history import HistoryWriter, continued_history
from .io.vtkhdf import write_vtkhdf
from .tunnelling.digging import Digging
from .tunnelling.measure import yielded

FRAMES = "stage-*.vtkhdf"
COLUMNS = {
    "relaxed [-]": "relaxed", "pressure on the wall [Pa]": "pressure", "lining pressure [Pa]": "lining_pressure",
    "mean convergence [m]": "mean", "crown [m]": "crown", "invert [m]": "invert", "horizontal [m]": "horizontal",
    "vertical [m]": "vertical", "plastic radius over radius [-]": "plastic_radius_ratio",
    "yielded area [m2]": "yielded_area", "settlement of the surface [m]": "settlement",
    "largest thrust [N per m]": "largest_thrust", "largest moment [N m per m]": "largest_moment",
    "largest bolt force [N per m]": "largest_bolt_force", "steps [-]": "steps",
    "unbalanced force ratio [-]": "unbalanced",
}  # fmt: skip


def history_line(row: Mapping[str, Any]) -> tuple[Any, ...]:
    """A line of history.csv: an opening after an increment."""
    return (row["stage"], row["opening"], *(row[key] for key in COLUMNS.values()))


def write_history(path: Path, rows: Sequence[Mapping[str, Any]]) -> HistoryWriter:
    """Every increment, one line an opening; may be gone on with."""
    return continued_history(path, ("stage [-]", "excavation [-]", *COLUMNS), map(history_line, rows))


def write_frame(folder: Path, number: int, digging: Digging) -> None:
    """The standing ground after a stage."""
    now = digging.progress
    scene = digging.scene()
    stands = scene.standing
    model, count = stands.model, len(stands.particle)
    stress = now.stress[stands.point]
    values = model.particle_mean(stress)[:count]
    opening = digging.plan.openings[digging.dug[0]] if digging.dug else digging.plan.openings[0]
    zone = yielded(model, stress, 1.0, opening.centre).points.astype(np.float64)
    write_vtkhdf(
        folder / f"stage-{number}.vtkhdf",
        model.positions[:count],
        model.triangles,
        point_data={
            "displacement [m]": now.displacement[stands.particle],
            "stress xx [Pa]": values[:, 0],
            "stress yy [Pa]": values[:, 1],
            "stress xy [Pa]": values[:, 2],
            "plastic shear strain [-]": values[:, 3],
            "yielded [-]": model.particle_mean(zone[:, None])[:count, 0],
        },
        cell_data={"part [-]": model.triangle_material},
        field_data={"stage": digging.plan.stages[number - 1].name, "parts": ", ".join(model.material_names)},
        time=float(number),
    )
