"""Surfaces of bodies as walls, of thousands of facets, that hold particles in motion."""

from __future__ import annotations

import numpy as np
import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.fill_body import fill_body
from geodem.builders.from_mesh import body_from_mesh, walls_from_body
from geodem.particle_simulation import ParticleSimulation
from tests.builders.mesh_files import write_stl

SPRING = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.3}


def ball_stl(path, count=2000):
    from scipy.spatial import ConvexHull

    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    wide = np.sqrt(1.0 - z * z)
    points = np.stack([wide * np.cos(angle), wide * np.sin(angle), z], axis=1)
    return write_stl(path, points[ConvexHull(points).simplices])


def ring_geo(path):
    path.write_text(
        "Point(1) = {0, 0, 0, 0.002}; Point(2) = {1, 0, 0, 0.002}; Point(3) = {-1, 0, 0, 0.002};\n"
        "Circle(1) = {2, 1, 3}; Circle(2) = {3, 1, 2}; Curve Loop(1) = {1, 2}; Plane Surface(1) = {1};\n"
        'Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeMax = 0.2;\nPhysical Surface("sand") = {1};\n'
    )
    return path


@pytest.mark.parametrize("dimension", [2, 3])
def test_particles_stay_in_a_body_of_thousands_of_facets(tmp_path, dimension):
    """Grains fall in a ball, or a drum: none leaves it, and the walls carry their weight once they rest."""
    body = body_from_mesh(
        ball_stl(tmp_path / "ball.stl") if dimension == 3 else ring_geo(tmp_path / "ring.geo")
    )
    walls = walls_from_body(body)
    assert sum(len(surface.corners) for surface in body.surfaces) > 3000
    build = AssemblyBuilder(dimension, gravity=(0.0,) * (dimension - 1) + (-9.81,))
    build.add_material("grain", density=2000.0, contact=SPRING)
    filling = fill_body(body, arrangement="square" if dimension == 2 else "simple_cubic", radius=0.12)
    inside = np.linalg.norm(filling.positions, axis=1) < 0.85
    build.add_particles(filling.positions[inside], filling.radii[inside], "grain")
    for wall in walls:
        build.add_wall(wall)
    simulation = ParticleSimulation(build.build(), local_damping=0.7)
    simulation.run(8000)
    distance = np.linalg.norm(simulation.positions, axis=1)
    assert distance.max() < 0.9
    mass = (np.pi * 0.12**2 if dimension == 2 else 4.0 / 3.0 * np.pi * 0.12**3) * 2000.0 * inside.sum()
    carried = sum(simulation.wall_force(wall.name)[-1] for wall in walls)
    assert carried == pytest.approx(-9.81 * mass, rel=0.02)
