"""Neighbour search: which particles are near enough to touch, and the order in which they are stored."""

from .bonds import bond_pairs
from .halo import Halo, find_halo
from .images import Lattice, lattice, make_copies, wrapped
from .order import spatial_order
from .pair_list import PairList
from .search import rebuild
from .trigger import max_displacement

__all__ = [
    "Halo",
    "Lattice",
    "PairList",
    "bond_pairs",
    "find_halo",
    "lattice",
    "make_copies",
    "max_displacement",
    "rebuild",
    "spatial_order",
    "wrapped",
]
