"""Loops without physics, composed with the law and the features of a scene."""
