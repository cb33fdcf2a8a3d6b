"""Measures of a state: energy, displacement, slip surface."""
