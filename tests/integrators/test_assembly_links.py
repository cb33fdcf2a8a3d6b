"""Links of a small assembly: the right pair of materials, bonds beside contacts, walls."""

from __future__ import annotations

import numpy as np

from geodem.assembly import Assembly, Wall
from geodem.integrators.assembly_links import bond_links, contact_links, wall_links
from geodem.integrators.network import RIGID
from geodem.laws.bond import parallel_bond
from geodem.laws.contact import linear_frictional
from geodem.laws.protocol import make_parameters, parameter_table, wall_table


def scene():
    """Three discs in a row, materials soft, hard, hard; the last two bonded; a floor under all."""
    law = linear_frictional
    materials = [
        make_parameters(
            law, {"normal_stiffness": kn, "shear_stiffness": 0.5 * kn, "friction_coefficient": 0.3}, ""
        )
        for kn in (1.0, 3.0)
    ]
    cement = parallel_bond.ParallelBondParameters(1.0, 10.0, 5.0, 1.0, 1.0)
    positions = np.array([[0.0, 0.0], [1.9, 0.0], [3.8, 0.0]])
    walls = wall_table(law, materials)
    floor = Wall(
        "floor",
        np.array([[[0.0, -0.95], [0.0, 1.0]]]),
        np.zeros((0, 2, 2)),
        np.zeros((0, 3, 3)),
        np.zeros(2),
        np.zeros(1),
        np.zeros(2),
        {"soft": walls[0], "hard": walls[1]},
    )
    return Assembly(
        2,
        positions,
        np.ones(3),
        np.ones(3),
        0.5 * np.ones(3),
        np.zeros((3, 2)),
        np.zeros((3, 1)),
        np.array([0, 1, 1], dtype=np.int32),
        ("soft", "hard"),
        law.NAME,
        parameter_table(law, materials).reshape(4, -1),
        parallel_bond.NAME,
        np.tile(cement, (4, 1)),
        np.array([[1, 2]], dtype=np.int32),
        np.ones(1),
        np.zeros((3, 3), dtype=bool),
        np.zeros((3, 3)),
        np.array([0.0, -9.81]),
        None,
        (floor,),
    )


def test_contacts_take_the_parameters_of_their_two_materials():
    """Two springs in series: 2 k1 k2/(k1 + k2)."""
    assembly = scene()
    found = contact_links(assembly, assembly.positions, [(0, 1), (1, 2)])
    np.testing.assert_allclose(found.kn, [2.0 * 3.0 / 4.0, 3.0])
    np.testing.assert_allclose(found.ks, [0.75, 1.5])
    np.testing.assert_allclose(found.arms, 0.95)
    np.testing.assert_allclose(found.normal, [[1.0, 0.0], [1.0, 0.0]])


def test_bonds():
    """A strip of 2 m: kn A = 20, ks A = 10, kn I = 10 * 2/3."""
    assembly = scene()
    found = bond_links(assembly, assembly.positions)
    np.testing.assert_allclose(found.kn, [20.0])
    np.testing.assert_allclose(found.ks, [10.0])
    np.testing.assert_allclose(found.k_bend, [20.0 / 3.0])
    assert len(bond_links(assembly, assembly.positions, [False]).first) == 0


def test_walls_are_twice_as_stiff():
    assembly = scene()
    down = np.tile([0.0, -1.0], (2, 1))
    found = wall_links(assembly, [0, 2], [0, 0], down, np.full(2, 0.05))
    np.testing.assert_allclose(found.kn, [2.0, 6.0])
    np.testing.assert_allclose(found.arms[:, 0], 0.95)
    assert (found.second == RIGID).all()
