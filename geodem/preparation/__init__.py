"""Granular samples made ready for a test: deposited under gravity, grown, or compacted in a periodic cell.

Particles without overlap to begin with come from `geodem.builders.random_addition`.
"""

from .compaction import compact
from .deposition import deposit
from .grains import Grains
from .growth import grow_radii
from .sample import PreparedSample

__all__ = ["Grains", "PreparedSample", "compact", "deposit", "grow_radii"]
