"""The loops of supports: gather the stretch of every link, let the law answer, hand its force to the particles.

As in `stress_particles`, these functions run joined with a law and constants.
"""

from __future__ import annotations

from ..laws.support.bar import update_force


def stretch(velocity, start, index, vector, table, support):
    """One step of stretch and force of every link.

    velocity (n, 2) [m/step]; start, index, vector: rows of links; table (k, 3): stiffness, lower and upper limit;
    support (k, 3), updated: force [N/m, or N for moments], plastic stretch, plastic work [J/m].
    """
    for link in range(len(table)):
        change = 0.0
        for entry in range(start[link], start[link + 1]):
            particle = index[entry]
            change += vector[entry, 0] * velocity[particle, 0] + vector[entry, 1] * velocity[particle, 1]
        force, plastic = update_force(
            table[link, 0], table[link, 1], table[link, 2], support[link, 0], change
        )
        support[link, 0] = force
        support[link, 1] += plastic
        support[link, 2] += force * plastic


def hold(support, start, index, vector, external, pushed):
    """External forces less those of the links: pushed (n, 2), overwritten.

    start, index, vector: rows of particles, columns links.
    """
    for particle in range(len(external)):
        fx = external[particle, 0]
        fy = external[particle, 1]
        for entry in range(start[particle], start[particle + 1]):
            force = support[index[entry], 0]
            fx -= force * vector[entry, 0]
            fy -= force * vector[entry, 1]
        pushed[particle, 0] = fx
        pushed[particle, 1] = fy
