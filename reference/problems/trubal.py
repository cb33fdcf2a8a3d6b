"""TRUBAL's and TPM's triaxial tests: `python -m reference run trubal`; draws docs/pictures/trubal_*.png.

The peaks of the finite sample of Cui and O'Sullivan (2005) are numbers of another simulation, of a part of a cylinder
that is periodic around its axis, with a membrane that follows the outer spheres. Ours are Cundall's and Rowe's whole
octagons, with constant forces on the outer spheres of the large layers and no periodicity.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from . import trubal_random
from .rows import Row, at_most, relative
from .trubal_rowe import CUNDALL, FRICTION, ROWE, Layers, Loading, load, prism, theory, uniform_strain

PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures"

SAMPLES = {"403 spheres": CUNDALL, "1672 spheres": ROWE}
COUNTS = {"403 spheres": (37, 24), "1672 spheres": (76, 57)}
SHAPES = "TPM, figures 4.1 and 4.2"

PUBLISHED = {0.05: 2.09, 0.12278: 2.46, 0.2: 2.92, 0.3: 3.64}
"""Peak stress ratios of Cui and O'Sullivan, by friction coefficient."""
FINITE = "Cui & O'Sullivan 2005, r 20 mm, finite sample"
BOUND = 0.05

SOFT_STRAIN, SOFT_STEPS = 0.02, 20_000
STIFF_RADIUS = 0.02  # of Cui and O'Sullivan [m]
STIFF_STRAIN, STIFF_STEPS = 1e-4, 100_000


def shapes(name: str, layers: Layers) -> list[Row]:
    """Spheres of the layers, and that the forces of the membrane are the pressure times the faces."""
    started = time.perf_counter()
    sample = prism(layers)
    counts = np.bincount(sample.layer)
    name = f"Rowe {name}"
    # half of the sizes of all forces push one way
    face = (np.ptp(sample.places[:, :2], axis=0)) * sample.height
    pushed = 0.5 * np.abs(sample.exposed).sum(axis=0)
    seconds = time.perf_counter() - started
    return [
        relative(name, "spheres", float(len(sample.places)), float(name.split()[1]), 0.0, seconds, SHAPES),
        relative(name, "of a large layer", float(counts[0]), float(COUNTS[name[5:]][0]), 0.0, seconds, SHAPES),
        relative(name, "of a small layer", float(counts[1]), float(COUNTS[name[5:]][1]), 0.0, seconds, SHAPES),
        *(
            relative(name, f"force along {axis} over sigma r^2", float(push), float(whole), 1e-12, seconds,
                     "width of the octagon times the height")
            for axis, push, whole in zip("xy", pushed, face, strict=True)
        ),
        Row(name, "sum of the membrane's forces over sigma r^2", float(np.abs(sample.exposed.sum(axis=0)).max()), 0.0,
            float(np.abs(sample.exposed.sum(axis=0)).max()), 1e-12, seconds, "balance"),
    ]  # fmt: skip


def as_in_the_text(name: str, layers: Layers) -> tuple[list[Row], Loading]:
    """Radius 20, pressure 5e4, friction 7 degrees: peak, and that neither rate nor damping decides it."""
    sample = prism(layers)
    whole = load(sample, to=SOFT_STRAIN, steps=SOFT_STEPS)
    half = load(sample, to=SOFT_STRAIN, steps=2 * SOFT_STEPS)
    other = load(sample, to=SOFT_STRAIN, steps=SOFT_STEPS, damping=0.2)
    name = f"Rowe {name}, r 20, f {FRICTION}"
    label = "peak stress ratio sigma1/sigma3"
    return [
        relative(name, label, whole.peak, PUBLISHED[FRICTION], BOUND, whole.seconds, FINITE),
        at_most(name, f"{label}: at most that without bounds", whole.peak, theory(FRICTION), whole.seconds,
                "2 (1 + f)/(1 - f), Rowe 1962, Thornton 1979"),
        relative(name, f"{label}, half the rate", half.peak, whole.peak, 0.005, half.seconds, "the full rate"),
        relative(name, f"{label}, damping 0.2", other.peak, whole.peak, 0.005, other.seconds, "damping 0.5"),
        at_most(name, "difference of the platens' forces up to the peak, at most", whole.apart, 0.01, whole.seconds,
                "balance"),
        at_most(name, "largest overlap over the diameter, at most", whole.overlap, 0.005, whole.seconds,
                "small against the slip, as the text asks"),
    ], half  # fmt: skip


def as_published(name: str, layers: Layers) -> tuple[list[Row], dict[float, float]]:
    """Radius 20 mm: peaks for all published friction coefficients."""
    rows, peaks = [], {}
    sample = prism(layers)
    for friction, published in PUBLISHED.items():
        run = load(sample, to=STIFF_STRAIN, steps=STIFF_STEPS, friction=friction, radius=STIFF_RADIUS)
        peaks[friction] = run.peak
        label = f"Rowe {name}, r 20 mm, f {friction:g}"
        rows += [
            relative(label, "peak stress ratio sigma1/sigma3", run.peak, published, BOUND, run.seconds, FINITE),
            at_most(label, "the same: at most that without bounds", run.peak, theory(friction), run.seconds,
                    "2 (1 + f)/(1 - f)"),
        ]  # fmt: skip
    return rows, peaks


def draw(curves: dict[str, Loading], peaks: dict[str, dict[float, float]], path: Path) -> None:
    """Stress ratio against axial strain of both samples, and peaks against friction."""
    from geodem.plotting.theme import FAILED, INK, SOFT, STABLE, new_figure, png, quiet_axes, style

    colours = dict(zip(SAMPLES, (STABLE, FAILED), strict=True))
    with style():
        figure = new_figure(9.0, 3.9)
        left, right = figure.subplots(1, 2)
        for name, curve in curves.items():
            left.plot(100.0 * curve.strain, curve.ratio, "-", color=colours[name], linewidth=1.6, label=name)
        strain = np.linspace(0.0, SOFT_STRAIN, 101)
        left.plot(100.0 * strain, uniform_strain(strain, FRICTION), "--", color=SOFT, linewidth=1.2,
                  label="uniform strain, rigid spheres")  # fmt: skip
        left.axhline(theory(FRICTION), color=INK, linewidth=0.8, label="2 (1 + f)/(1 - f)")
        left.axhline(
            PUBLISHED[FRICTION], color=INK, linewidth=0.8, linestyle=":", label="Cui & O'Sullivan, finite"
        )
        left.set_title(f"f = {FRICTION}, kn/(sigma r) = 1500")
        left.set_xlabel("axial strain [%]")
        left.set_ylabel("stress ratio sigma1/sigma3")
        left.set_ylim(0.0, 2.8)
        left.legend(loc="lower right")
        friction = np.linspace(0.0, 0.32, 101)
        right.plot(friction, theory(friction), "-", color=INK, linewidth=0.8, label="2 (1 + f)/(1 - f)")
        right.plot(*zip(*PUBLISHED.items(), strict=True), "D", color=INK, markerfacecolor="none",
                   label="Cui & O'Sullivan, finite")  # fmt: skip
        for name, found in peaks.items():
            right.plot(
                *zip(*found.items(), strict=True), "o", markersize=4.5, color=colours[name], label=name
            )
        right.set_title("Peaks, kn/(sigma r) = 1.5e6")
        right.set_xlabel("friction coefficient f")
        right.legend(loc="upper left")
        for axes in (left, right):
            quiet_axes(axes)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(png(figure))


def random_spheres() -> list[Row]:
    """The random assembly in its periodic cell: every seed at two rates."""
    runs = {
        seed: (trubal_random.triaxial(seed), trubal_random.triaxial(seed, slower=2))
        for seed in trubal_random.SEEDS
    }
    (PICTURES / "trubal_random.png").write_bytes(trubal_random.draw(runs))
    return [row for seed, (run, half) in runs.items() for row in trubal_random.rows_of(seed, run, half)]


def run() -> list[Row]:
    """Rowe's samples and the random one."""
    rows: list[Row] = []
    curves, peaks = {}, {}
    for name, layers in SAMPLES.items():
        soft, curves[name] = as_in_the_text(name, layers)
        stiff, peaks[name] = as_published(name, layers)
        rows += [*shapes(name, layers), *soft, *stiff]
    few, many = (np.array(list(found.values())) for found in peaks.values())
    rows.append(
        at_most("Rowe 403 and 1672 spheres", "peaks of 403 over those of 1672 spheres: at most",
                float((few / many).max()), 1.0, 0.0, "the share of the boundary falls with the size")
    )  # fmt: skip
    draw(curves, peaks, PICTURES / "trubal_rowe.png")
    return [*rows, *random_spheres()]
