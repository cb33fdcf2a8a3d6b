"""How far the sides are pressed in the test that gives the friction angle."""

CONFINED = 0.5
"""Of the compressive strength: up to there Hoek & Brown (1980) fit the strengths of rock."""

LOW = 0.1
"""Of the compressive strength: where friction is measured besides, because rock is steeper at low confinement."""
