"""Geometry of the ground: from polygons and pictures to particles."""
