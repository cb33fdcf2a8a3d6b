"""Neighbour search: which particles are near enough to touch, and the order in which they are stored."""

from .bonds import bond_pairs
from .order import spatial_order
from .pair_list import PairList
from .search import rebuild
from .trigger import max_displacement

__all__ = ["PairList", "bond_pairs", "max_displacement", "rebuild", "spatial_order"]
