"""Spheres and their walls in parallel projection, drawn off-screen by VTK."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geodem.errors import InputError

if TYPE_CHECKING:
    from geodem.particle_reading import ParticleReading

Floats = NDArray[np.float64]

PIXELS = (1600, 1120)
UPRIGHT = (1000, 1400)
LIGHTS = (((-0.5, 0.9, 0.8), 0.7), ((0.9, 0.2, 0.6), 0.3), ((0.0, 0.0, 1.0), 0.2))
"""Where light comes from, to the right, up and towards the viewer, and how strong it is."""
DETAIL = {2_000: 24, 20_000: 14}
"""Up to how many spheres each is drawn with so many meridians; beyond, as shaded points."""


def render_spheres(
    simulation: ParticleReading, faces: Floats, *, view: tuple[float, float] = (-60.0, 22.0)
) -> NDArray[np.uint8]:
    """A picture (height, width, 3) of the spheres in the colours `faces` (n, 4), walls behind them.

    `view`: azimuth and elevation that they are looked at from [deg]. Raises InputError where pyvista is missing.
    """
    s = simulation
    centres, radii = s.seen_positions(), s.assembly.radii
    low, high = (centres - radii[:, None]).min(axis=0), (centres + radii[:, None]).max(axis=0)

    def draw(plotter: Any, towards: Floats) -> list[Floats]:
        import pyvista

        _add_spheres(plotter, centres, radii, faces)
        corners = [_corners(low, high)]
        if s.cell is not None:
            for first, last in s.cell.outline():
                plotter.add_mesh(pyvista.Line(first, last), color="black", line_width=2.5)
            corners.append(s.cell.corners())
        return corners + _add_walls(plotter, s, 0.5 * (low + high), high - low, towards)

    return _picture(draw, view, PIXELS)


def render_balls(
    centres: Floats,
    radii: Floats,
    faces: Floats,
    *,
    view: tuple[float, float] = (-60.0, 22.0),
    pixels: tuple[int, int] = UPRIGHT,
) -> NDArray[np.uint8]:
    """A picture (height, width, 3) of spheres (n, 3) [m] in the colours `faces` (n, 4); errors as `render_spheres`."""

    def draw(plotter: Any, towards: Floats) -> list[Floats]:
        _add_spheres(plotter, centres, radii, faces)
        return [_corners((centres - radii[:, None]).min(axis=0), (centres + radii[:, None]).max(axis=0))]

    return _picture(draw, view, pixels)


def render_flakes(
    centres: Floats,
    normals: Floats,
    radii: Floats,
    colours: Floats,
    box: Floats,
    *,
    view: tuple[float, float] = (-60.0, 22.0),
) -> NDArray[np.uint8]:
    """A picture of thin discs, such as cracks, in a box (3,) [m] drawn by its edges; errors as `render_spheres`.

    Parameters
    ----------
    centres, normals : (k, 3) [m], [-]
    radii : (k,) [m]
    colours : (k, 3)
    """

    def draw(plotter: Any, towards: Floats) -> list[Floats]:
        import pyvista

        frame = pyvista.Box(bounds=[value for side in box for value in (0.0, float(side))])
        plotter.add_mesh(frame, style="wireframe", color="#8794a1", line_width=2.0, lighting=False)
        inside = ((centres > -0.1 * box) & (centres < 1.1 * box)).all(axis=1)
        if inside.any():
            cloud = pyvista.PolyData(centres[inside])
            cloud["radius"] = radii[inside]
            cloud["normal"] = normals[inside]
            cloud["colour"] = (255.0 * colours[inside]).round().astype(np.uint8)
            flake = pyvista.Disc(inner=0.0, outer=1.0, normal=(1.0, 0.0, 0.0), c_res=12)
            flakes = cloud.glyph(scale="radius", orient="normal", geom=flake, factor=1.0)
            plotter.add_mesh(flakes, scalars="colour", rgb=True, ambient=0.5, diffuse=0.5)
        return [_corners(np.zeros(3), box)]

    return _picture(draw, view, UPRIGHT)


def _picture(
    draw: Callable[[Any, Floats], list[Floats]], view: tuple[float, float], pixels: tuple[int, int]
) -> NDArray[np.uint8]:
    """What `draw` adds to a plotter that is looked at from `view`; it returns the points that must be seen."""
    try:
        import pyvista
    except ImportError:
        raise InputError(
            "picture",
            "spheres are drawn by pyvista, which is not here",
            "Run: pip install 'geodem[pictures]'",
        ) from None
    towards, right, up = _camera(*np.radians(view))
    with _quiet():
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=list(pixels), lighting="none")
        try:
            plotter.set_background("white")
            for place, strength in LIGHTS:
                position = np.array(place) @ np.stack([right, up, towards])
                light = pyvista.Light(
                    position=tuple(position), focal_point=(0.0, 0.0, 0.0), intensity=strength
                )
                light.positional = False
                plotter.add_light(light)
            _look_at(plotter, np.concatenate(draw(plotter, towards)), towards, right, up, pixels)
            plotter.enable_anti_aliasing("ssaa")
            image = np.asarray(plotter.screenshot(return_img=True))
        finally:
            plotter.close()
    return _cropped(image[:, :, :3])


def _corners(low: Floats, high: Floats) -> Floats:
    """Of a box (8, 3)."""
    return np.array(list(itertools.product(*zip(low, high, strict=True))))


def _camera(azimuth: float, elevation: float) -> tuple[Floats, Floats, Floats]:
    """Unit vectors towards the viewer, to the right and up in the picture."""
    flat = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    towards = np.cos(elevation) * flat + np.array([0.0, 0.0, np.sin(elevation)])
    right = np.array([-flat[1], flat[0], 0.0])
    return towards, right, np.cross(towards, right)


def _look_at(
    plotter: Any, points: Floats, towards: Floats, right: Floats, up: Floats, pixels: tuple[int, int]
) -> None:
    """Parallel projection in which all points fit the picture."""
    spans = [(points @ axis).min() + (points @ axis).max() for axis in (right, up, towards)]
    middle = 0.5 * (spans[0] * right + spans[1] * up + spans[2] * towards)
    halves = [0.5 * float(np.ptp(points @ axis)) for axis in (right, up, towards)]
    camera = plotter.camera
    camera.parallel_projection = True
    camera.focal_point = tuple(middle)
    camera.position = tuple(middle + 4.0 * max(halves) * towards)
    camera.up = tuple(up)
    camera.parallel_scale = 1.03 * max(halves[1], halves[0] * pixels[1] / pixels[0])
    plotter.renderer.ResetCameraClippingRange()


@contextmanager
def _quiet() -> Iterator[None]:
    """VTK complains of a missing display, which it then does without."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(before)


def _add_spheres(plotter: Any, centres: Floats, radii: Floats, faces: Floats) -> None:
    import pyvista

    cloud = pyvista.PolyData(centres)
    cloud["radius"] = radii
    cloud["colour"] = (255.0 * faces[:, :3]).round().astype(np.uint8)
    meridians = next((detail for most, detail in DETAIL.items() if len(radii) <= most), None)
    shading = {"ambient": 0.28, "diffuse": 0.75, "specular": 0.12, "specular_power": 18.0}
    if meridians is None:
        actor = plotter.add_mesh(
            cloud,
            scalars="colour",
            rgb=True,
            style="points_gaussian",
            emissive=False,
            render_points_as_spheres=True,
        )
        actor.mapper.SetScaleArray("radius")
        actor.mapper.SetScaleFactor(1.0)
        return
    ball = pyvista.Sphere(radius=1.0, theta_resolution=meridians, phi_resolution=meridians)
    balls = cloud.glyph(scale="radius", orient=False, geom=ball, factor=1.0)
    plotter.add_mesh(balls, scalars="colour", rgb=True, smooth_shading=True, **shading)


def _add_walls(
    plotter: Any, s: ParticleReading, middle: Floats, extent: Floats, towards: Floats
) -> list[Floats]:
    """Triangles as they are; of planes the part behind or below the spheres. Returns the corners of what is drawn."""
    import pyvista

    corners = s.walls.corners_now()
    drawn = []
    shown = corners[s.walls.kind == 2]
    if len(shown):
        drawn.append(shown.reshape(-1, 3))
        numbers: Any = np.arange(3 * len(shown)).reshape(-1, 3)
        mesh = pyvista.PolyData.from_regular_faces(drawn[0], numbers)
        plotter.add_mesh(
            mesh, color="#aab4bf", opacity=0.55, show_edges=len(shown) < 500, edge_color="#5f6c7b"
        )
    for at, normal, _ in corners[s.walls.kind == 0]:
        depth = float((middle - at) @ normal)
        # one before the spheres would hide them, one far away make them small
        if normal @ towards <= 0.0 or depth > float(np.linalg.norm(extent)):
            continue
        axis = np.eye(3)[np.argmin(np.abs(normal))]
        first = np.cross(normal, axis)
        first /= np.linalg.norm(first)
        second = np.cross(normal, first)
        reaches = [0.55 * float(np.abs(extent) @ np.abs(side)) for side in (first, second)]
        ends = [
            middle - depth * normal + p * reaches[0] * first + q * reaches[1] * second
            for p, q in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        drawn.append(np.array(ends))
        side = pyvista.PolyData.from_regular_faces(drawn[-1], np.array([[0, 1, 2, 3]]))
        plotter.add_mesh(
            side, color="#e3e7ec", ambient=0.75, diffuse=0.25, show_edges=True, edge_color="#aab4bf"
        )
    return drawn


def _cropped(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Without the white around."""
    drawn = (image < 250).any(axis=2)
    rows, columns = (np.flatnonzero(drawn.sum(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return image
    pad = 12
    top, left = max(rows[0] - pad, 0), max(columns[0] - pad, 0)
    return image[top : rows[-1] + pad, left : columns[-1] + pad]
