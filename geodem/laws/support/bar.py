"""One link of a support: elastic, ideally plastic between two limits.

A link answers to one generalised stretch: the lengthening of a piece of lining or bolt [m] with a force, the turning
of two pieces of lining against each other [-] with a moment, the slip of a bolt in its grout [m] with a shear force.
All are per metre of tunnel.
"""

from __future__ import annotations

NAME = "bar"


def update_force(stiffness, lower, upper, force, stretch):
    """Force after an increment of stretch, and the part of the increment that is plastic.

    force = min(max(force + stiffness stretch, lower), upper); what the limits cut off is plastic.
    """
    trial = force + stiffness * stretch
    plastic = 0.0
    if trial > upper:
        plastic = (trial - upper) / stiffness
        trial = upper
    elif trial < lower:
        plastic = (trial - lower) / stiffness
        trial = lower
    return trial, plastic
