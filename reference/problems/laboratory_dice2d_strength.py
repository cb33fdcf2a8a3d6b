"""DICE2D's Brazilian, uniaxial and triaxial compression tests (Zhao 2015, sections 3.3.2 to 3.3.4).

Irregular specimens of 20 discs across, bonded within 1.02 and 1.2 times the sum of the radii; the second gives 5.0
bonds a disc where the text has 5.08. Strengths are compared as ratios, since the text's stresses are not those of its
own bonds (see `laboratory_dice2d_tension`); so is the confinement, up to 1.5 of 8 MPa in the text.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from geodem.boundaries.walls import plane
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.laboratory import axial
from geodem.laboratory.envelope import Envelope, fit_envelope
from geodem.laboratory.material import BondedMaterial
from geodem.laboratory.pace import LOOKS
from geodem.laboratory.record import TestRecord
from geodem.laboratory.rig import DAMPING, even_density
from geodem.laboratory.specimen import Specimen, make_specimen
from geodem.particle_simulation import ParticleSimulation

from .laboratory_dice2d_specimens import UNIT, Floats, material
from .laboratory_dice2d_tension import DENSE, LOOSE, SEEDS, SIZE
from .laboratory_points import FAST
from .rows import Row, at_most, relative

FEW_SEEDS = SEEDS[:3]
"""Of the studies of parameters."""
DIAMETER = 400.0  # of the Brazilian discs [m]
ACROSS = 20.0
STEP = 0.3  # of the time step over sqrt(m/kn), of the Brazilian test; with six bonds a disc 0.58 is critical
WIDTHS = (0.0, 0.1, 0.4, 0.7, 1.0)
RATIOS = (0.01, 0.2, 0.4, 0.7, 1.0)
COHESIONS = (0.25, 0.5, 1.0, 2.0, 4.0, 10.0)
"""Over Ft, at `ANGLE`."""
ANGLE = 40.0  # [deg]
ANGLES = (0.0, 20.0, 40.0, 60.0)
"""[deg]."""
COHESION = 1.0
"""Over Ft in the study of the friction: bonds fail in shear as well as in tension."""
CONFINEMENTS = (0.0, 0.0625, 0.125, 0.1875)
"""Over the uniaxial strength."""
SPLIT_STRAIN = 0.04
"""Way of the plates over the diameter at the peak of a Brazilian test, roughly: sets the rate."""
FALL = 0.7
"""Share of the largest load to which it has fallen when a disc has split."""
LONGEST = 5.0
"""Ways over that at the peak, roughly, at which a disc that has not split is given up."""

TEXT = "Zhao 2015, section 3.3"


@cache
def prism(seed: int) -> Specimen:
    """400 m x 695.5 m."""
    return make_specimen(2, width=SIZE[0], height=SIZE[1], across=ACROSS, seed=seed)


@cache
def disc(seed: int) -> Specimen:
    """400 m across."""
    return make_specimen(2, width=DIAMETER, across=ACROSS, shape="disc", seed=seed)


class Outcome(NamedTuple):
    """Strength [Pa], whether there was a peak, cracks by tension and by shear up to it, and seconds."""

    strength: float
    failed: bool
    tension: float
    shear: float
    seconds: float


Test = Callable[[Specimen, BondedMaterial], Outcome]


def of_record(record: TestRecord) -> Outcome:
    """What is looked at here."""
    numbers = record.numbers
    return Outcome(
        record.strength, record.failed, numbers["tension_cracks_at_peak"], numbers["shear_cracks_at_peak"],
        record.seconds,
    )  # fmt: skip


def pull(specimen: Specimen, made_of: BondedMaterial) -> Outcome:
    """Direct tension."""
    return of_record(axial.pull(specimen, made_of, pace=FAST))


def compress(specimen: Specimen, made_of: BondedMaterial) -> Outcome:
    """Uniaxial compression."""
    return of_record(axial.compress(specimen, made_of, pace=FAST))


def split(specimen: Specimen, made_of: BondedMaterial, pace: float = 2.0 * FAST) -> Outcome:
    """A disc between two plane walls, as in the text, and not the laboratory's curved jaws; 2 F/(pi D) at the peak.

    The walls come from where they touch the first discs, smooth and as stiff as the discs. Jaws of 10 degrees would
    hold one or two of the 20 discs across. Few discs bear on the walls: the order of the first breaks changes with the
    rate, and with it the strength of one disc by a tenth.
    """
    started = time.perf_counter()
    builder = AssemblyBuilder(2, contact_law=made_of.contact_law, bond_law=made_of.bond_law)
    builder.add_material(made_of.name, density=made_of.density, contact=made_of.contact, bond=made_of.bond)
    heavy = made_of.density * even_density(specimen.radii, 2)
    builder.add_particles(specimen.positions, specimen.radii, made_of.name, density=heavy)
    builder.bond_within(made_of.bonding_range)
    low = float((specimen.positions[:, 1] - specimen.radii).min())
    high = float((specimen.positions[:, 1] + specimen.radii).max())
    steps = round(pace * specimen.across)
    smooth = {**made_of.contact, "friction_coefficient": 0.0}

    def between_plates(speed: float) -> AssemblyBuilder:
        builder.add_wall(plane("below", (0.0, low), (0.0, 1.0), velocity=(0.0, speed), contact=smooth))
        builder.add_wall(plane("above", (0.0, high), (0.0, -1.0), velocity=(0.0, -speed), contact=smooth))
        return builder

    mass = math.pi * made_of.density * float((specimen.radii**2).mean())
    step = STEP * math.sqrt(mass / made_of.bond["normal_stiffness"])
    speed = 0.5 * SPLIT_STRAIN * specimen.width / (steps * step)
    simulation = ParticleSimulation(
        between_plates(speed).build(), time_step=step, local_damping=DAMPING, orientation=False
    )
    every = max(1, round(steps / LOOKS))
    top, tension, shear, failed = 0.0, 0, 0, False
    while simulation.steps < LONGEST * steps and not failed:
        simulation.run(every)
        force = 0.5 * float(simulation.wall_force("above")[1] - simulation.wall_force("below")[1])
        if force > top:
            top = force
            modes = simulation.broken_bonds().mode
            tension, shear = int((modes == 1).sum()), int((modes == 2).sum())
        # at the very start the walls touch one disc each
        failed = tension + shear > 0 and force < FALL * top
    strength = 2.0 * top / (math.pi * specimen.width)
    return Outcome(strength, failed, tension, shear, time.perf_counter() - started)


class Sample(NamedTuple):
    """Strengths (k,) over Ft/D of one material on several seeds, nan where there was no peak.

    `seconds` is what they took, `tension` the share of the cracks up to the peaks that are tensile.
    """

    values: Floats
    seconds: float
    tension: float

    @property
    def mean(self) -> float:
        """[-]"""
        return float(self.values.mean())

    @property
    def deviation(self) -> float:
        """Standard deviation [-]."""
        return float(self.values.std(ddof=1))


def tested(test: Test, specimens: Sequence[Specimen], made_of: BondedMaterial) -> Sample:
    """The same test on several specimens."""
    found = [test(specimen, made_of) for specimen in specimens]
    tension, shear = sum(each.tension for each in found), sum(each.shear for each in found)
    return Sample(
        np.array([each.strength / UNIT if each.failed else math.nan for each in found]),
        sum(each.seconds for each in found),
        tension / max(tension + shear, 1.0),
    )


def strengths(seeds: tuple[int, ...] = SEEDS) -> list[Row]:
    """Tension, splitting and compression of loosely and densely bonded specimens."""
    rows = []
    for factor, indirect, direct in ((LOOSE, 1.00, 2.0), (DENSE, 1.23, 2.5)):
        made_of = material(factor)
        pulled = tested(pull, [prism(seed) for seed in seeds], made_of)
        halved = tested(split, [disc(seed) for seed in seeds], made_of)
        name = f"irregular, bonded within {factor:g}, {len(seeds)} seeds"
        share = halved.values.mean() / pulled.values.mean()
        spread = f"D/Ft {halved.mean:.2f} +- {halved.deviation:.2f} over {pulled.mean:.2f} +- {pulled.deviation:.2f}"
        rows.append(
            relative(name, f"Brazilian over direct tension ({spread})", float(share), indirect / direct, 0.3,
                     pulled.seconds + halved.seconds, f"{TEXT}.2: {indirect:.2f} of {direct:g} MPa")
        )  # fmt: skip
        if factor == LOOSE:
            before = halved.mean
        else:
            rows.append(
                at_most(name, "Brazilian strength with few bonds over that with many: at most 1", before / halved.mean,
                        1.0, halved.seconds, f"{TEXT}.2: 1.00 and 1.23 MPa")
            )  # fmt: skip
            pressed = tested(compress, [prism(seed) for seed in seeds], made_of)
            spread = f"D/Ft {pressed.mean:.2f} +- {pressed.deviation:.2f}"
            rows += [
                relative(name, f"uniaxial compression ({spread}) over direct tension", pressed.mean / pulled.mean, 3.5,
                         0.5 / 3.5, pressed.seconds, f"{TEXT}.3: 3 to 4"),
                relative(name, "uniaxial compression over Brazilian", pressed.mean / halved.mean, 7.0, 0.15,
                         pressed.seconds, f"{TEXT}.3: about 7"),
                at_most(name, "share of shear cracks at the peak of compression, at most", 1.0 - pressed.tension, 0.1,
                        pressed.seconds, "strong in shear"),
            ]  # fmt: skip
    return rows


class Study(NamedTuple):
    """Strengths at the values of one parameter."""

    label: str
    values: tuple[float, ...]
    samples: tuple[Sample, ...]

    @property
    def means(self) -> Floats:
        """Strengths (k,) over Ft/D."""
        return np.array([sample.mean for sample in self.samples])

    @property
    def deviations(self) -> Floats:
        """Standard deviations (k,) over seeds."""
        return np.array([sample.deviation for sample in self.samples])

    @property
    def seconds(self) -> float:
        """Of all tests."""
        return sum(sample.seconds for sample in self.samples)


def splitting(seeds: tuple[int, ...] = FEW_SEEDS) -> tuple[list[Row], list[Study]]:
    """WRT and ks/kn on the Brazilian strength."""
    discs = [disc(seed) for seed in seeds]
    widths = Study(
        "WRT", WIDTHS, tuple(tested(split, discs, material(DENSE, width_ratio=each)) for each in WIDTHS)
    )
    ratios = Study(
        "ks/kn", RATIOS, tuple(tested(split, discs, material(DENSE, ratio=each)) for each in RATIOS)
    )
    name = f"Brazilian, bonded within {DENSE:g}, {len(seeds)} seeds"
    first, last = widths.means[0], widths.means[-1]
    low, high = ratios.means[0], ratios.means[-1]
    return [
        at_most(name, f"strength at WRT 1 over that at 0 (deviation {widths.deviations.max():.2f}), at most",
                last / first, 1.0, widths.seconds, f"{TEXT}.2: falls as WRT grows"),
        at_most(name, f"strength at ks/kn 0.01 over that at 1 (deviation {ratios.deviations.max():.2f}), at most",
                low / high, 1.0, ratios.seconds, f"{TEXT}.2: as in direct tension, where it grows"),
    ], [widths, ratios]  # fmt: skip


def compression(seeds: tuple[int, ...] = FEW_SEEDS) -> tuple[list[Row], list[Study]]:
    """Friction and cohesion of the bonds on the uniaxial strength."""
    prisms = [prism(seed) for seed in seeds]
    angles = Study(
        "phi", ANGLES,
        tuple(tested(compress, prisms, material(DENSE, cohesion=COHESION, angle=each)) for each in ANGLES),
    )  # fmt: skip
    cohesions = Study(
        "C/Ft", COHESIONS,
        tuple(tested(compress, prisms, material(DENSE, cohesion=each, angle=ANGLE)) for each in COHESIONS),
    )  # fmt: skip
    name = f"uniaxial compression, bonded within {DENSE:g}, {len(seeds)} seeds"
    with_angle = float((angles.means[1:] / angles.means[:-1]).min())
    with_cohesion = float((cohesions.means[1:4] / cohesions.means[:3]).min())
    at_end = float(cohesions.means[-1] / cohesions.means[-2])
    spread = f"deviation of seeds {float((angles.deviations / angles.means).max()):.0%}"
    return [
        at_least(name, f"strength at one friction angle over that at the one before, least ({spread}), at least",
                 with_angle, 1.0, angles.seconds, f"{TEXT}.3: rises with the friction angle"),
        at_least(name, "strength at one cohesion up to C/Ft 2 over that at the one before, least, at least",
                 with_cohesion, 1.0, cohesions.seconds, f"{TEXT}.3: rises with the cohesion"),
        relative(name, "strength at C/Ft 10 over that at 4", at_end, 1.0, 0.02, cohesions.seconds,
                 f"{TEXT}.3: then stable"),
    ], [angles, cohesions]  # fmt: skip


def at_least(name: str, quantity: str, value: float, limit: float, seconds: float, source: str) -> Row:
    """A row whose error is how far the value lies below a limit, over the limit; rounding is let pass."""
    return Row(name, quantity, value, limit, max(1.0 - value / limit, 0.0), 1e-9, seconds, source)


class Confined(NamedTuple):
    """Strengths (seeds, confinements) [Pa] at one micro friction angle [deg], their envelopes, and the seconds."""

    angle: float
    pressure: Floats
    strength: Floats
    envelopes: tuple[Envelope, ...]
    seconds: float

    @property
    def friction(self) -> Floats:
        """Angles (seeds,) [deg]."""
        return np.degrees([each.friction_angle for each in self.envelopes])


def press(specimen: Specimen, made_of: BondedMaterial, pressure: float) -> float:
    """Largest axial stress under a pressure on the sides [Pa]; nan where there was no peak."""
    record = axial.compress(specimen, made_of, confinement=pressure, pace=FAST)
    return record.strength if record.failed else math.nan


def confined(angle: float, seeds: tuple[int, ...] = FEW_SEEDS) -> Confined:
    """Envelopes of specimens with this friction in bonds and contacts."""
    started = time.perf_counter()
    made_of = material(DENSE, angle=angle)
    pressure = np.array(CONFINEMENTS) * compress(prism(seeds[0]), made_of).strength
    strength = np.array([[press(prism(seed), made_of, float(each)) for each in pressure] for seed in seeds])
    envelopes = tuple(fit_envelope(pressure, each) for each in strength)
    return Confined(angle, pressure, strength, envelopes, time.perf_counter() - started)


def triaxial(seeds: tuple[int, ...] = FEW_SEEDS) -> tuple[list[Row], list[Confined]]:
    """Macroscopic friction against that of bonds and contacts."""
    found = [confined(angle, seeds) for angle in ANGLES]
    name = f"triaxial, bonded within {DENSE:g}, {len(seeds)} seeds"
    none = found[0].friction
    seconds = sum(each.seconds for each in found)
    means = np.array([each.friction.mean() for each in found])
    rises = min(float((each.strength[:, 1:] / each.strength[:, :-1]).min()) for each in found)
    apart = float(np.abs(means - ANGLES).max())
    rows = [
        relative(name, f"macroscopic friction at micro 0 [deg], deviation {none.std(ddof=1):.1f}", float(none.mean()),
                 20.0, 0.25, found[0].seconds, f"{TEXT}.4: about 20 deg"),
        at_least(name, "strength at one pressure over that at the one before, least, at least", rises, 1.0, seconds,
                 f"{TEXT}.4: rises with confinement"),
        at_least(name, "largest difference of macroscopic and micro friction [deg], at least", apart, 10.0, seconds,
                 f"{TEXT}.4: they are not equal; bound ours"),
    ]  # fmt: skip
    for each in found[1:]:
        spread = f"deviation {each.friction.std(ddof=1):.1f}"
        rows.append(
            at_least(name, f"macroscopic friction at micro {each.angle:g} [deg], {spread}: at least that at 0",
                     float(each.friction.mean()), float(none.mean()), each.seconds,
                     f"{TEXT}.4: rises with the micro friction")
        )  # fmt: skip
    return rows, found


def draw(split_studies: list[Study], pressed_studies: list[Study], found: list[Confined]) -> bytes:
    """Strengths against four parameters, envelopes, macroscopic against micro friction (figures 3.20 to 3.30)."""
    from geodem.plotting.theme import INK, OTHER_CIRCLES, STABLE, new_figure, png, quiet_axes, style

    with style():
        figure = new_figure(9.6, 6.0)
        panels = figure.subplots(2, 3).T.flat
        labels = (
            "Brazilian, bond width WRT", "Brazilian, ks/kn", f"uniaxial, phi [deg], C/Ft {COHESION:g}",
            f"uniaxial, C/Ft, phi {ANGLE:g} deg",
        )  # fmt: skip
        for axes, study, label in zip(panels, [*split_studies, *pressed_studies], labels, strict=False):
            axes.errorbar(study.values, study.means, study.deviations, fmt="o-", color=STABLE, markersize=4.0,
                          linewidth=1.0, capsize=2.0)  # fmt: skip
            axes.set_xlabel(label)
            axes.set_ylabel("strength D/Ft")
            axes.set_ylim(bottom=0.0)
            quiet_axes(axes)
        envelopes, angles = figure.axes[2], figure.axes[5]
        for axes in (envelopes, angles):
            quiet_axes(axes)
        for each, colour in zip(found, OTHER_CIRCLES, strict=False):
            envelopes.errorbar(
                1e-6 * each.pressure, 1e-6 * each.strength.mean(axis=0), 1e-6 * each.strength.std(axis=0, ddof=1),
                fmt="o-", color=colour, markersize=3.5, linewidth=1.0, capsize=2.0, label=f"micro {each.angle:g} deg",
            )  # fmt: skip
        envelopes.set_xlabel("confinement [MPa]")
        envelopes.set_ylabel("strength [MPa]")
        envelopes.legend(loc="lower right")
        angles.errorbar(
            [each.angle for each in found], [each.friction.mean() for each in found],
            [each.friction.std(ddof=1) for each in found], fmt="o-", color=INK, markersize=4.0, linewidth=1.0,
            capsize=2.0,
        )  # fmt: skip
        angles.set_xlabel("micro friction angle [deg]")
        angles.set_ylabel("macroscopic [deg]")
        angles.set_ylim(bottom=0.0)
        return png(figure)
