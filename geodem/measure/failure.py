"""What a failed state shows: how far the ground has moved, where it sheared, which mass slides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geodem.measure.slip_surface import moving_mass, shear_band_distance

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Failure:
    """The failed state of one trial; a static state (quasi-static relaxation), not a moment in time.

    Attributes
    ----------
    displacement : (n, 2) [m]
        From the settled state.
    plastic_shear_strain : (n,) [-]
    moving : (n,) bool
        Particles of the largest connected moving mass.
    slip_surface : (k, 2) [m]
        From crest to toe; k = 0 where no surface parts moving from staying ground.
    moving_area : float [m2]
        Of the section, that is volume per metre of slope.
    band_distance : float [m]
        Mean distance of the slip surface from the ridge of plastic shear strain; NaN where there is none.
    """

    displacement: Floats
    plastic_shear_strain: Floats
    moving: NDArray[np.bool_]
    slip_surface: Floats
    moving_area: float
    band_distance: float = float("nan")


def describe_failure(
    positions: Floats, triangles: NDArray[np.integer], displacement: Floats, plastic_shear_strain: Floats
) -> Failure:
    """Read the moving mass and its slip surface off a failed state.

    Parameters
    ----------
    positions : (n, 2) [m]
        Particle centres of the settled state, y upwards.
    triangles : (m, 3) integers
    displacement : (n, 2) [m]
        From the settled state to the failed one.
    plastic_shear_strain : (n,) [-]
        Accumulated over the failing trial.

    Returns
    -------
    Failure
        With copies of the fields, so that the engine may go on with its own.
    """
    displacement = np.array(displacement, dtype=np.float64)
    strain = np.array(plastic_shear_strain, dtype=np.float64)
    mass = moving_mass(positions, triangles, displacement, strain)
    return Failure(
        displacement=displacement,
        plastic_shear_strain=strain,
        moving=mass.moving,
        slip_surface=mass.slip_surface,
        moving_area=mass.area,
        band_distance=shear_band_distance(positions, triangles, strain, mass.slip_surface),
    )
