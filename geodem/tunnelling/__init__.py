"""Tunnels in ground that yields: excavation in stages, supports, convergence. SI units, no text."""
