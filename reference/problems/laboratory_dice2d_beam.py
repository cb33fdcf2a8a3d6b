"""DICE2D's beam of triangular packing in three-point bending (Zhao 2015, section 2.5.2); run with `laboratory_elastic`.

203 discs are five rows of 41 and 40; the finer beam has eleven rows and is more slender. Of pure bending such a strip
has a closed form: a bond in the middle of which the axial strain is kappa y feels nothing else of the curvature kappa,
since discs turn with the line. Rows of bonds along the beam give kn a y^2 each, the bonds between two rows what they
give in uniaxial tension, every bond the bending of its two springs:

    EI = kn a sum(y of rows)^2 + (E - 2 kn/sqrt3) h sum(y of layers)^2 + kn (WRT a)^2/4 a (n + (n - 1)/2)

for n rows of the distance h = sqrt3/2 a, with E of the lattice; the last term only if ks > 0 makes discs turn. The
height that stands in H^3/12 follows from it: with ks = 0 (n (n^2 - 1))^(1/3) h, a little less than n rows.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.integrators.elastic_network import solve_network
from geodem.particle_simulation import ParticleSimulation
from geodem.particle_statics import find_equilibrium

from .dice2d_tables import book_step, disc_mass, friction
from .laboratory_dice2d_specimens import DENSITY, HEIGHT, RADIUS, STIFFNESS, Bonded, Floats, triangular
from .rows import Row, at_most, relative

LOAD = 1e4  # [N]: the text keeps it small
BOOK, FINE = (41, 5), (221, 11)
"""Discs in the longest rows, rows: 203 discs as in table 2.7; 2426."""
RATIOS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
"""ks/kn."""
WIDTHS = (0.0, 0.1, 0.2, 0.5, 0.9, 1.0)
"""WRT."""
WIDTH, RATIO = 0.2, 0.2  # of figure 2.16
SPACING = 2.0 * RADIUS
SHAPE = 5.0 / 6.0
"""Share of a rectangular section that shear deflection counts with, in Timoshenko's beam."""

TEXT = "Zhao 2015, section 2.5.2"
STRIP = "closed form of the strip in pure bending, and Timoshenko's shear deflection F L/(4 5/6 G H)"


class Bent(NamedTuple):
    """Span [m], and the middle row's places (k,) over it with its deflections (k,) [m], none at its ends."""

    span: float
    at: Floats
    deflection: Floats

    @property
    def largest(self) -> float:
        """In the middle [m]."""
        return float(np.interp(0.5, self.at, self.deflection))

    @property
    def line_error(self) -> float:
        """Farthest from the elastic line of eq. 2.3, over the largest deflection [-]."""
        return float(np.abs(self.deflection / self.largest - elastic_line(self.at)).max())


def elastic_line(at: Floats) -> Floats:
    """Deflection of a slender beam over its largest, eq. 2.3."""
    near = np.minimum(at, 1.0 - at)
    return np.asarray(near * (3.0 - 4.0 * near**2))


def timoshenko_line(at: Floats, share: float) -> Floats:
    """The same where shear makes up that share of the largest deflection."""
    return np.asarray((1.0 - share) * elastic_line(at) + share * 2.0 * np.minimum(at, 1.0 - at))


def young(ratio: float) -> float:
    """E of the lattice [Pa]."""
    return 2.0 * math.sqrt(3.0) * STIFFNESS * (1.0 + ratio) / (3.0 + ratio)


def stiffness(rows: int, ratio: float, width_ratio: float) -> float:
    """EI of the strip [N m2]."""
    of_rows = HEIGHT**2 * rows * (rows**2 - 1) / 12.0
    of_layers = HEIGHT**2 * rows * (rows - 1) * (rows - 2) / 12.0
    found = STIFFNESS * SPACING * of_rows
    found += (young(ratio) - 2.0 / math.sqrt(3.0) * STIFFNESS) * HEIGHT * of_layers
    if ratio > 0.0:
        found += 0.25 * STIFFNESS * (width_ratio * SPACING) ** 2 * SPACING * (rows + 0.5 * (rows - 1))
    return found


def height(rows: int, ratio: float, width_ratio: float) -> float:
    """The H that makes EI = E H^3/12 [m]."""
    return float((12.0 * stiffness(rows, ratio, width_ratio) / young(ratio)) ** (1.0 / 3.0))


def deflections(shape: tuple[int, int], span: float, ratio: float, width_ratio: float) -> tuple[float, float]:
    """Largest deflection by bending and by shear [m]."""
    bending = LOAD * span**3 / (48.0 * stiffness(shape[1], ratio, width_ratio))
    rigidity = math.sqrt(3.0) / 4.0 * STIFFNESS * (1.0 + ratio)
    return bending, LOAD * span / (4.0 * SHAPE * rigidity * height(shape[1], ratio, width_ratio))


def ends_and_middle(sample: Bonded) -> tuple[int, int, int, NDArray[np.int64]]:
    """Discs at the two supports, under the load, and those of the middle row from left to right."""
    x, y = sample.positions.T
    bottom, top = np.flatnonzero(y < 1.5 * RADIUS), np.flatnonzero(y > sample.box[1] - 1.5 * RADIUS)
    row = np.flatnonzero(np.abs(y - 0.5 * sample.box[1]) < 0.5 * RADIUS)
    row = row[np.argsort(x[row])]
    load = top[np.argmin(np.abs(x[top] - 0.5 * sample.box[0]))]
    return int(bottom[np.argmin(x[bottom])]), int(bottom[np.argmax(x[bottom])]), int(load), row


def measured(sample: Bonded, moved: Floats) -> Bent:
    """The middle row against the line between its ends."""
    left, right, _, row = ends_and_middle(sample)
    x = sample.positions[:, 0]
    span = float(x[right] - x[left])
    at = (x[row] - x[left]) / span
    fallen = -moved[row, 1]
    return Bent(span, at, fallen - np.interp(at, at[[0, -1]], fallen[[0, -1]]))


def bend(shape: tuple[int, int], ratio: float, width_ratio: float) -> Bent:
    """Solved at rest: one support fixed, one rolling, the load in the middle of the top row."""
    sample = triangular(*shape)
    left, right, load, _ = ends_and_middle(sample)
    held = np.zeros((len(sample.radii), 3), dtype=bool)
    held[left, :2] = held[right, 1] = True
    force = np.zeros(held.shape)
    force[load, 1] = -LOAD
    return measured(sample, solve_network(sample.network(ratio, width_ratio), force, held=held))


def bent_by_the_engine(width_ratio: float, steps: int) -> tuple[Bent, Bent]:
    """The text's own run of 203 discs: after its steps, and once it is at rest."""
    sample = triangular(*BOOK)
    left, right, load, _ = ends_and_middle(sample)
    builder = AssemblyBuilder(2, bond_law="two_springs")
    contact = {
        "normal_stiffness": STIFFNESS,
        "shear_stiffness": RATIO * STIFFNESS,
        "friction_coefficient": friction(80.0),
    }
    bond = {**contact, "tensile_strength": 1.3e10, "cohesion": 1.3e10, "width_ratio": width_ratio}
    builder.add_material("disc", density=DENSITY, contact=contact, bond=bond)
    builder.add_particles(sample.positions, sample.radii, "disc")
    builder.bond(sample.pairs)
    builder.hold([left], x=0.0, y=0.0)
    builder.hold([right], y=0.0)
    builder.apply([load], force=(0.0, -LOAD))
    step = book_step(0.1, disc_mass(DENSITY), STIFFNESS, RATIO * STIFFNESS)
    simulation = ParticleSimulation(builder.build(), time_step=step, local_damping=0.8)
    simulation.run(steps)
    under_way = measured(sample, simulation.positions - sample.positions)
    find_equilibrium(simulation, tolerance=1e-6)
    return under_way, measured(sample, simulation.positions - sample.positions)


def stiffnesses(shape: tuple[int, int], ratio: float, width_ratio: float) -> list[Row]:
    """Deflection and line of one beam."""
    started = time.perf_counter()
    found = bend(shape, ratio, width_ratio)
    seconds = time.perf_counter() - started
    sample = triangular(*shape)
    name = f"beam of {len(sample.radii)} discs, ks/kn {ratio:g}, WRT {width_ratio:g}"
    bending, shear = deflections(shape, found.span, ratio, width_ratio)
    share = shear / (bending + shear)
    apart = float(np.abs(found.deflection / found.largest - timoshenko_line(found.at, share)).max())
    inertia = height(shape[1], ratio, width_ratio) ** 3 / 12.0
    modulus = LOAD * found.span**3 / (48.0 * found.largest * inertia)
    rows = [
        relative(name, "largest deflection [m]", found.largest, bending + shear, 0.02, seconds, STRIP),
        at_most(name, "line from eq. 2.3, over the largest deflection, at most", found.line_error, 0.02, seconds, TEXT),
        at_most(name, "the same from Timoshenko's line, at most", apart, 0.01, seconds, STRIP),
    ]  # fmt: skip
    if share < 0.01:
        rows.append(
            relative(name, "E by eq. 2.4 with the height of the strip [Pa]", modulus, young(ratio), 0.02, seconds,
                     "closed form of the triangular lattice")
        )  # fmt: skip
    return rows


def heights() -> list[Row]:
    """The text's effective height goes from H - D to H as WRT grows; what the deflections of the beams ask for."""
    rows = []
    for shape in (BOOK, FINE):
        name = f"beam of {len(triangular(*shape).radii)} discs, ks/kn {RATIO:g}"
        started = time.perf_counter()
        found = {width: bend(shape, RATIO, width) for width in (0.0, 1.0)}
        seconds = time.perf_counter() - started
        for width, bent in found.items():
            _, shear = deflections(shape, bent.span, RATIO, width)
            asked = (12.0 * LOAD * bent.span**3 / (48.0 * (bent.largest - shear) * young(RATIO))) ** (1 / 3)
            of_rows = asked / HEIGHT
            rows.append(
                relative(name, f"effective height at WRT {width:g}, in rows", of_rows,
                         height(shape[1], RATIO, width) / HEIGHT, 0.01, seconds, STRIP)
            )  # fmt: skip
        gain = found[0.0].largest / found[1.0].largest
        rows.append(
            relative(name, "E by eq. 2.4 with one height: WRT 1 over WRT 0", gain,
                     stiffness(shape[1], RATIO, 1.0) / stiffness(shape[1], RATIO, 0.0), 0.01, seconds,
                     "closed form of the strip in pure bending; the text: more, and less so in finer beams")
        )  # fmt: skip
    return rows


def moduli_by_ratio() -> list[Row]:
    """E over E at ks = 0, by eq. 2.4: linear in ks/kn, says the text.

    With the height of each strip it is that of the lattice, 3 (1 + k)/(3 + k). With one height for all, as in the text,
    it rises less: the bonds between rows, which ks strengthens, lie less far out than the rows.
    """
    started = time.perf_counter()
    bent = [bend(FINE, ratio, WIDTH) for ratio in RATIOS]
    plain = np.array([bent[0].largest / each.largest for each in bent])
    own = plain * [(height(FINE[1], 0.0, WIDTH) / height(FINE[1], ratio, WIDTH)) ** 3 for ratio in RATIOS]
    seconds = time.perf_counter() - started
    name = f"beam of {len(triangular(*FINE).radii)} discs, WRT {WIDTH:g}"
    rows = []
    for ratio, with_one, with_own in zip(RATIOS[1:], plain[1:], own[1:], strict=True):
        strips = stiffness(FINE[1], ratio, WIDTH) / stiffness(FINE[1], 0.0, WIDTH)
        rows += [
            relative(name, f"E/E0 at ks/kn {ratio:g}, with the height of each strip", float(with_own),
                     3.0 * (1.0 + ratio) / (3.0 + ratio), 0.01, seconds, "closed form of the triangular lattice"),
            relative(name, f"E/E0 at ks/kn {ratio:g}, with one height", float(with_one), strips, 0.01, seconds,
                     "closed form of the strip in pure bending"),
        ]  # fmt: skip
    line = np.polyval(np.polyfit(RATIOS, plain, 1), RATIOS)
    rows.append(
        at_most(name, "farthest of E/E0 from a straight line, at most", float(np.abs(plain - line).max()), 0.03,
                seconds, f"{TEXT}: linear; bound from the closed form, 0.022")
    )  # fmt: skip
    return rows


def engine() -> list[Row]:
    """At WRT 1 the text's code finds no elastic line; ours does, at rest."""
    rows = []
    for width in (WIDTH, 1.0):
        started = time.perf_counter()
        under_way, at_rest = bent_by_the_engine(width, 800)
        seconds = time.perf_counter() - started
        name = f"beam of 203 discs by the engine, ks/kn {RATIO:g}, WRT {width:g}"
        solved = bend(BOOK, RATIO, width)
        rows += [
            relative(name, "largest deflection at rest [m]", at_rest.largest, solved.largest, 1e-3, seconds,
                     "solved as a network"),
            at_most(name, "deflection after the 800 steps of table 2.7 over that at rest, at most",
                    under_way.largest / at_rest.largest, 0.2, seconds,
                    "800 steps are a fifth of the period (pi/2) sqrt(EI/m)/L^2 of the beam: none at rest"),
            at_most(name, "line from eq. 2.3, over the largest deflection, at most", at_rest.line_error, 0.02, seconds,
                    TEXT if width < 1.0 else "elastic here; the text finds no elastic line at WRT 1"),
        ]  # fmt: skip
    return rows


def run() -> list[Row]:
    """All of them."""
    rows: list[Row] = []
    for width in WIDTHS:
        rows += stiffnesses(BOOK, RATIO, width)
    for ratio, width in ((0.0, 0.1), (0.2, 0.0), (0.2, 0.2), (0.2, 1.0), (1.0, 0.1)):
        rows += stiffnesses(FINE, ratio, width)
    return [*rows, *heights(), *moduli_by_ratio(), *engine()]
