"""What the numbers of a run depend on beside its case: versions, and the code that made them."""

from __future__ import annotations

import hashlib
import platform
from functools import lru_cache
from pathlib import Path

from ._version import __version__

TELLING = (
    "plotting",
    "templates",
    "io/particle_frames.py",
    "particle_recorder.py",
    "measure/contact_forces.py",
    "measure/failure.py",
    "measure/slip_surface.py",
    "cli.py",
    "checking.py",
    "outputs.py",
    "result.py",
    "workflow.py",
    "kinds.py",
    "run_progress.py",
    "telling.py",
    "check_printing.py",
    "slope_run.py",
    "slope_check.py",
    "laboratory_check.py",
    "ground_check.py",
    "breaking_check.py",
    "sweep_check.py",
    "sweep_hands.py",
    "sweep_record.py",
    "sweep_result.py",
    "sweep_run.py",
    "sweep_worker.py",
    "case/sweep.py",
    "case/sweep_files.py",
    "case/sweep_reading.py",
    "case/sweep_values.py",
    "cutting_check.py",
    "cutting_result.py",
    "cutting_run.py",
    "breaking_result.py",
    "breaking_run.py",
    "runout_check.py",
    "__main__.py",
    "laboratory_run.py",
    "calibration_run.py",
    "io/run_folder.py",
    "laboratory/entries.py",
    "laboratory/estimate.py",
    "laboratory/files.py",
    "laboratory/processes.py",
    "laboratory/summary.py",
    "laboratory/worker.py",
    "laboratory/workers.py",
    "calibration/entries.py",
    "calibration/outcomes.py",
)
"""Parts of geodem that tell results and decide none."""


@lru_cache(maxsize=1)
def versions() -> dict[str, str]:
    """Versions of what the numbers depend on."""
    import numba
    import numpy
    import scipy

    return {
        "geodem": __version__,
        "python": platform.python_version(),
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
    }


@lru_cache(maxsize=1)
def sources_digest() -> str:
    """Hash of all that decides numbers: a checkpoint is continued only by the code and libraries that began it."""
    digest = hashlib.sha256(repr(sorted(versions().items())).encode())
    root = Path(__file__).parent
    for path in sorted(root.rglob("*.py")):
        inside = path.relative_to(root)
        if inside.parts[0] in TELLING or inside.as_posix() in TELLING:
            continue
        digest.update(str(inside).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
