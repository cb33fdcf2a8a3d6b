"""Independent answers that geodem is checked against: other methods, other codes, published problems.

This package may import geodem; geodem never imports it.
"""
