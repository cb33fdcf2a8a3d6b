"""Constitutive laws of ground that yields (stress-carrying particles)."""
