"""Comparisons of geodem with other codes, each posed once: `python -m reference compare NAME`."""
