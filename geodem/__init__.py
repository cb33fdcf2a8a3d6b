"""geodem: factor of safety and failure of the ground by particle models."""

__version__ = "0.1.0"
