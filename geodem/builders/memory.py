"""Memory that a scene needs, and what the machine has, compared before anything is made."""

from __future__ import annotations

import os

from geodem.errors import InputError

BYTES_PER_PARTICLE = {2: 700, 3: 1600}
"""Growth of the process at its peak, by dimension: rows, pairs of a dense packing, what the caller holds, and the
links that the critical step is measured on. Once a simulation is made less than half of it is left."""
BYTES_PER_BOND = 150
"""The same of a bond."""


def available_bytes() -> int | None:
    """Memory [B] that can be had without swapping; None where the system does not tell."""
    try:
        with open("/proc/meminfo") as lines:
            for line in lines:
                if line.startswith("MemAvailable:"):
                    return int(line.split()[1]) * 1024
    except OSError:
        pass
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return None


def needed_bytes(dimension: int, particles: int, bonds: int = 0) -> int:
    """Memory [B] of a run with so many discs or spheres and bonds."""
    return particles * BYTES_PER_PARTICLE[dimension] + bonds * BYTES_PER_BOND


def refuse_too_large(dimension: int, particles: int, bonds: int = 0, *, place: str = "particles") -> None:
    """Raise `InputError` where a scene needs more memory than the machine has left."""
    free = available_bytes()
    need = needed_bytes(dimension, particles, bonds)
    if free is None or need <= free:
        return
    most = max(0, free - bonds * BYTES_PER_BOND) // BYTES_PER_PARTICLE[dimension]
    kind = "discs" if dimension == 2 else "spheres"
    joined = f" with {bonds} bonds" if bonds else ""
    raise InputError(
        place,
        f"{particles} {kind}{joined} need about {need / 1e9:.3g} GB, and {free / 1e9:.3g} GB are free",
        f"Stay below {most} {kind}, or take a machine with more memory.",
        value=particles,
    )
