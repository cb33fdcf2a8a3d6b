"""Ground from meshes against closed forms; longer runs: reference/problems/ground_meshes.py."""

from __future__ import annotations

from reference.problems.ground_meshes import section, step_volume, stl_body
from reference.problems.ground_meshes_hole import hole
from tests.verification.rows import check


def test_section_of_three_materials(tmp_path):
    """Areas of the polygons that were drawn, and masses, within 0.5 %, from .msh 2 and 4."""
    check(*section(tmp_path))


def test_volume_of_a_step_file(tmp_path):
    """A block less a cylinder, in millimetres: volume and mass within 0.5 %."""
    check(*step_volume(tmp_path))


def test_body_of_an_stl_file(tmp_path):
    """Volume by qhull, and mass, within 0.5 %."""
    check(*stl_body(tmp_path))


def test_hole_on_the_nodes_of_a_graded_mesh_and_filled_in(tmp_path):
    """Kirsch 1898: within 3 % from 1.25 a on, within 10 % at the wall."""
    check(*hole(tmp_path))
