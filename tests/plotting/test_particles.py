"""Pictures of discs and spheres: what is drawn where, in which colour."""

import io
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from geodem.boundaries.walls import plane, segments, triangles
from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.errors import InputError
from geodem.particle_simulation import ParticleSimulation
from geodem.plotting import particles
from geodem.plotting.theme import MATERIALS, displacement_colours, new_figure

CONTACT = {"normal_stiffness": 1e6, "shear_stiffness": 5e5, "friction_coefficient": 0.5}
SPRINGS = {
    "normal_stiffness": 1e6, "shear_stiffness": 5e5, "tensile_strength": 1.0, "cohesion": 1.0,
    "friction_coefficient": 0.0, "width_ratio": 0.8,
}  # fmt: skip


def row(speeds):
    """Four discs in a row, bonded, that move along it; the last one of another material."""
    builder = AssemblyBuilder(2, bond_law="two_springs")
    for name in ("soil", "rock"):
        builder.add_material(name, density=2000.0, contact=CONTACT, bond=SPRINGS)
    velocities = [(speed, 0.0) for speed in speeds]
    places = [(0.2 * k, 0.0) for k in range(4)]
    builder.add_particles(places[:3], 0.1, "soil", velocity=velocities[:3])
    builder.add_particles(places[3:], 0.1, "rock", velocity=velocities[3:])
    builder.bond([(0, 1), (1, 2), (2, 3)])
    builder.add_wall(plane("floor", (0.0, -0.2), (0.0, 1.0)))
    builder.add_wall(segments("stop", [(1.0, -0.1), (1.0, 0.1)]))
    return ParticleSimulation(builder.build(), time_step=1e-4)


@pytest.fixture(scope="module")
def parted():
    """The first bond opened by 2 cm, the last one by 20 cm."""
    simulation = row((-1.0, 0.0, 0.0, 10.0))
    simulation.run(200)
    assert simulation.intact().tolist() == [False, True, False]
    return simulation


def test_cracks_stand_across_what_was_bonded_and_where_gaps_show_there_is_none(parted):
    axes = new_figure(7.7, 4.0).add_subplot()
    axes.set_xlim(-0.2, 1.2)
    handles = particles.draw_cracks(axes, parted)
    drawn = [line for lines in axes.collections for line in lines.get_segments()]
    assert len(drawn) == 1
    # midway between the surfaces: -0.02 + 0.1 and 0.2 - 0.1
    assert drawn[0][:, 0] == pytest.approx([0.09, 0.09], abs=2e-3)
    assert sorted(drawn[0][:, 1]) == pytest.approx([-0.065, 0.065], abs=1e-9)
    assert [handle.get_label() for handle in handles] == ["crack, tension (2)"]


def test_colours_mean_what_the_scale_says(parted):
    speed = particles.colour_particles(parted, "speed")
    fastest = np.abs(parted.velocities[:, 0])
    top = np.percentile(fastest, 99.5)
    assert speed.faces == pytest.approx(displacement_colours()(fastest / top))
    assert speed.more
    moved = particles.colour_particles(parted, "displacement")
    assert moved.label == "displacement [m]"
    assert moved.norm(0.2) == pytest.approx(1.0, abs=0.05)
    damaged = particles.colour_particles(parted, "damage")
    assert damaged.norm.vmax == 1.0
    # both bonds of disc 2: one broke, one holds; the only bond of the first and of the last broke
    assert (damaged.faces[0] == damaged.faces[3]).all()
    assert (damaged.faces[1] == damaged.faces[2]).all()
    assert damaged.faces[1, :3].sum() > damaged.faces[0, :3].sum()
    with pytest.raises(InputError, match=r"no such colouring.*'damage'"):
        particles.colour_particles(parted, "pressure")


def test_at_rest_nothing_is_beyond_the_scale():
    still = particles.colour_particles(row((0.0, 0.0, 0.0, 0.0)), "speed")
    assert not still.more
    assert len(np.unique(still.faces, axis=0)) == 1


def share_of(colour, image, tolerance=3):
    wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])
    return (np.abs(image.astype(int) - wanted).max(axis=2) <= tolerance).mean()


def test_a_picture_of_discs(parted, tmp_path):
    data = particles.write_particle_picture(tmp_path / "row.png", parted)
    assert (tmp_path / "row.png").read_bytes() == data
    image = np.asarray(Image.open(io.BytesIO(data)).convert("RGB"))
    soil, rock = share_of(MATERIALS[0], image), share_of(MATERIALS[1], image)
    # three discs of one and one of the other, and their patches in the legend
    assert 2.0 < soil / rock < 3.5
    assert share_of(particles.TENSION, image, 40) > 1e-4
    without = particles.write_particle_picture(tmp_path / "without.png", parted, cracks=False)
    image = np.asarray(Image.open(io.BytesIO(without)).convert("RGB"))
    assert share_of(particles.TENSION, image, 40) == 0.0
    again = particles.write_particle_picture(tmp_path / "again.png", parted)
    assert again == data


def test_the_walls_are_within_the_picture(parted):
    figure = particles.particle_figure(parted)
    axes = figure.axes[0]
    assert axes.get_ylim()[0] < -0.2
    assert axes.get_xlim()[1] > 1.0
    assert axes.get_title() == "0.02 s"
    assert axes.get_title(loc="right") == "4 discs, 2 of 3 bonds broken"


@pytest.mark.parametrize("many", [False, True])
def test_a_picture_of_spheres(many, tmp_path, monkeypatch):
    """Red-brown soil to the left and blue rock to the right of who looks along y; a plate below, no wall before."""
    pytest.importorskip("pyvista")
    if many:
        monkeypatch.setattr("geodem.plotting.spheres.DETAIL", {})
    builder = AssemblyBuilder(3)
    for name in ("soil", "rock"):
        builder.add_material(name, density=2000.0, contact=CONTACT)
    builder.add_particles([(-0.3, 0.0, 0.2)], 0.2, "soil")
    builder.add_particles([(0.3, 0.0, 0.2)], 0.2, "rock")
    builder.add_wall(triangles("plate", [[(-1, -1, -0.1), (1, -1, -0.1), (0, 1, -0.1)]]))
    builder.add_wall(plane("front", (0.0, -0.3, 0.0), (0.0, 1.0, 0.0)))
    simulation = ParticleSimulation(builder.build(), time_step=1e-4)
    picture = particles.write_particle_picture(tmp_path / "two.png", simulation, view=(-90.0, 15.0))
    image = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(float)
    warm = image[:, :, 0] - image[:, :, 2]
    columns = np.arange(warm.shape[1])
    left = np.average(columns, weights=(warm > 20).sum(axis=0))
    right = np.average(columns, weights=(warm < -20).sum(axis=0))
    assert left < 0.45 * len(columns)
    assert right > 0.55 * len(columns)


def test_spheres_without_pyvista(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    builder = AssemblyBuilder(3)
    builder.add_material("soil", density=2000.0, contact=CONTACT)
    builder.add_particles([(0.0, 0.0, 0.0)], 0.2, "soil")
    simulation = ParticleSimulation(builder.build(), time_step=1e-4)
    with pytest.raises(InputError, match=r"pip install 'geodem\[pictures\]'"):
        particles.write_particle_picture(tmp_path / "one.png", simulation)
    assert not list(tmp_path.iterdir())


def test_nobody_pays_for_pictures_that_are_not_drawn():
    code = "import geodem.plotting.particles, sys; print({'matplotlib', 'pyvista', 'vtkmodules'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
