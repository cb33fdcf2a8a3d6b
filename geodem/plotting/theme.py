"""Colours, type and figures that all pictures share.

The colour maps run through OKLab (B. Ottosson 2020, "A perceptual color space for image processing") with
lightness falling evenly from paper to ink, so that equal steps of value are equal steps to the eye, in print
without colour as well as to readers who see colours differently. Line colours follow M. Okabe & K. Ito 2008,
"Color Universal Design".
"""

from __future__ import annotations

import io
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure

INK, SOFT, FAINT, PAPER = "#1f2933", "#5f6c7b", "#d7dce2", "#ffffff"
STABLE, FAILED, UNDECIDED = "#0072b2", "#d55e00", "#7a7f87"
SLIP, CIRCLE, OTHER_CIRCLES = "#c2410c", "#0b4f8a", ("#0b4f8a", "#00755b", "#8a3b78", "#6b5200")

VERDICT_COLOURS = {"stable": STABLE, "failed": FAILED, "undecided": UNDECIDED}
VERDICT_MARKERS = {"stable": "o", "failed": "X", "undecided": "D"}

MATERIALS = (
    "#e6d3ad", "#b7cfe3", "#c9dfb8", "#edc3b4", "#d5c8e4", "#f3e39a",
    "#b9dcd6", "#d9d4cd", "#f0bfd2", "#c6cdb0",
)  # fmt: skip
"""Light fills of materials, in order of first appearance; names and boundaries stand beside them."""

_DOTS_PER_INCH = 130

_STYLE: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.labelsize": 9.0,
    "axes.labelcolor": SOFT,
    "axes.edgecolor": "#9aa5b1",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "text.color": INK,
    "axes.titlecolor": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "hatch.linewidth": 0.6,
    "svg.fonttype": "path",
    "svg.hashsalt": "geodem",
    "axes.unicode_minus": True,
}


def style() -> Any:
    """Context in which figures are made and written, so that no setting of the user's own leaks in or out."""
    import matplotlib

    settings: dict[Any, Any] = {**matplotlib.rcParamsDefault}
    settings.update(_STYLE, backend="agg")
    return matplotlib.rc_context(settings)


def new_figure(width: float, height: float) -> Figure:
    """A figure of the given size [inch] on the Agg canvas, outside any global state."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=_DOTS_PER_INCH, layout="constrained", facecolor=PAPER)
    FigureCanvasAgg(figure)
    return figure


def png(figure: Figure) -> bytes:
    """The figure as PNG, always the same bytes for the same figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=_DOTS_PER_INCH, metadata={"Software": None})
    return buffer.getvalue()


def svg(figure: Figure) -> bytes:
    """The figure as SVG, letters as outlines, always the same bytes for the same figure."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    return buffer.getvalue()


def quiet_axes(axes: Axes) -> None:
    """Ticks outside and short, a faint grid behind."""
    axes.tick_params(length=3.0, width=0.8)
    axes.grid(True, color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


def halo(width: float = 2.6) -> list[Any]:
    """A rim of paper that keeps letters and lines readable over what lies below."""
    from matplotlib import patheffects

    return [patheffects.Stroke(linewidth=width, foreground=PAPER, alpha=0.85), patheffects.Normal()]


def material_colour(index: int) -> str:
    """Light fill of the material at that place in the list; colours repeat after ten."""
    return MATERIALS[index % len(MATERIALS)]


@cache
def displacement_colours() -> ListedColormap:
    """Paper to deep blue."""
    return _even_lightness(
        "displacement", hues=(105.0, 185.0, 230.0, 262.0), chroma=(0.012, 0.085, 0.13, 0.10)
    )


@cache
def strain_colours() -> ListedColormap:
    """Paper to dark red-violet."""
    return _even_lightness(
        "plastic shear strain", hues=(95.0, 65.0, 30.0, -20.0), chroma=(0.012, 0.12, 0.17, 0.10)
    )


def _even_lightness(name: str, *, hues: tuple[float, ...], chroma: tuple[float, ...]) -> ListedColormap:
    """A colour map with OKLab lightness falling evenly, hue [deg] and chroma through the given stops."""
    from matplotlib.colors import ListedColormap

    at = np.linspace(0.0, 1.0, 256)
    lightness = 0.975 - 0.675 * at
    hue = np.radians(np.interp(at, np.linspace(0.0, 1.0, len(hues)), hues))
    strength = np.interp(at, np.linspace(0.0, 1.0, len(chroma)), chroma)
    return ListedColormap(
        _oklab_to_srgb(lightness, strength * np.cos(hue), strength * np.sin(hue)), name=name
    )


def _oklab_to_srgb(
    lightness: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """OKLab (k,) to gamma-encoded sRGB (k, 3) in 0..1; the matrices are Ottosson's."""
    long = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3
    middle = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3
    short = (lightness - 0.0894841775 * a - 1.2914855480 * b) ** 3
    linear = np.stack(
        [
            4.0767416621 * long - 3.3077115913 * middle + 0.2309699292 * short,
            -1.2684380046 * long + 2.6097574011 * middle - 0.3413193965 * short,
            -0.0041960863 * long - 0.7034186147 * middle + 1.7076147010 * short,
        ],
        axis=1,
    ).clip(0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
