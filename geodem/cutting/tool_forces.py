"""Forces on the parts of a tool: what its face feels apart from its tip and its wear flat, and where it is slid on."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kernels.wall_geometry import BODY_VELOCITY
from ..measure.contact_forces import law_forces
from ..particle_simulation import ParticleSimulation
from .tool import BODY, FACE, FLAT, NAME, PARTS, TIP, Tool

Floats = NDArray[np.float64]

INTERIOR = 0
"""Feature of a contact inside a side; others are at a corner."""

SLIDES = 0.05
"""Speed up the face over that of the tool from which a contact counts as sliding; what creeps winds its spring up."""


class Felt(NamedTuple):
    """What the tool feels in one step.

    Attributes
    ----------
    parts : (parts, 2)
        Forces of the particles on every part [N] (2D: N per m).
    pressed : float
        Sum of the normal forces on the face [N].
    slid : float
        Those of contacts that slide up it [N].
    sliding : (2,)
        Force of those contacts on the face [N].
    """

    parts: Floats
    pressed: float
    slid: float
    sliding: Floats


class ToolForces:
    """Reads the forces on the parts of the tool of a simulation.

    A contact at a corner between two parts belongs to the tip at the lower end of the face, to the flat at that of a
    flat, and to the body elsewhere.

    Parameters
    ----------
    simulation : ParticleSimulation
        With a wall named `geodem.cutting.tool.NAME`.
    tool : Tool
    """

    def __init__(self, simulation: ParticleSimulation, tool: Tool) -> None:
        self.simulation = s = simulation
        self.body = s.walls.index(NAME)
        self.up = np.array([-math.sin(tool.rake), math.cos(tool.rake)])
        _, parts = tool.outline()
        own = np.flatnonzero(s.walls.body == self.body)
        self.part = np.full(len(s.walls.body), BODY, dtype=np.int64)
        self.part[own] = parts
        # of the corner at the beginning of every side
        before = np.roll(parts, 1)
        corner = np.where(parts == before, parts, BODY)
        corner[(parts == TIP) | (before == TIP)] = TIP
        front = (before == 0) & (parts != BODY)
        corner[front] = TIP
        corner[(before == FLAT) & (parts != TIP)] = FLAT
        self.begins = np.full(len(self.part), BODY, dtype=np.int64)
        self.ends = self.begins.copy()
        self.begins[own] = corner
        self.ends[own] = np.roll(corner, -1)

    def now(self) -> Felt:
        """What the tool felt in the last step."""
        s = self.simulation
        w = s.wall_pairs
        found = np.zeros((len(PARTS), 2))
        at = np.flatnonzero((s.walls.body[w.primitive] == self.body) & (w.touching > 0))
        if not len(at):
            return Felt(found, 0.0, 0.0, np.zeros(2))
        row = w.particle[at].astype(np.int64)
        radius = s.now[row, s.columns.radius]
        distance = w.geometry[at, 3]
        contact, _ = s.features.laws()
        known = {name: w.history[at, k] for k, name in enumerate(s.layout.contact)} | {
            "overlap": radius - distance, "radius_a": radius, "radius_b": 1e15 * radius, "distance": distance,
            "mass_a": s.now[row, s.columns.mass], "mass_b": 1e15 * s.now[row, s.columns.mass],
            "time_step": np.full(len(at), s.time_step),
        }  # fmt: skip
        rows = s.now[row, s.columns.material].astype(np.int64) * len(s.walls.bodies) + self.body
        force = law_forces(contact, 2, s.wall_parameters[rows], known)
        # from the particle to the wall
        normal = w.geometry[at, :2]
        across = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        # on the particle: away from the wall, and the shear force along t = (-ny, nx)
        on_wall = force[:, :1] * normal - force[:, 1:2] * across
        part = self.parts_of(w.primitive[at].astype(np.int64), w.feature[at])
        np.add.at(found, part, on_wall)
        slides = (part == FACE) & (self._up_the_face(row, distance[:, np.newaxis] * normal) > SLIDES)
        pressed, slid = (float(force[which, 0].sum()) for which in (part == FACE, slides))
        return Felt(found, pressed, slid, on_wall[slides].sum(axis=0))

    def _up_the_face(self, row: NDArray[np.int64], arm: Floats) -> Floats:
        """Speed up the face (k,) of points of particles that touch it, over the tool's; `arm` (k, 2) to them [m]."""
        s = self.simulation
        turned = s.now[row, s.columns.spin] * np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        tool = s.walls.bodies[self.body, BODY_VELOCITY : BODY_VELOCITY + 2]
        seen = s.now[row, s.columns.velocity] + turned - tool
        return np.asarray(seen @ self.up / max(float(np.linalg.norm(tool)), 1e-300))

    def parts_of(self, primitive: NDArray[np.int64], feature: NDArray[np.int8]) -> NDArray[np.int64]:
        """Part (k,) that contacts belong to, by side and where on it."""
        part = self.part[primitive]
        at_start, at_end = feature == 4, feature == 5
        part = np.where(at_start, self.begins[primitive], part)
        return np.where(at_end, self.ends[primitive], part)
