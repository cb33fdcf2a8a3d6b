"""Envelope of failure from strengths at several confinements: friction angle and cohesion, Hoek and Brown's m_i."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..errors import InputError


@dataclass(frozen=True)
class Envelope:
    """Straight envelope of Mohr-Coulomb, and Hoek and Brown's curve through the same points.

    Attributes
    ----------
    friction_angle : float [rad]
    cohesion : float [Pa]
    intercept : float
        Strength without confinement on the straight line [Pa].
    misfit : float
        Root mean square of the distances from the line over its mean stress [-].
    m_i : float
        Of Hoek and Brown (1980) with s = 1: (s1 - s3)^2 = m_i UCS s3 + UCS^2, by least squares; nan where it is not
        positive.
    """

    friction_angle: float
    cohesion: float
    intercept: float
    misfit: float
    m_i: float


def fit_envelope(confinement: ArrayLike, strength: ArrayLike) -> Envelope:
    """Straight line through (confinement, strength) by least squares.

    s1 = UCS + N s3 with N = (1 + sin phi)/(1 - sin phi) and UCS = 2 c sqrt(N) (Jaeger, Cook & Zimmerman
    2007, Fundamentals of Rock Mechanics, eq. 4.22).

    Parameters
    ----------
    confinement, strength : (k,) [Pa]
        At two different confinements at least.

    Raises
    ------
    InputError
        All at one confinement, or strength that falls with confinement.
    """
    across = np.asarray(confinement, dtype=float)
    along = np.asarray(strength, dtype=float)
    if len(np.unique(across)) < 2:
        raise InputError(
            "envelope", "all strengths are at one confinement", "Test at two confinements at least, 0 counts"
        )
    slope, intercept = np.polyfit(across, along, 1)
    # without friction the slope is 1 up to rounding
    if slope < 1.0 - 1e-9:
        raise InputError(
            "envelope", "the strength rises by less than the confinement: there is no friction angle",
            "Look at the curves: a test may have ended before its peak", value=f"slope {slope:.3g}",
        )  # fmt: skip
    slope = max(float(slope), 1.0)
    friction = math.asin((slope - 1.0) / (slope + 1.0))
    away = along - slope * across - intercept
    weight = across * intercept
    excess = (along - across) ** 2 - intercept**2
    m_i = float((weight * excess).sum() / (weight**2).sum())
    return Envelope(
        friction, float(intercept / (2.0 * math.sqrt(slope))), float(intercept),
        float(np.sqrt((away**2).mean()) / along.mean()), m_i if m_i > 0.0 else math.nan,
    )  # fmt: skip
