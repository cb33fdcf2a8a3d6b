"""Frames read back with VTK's own reader hold what the simulation says, and statics says what they must hold."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geodem.boundaries.walls import plane, segments, triangles
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.io.particle_frames import BONDED, CONTACT, DEBONDED, damage, remove_later_frames, write_frame
from geodem.particle_simulation import ParticleSimulation

pyvista = pytest.importorskip("pyvista")

GRAVITY = 9.81
CONTACTS = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
SPRINGS = {
    "normal_stiffness": 1e6, "shear_stiffness": 5e5, "tensile_strength": 1e12, "cohesion": 1e12,
    "friction_coefficient": 0.5, "width_ratio": 0.8,
}  # fmt: skip
WEIGHT = 2000.0 * np.pi * 0.01 * GRAVITY


def column():
    """Five discs on a ledge: two bonds, one that breaks as the upper two hop, and two discs that only touch."""
    builder = AssemblyBuilder(2, bond_law="two_springs", gravity=(0.0, -GRAVITY))
    builder.add_material("base", density=2000.0, contact=CONTACTS, bond=SPRINGS)
    builder.add_material("rock", density=2000.0, contact=CONTACTS, bond=SPRINGS)
    places = [(0.0, 0.1 + 0.2 * k) for k in range(5)]
    low = builder.add_particles(places[:1], 0.1, "base")
    hop = [(0.0, 0.0), (0.0, 0.0), (0.0, 0.3), (0.0, 0.3)]
    high = builder.add_particles(places[1:], 0.1, "rock", velocity=hop)
    builder.hold([*low, *high], x=0.0, rotation=0.0)
    builder.bond([(0, 1), (1, 2), (2, 3)], scale=[1.0, 1.0, 1e-12])
    builder.add_wall(segments("ledge", [(-1.0, 0.0), (1.0, 0.0)]))
    builder.add_wall(plane("floor", (0.0, -1.0), (0.0, 1.0)))
    return ParticleSimulation(builder.build(), local_damping=0.8)


@pytest.fixture(scope="module")
def simulation():
    found = column()
    found.run(3000)
    return found


@pytest.fixture(scope="module")
def folder(simulation, tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")
    names = [path.name for path in write_frame(folder, simulation)]
    assert names == [f"{kind}-000003000.vtkhdf" for kind in ("particles", "contacts", "cracks", "walls")]
    return folder


def read(folder, kind):
    return pyvista.read(folder / f"{kind}-000003000.vtkhdf")


def test_particles(folder, simulation):
    mesh = read(folder, "particles")
    assert np.array_equal(mesh.points[:, :2], simulation.positions)
    data = mesh.point_data
    assert (data["radius [m]"] == 0.1).all()
    assert data["material [-]"].tolist() == [0, 1, 1, 1, 1]
    assert data["id [-]"].tolist() == [0, 1, 2, 3, 4]
    assert np.array_equal(data["velocity [m per s]"][:, :2], simulation.velocities)
    assert np.array_equal(data["force [N per m]"][:, :2], simulation.forces[:, :2])
    assert np.array_equal(data["angle [rad]"], simulation.orientations[:, 0])
    # of the bonds of discs 3 and 4 one broke
    assert data["broken bonds [-]"].tolist() == [0, 0, 1, 1, 0]
    assert data["damage [-]"].tolist() == [0.0, 0.0, 0.5, 1.0, 0.0]
    assert mesh.field_data["materials"][0] == "base, rock"
    assert mesh.field_data["TimeValue"][0] == simulation.time


def test_contacts_bear_what_lies_above(folder):
    mesh = read(folder, "contacts")
    assert [mesh.get_cell(k).point_ids for k in range(mesh.n_cells)] == [[0, 1], [1, 2], [2, 3], [3, 4]]
    assert mesh.cell_data["normal force [N per m]"] == pytest.approx(
        np.array([4, 3, 2, 1]) * WEIGHT, rel=1e-6
    )
    assert np.abs(mesh.cell_data["shear force [N per m]"]).max() < 1e-6 * WEIGHT
    assert mesh.cell_data["state [-]"].tolist() == [BONDED, BONDED, DEBONDED, CONTACT]


def test_cracks(folder, simulation):
    mesh = read(folder, "cracks")
    assert mesh.n_points == 1
    assert mesh.points[0, 1] == pytest.approx(0.6, abs=1e-3)
    assert mesh.point_data["bond [-]"].tolist() == [2]
    assert mesh.point_data["mode [-]"].tolist() == [1]
    assert 0.0 <= mesh.point_data["time [s]"][0] < simulation.time


def test_walls(folder):
    """The ledge bears five discs; the infinite floor has no corners to draw."""
    mesh = read(folder, "walls")
    assert mesh.n_cells == 1
    assert mesh.points[:, :2].tolist() == [[-1.0, 0.0], [1.0, 0.0]]
    assert mesh.cell_data["force on the whole wall [N per m]"][0, 1] == pytest.approx(-5 * WEIGHT, rel=1e-6)


def test_spheres_without_bonds(tmp_path):
    builder = AssemblyBuilder(3)
    builder.add_material("grain", density=2000.0, contact=CONTACTS)
    builder.add_particles([(0.0, 0.0, 0.0), (0.3, 0.0, 0.0)], 0.1, "grain", velocity=[(0, 0, 1), (0, 0, 0)])
    builder.add_wall(triangles("plate", [[(-1, -1, -1), (1, -1, -1), (0, 1, -1)]], velocity=(0.0, 0.0, 2.0)))
    simulation = ParticleSimulation(builder.build(), time_step=1e-4, orientation=True)
    simulation.run(100)
    paths = {path.name.split("-")[0]: pyvista.read(path) for path in write_frame(tmp_path, simulation)}
    assert set(paths) == {"particles", "contacts", "walls"}
    assert paths["particles"].points[0, 2] == pytest.approx(0.01)
    assert paths["particles"].point_data["quaternion w, x, y, z [-]"].shape == (2, 4)
    assert "force [N]" in paths["particles"].point_data
    assert paths["contacts"].n_cells == 0
    # the plate moves at 2 m/s
    assert paths["walls"].points[:, 2] == pytest.approx([-0.98] * 3)


def test_frames_of_one_run_are_an_animation_and_can_be_wound_back(tmp_path):
    simulation = column()
    for _ in range(4):
        write_frame(tmp_path, simulation)
        simulation.run(10)
    write_frame(tmp_path, simulation)
    write_frame(tmp_path, simulation)
    remove_later_frames(tmp_path, 20)
    for kind in ("particles", "contacts", "cracks", "walls"):
        series = json.loads((tmp_path / f"{kind}.vtkhdf.series").read_text())["files"]
        assert [entry["name"] for entry in series] == [f"{kind}-{k:09d}.vtkhdf" for k in (0, 10, 20)]
        assert [entry["time"] for entry in series] == [k * simulation.time_step for k in (0, 10, 20)]
        assert sorted(path.name for path in tmp_path.glob(f"{kind}-*")) == [entry["name"] for entry in series]


def test_damage_counts_the_bonds_of_a_particle(simulation):
    broken, share = damage(simulation)
    assert broken.tolist() == [0, 0, 1, 1, 0]
    assert share.tolist() == [0.0, 0.0, 0.5, 1.0, 0.0]
