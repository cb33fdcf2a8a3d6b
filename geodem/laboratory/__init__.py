"""The virtual laboratory: specimens of bonded particles, the tests of rock mechanics on them, and what they tell.

Stress and strain are positive in compression in everything that a test returns.
"""
