"""The picture that `geodem check` leaves: what the section became before anything is computed."""

from __future__ import annotations

from pathlib import Path

from geodem.io.files import write_whole
from geodem.plotting.scenes import particles_scene
from geodem.plotting.theme import png, style
from geodem.plotting.views import ReportView


def write_check_picture(path: Path | str, view: ReportView) -> bytes:
    """Draw the section with its particles, supports and loads, true to scale.

    Parameters
    ----------
    path : path
        A PNG file.
    view : ReportView
        Without methods: only the section, the particles, supports and loads are drawn.

    Returns
    -------
    bytes
        The PNG.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    with style():
        picture = png(particles_scene(view, width=9.0, title=view.title))
    write_whole(path, picture)
    return picture
