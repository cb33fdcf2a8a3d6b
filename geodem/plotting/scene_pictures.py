"""Pictures of a scene: particles with joints, bolts, linings and what holds the sides."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.breaking.scene import BondedScene
from geodem.breaking.supports import side
from geodem.plotting.bodies import draw_filling, particle_colours
from geodem.plotting.spheres import PIXELS, render_balls, render_facets
from geodem.plotting.theme import FAILED, INK, SOFT, material_colour, new_figure, png, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

JOINT = "#0072b2"
BOLT = FAILED
LINING = "#1f2933"
VIEW = (-60.0, 25.0)
MARKS = 22
"""Marks of a support along the longest side."""
GAP = 0.022
"""Room for them over the longest side."""
DISC_CORNERS = 48


def scene_picture(scene: BondedScene, *, title: str) -> bytes:
    """A PNG; raises InputError in 3D without pyvista."""
    with style():
        return png(scene_figure(scene, title=title) if scene.dimension == 2 else _space(scene, title))


def scene_figure(scene: BondedScene, *, title: str) -> Figure:
    """The discs with joints, bolts, linings and sides, true to scale."""
    width, height = np.ptp(scene.box, axis=0)
    figure = new_figure(7.6, float(np.clip(7.6 * height / width + 1.1, 2.6, 8.4)))
    axes: Any = figure.subplots()
    draw_scene(axes, scene)
    axes.set_title(title)
    figure.legend(handles=_handles(scene), loc="outside lower center", ncols=4, labelcolor=INK)
    return figure


def draw_scene(axes: Axes, scene: BondedScene) -> None:
    """What `scene_figure` shows, into given axes."""
    from matplotlib.collections import LineCollection

    draw_filling(axes, scene.filling)
    a = scene.assembly
    for facts in scene.structures.joints.values():
        axes.add_collection(
            LineCollection(list(facts.traces), colors=JOINT, linewidths=1.8, capstyle="round")
        )
    for bolt in scene.structures.bolts.values():
        ends = a.positions[bolt.particles]
        axes.plot(*ends.T, color=BOLT, linewidth=2.0, solid_capstyle="round")
        if len(bolt.plate):
            axes.plot(*ends[0], marker="s", color=BOLT, markersize=5.0)
    for ids in scene.structures.linings.values():
        axes.plot(*a.positions[ids].T, color=LINING, linewidth=3.0, solid_capstyle="round")
    low, high = scene.box
    room = 1.9 * GAP * float((high - low).max()) + float(scene.filling.radii.max())
    for name, kind in scene.supports.items():
        _draw_side(axes, scene.box, name, kind, room)
    axes.set(
        xlim=(low[0] - 1.6 * room, high[0] + 1.6 * room), ylim=(low[1] - 1.6 * room, high[1] + 1.6 * room)
    )


def _draw_side(axes: Axes, box: Floats, name: str, kind: str, room: float) -> None:
    """The usual signs of supports beside a side: circles, triangles, a line, a hatched line."""
    if kind == "free":
        return
    axis, upper = side(name, 2)
    other = 1 - axis
    longest = float(np.ptp(box, axis=0).max())
    count = max(3, round(MARKS * float(box[1, other] - box[0, other]) / longest))
    along = np.linspace(box[0, other], box[1, other], 2 * count + 1)[1::2]
    away = float(box[1, axis] + 0.75 * room if upper else box[0, axis] - 0.75 * room)
    points = np.empty((len(along), 2))
    points[:, axis], points[:, other] = away, along
    if kind in ("roller", "fixed"):
        marker = "o" if kind == "roller" else {0: "<" if upper else ">", 1: "v" if upper else "^"}[axis]
        face = "white" if kind == "roller" else INK
        axes.plot(*points.T, marker, color=INK, markerfacecolor=face, markersize=4.6, linestyle="none")
        return
    line = np.empty((2, 2))
    line[:, axis] = float(box[1, axis] if upper else box[0, axis])
    line[:, axis] += (0.45 if upper else -0.45) * room
    line[:, other] = box[:, other]
    axes.plot(*line.T, color=INK, linewidth=2.4, solid_capstyle="butt")
    if kind == "rough":
        axes.plot(*points.T, marker="x", color=INK, markersize=4.0, linestyle="none")


def _handles(scene: BondedScene, *, sides: bool = True) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Patch(
            facecolor=material_colour(k),
            edgecolor=SOFT,
            linewidth=0.6,
            label=f"{share.name} ({share.particles:,})",
        )
        for k, share in enumerate(scene.filling.shares)
    ]
    s = scene.structures
    for found, colour, words in (
        (sum(facts.joints for facts in s.joints.values()), JOINT, "joint"),
        (len(s.bolts), BOLT, "bolt"),
        (len(s.linings), LINING, "lining"),
    ):
        if found:
            label = words if found == 1 else f"{found:,} {words}s"
            handles.append(Line2D([], [], color=colour, linewidth=2.4, label=label))
    signs: dict[str, dict[str, Any]] = {
        "roller": {"marker": "o", "markerfacecolor": "white", "linestyle": "none"},
        "fixed": {"marker": "^", "linestyle": "none"},
        "wall": {"linewidth": 2.4},
        "rough": {"linewidth": 2.4, "marker": "x"},
    }
    names = {"roller": "rollers", "fixed": "fixed", "wall": "smooth wall", "rough": "rough wall"}
    for kind, sign in signs.items():
        if sides and kind in scene.supports.values():
            given: dict[str, Any] = {"color": INK, "markersize": 5.0, **sign}
            handles.append(Line2D([], [], label=names[kind], **given))
    return handles


def _space(scene: BondedScene, title: str) -> Figure:
    """Spheres from outside, and joints and bolts alone beside them."""
    faces = particle_colours(scene.filling)
    images = [render_balls(scene.filling.positions, scene.filling.radii, faces, view=VIEW, pixels=PIXELS)]
    facets, colours, opacities = _facets(scene)
    images.append(render_facets(facets, colours, opacities, view=VIEW))
    figure = new_figure(11.0, 5.0)
    for axes, image, words in zip(figure.subplots(1, 2), images, (title, "Joints and bolts"), strict=True):
        axes.imshow(image)
        axes.set_axis_off()
        axes.set_title(words)
    figure.legend(handles=_handles(scene, sides=False), loc="outside lower center", ncols=6, labelcolor=INK)
    return figure


def _facets(scene: BondedScene) -> tuple[list[Floats], list[str], list[float]]:
    """Triangles (f, 3, 3) of the box, of joints and of bolts, with colours and opacities."""
    facets, colours, opacities = [_box(scene.box)], [SOFT], [0.15]
    discs = [
        np.concatenate([_disc(*face) for face in facts.faces]) for facts in scene.structures.joints.values()
    ]
    if discs:
        facets.append(np.concatenate(discs))
        colours.append(JOINT)
        opacities.append(0.55)
    thick = 0.006 * float(np.ptp(scene.box, axis=0).max())
    ends = [scene.assembly.positions[bolt.particles[[0, -1]]] for bolt in scene.structures.bolts.values()]
    if ends:
        facets.append(np.concatenate([_rod(pair[0], pair[1], thick) for pair in ends]))
        colours.append(BOLT)
        opacities.append(1.0)
    return facets, colours, opacities


def _box(box: Floats) -> Floats:
    """Twelve triangles of a block."""
    corners = np.array([[x, y, z] for x in box[:, 0] for y in box[:, 1] for z in box[:, 2]])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.array([corners[[q[0], *q[k : k + 2]]] for q in faces for k in (1, 2)])


def _across(axis: Floats) -> tuple[Floats, Floats]:
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first = first / np.linalg.norm(first)
    return first, np.cross(axis, first)


def _ring(centre: Floats, axis: Floats, radius: float, corners: int) -> Floats:
    first, second = _across(axis)
    turn = 2.0 * math.pi * np.arange(corners) / corners
    return np.asarray(centre + radius * (np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second))


def _disc(centre: Floats, normal: Floats, radius: float) -> Floats:
    ring = _ring(centre, normal, radius, DISC_CORNERS)
    return np.stack([np.broadcast_to(centre, ring.shape), ring, np.roll(ring, -1, axis=0)], axis=1)


def _rod(start: Floats, end: Floats, radius: float) -> Floats:
    axis = (end - start) / np.linalg.norm(end - start)
    low, high = _ring(start, axis, radius, 8), _ring(end, axis, radius, 8)
    after, above = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    return np.concatenate([np.stack([low, after, high], axis=1), np.stack([after, above, high], axis=1)])
