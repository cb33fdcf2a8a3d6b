"""Energy accounts close to 0.1 %: reference/problems/energy_account.py, with fewer steps."""

from __future__ import annotations

from reference.problems.energy_account import block, cell, closes, drum
from tests.verification.rows import check


def test_turning_drum():
    check(*closes("drum of discs", drum(), 20_000, breaks=False))


def test_discs_in_a_cell_that_deforms():
    check(*closes("discs in a periodic cell", cell(20_000), 20_000, breaks=False))


def test_block_of_bonded_discs_breaks():
    check(*closes("block of bonded discs", block(2, 30_000), 30_000, breaks=True))


def test_block_of_bonded_spheres_breaks():
    check(*closes("block of bonded spheres", block(3, 20_000), 20_000, breaks=True))
