"""From a rock's properties to the parameters of its bonds: targets, the measured map between the two, and its inverse.

Stress is positive in compression, strengths are positive, angles are in radians.
"""
