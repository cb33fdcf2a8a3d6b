"""Particles of bodies: sizes and masses of the source, the same bits every time, and a file that keeps them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
import pytest

from geodem.builders.assembly_builder import AssemblyBuilder
from geodem.builders.body_filling import add_body
from geodem.builders.body_filling_file import load_filling, save_filling
from geodem.builders.fill_body import fill_body
from geodem.builders.grid_body import grid_body
from geodem.builders.packings import volumes
from geodem.builders.section_body import box_body
from geodem.errors import InputError

CONTACT = {"normal_stiffness": 1e7, "shear_stiffness": 5e6, "friction_coefficient": 0.5}
BOND = {
    "radius_factor": 1.0,
    "normal_stiffness": 1e9,
    "shear_stiffness": 5e8,
    "tensile_strength": 1e6,
    "shear_strength": 1e6,
}


@dataclass
class Ball:
    """A disc or ball of radius 1 m about (2, 2, 2) m, of two halves."""

    dimension: int
    materials: tuple[str, ...] = ("upper", "lower")
    surfaces: tuple = ()
    remarks: tuple[str, ...] = ("made for a test",)
    asked: list[int] = field(default_factory=list)

    @property
    def bounds(self):
        return np.array([[1.0] * self.dimension, [3.0] * self.dimension])

    @property
    def sizes(self):
        whole = math.pi if self.dimension == 2 else 4.0 / 3.0 * math.pi
        return np.array([0.5 * whole, 0.5 * whole])

    def material_at(self, points):
        self.asked.append(len(points))
        step = points - 2.0
        found = np.where(step[:, -1] > 0.0, 0, 1).astype(np.int32)
        found[(step**2).sum(axis=1) > 1.0] = -1
        return found


@dataclass
class Scattered(Ball):
    """The same in a box that reaches to a place far away."""

    @property
    def bounds(self):
        return np.array([[1.0] * self.dimension, [1e9] * self.dimension])


def test_sizes_that_are_mistaken_are_refused_before_anything_is_looked_for():
    with pytest.raises(InputError, match=r"1\.6e\+11 m by 16 m, far thinner than a particle of about 9\.2"):
        fill_body(box_body((16e10, 16.0), [("rock", 1.0)]), particles=300)
    for dimension in (2, 3):
        with pytest.raises(InputError, match=r"reaches over 1e.09 m by 1e.09 m.*and fills"):
            fill_body(Scattered(dimension), particles=300)


LATTICES = [(2, "square"), (2, "hexagonal"), (3, "simple_cubic"), (3, "bcc"), (3, "fcc"), (3, "hcp")]


@pytest.mark.parametrize(("dimension", "arrangement"), [*LATTICES, (2, "random"), (3, "random")])
def test_a_ball_of_two_halves_is_represented_and_weighs_what_it_should(dimension, arrangement):
    filling = fill_body(Ball(dimension), arrangement=arrangement, particles=20_000)
    whole = math.pi if dimension == 2 else 4.0 / 3.0 * math.pi
    assert filling.particles == pytest.approx(20_000, rel=0.005)
    assert set(filling.material) == {0, 1}
    assert (np.linalg.norm(filling.positions - 2.0, axis=1) <= 1.0).all()
    mass = filling.density({"upper": 1000.0, "lower": 3000.0}) * volumes(filling.radii, dimension)
    for number, density in enumerate((1000.0, 3000.0)):
        assert filling.shares[number].represented == pytest.approx(0.5 * whole, rel=0.005)
        assert mass[filling.material == number].sum() == pytest.approx(0.5 * whole * density, rel=1e-12)
    assert "made for a test" in filling.remarks


@pytest.mark.parametrize(("dimension", "arrangement"), LATTICES)
def test_particles_of_a_lattice_touch_their_neighbours(dimension, arrangement):
    """Coordination of the whole lattice, e.g. Conway & Sloane, less what the boundary lacks."""
    neighbours = {"square": 4, "hexagonal": 6, "simple_cubic": 6, "bcc": 8, "fcc": 12, "hcp": 12}[arrangement]
    found = fill_body(Ball(dimension), arrangement=arrangement, particles=20_000).contacts()
    assert 0.9 * neighbours < found.coordination < neighbours
    assert found.largest_overlap < 1e-9
    assert found.loose == 0


def test_a_random_arrangement_is_dense_and_free_of_overlap():
    filling = fill_body(Ball(2), particles=5000, size_ratio=2.0)
    assert filling.solid_fraction == pytest.approx(0.83, abs=0.001)
    assert filling.radii.max() / filling.radii.min() == pytest.approx(2.0, rel=0.01)
    # also where copies of the periodic packing meet
    assert filling.contacts(1.05).largest_overlap == 0.0
    assert filling.contacts(1.05).coordination > 3.5


def test_a_grading_gives_its_sizes():
    filling = fill_body(Ball(2), grading=[(0.01, 0.0), (0.02, 0.5), (0.03, 1.0)])
    assert 0.01 <= filling.radii.min() < 0.0101
    assert 0.0299 < filling.radii.max() <= 0.03 + 1e-12
    area = volumes(filling.radii, 2)
    assert area[filling.radii < 0.02].sum() / area.sum() == pytest.approx(0.5, abs=0.03)


def test_the_same_call_gives_the_same_bits_and_another_seed_other_ones():
    one, two = (fill_body(Ball(2), radius=0.03, seed=3) for _ in range(2))
    other = fill_body(Ball(2), radius=0.03, seed=4)
    assert one.positions.tobytes() == two.positions.tobytes()
    assert one.radii.tobytes() == two.radii.tobytes()
    assert one.positions.tobytes() != other.positions.tobytes()


def test_the_arrangement_is_moved_until_sizes_agree():
    fixed = fill_body(Ball(2), arrangement="hexagonal", radius=0.06, shifts=1)
    moved = fill_body(Ball(2), arrangement="hexagonal", radius=0.06, shifts=64)

    def worst(filling):
        return max(abs(share.difference) for share in filling.shares)

    assert worst(moved) < 0.5 * worst(fixed)
    # one of the 126 particles of a half is 0.8 %
    assert worst(moved) < 0.008


def test_thin_layers_few_particles_and_differences_are_remarked():
    labels = np.zeros((100, 100), dtype=int)
    labels[:, 50:54] = 1
    labels[10:16, 10:16] = 2
    body = grid_body(labels, ["soil", "seam", "stone"], 0.01)
    remarks = fill_body(body, radius=0.01, arrangement="hexagonal").remarks
    thin = [remark for remark in remarks if remark.startswith("seam is about 2.")]
    assert len(thin) == 1
    assert any(remark.startswith("stone has only") for remark in remarks)
    assert not any(remark.startswith("soil is about") for remark in remarks)
    # 9 rows for 0.04 m, of which each stands for 4.33 mm
    (rows,) = [r for r in fill_body(body, radius=0.0025, arrangement="hexagonal").remarks if "seam" in r]
    assert rows.startswith("The particles of seam stand for -2.57 %")
    assert not [r for r in fill_body(body, radius=0.0025).remarks if "seam" in r or "soil" in r]


def test_a_body_of_pixels_gets_one_particle_in_each():
    labels = np.array([[0, 0, -1], [1, 0, 0]])
    filling = fill_body(grid_body(labels, ["soil", "rock"], 0.5, origin=(1.0, 2.0)), arrangement="pixel")
    order = np.lexsort(filling.positions.T[::-1])
    expected = [(1.25, 2.25), (1.25, 2.75), (1.75, 2.25), (1.75, 2.75), (1.75, 3.25)]
    assert filling.positions[order] == pytest.approx(np.array(expected), abs=1e-12)
    assert filling.material[order].tolist() == [0, 0, 1, 0, 0]
    assert (filling.radii == 0.25).all()
    assert filling.shares[0].represented == pytest.approx(1.0, rel=1e-12)


def test_the_summary_names_materials_sizes_and_differences():
    filling = fill_body(Ball(2), arrangement="square", particles=300)
    head, upper, lower = filling.summary().splitlines()
    assert head.split("  ")[0] == "material"
    assert "mass difference [%]" in head
    assert upper.split() == ["upper", "150", "1.5708", "1.5708", "+0.000", "+0.000"]
    assert lower.startswith("lower")


def test_an_assembly_has_the_masses_of_the_source_and_bonds_within_grains_apart():
    labels = np.zeros((20, 10), dtype=int)
    grains = np.repeat([0, 1], 10)[:, None].repeat(10, axis=1)
    filling = fill_body(grid_body(labels, ["rock"], 0.1, grains=grains), arrangement="pixel")
    build = AssemblyBuilder(2, bond_law="parallel_bond")
    build.add_material("rock", density=2600.0, contact=CONTACT, bond=BOND)
    added = add_body(build, filling, {"rock": 2600.0}, bond_factor=1.05, across=0.25)
    # a grid of 10 x 10 cells has 180 neighbours; ten pairs lie across the border
    assert len(added.bonds) == 360
    assert len(added.across) == 10
    assembly = build.build()
    assert assembly.mass.sum() == pytest.approx(2.0 * 2600.0, rel=1e-12)
    assert len(assembly.bonds) == 370
    assert sorted(set(assembly.bond_scale)) == [0.25, 1.0]
    apart = AssemblyBuilder(2, bond_law="parallel_bond")
    apart.add_material("rock", density=2600.0, contact=CONTACT, bond=BOND)
    assert len(add_body(apart, filling, {"rock": 2600.0}, bond_factor=1.05, across=0.0).across) == 0
    assert len(apart.build().bonds) == 360


def test_a_file_keeps_every_bit(tmp_path):
    filling = fill_body(Ball(3), radius=0.15, arrangement="fcc")
    loaded = load_filling(save_filling(filling, tmp_path / "ball.npz"))
    for name in ("positions", "radii", "material", "sources", "group"):
        assert getattr(loaded, name).tobytes() == getattr(filling, name).tobytes()
    assert (loaded.materials, loaded.arrangement, loaded.remarks) == (
        filling.materials, filling.arrangement, filling.remarks,
    )  # fmt: skip
    assert loaded.summary() == filling.summary()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ball.npz"]


def test_a_file_of_another_kind_version_or_content_is_refused(tmp_path):
    path = save_filling(fill_body(Ball(2), radius=0.2, arrangement="square"), tmp_path / "disc.npz")
    held = dict(np.load(path))
    for change, problem in (
        ({"kind": np.array("else")}, "no filling"),
        ({"format": np.array(99)}, "format 99"),
        ({"material": held["material"] + 5}, "material does not fit"),
        ({"positions": held["positions"][:-1]}, "positions does not fit"),
        ({"radii": np.array([None], dtype=object)}, "damaged or another kind"),
        ({"format": np.zeros(3)}, "this version reads"),
        ({"materials": np.array("rock")}, "materials does not fit"),
        ({"solid_fraction": np.zeros(2)}, "solid_fraction does not fit"),
    ):
        np.savez(path, **{**held, **change})
        with pytest.raises(InputError, match=problem):
            load_filling(path)
    np.savez_compressed(path, **held)
    whole = path.read_bytes()
    # zlib has an error of its own, the archive another
    middle = len(whole) // 3
    for spoilt in (b"PK no archive", whole[:middle] + b"\xff" * 40 + whole[middle + 40 :], whole[:-20]):
        path.write_bytes(spoilt)
        with pytest.raises(InputError, match="damaged"):
            load_filling(path)
    with pytest.raises(InputError, match="no such file"):
        load_filling(tmp_path / "absent.npz")


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"arrangement": "cubic", "radius": 0.1}, "no such arrangement in 2D"),
        ({}, "one of radius, particles and grading"),
        ({"radius": 0.1, "particles": 10}, "one of radius, particles and grading"),
        ({"radius": -0.1}, "not a positive number"),
        ({"particles": 0}, "not a whole number"),
        ({"particles": 100, "shifts": 0}, "not a whole number"),
        ({"arrangement": "pixel"}, "not made of pixels"),
        ({"arrangement": "square", "grading": [(0.1, 0.0), (0.2, 1.0)]}, "equal particles"),
        ({"grading": [(0.1, 0.0), (-0.2, 1.0)]}, "not pairs of a positive radius"),
        ({"grading": [0.1, 0.2]}, "not pairs of a positive radius"),
        ({"radius": 1e-7}, "GB are free"),
        ({"arrangement": "square", "radius": 5.0}, "gets no particle"),
    ],
)
def test_what_cannot_be_filled_is_refused(options, problem):
    with pytest.raises(InputError, match=problem):
        fill_body(Ball(2), **options)


def test_densities_and_dimensions_that_do_not_fit_are_refused():
    filling = fill_body(Ball(2), radius=0.2, arrangement="square")
    with pytest.raises(InputError, match="density of 'lower'"):
        filling.density({"upper": 1000.0})
    with pytest.raises(InputError, match="the assembly is 3D"):
        add_body(AssemblyBuilder(3), filling, {"upper": 1.0, "lower": 1.0})
