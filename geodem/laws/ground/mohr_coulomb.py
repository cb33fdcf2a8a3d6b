"""Mohr-Coulomb ground in plane strain: elastic, perfectly plastic, with dilation and a tension cut-off.

Reference: the return in the plane of the largest and smallest principal stress, as in Davis & Selvadurai,
Plasticity and Geomechanics (2002), ch. 4 and 8. The out-of-plane stress is taken as the intermediate one, which
holds in plane strain for all but extreme initial stresses.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

NAME = "mohr_coulomb"

# What a scene may lack; the kernel's module overrides these, and the branch is then not compiled in.
PLASTIC = True
TENSION = True


class MohrCoulombParameters(NamedTuple):
    """What the law needs of a material. Tension is positive.

    With s the mean and t the radius of the in-plane stress, the yield function is
    f = t + s sin(phi) - c cos(phi), the plastic potential t + s sin(psi).
    """

    area_modulus: float  # lambda + G [Pa]: mean in-plane stress over area strain
    shear_modulus: float  # G [Pa]
    cohesion_cos_phi: float  # c cos(phi) [Pa]
    sin_phi: float  # [-]
    sin_psi: float  # [-]
    tensile_strength: float  # [Pa]; inf: none, the full cone


def parameters(
    *,
    young_modulus: float,
    poisson_ratio: float,
    cohesion: float,
    friction_angle: float,
    dilation_angle: float,
    tensile_strength: float,
) -> MohrCoulombParameters:
    """Parameters of the law from the engineer's constants: [Pa], [-], [Pa], [rad], [rad], [Pa]."""
    shear_modulus = young_modulus / (2.0 * (1.0 + poisson_ratio))
    lame = young_modulus * poisson_ratio / ((1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio))
    return MohrCoulombParameters(
        area_modulus=lame + shear_modulus,
        shear_modulus=shear_modulus,
        cohesion_cos_phi=cohesion * math.cos(friction_angle),
        sin_phi=math.sin(friction_angle),
        sin_psi=math.sin(dilation_angle),
        tensile_strength=tensile_strength,
    )


def reduced(material: MohrCoulombParameters, factor: float) -> MohrCoulombParameters:
    """The material with its strength divided by `factor`: c/F, tan(phi)/F, psi at most phi_F, tension cut by F."""
    phi = math.asin(material.sin_phi)
    cohesion = material.cohesion_cos_phi / math.cos(phi)
    phi_reduced = math.atan(math.tan(phi) / factor)
    return material._replace(
        cohesion_cos_phi=cohesion / factor * math.cos(phi_reduced),
        sin_phi=math.sin(phi_reduced),
        sin_psi=min(material.sin_psi, math.sin(phi_reduced)),
        tensile_strength=material.tensile_strength / factor,
    )


def update_stress(
    area_modulus, shear_modulus, cohesion_cos_phi, sin_phi, sin_psi, tensile_strength,
    stress_xx, stress_yy, stress_xy, strain_xx, strain_yy, strain_xy,
):  # fmt: skip
    """Stress after a strain increment (tension positive; strain_xy is the tensor component, half the angle).

    Returns
    -------
    stress_xx, stress_yy, stress_xy : float
        [Pa]
    plastic_area, plastic_shear : float
        Increments of plastic area strain and plastic shear strain (the angle gamma) [-].
    """
    area_strain = strain_xx + strain_yy
    s = 0.5 * (stress_xx + stress_yy) + area_modulus * area_strain
    d = 0.5 * (stress_xx - stress_yy) + shear_modulus * (strain_xx - strain_yy)
    q = stress_xy + 2.0 * shear_modulus * strain_xy
    plastic_area = 0.0
    plastic_shear = 0.0
    squared = d * d + q * q
    # f > 0 without the square root: nearly every particle is elastic, and a root costs as much as the rest
    strength = cohesion_cos_phi - s * sin_phi
    if PLASTIC and (
        squared > strength * abs(strength) or (TENSION and s + math.sqrt(squared) > tensile_strength)
    ):
        radius = math.sqrt(squared)
        t = radius
        excess = t - strength
        if excess > 0.0:
            plastic_shear = excess / (shear_modulus + area_modulus * sin_phi * sin_psi)
            if plastic_shear * shear_modulus > t:
                # beyond the apex of the cone: back to the apex, where the shear stress is gone
                plastic_shear = t / shear_modulus
                apex = cohesion_cos_phi / sin_phi if sin_phi > 0.0 else s
                plastic_area = (s - apex) / area_modulus
                s = apex
                t = 0.0
            else:
                plastic_area = sin_psi * plastic_shear
                t -= shear_modulus * plastic_shear
                s -= area_modulus * plastic_area
        if TENSION:
            excess = s + t - tensile_strength
            if excess > 0.0:
                opening = excess / (area_modulus + shear_modulus)
                if opening * shear_modulus > t:
                    plastic_shear += t / shear_modulus
                    plastic_area += (s - tensile_strength) / area_modulus
                    s = tensile_strength
                    t = 0.0
                else:
                    plastic_shear += opening
                    plastic_area += opening
                    s -= area_modulus * opening
                    t -= shear_modulus * opening
        shrink = t / radius if radius > 0.0 else 0.0
        d *= shrink
        q *= shrink
    return s + d, s - d, q, plastic_area, plastic_shear


def elastic_energy(area_modulus, shear_modulus, stress_xx, stress_yy, stress_xy):
    """Elastic energy per area of section [J/m3], plane strain: s^2/(2 (lambda + G)) + t^2/(2 G)."""
    s = 0.5 * (stress_xx + stress_yy)
    d = 0.5 * (stress_xx - stress_yy)
    return 0.5 * (s * s / area_modulus + (d * d + stress_xy * stress_xy) / shear_modulus)


def features(materials: Sequence[MohrCoulombParameters], *, plastic: bool) -> dict[str, bool]:
    """Which branches of the law these materials need."""
    return {
        "PLASTIC": plastic,
        "TENSION": plastic and any(math.isfinite(m.tensile_strength) for m in materials),
    }


def elastic_moduli(material: MohrCoulombParameters) -> tuple[float, float]:
    """lambda + G and G [Pa]."""
    return material.area_modulus, material.shear_modulus


def radius_allowed(material: MohrCoulombParameters, mean: Any) -> Any:
    """Radius [Pa] of the in-plane stress at which it yields at a mean [Pa] (a number, or an array of them)."""
    return material.cohesion_cos_phi - mean * material.sin_phi


def without_dilation(material: MohrCoulombParameters) -> MohrCoulombParameters:
    """The same material with a dilation angle of zero."""
    return material._replace(sin_psi=0.0)
