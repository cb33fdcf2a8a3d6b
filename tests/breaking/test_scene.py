"""Bonded ground from a body: bonds, what holds between materials, supports, initial stress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from geodem.breaking.materials import Interface, LooseMaterial
from geodem.breaking.scene import build_scene, start
from geodem.errors import InputError
from geodem.laboratory.material import BondedMaterial
from geodem.preparation.initial_stress import far_field
from tests.breaking.scenes import ROCK, lattice, random_ground

LAYERS = [("rock", 3.0), ("seam", 3.0)]
SOFT = replace(
    ROCK, density=2000.0, bond={**ROCK.bond, "effective_modulus": 5e8, "tensile_strength": 1e6},
    contact={**ROCK.contact, "effective_modulus": 5e8},
)  # fmt: skip


def test_a_square_lattice_has_the_bonds_of_its_neighbours():
    """w columns and h rows: h (w - 1) + w (h - 1) pairs; three rows each side of the plane between two materials."""
    body, filling = lattice(8, 6, LAYERS)
    scene = build_scene(body, filling, {"rock": ROCK, "seam": SOFT})
    counts = {pair: found.bonds for pair, found in scene.bonds.items()}
    assert counts == {("rock", "rock"): 3 * 7 + 2 * 8, ("rock", "seam"): 8, ("seam", "seam"): 3 * 7 + 2 * 8}
    assert len(scene.loose) == 0
    assert float(scene.assembly.mass.sum()) == pytest.approx(2600.0 * 24.0 + 2000.0 * 24.0)
    assert len(scene.material_ids("seam")) == 24


def test_between_two_materials_springs_are_in_series_and_the_lower_strength_holds():
    body, filling = lattice(8, 6, LAYERS)
    a = build_scene(body, filling, {"rock": ROCK, "seam": SOFT}).assembly
    names = a.material_names
    row = a.bond_table[names.index("rock") * len(names) + names.index("seam")]
    # effective_modulus first; two halves in series: 2 k1 k2 / (k1 + k2)
    assert row[0] == pytest.approx(2.0 * 1e9 * 5e8 / 1.5e9)
    fields = list(ROCK.bond)
    assert fields[2] == "tensile_strength"
    assert row[2] == 1e6


def test_an_interface_replaces_the_rule():
    body, filling = lattice(8, 6, LAYERS)
    materials = {"rock": ROCK, "seam": SOFT}
    cut = build_scene(body, filling, materials, interfaces=[Interface("seam", "rock", bonded=False)])
    assert cut.bonds[("rock", "seam")] == (0, 8)
    weak = build_scene(
        body, filling, materials, interfaces=[Interface("rock", "seam", strength=0.25)]
    ).assembly
    kinds = weak.material[weak.bonds]
    across = kinds[:, 0] != kinds[:, 1]
    assert set(weak.bond_scale[across]) == {0.25}
    assert set(weak.bond_scale[~across]) == {1.0}


def test_strength_scatters_by_seed():
    body, filling = lattice(40, 30)
    material = replace(ROCK, variation=0.3)
    one, other, again = (build_scene(body, filling, {"rock": material}, seed=n).assembly for n in (1, 2, 1))
    assert np.array_equal(one.bond_scale, again.bond_scale)
    assert not np.array_equal(one.bond_scale, other.bond_scale)
    # mean 1, coefficient of variation 0.3: of 2330 bonds, within four standard errors
    assert one.bond_scale.mean() == pytest.approx(1.0, abs=4 * 0.3 / np.sqrt(2330))
    assert one.bond_scale.std() == pytest.approx(0.3, abs=0.03)


def test_loose_material_is_not_bonded():
    body, filling = lattice(8, 6, LAYERS)
    grains = LooseMaterial(1800.0, ROCK.contact)
    scene = build_scene(body, filling, {"rock": ROCK, "seam": grains})
    assert scene.bonds[("seam", "seam")].bonds == 0
    assert scene.bonds[("rock", "seam")].bonds == 0
    assert scene.bonds[("rock", "rock")].bonds == 37
    both = build_scene(body, filling, {"rock": grains, "seam": grains})
    assert both.assembly.bond_law is None


def test_numbers_per_contact_as_in_tables_of_dice2d():
    numbers = {
        "normal_stiffness": 1e9, "shear_stiffness": 4e8, "tensile_strength": 1e5, "cohesion": 2e5,
        "friction_coefficient": 0.4, "width_ratio": 0.5,
    }  # fmt: skip
    contact = {"normal_stiffness": 1e9, "shear_stiffness": 4e8, "friction_coefficient": 0.4}
    material = BondedMaterial(
        2500.0, numbers, contact, bond_law="two_springs", contact_law="linear_frictional"
    )
    body, filling = lattice()
    a = build_scene(body, filling, {"rock": material}).assembly
    assert a.bond_law == "two_springs"
    assert a.bond_table[0, :6].tolist() == list(numbers.values())


def test_sides_are_held_as_asked():
    scene = random_ground(supports={"left": "roller", "bottom": "fixed", "top": "wall", "right": "rough"})
    a = scene.assembly
    left, bottom = scene.held["left"], scene.held["bottom"]
    only = np.setdiff1d(left, bottom)
    assert a.held[only].tolist() == [[True, False, False]] * len(only)
    assert a.held[bottom].all()
    assert a.positions[left, 0].max() <= 2.0 * scene.filling.radii.mean()
    assert scene.walls == ("top", "right")
    smooth, rough = a.walls
    assert smooth.contact["rock"].friction_coefficient == 0.0
    assert rough.contact["rock"].friction_coefficient == 0.5
    assert smooth.planes[0, 0, 1] == pytest.approx((a.positions[:, 1] + a.radii).max())
    assert any("touch its wall" in words for words in scene.warnings)


def test_initial_stress_is_brought_about():
    wanted = np.diag([-2e6, -1e6])
    simulation, found = start(random_ground(1200, initial_stress=far_field(wanted)), applied=True)
    assert found is not None
    assert found.reached
    assert found.measured[0] == pytest.approx(wanted, abs=2e4)
    assert simulation.intact().all()


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"supports": {"up": "wall"}}, "no such side"),
        ({"supports": {"left": "glue"}}, "no such support"),
        (
            {"supports": {"bottom": "wall"}, "initial_stress": far_field(np.diag([-1.0, -1.0]))},
            "nothing holds",
        ),
        ({"initial_stress": far_field([[-2.0, 1.0], [1.0, -2.0]])}, "no shear stress"),
        ({"interfaces": [Interface("rock", "clay")]}, "no such material"),
        ({"interfaces": [Interface("rock", "rock"), Interface("rock", "rock")]}, "twice"),
        ({"across": -1.0}, "number from 0"),
    ],
)
def test_what_cannot_be_is_refused(options, match):
    with pytest.raises(InputError, match=match):
        random_ground(**options)


def test_one_law_for_all():
    body, filling = lattice(8, 6, LAYERS)
    other = LooseMaterial(
        2000.0,
        {"normal_stiffness": 1e8, "shear_stiffness": 1e8, "friction_coefficient": 0.5},
        "linear_frictional",
    )
    with pytest.raises(InputError, match="one for all"):
        build_scene(body, filling, {"rock": ROCK, "seam": other})
    with pytest.raises(InputError, match="missing"):
        build_scene(body, filling, {"rock": ROCK})
