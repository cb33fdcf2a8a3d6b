"""Neighbour search: which particles are near enough to touch, and the order in which they are stored."""

from .bonds import bond_pairs
from .halo import Halo, find_halo
from .order import spatial_order
from .pair_list import PairList
from .search import rebuild
from .trigger import max_displacement

__all__ = ["Halo", "PairList", "bond_pairs", "find_halo", "max_displacement", "rebuild", "spatial_order"]
