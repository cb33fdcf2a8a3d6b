"""Walls: how they are made and checked, the tables the loops read, and the search for particles near them."""
