"""Ways to equilibrium: the direct sparse solve of the elastic state, and the masses of adaptive relaxation."""
