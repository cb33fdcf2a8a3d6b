"""Bishop's simplified method and Spencer's on many sliding masses at once.

Sources: A.W. Bishop, The use of the slip circle in the stability analysis of slopes, Geotechnique 5 (1955);
E. Spencer, A method of analysis of the stability of embankments assuming parallel inter-slice forces,
Geotechnique 17 (1967), here written for surfaces of any shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference.ground import Array, Ground, Slices

M_ALPHA_LEAST = 0.2
THICKNESS_LEAST = 0.02


@dataclass(frozen=True)
class Answer:
    """A factor of safety and the surface that it belongs to.

    Attributes
    ----------
    method : str
    factor : float
        Strength over strength needed for equilibrium.
    centre : tuple of float or None
        Centre of the circle [m]; None for a surface that is no circle.
    radius : float or None
        [m].
    surface : ndarray, (n, 2)
        Slip surface from left to right [m].
    slices : int
    circles_tried : int
    notes : tuple of str
        What a reader has to know about the number.
    inclination : float or None
        Inclination of the interslice forces (Spencer) [rad].
    """

    method: str
    factor: float
    centre: tuple[float, float] | None
    radius: float | None
    surface: Array
    slices: int
    circles_tried: int = 1
    notes: tuple[str, ...] = ()
    inclination: float | None = None


# -- the two methods, on many masses at once -----------------------------------------------------------------


def solve_bishop(
    slices: Slices,
    x_centre: Array,
    y_centre: Array,
    *,
    tolerance: float = 1e-9,
    rounds: int = 100,
    spare: float = 1.0,
) -> tuple[Array, Array]:
    """Factor of safety of masses (m, n) from moments about (x_centre, y_centre), both (m, 1) [m].

    The normal force comes from vertical equilibrium without interslice shear. Chords have no normal force
    moment about the centre; the part of a surface that follows the underside of the section has.

    `spare` above 1 makes the rule on m_alpha stricter by that factor.

    Returns
    -------
    factor : ndarray, (m,)
        NaN where the surface is refused (see the module) or nothing drives it.
    normal : ndarray, (m, n)
        Normal force on the bases [N/m].
    """
    s = slices
    dx, dy = s.x - x_centre, s.y - y_centre
    arm_shear = dx * s.sine - dy * s.cosine
    arm_normal = dx * s.cosine + dy * s.sine
    drive = np.sum(s.weight * dx + s.horizontal * y_centre - s.horizontal_moment, axis=1)
    glue = s.cohesion * s.length
    factor = np.ones((len(drive), 1))
    before = miss_before = np.full_like(factor, np.nan)
    m_alpha = normal = miss = np.empty(0)
    with np.errstate(all="ignore"):
        for _ in range(rounds):
            m_alpha = s.cosine + s.sine * s.tan_phi / factor
            normal = (s.weight - glue * s.sine / factor) / m_alpha
            resist = np.sum((glue + normal * s.tan_phi) * arm_shear, axis=1)
            miss = (resist / (drive - np.sum(normal * arm_normal, axis=1)))[:, None] - factor
            if not np.any(np.abs(miss) > tolerance * factor):
                break
            # Secant steps; plain iteration crawls where the factor is small and the bases are steep.
            secant = factor - miss * (factor - before) / (miss - miss_before)
            sane = (secant > 0.5 * factor) & (secant < 2.0 * factor)
            plain = factor + miss
            before, miss_before = factor, miss
            factor = np.where(sane, secant, np.where(plain > 0.0, plain, np.nan))
        rough = (s.tan_phi > 0.0) & (s.width > 0.0)
        sound = np.all((m_alpha >= spare * M_ALPHA_LEAST) | ~rough, axis=1)
        sound &= np.abs(miss[:, 0]) <= 10.0 * tolerance * factor[:, 0]
    return np.where(sound, factor[:, 0], np.nan), normal


def solve_spencer(
    slices: Slices,
    pole: tuple[Array, Array],
    start: Array,
    *,
    tolerance: float = 1e-9,
    rounds: int = 60,
    spare: float = 1.0,
) -> tuple[Array, Array, Array]:
    """Factor of safety of masses (m, n) with interslice forces of one inclination, for surfaces of any shape.

    The net interslice force Q of a slice follows from its equilibrium along its base; the sum of all Q and
    the sum of their moments about a pole vanish at the factor and the inclination sought (Newton's method).

    Parameters
    ----------
    pole : pair of ndarray, (m, 1)
        Point for moments [m]; it changes the conditioning only.
    start : ndarray, (m,)
        Factor to start from.
    spare : float
        Above 1 it makes the rule on m_alpha stricter by that factor.

    Returns
    -------
    factor, inclination : ndarray, (m,)
        NaN where refused or where no solution was found; inclination in rad.
    normal : ndarray, (m, n)
        Normal force on the bases [N/m].
    """
    s = slices
    dx, dy = s.x - pole[0], s.y - pole[1]
    along = s.weight * s.sine + s.horizontal * s.cosine
    across = s.weight * s.cosine - s.horizontal * s.sine
    strength = s.cohesion * s.length + across * s.tan_phi
    turn = np.sum(s.horizontal_moment - s.horizontal * s.y, axis=1)
    total = np.sum(np.abs(along), axis=1) + 1e-300
    reach = np.max(np.abs(dx) + np.abs(dy), axis=1)
    factor = np.where(np.isfinite(start), start, 1.0)
    chord = np.arctan2(s.y[:, -1] - s.y[:, 0], s.x[:, -1] - s.x[:, 0])
    theta = 0.6 * chord
    lever = s.sine, s.cosine
    force = moment = denominator = np.empty(0)
    with np.errstate(all="ignore"):
        for _ in range(rounds):
            f, sin_t, cos_t = factor[:, None], np.sin(theta)[:, None], np.cos(theta)[:, None]
            sin_d, cos_d = lever[0] * cos_t - lever[1] * sin_t, lever[1] * cos_t + lever[0] * sin_t
            denominator = cos_d + sin_d * s.tan_phi / f
            q = (along - strength / f) / denominator
            q_f = (strength + q * sin_d * s.tan_phi) / (f * f * denominator)
            q_t = -q * (sin_d - cos_d * s.tan_phi / f) / denominator
            arm, arm_t = dx * sin_t - dy * cos_t, dx * cos_t + dy * sin_t
            force, moment = np.sum(q, axis=1), np.sum(q * arm, axis=1) - turn
            a, b = np.sum(q_f, axis=1), np.sum(q_t, axis=1)
            c, d = np.sum(q_f * arm, axis=1), np.sum(q_t * arm + q * arm_t, axis=1)
            determinant = a * d - b * c
            step_f = -(d * force - b * moment) / determinant
            step_t = -(a * moment - c * force) / determinant
            step_f = np.clip(step_f, -0.3 * factor, 0.5 * factor)
            step_t = np.clip(step_t, -0.2, 0.2)
            factor, theta = factor + step_f, theta + step_t
            if not np.any(np.abs(step_f) > tolerance * factor) and not np.any(np.abs(step_t) > tolerance):
                break
        normal = across + q * sin_d
        rough = s.width > 0.0
        sound = np.all((denominator >= spare * M_ALPHA_LEAST) | ~rough, axis=1) & (factor > 0.0)
        sound &= (np.abs(force) < 1e-4 * total) & (np.abs(moment) < 1e-4 * total * reach)
        sound &= (np.abs(step_f) < 1e-3 * factor) & (np.abs(theta) < 1.4)
    return np.where(sound, factor, np.nan), np.where(sound, theta, np.nan), normal


def remarks(ground: Ground, cut: Slices, normal: Array) -> list[str]:
    """What a reader has to know about the factor of one mass (1, n)."""
    notes = []
    length = float(cut.length.sum())
    tension = float(cut.length[(normal < 0.0) & (cut.tan_phi > 0.0)].sum())
    if tension > 0.01 * length:
        notes.append(
            f"{100.0 * tension / length:.0f} % of the slip surface is in tension: full Mohr-Coulomb cone, "
            "no tension crack."
        )
    thickness = float(cut.height.max())
    bare = ground.cohesionless_surface()
    if thickness < 1.3 * THICKNESS_LEAST * ground.height and len(bare):
        steepness = np.abs(bare[:, 3] - bare[:, 1]) / (bare[:, 2] - bare[:, 0])
        steep = steepness > 1e-6
        if np.any(steep):
            infinite = float(np.min(bare[steep, 4] / steepness[steep]))
            notes.append(
                f"Surficial: the least thickness allowed, {100.0 * THICKNESS_LEAST:.0f} % of the slope "
                "height, governs. A cohesionless skin has the infinite slope factor "
                f"tan(phi)/tan(beta) = {infinite:.3f}."
            )
    return notes
