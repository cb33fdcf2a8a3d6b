"""What several tests say together: means with their scatter, the envelope, and the properties of the material."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from .envelope import Envelope, fit_envelope
from .orders import FinishedTest


class Spread(NamedTuple):
    """A mean, the standard deviation of single values (nan for fewer than two), and how many there are."""

    mean: float
    deviation: float
    specimens: int

    @classmethod
    def of(cls, values: Iterable[float]) -> Spread:
        """Of what is finite; the mean of nothing is nan."""
        found = np.array([value for value in values if math.isfinite(value)])
        if not len(found):
            return cls(math.nan, math.nan, 0)
        return cls(float(found.mean()), float(found.std(ddof=1)) if len(found) > 1 else math.nan, len(found))


@dataclass(frozen=True, eq=False)
class TestGroup:
    """The same test on several specimens.

    Attributes
    ----------
    kind : str
    stress : float
        Confinement or normal stress [Pa].
    tests : tuple of FinishedTest
        At least one, in the order of their seeds.
    """

    __test__ = False  # not one of pytest's

    kind: str
    stress: float
    tests: tuple[FinishedTest, ...]

    @property
    def strength(self) -> Spread:
        """[Pa]"""
        return Spread.of(test.record.strength for test in self.tests)

    def number(self, name: str) -> Spread:
        """Of a number of the records; nothing where none has it."""
        return Spread.of(test.record.numbers.get(name, math.nan) for test in self.tests)

    @property
    def typical(self) -> FinishedTest:
        """The test whose strength is the middle one, the lower of two."""
        ranked = sorted(self.tests, key=lambda test: (test.record.strength, test.order.seed))
        return ranked[(len(ranked) - 1) // 2]


def group_tests(tests: Sequence[FinishedTest]) -> list[TestGroup]:
    """Tests of the same kind and stress together, in the order in which they come."""
    found: dict[tuple[str, float], list[FinishedTest]] = {}
    for test in tests:
        found.setdefault((test.order.kind, test.order.stress), []).append(test)
    return [
        TestGroup(kind, stress, tuple(sorted(group, key=lambda test: test.order.seed)))
        for (kind, stress), group in found.items()
    ]


class EnvelopeSummary(NamedTuple):
    """The envelope of all compression tests, and how it scatters from specimen to specimen.

    whole : through all strengths; confinement, strength: (k,) [Pa] of every test; friction_angle [rad], cohesion [Pa],
    m_i [-]: over the envelopes of single specimens.
    """

    whole: Envelope
    confinement: list[float]
    strength: list[float]
    friction_angle: Spread
    cohesion: Spread
    m_i: Spread


def summarise_envelope(groups: Sequence[TestGroup]) -> EnvelopeSummary | None:
    """The envelope; None where there are no two confinements.

    Raises
    ------
    InputError
        Strength falls with confinement.
    """
    tests = [
        test
        for group in groups
        if group.kind in ("uniaxial-compression", "triaxial-compression")
        for test in group.tests
    ]
    across = [test.order.stress for test in tests]
    along = [test.record.strength for test in tests]
    if len(set(across)) < 2:
        return None
    singles = []
    for seed in sorted({test.order.seed for test in tests}):
        own = [k for k, test in enumerate(tests) if test.order.seed == seed]
        try:
            singles.append(fit_envelope([across[k] for k in own], [along[k] for k in own]))
        except InputError:
            continue  # one confinement only, or so few particles that it got weaker
    return EnvelopeSummary(
        fit_envelope(across, along), across, along,
        Spread.of(single.friction_angle for single in singles), Spread.of(single.cohesion for single in singles),
        Spread.of(single.m_i for single in singles),
    )  # fmt: skip


class Property(NamedTuple):
    """A property of the material: key (unit at its end), kind of quantity of `geodem.units`, and what it is from."""

    key: str
    name: str
    quantity: str
    spread: Spread
    source: str


def material_properties(groups: Sequence[TestGroup], envelope: EnvelopeSummary | None) -> list[Property]:
    """All that the tests tell of the material; what they do not tell is left out."""
    by_kind = {group.kind: group for group in groups if group.stress == 0.0}
    pressed = by_kind.get("uniaxial-compression")
    elastic = pressed or next((g for g in groups if "young_modulus" in g.tests[0].record.numbers), None)
    found: list[Property] = []
    if elastic is not None:
        source = _told(elastic.kind)
        young, poisson = elastic.number("young_modulus"), elastic.number("poisson_ratio")
        found += [
            Property("young_modulus_Pa", "Young's modulus", "stress", young, source),
            Property("poisson_ratio", "Poisson's ratio", "dimensionless", poisson, source),
        ]
    for kind, key, name in STRENGTHS:
        if kind in by_kind:
            spread = by_kind[kind].strength
            found.append(Property(f"{key}_Pa", name, "stress", spread, _told(kind)))
    pulled = by_kind.get("direct-tension")
    if pressed is not None and pulled is not None:
        ratio = _ratio(pressed, pulled)
        source = "both on the same specimens"
        name = "compressive over tensile strength"
        found.append(Property("strength_ratio", name, "dimensionless", ratio, source))
    if pressed is not None:
        for key, name in (
            ("crack_initiation_stress", "crack initiation"),
            ("crack_damage_stress", "crack damage"),
        ):
            spread = pressed.number(key)
            if spread.specimens:
                found.append(Property(f"{key}_Pa", name, "stress", spread, _told(pressed.kind)))
    if envelope is not None:
        source = f"straight envelope, confinement up to {max(envelope.confinement) / 1e6:g} MPa"
        found += [
            Property("friction_angle_rad", "friction angle", "angle", envelope.friction_angle, source),
            Property("cohesion_Pa", "cohesion", "stress", envelope.cohesion, source),
            Property("m_i", "Hoek and Brown's mi", "dimensionless", envelope.m_i, "curve through the same points"),
        ]  # fmt: skip
    return [entry for entry in found if entry.spread.specimens]


STRENGTHS = (
    ("uniaxial-compression", "uniaxial_compressive_strength", "uniaxial compressive strength"),
    ("direct-tension", "tensile_strength", "direct tensile strength"),
    ("brazilian", "brazilian_strength", "Brazilian tensile strength"),
    ("three-point-bending", "flexural_strength", "flexural strength"),
)
"""Kinds of tests whose strength is a property by itself."""


def _ratio(above: TestGroup, below: TestGroup) -> Spread:
    """Of strengths, specimen by specimen."""
    of = {test.order.seed: test.record.strength for test in below.tests}
    return Spread.of(
        test.record.strength / of[test.order.seed] for test in above.tests if test.order.seed in of
    )


def _told(kind: str) -> str:
    return f"{kind.replace('-', ' ').replace('brazilian', 'Brazilian')} test"
