"""Walls as the loops read them: primitives in their bodies' frames, and a row of state for every body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import _jit
from ..assembly import Wall
from ..errors import InputError
from ..kernels import wall_geometry as columns
from ..kernels.wall_motion import MOTION_FUNCTIONS
from .checks import merge_corners

Floats = NDArray[np.float64]

SERVO_SHARE = 0.5
"""Share of its error that a servo makes good in one step, all touching contacts being linear."""


@dataclass
class WallTable:
    """Primitives of all walls; a body is a wall, in the order given.

    Attributes
    ----------
    dimension : int
    names : tuple of str
    shape : (q, 9) [m]
        In the body's frame, components x, y, z (z = 0 in 2D). Plane: point, normal. Segment: ends. Triangle: corners.
    kind : (q,) int8
        0 plane, 1 segment, 2 triangle.
    body : (q,) int32
    vertex : (q, 3) int32
        Numbers of the corners; equal corners of one body have one number; -1: none.
    bodies : (b, BODY_WIDTH)
        State of the bodies; columns in `geodem.kernels.wall_geometry`. Changes while they move.
    """

    dimension: int
    names: tuple[str, ...]
    shape: Floats
    kind: NDArray[np.int8]
    body: NDArray[np.int32]
    vertex: NDArray[np.int32]
    bodies: Floats

    @property
    def walls_turn(self) -> bool:
        """Whether any body has spin or has turned: the constant WALLS_TURN of the kernels."""
        r = columns.BODY_ROTATION
        turned = self.bodies[:, r : r + 9] != np.eye(3).reshape(-1)
        return bool(turned.any() or self.bodies[:, columns.BODY_SPIN : columns.BODY_SPIN + 3].any())

    def forces(self) -> Floats:
        """Force of the particles on every body in the last step, (b, d) [N]."""
        return self.bodies[:, columns.BODY_FORCE : columns.BODY_FORCE + self.dimension]

    def torques(self) -> Floats:
        """Torque of the particles on every body about its centre in the last step, (b, 1 or 3) [N m]."""
        last = columns.BODY_TORQUE + 3
        return self.bodies[:, last - 1 if self.dimension == 2 else columns.BODY_TORQUE : last]

    def displacements(self) -> Floats:
        """Displacement of every body's centre since the start, (b, d) [m]."""
        return self.bodies[:, columns.BODY_DISPLACEMENT : columns.BODY_DISPLACEMENT + self.dimension]

    def work(self) -> Floats:
        """Work that every body has done on the particles since the start, (b,) [J]."""
        return self.bodies[:, columns.BODY_WORK]

    def corners_now(self) -> Floats:
        """The primitives' points where they are now, (q, 3, 3) [m]; a plane's second row is its normal."""
        rotation = self._rotations()[self.body]
        start = self.bodies[self.body, columns.BODY_CENTRE : columns.BODY_CENTRE + 3]
        moved = self.bodies[self.body, columns.BODY_DISPLACEMENT : columns.BODY_DISPLACEMENT + 3]
        points = self.shape.reshape(-1, 3, 3)
        now = (
            np.einsum("qij,qcj->qci", rotation, points - start[:, np.newaxis])
            + (start + moved)[:, np.newaxis]
        )
        flat = self.kind == 0
        now[flat, 1] = np.einsum("qij,qj->qi", rotation[flat], points[flat, 1])
        return now

    def _rotations(self) -> Floats:
        r = columns.BODY_ROTATION
        return self.bodies[:, r : r + 9].reshape(-1, 3, 3)

    def set_velocity(self, name: str, velocity: Floats, spin: Floats | None = None) -> None:
        """Change a wall's velocity (d,) [m/s] and, where given, its spin (1 or 3,) [rad/s]."""
        b = self.bodies[self.index(name)]
        b[columns.BODY_VELOCITY : columns.BODY_VELOCITY + self.dimension] = velocity
        if spin is not None:
            last = columns.BODY_SPIN + 3
            b[last - 1 if self.dimension == 2 else columns.BODY_SPIN : last] = spin

    def stop(self) -> Floats:
        """Take every body's velocity and spin away but a servo's; returns what `go_on` gives back."""
        b = self.bodies
        before = b.copy()
        driven = b[:, columns.BODY_GAIN] > 0.0
        for first in (columns.BODY_VELOCITY, columns.BODY_SPIN):
            b[~driven, first : first + 3] = 0.0
        return before

    def go_on(self, before: Floats) -> None:
        """Give the velocities and spins back that `stop` took away."""
        for first in (columns.BODY_VELOCITY, columns.BODY_SPIN):
            self.bodies[:, first : first + 3] = before[:, first : first + 3]

    def index(self, name: str) -> int:
        """Number of the body of that name; raises InputError for an unknown one."""
        if name not in self.names:
            known = ", ".join(self.names) or "none"
            raise InputError("wall", "there is no wall of that name", f"Known walls: {known}.", value=name)
        return self.names.index(name)

    def advance(self, time_step: float) -> float:
        """One step of every body, after its forces; as the kernels do it. Returns the largest speed [m/s]."""
        module = _jit.compile_kernel(MOTION_FUNCTIONS, columns.WALL_CONSTANTS, parallel=False)
        return float(module.move_walls(self.bodies, time_step))


def wall_table(walls: Sequence[Wall], dimension: int) -> WallTable:
    """Primitives and state of the walls of a scene; they are to be checked before (`checks.wall_errors`)."""
    shape, kind, body, vertex = [], [], [], []
    corners = 0
    for number, wall in enumerate(walls):
        merged = []
        for which, facets in ((0, wall.planes), (1, wall.segments), (2, wall.triangles)):
            if not len(facets):
                continue
            points = np.zeros((len(facets), 3, 3))
            points[:, : facets.shape[1], : facets.shape[2]] = facets
            numbers = np.full((len(facets), 3), -1, dtype=np.int32)
            if which > 0:
                numbers[:, : facets.shape[1]] = merge_corners(facets) + corners
                corners = int(numbers.max()) + 1
            shape.append(points.reshape(-1, 9))
            kind.append(np.full(len(facets), which, dtype=np.int8))
            merged.append(numbers)
            body.append(np.full(len(facets), number, dtype=np.int32))
        vertex += merged
    return WallTable(
        dimension=dimension,
        names=tuple(wall.name for wall in walls),
        shape=np.concatenate([np.empty((0, 9)), *shape]),
        kind=np.concatenate([np.empty(0, dtype=np.int8), *kind]),
        body=np.concatenate([np.empty(0, dtype=np.int32), *body]),
        vertex=np.concatenate([np.empty((0, 3), dtype=np.int32), *vertex]),
        bodies=np.stack([_body(wall, dimension) for wall in walls])
        if walls
        else np.empty((0, columns.BODY_WIDTH)),
    )


def _body(wall: Wall, dimension: int) -> Floats:
    b = np.zeros(columns.BODY_WIDTH)
    b[columns.BODY_VELOCITY : columns.BODY_VELOCITY + dimension] = wall.velocity
    b[columns.BODY_ROTATION : columns.BODY_ROTATION + 9] = np.eye(3).reshape(-1)
    first = columns.BODY_SPIN + (2 if dimension == 2 else 0)
    b[first : columns.BODY_SPIN + 3] = wall.spin
    b[columns.BODY_CENTRE : columns.BODY_CENTRE + dimension] = wall.centre
    facets = wall.segments if dimension == 2 else wall.triangles
    if len(facets):
        b[columns.BODY_EXTENT] = np.linalg.norm(facets - wall.centre, axis=2).max()
    if wall.servo is not None:
        b[columns.BODY_DIRECTION : columns.BODY_DIRECTION + dimension] = wall.servo.direction
        b[columns.BODY_TARGET] = wall.servo.force
        b[columns.BODY_LIMIT] = wall.servo.limit
        b[columns.BODY_GAIN] = wall.servo.gain or 0.0
    return b


def servo_gain(stiffness: float, time_step: float) -> float:
    """Gain of a servo [m/(N s)] against contacts of this total normal stiffness [N/m].

    A step moves the wall by gain * error * time_step and changes the force by stiffness times that: by SERVO_SHARE
    of the error. It is the relaxation factor of the servo mechanism in Itasca, PFC2D Manual, Theory and Background.
    """
    return SERVO_SHARE / (stiffness * time_step)


def set_servo_gains(table: WallTable, walls: Sequence[Wall], stiffness: Floats, time_step: float) -> None:
    """Give every servo without a gain of its own the one for `stiffness` (b,), its contacts' sum of kn [N/m].

    Where a wall has no contacts, give what one contact would have. To be called whenever wall pairs are searched.
    """
    for number, wall in enumerate(walls):
        if wall.servo is not None and wall.servo.gain is None:
            table.bodies[number, columns.BODY_GAIN] = servo_gain(float(stiffness[number]), time_step)
