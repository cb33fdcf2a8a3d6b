"""Where a wall is nearest to a particle, and which of a particle's contacts with one wall count.

A primitive is an infinite plane, a segment (2D) or a triangle (3D), given in its body's own frame and never
moved there; instead the particle is brought into that frame. Contact normals point from the particle to the wall.

A particle that slides over many facets must feel one surface. Two facts make that possible. If the nearest point P
of a facet lies on an edge or corner, and another facet contains that edge or corner, then that other facet is
at least as near, and unless its own nearest point is P too it is nearer: so the first one's contact is not
real. And where both have the same nearest point it is one contact. Nothing is compared but corner numbers and
points, so no rounding of distances decides.
"""

from __future__ import annotations

import math

# Columns of a body's row. Vectors have three components in 2D too, so that all bodies move by one function.
BODY_DISPLACEMENT = 0  # [m] of the centre
BODY_VELOCITY = 3  # [m/s] of the centre
BODY_ROTATION = 6  # matrix since the start, by rows
BODY_SPIN = 15  # [rad/s]
BODY_CENTRE = 18  # [m] at the start
BODY_FORCE = 21  # [N] of the particles on the body
BODY_TORQUE = 24  # [N m] of the particles on the body, about its centre
BODY_WORK = 27  # [J] done by the body on the particles
BODY_DIRECTION = 28  # servo: unit vector into the particles
BODY_TARGET = 31  # servo: [N]
BODY_LIMIT = 32  # servo: [m/s]
BODY_GAIN = 33  # servo: [m/(N s)]; 0: not driven
BODY_EXTENT = 34  # [m] from the centre to the farthest point that a particle may touch
BODY_WIDTH = 35

# What a scene may lack; set by the module that the kernel is compiled in.
SPACE = True  # spheres in 3D, not discs in 2D
WALLS_TURN = True  # a wall has spin or has turned
FACETS = True  # a wall has segments or triangles, not planes alone

# Features of a primitive: 0 its interior; 1, 2, 3 its edges (corners 0-1, 1-2, 2-0); 4, 5, 6 its corners.
SAME_POINT = 1e-10  # points nearer to each other than this share of the particle's radius are one

RIGID = 1e15  # radius and mass of a wall over those of the particle


def closest_on_segment(px, py, ax, ay, bx, by, near):
    """Normal from a point to a segment in the plane, distance [m], feature.

    The point p, the ends a and b [m]; near [m]: an end is the nearest point where it is within this of it.
    """
    ex = bx - ax
    ey = by - ay
    length = math.sqrt(ex * ex + ey * ey)
    ex /= length
    ey /= length
    along = (px - ax) * ex + (py - ay) * ey
    if along > near and along < length - near:
        side = (py - ay) * ex - (px - ax) * ey
        sign = -1.0 if side > 0.0 else 1.0
        return -sign * ey, sign * ex, abs(side), 0
    feature = 4 if along <= near else 5
    ox = (ax if feature == 4 else bx) - px
    oy = (ay if feature == 4 else by) - py
    distance = math.sqrt(ox * ox + oy * oy)
    if distance > 0.0:
        return ox / distance, oy / distance, distance, feature
    return -ey, ex, 0.0, feature


def closest_on_edge(px, py, pz, ax, ay, az, bx, by, bz, near):
    """Vector from a point to the nearest point of an edge in space, 0 inside, 1 or 2 at its ends a and b."""
    ex = bx - ax
    ey = by - ay
    ez = bz - az
    length = math.sqrt(ex * ex + ey * ey + ez * ez)
    along = ((px - ax) * ex + (py - ay) * ey + (pz - az) * ez) / length
    if along <= near:
        return ax - px, ay - py, az - pz, 1
    if along >= length - near:
        return bx - px, by - py, bz - pz, 2
    share = along / length
    return ax + share * ex - px, ay + share * ey - py, az + share * ez - pz, 0


def beside_edge(px, py, pz, ax, ay, az, bx, by, bz, gx, gy, gz):
    """Distance of a point from an edge within the triangle's plane [m], positive inside; g its unit normal."""
    ex = bx - ax
    ey = by - ay
    ez = bz - az
    ix = gy * ez - gz * ey
    iy = gz * ex - gx * ez
    iz = gx * ey - gy * ex
    return ((px - ax) * ix + (py - ay) * iy + (pz - az) * iz) / math.sqrt(ex * ex + ey * ey + ez * ez)


def closest_on_triangle(px, py, pz, ax, ay, az, bx, by, bz, cx, cy, cz, near):
    """Normal from a point to a triangle, distance [m], feature.

    Inside the prism over the triangle its plane is nearest, elsewhere one of its edges or corners. Within `near` [m]
    of an edge or corner that one is taken, so that neighbours agree. Compare the Voronoi regions of a triangle in
    C. Ericson, Real-Time Collision Detection (2005), section 5.1.5.
    """
    ux = bx - ax
    uy = by - ay
    uz = bz - az
    vx = cx - ax
    vy = cy - ay
    vz = cz - az
    gx = uy * vz - uz * vy
    gy = uz * vx - ux * vz
    gz = ux * vy - uy * vx
    size = math.sqrt(gx * gx + gy * gy + gz * gz)
    gx /= size
    gy /= size
    gz /= size
    height = (px - ax) * gx + (py - ay) * gy + (pz - az) * gz
    if (
        beside_edge(px, py, pz, ax, ay, az, bx, by, bz, gx, gy, gz) > near
        and beside_edge(px, py, pz, bx, by, bz, cx, cy, cz, gx, gy, gz) > near
        and beside_edge(px, py, pz, cx, cy, cz, ax, ay, az, gx, gy, gz) > near
    ):
        sign = -1.0 if height > 0.0 else 1.0
        return sign * gx, sign * gy, sign * gz, abs(height), 0
    ox, oy, oz, end = closest_on_edge(px, py, pz, ax, ay, az, bx, by, bz, near)
    square = ox * ox + oy * oy + oz * oz
    feature = 1 if end == 0 else 3 + end
    x, y, z, end = closest_on_edge(px, py, pz, bx, by, bz, cx, cy, cz, near)
    if x * x + y * y + z * z < square:
        ox, oy, oz = x, y, z
        square = x * x + y * y + z * z
        feature = 2 if end == 0 else 4 + end
    x, y, z, end = closest_on_edge(px, py, pz, cx, cy, cz, ax, ay, az, near)
    if x * x + y * y + z * z < square:
        ox, oy, oz = x, y, z
        square = x * x + y * y + z * z
        feature = 3 if end == 0 else (6 if end == 1 else 4)
    distance = math.sqrt(square)
    if distance > 0.0:
        return ox / distance, oy / distance, oz / distance, distance, feature
    return gx, gy, gz, 0.0, feature


def closest_on_wall(x, y, z, near, shape, kind, bodies, primitive, owner):
    """Normal from a point in space to a primitive of a body, distance [m], feature.

    shape (q, 9), kind (q,): the primitives in their bodies' frames; bodies (b, BODY_WIDTH). The distance to a plane is
    negative behind it.
    """
    px = x - bodies[owner, BODY_CENTRE] - bodies[owner, BODY_DISPLACEMENT]
    py = y - bodies[owner, BODY_CENTRE + 1] - bodies[owner, BODY_DISPLACEMENT + 1]
    pz = z - bodies[owner, BODY_CENTRE + 2] - bodies[owner, BODY_DISPLACEMENT + 2]
    if WALLS_TURN:
        r = bodies[owner, BODY_ROTATION : BODY_ROTATION + 9]
        tx = r[0] * px + r[3] * py + r[6] * pz
        ty = r[1] * px + r[4] * py + r[7] * pz
        pz = r[2] * px + r[5] * py + r[8] * pz
        px = tx
        py = ty
    px += bodies[owner, BODY_CENTRE]
    py += bodies[owner, BODY_CENTRE + 1]
    pz += bodies[owner, BODY_CENTRE + 2]
    nz = 0.0
    if not FACETS or kind[primitive] == 0:
        # no part of the row by itself: that would count references
        nx = -shape[primitive, 3]
        ny = -shape[primitive, 4]
        nz = -shape[primitive, 5]
        distance = (
            (shape[primitive, 0] - px) * nx
            + (shape[primitive, 1] - py) * ny
            + (shape[primitive, 2] - pz) * nz
        )
        feature = 0
    elif SPACE:
        s = shape[primitive]
        nx, ny, nz, distance, feature = closest_on_triangle(
            px, py, pz, s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7], s[8], near
        )
    else:
        s = shape[primitive]
        nx, ny, distance, feature = closest_on_segment(px, py, s[0], s[1], s[3], s[4], near)
    if WALLS_TURN:
        tx = r[0] * nx + r[1] * ny + r[2] * nz
        ty = r[3] * nx + r[4] * ny + r[5] * nz
        nz = r[6] * nx + r[7] * ny + r[8] * nz
        nx = tx
        ny = ty
    return nx, ny, nz, distance, feature


def has_corner(vertex, primitive, corner):
    """Whether a primitive has a corner of this number."""
    return corner >= 0 and (
        vertex[primitive, 0] == corner or vertex[primitive, 1] == corner or vertex[primitive, 2] == corner
    )


def contains(vertex, primitive, other, feature):
    """Whether a primitive contains the edge or corner `feature` of another one."""
    if feature >= 4:
        return has_corner(vertex, primitive, vertex[other, feature - 4])
    if feature >= 1:
        return has_corner(vertex, primitive, vertex[other, feature - 1]) and has_corner(
            vertex, primitive, vertex[other, feature % 3]
        )
    return False


def drop_shared(first, last, primitive, body, vertex, geometry, feature, near):
    """Mark (by 8 added to the feature) the contacts of one particle that its other contacts make unreal.

    first, last: the particle's pairs; geometry (w, 4): normal, distance [m]; feature (w,) int8: -1 where the pair is
    not within reach.
    """
    for p in range(first, last):
        mine = feature[p]
        if mine < 0:
            continue
        for q in range(first, last):
            if q == p or feature[q] < 0 or body[primitive[q]] != body[primitive[p]]:
                continue
            other = feature[q] % 8
            square = 0.0
            for k in range(3):
                apart = geometry[p, k] * geometry[p, 3] - geometry[q, k] * geometry[q, 3]
                square += apart * apart
            if square <= near * near:
                # one point, one contact: interior before edge before corner, then the lower number
                rank = (mine + 2) // 3
                rank_of_other = (other + 2) // 3
                unreal = rank_of_other < rank or (rank_of_other == rank and primitive[q] < primitive[p])
            else:
                unreal = contains(vertex, primitive[q], primitive[p], mine)
            if unreal:
                feature[p] = mine + 8
                break


def move_history(first, last, primitive, body, vertex, touching, history, normal, geometry, feature):
    """Hand what a contact has stored to the neighbour that the particle has slid onto.

    Of the new contacts on the same body the nearest one takes it; from a contact that has opened, only one that shares
    a corner with it.
    """
    for p in range(first, last):
        if touching[p] == 0 or (feature[p] >= 0 and feature[p] < 8):
            continue
        heir = -1
        nearest = 1e300
        for q in range(first, last):
            if touching[q] != 0 or feature[q] < 0 or feature[q] >= 8:
                continue
            if body[primitive[q]] != body[primitive[p]]:
                continue
            if feature[p] < 0 and not (
                has_corner(vertex, primitive[q], vertex[primitive[p], 0])
                or has_corner(vertex, primitive[q], vertex[primitive[p], 1])
                or has_corner(vertex, primitive[q], vertex[primitive[p], 2])
            ):
                continue
            square = 0.0
            for k in range(3):
                apart = geometry[p, k] * geometry[p, 3] - geometry[q, k] * geometry[q, 3]
                square += apart * apart
            if square < nearest:
                nearest = square
                heir = q
        if heir >= 0:
            touching[p] = 0
            touching[heir] = 1
            for k in range(3):
                normal[heir, k] = normal[p, k]
            for k in range(history.shape[1]):
                history[heir, k] = history[p, k]
                history[p, k] = 0.0


WALL_CONSTANTS = {
    name: value
    for name, value in list(globals().items())
    if name.startswith("BODY_") or name in ("SAME_POINT", "RIGID")
}
"""Constants that every module compiled from these functions needs, besides SPACE and WALLS_TURN."""

GEOMETRY_FUNCTIONS = (
    closest_on_segment,
    closest_on_edge,
    beside_edge,
    closest_on_triangle,
    closest_on_wall,
)
"""Functions to compile, callees first."""
RESOLUTION_FUNCTIONS = (has_corner, contains, drop_shared, move_history)
