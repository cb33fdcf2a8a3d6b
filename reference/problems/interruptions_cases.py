"""Cases of every kind, so small that a run takes seconds: for runs that are interrupted or have no room."""

from __future__ import annotations

from . import fuzzing_files

SLOPE = """\
workflow = "slope"
title = "Small slope"
particles = 1650
methods = ["strength-reduction", "gravity-increase"]
tolerance = 0.05
seed = 3

[section]
regions = [{material = "soil", polygon = [[0,0],[40,0],[40,15],[25,15],[10,5],[0,5]]}]

[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
""" + fuzzing_files.SOIL.replace("{name}", "soil")
"""Coarse model, particles placed anew where it failed, both methods, the search without dilation."""

GROUND = """\
workflow = "ground"
title = "Bank"

[source]
image = "section.png"
scale = "0.5 m/px"
legend = {"#8c6d31" = "soil", "#d62728" = "seam"}

[particles]
particles = 300

[material.soil]
density = "1900 kg/m3"

[material.seam]
density = "2100 kg/m3"
"""
ROCK = """
[material{name}]
law = "rock"
density = "2630 kg/m3"
effective_modulus = "{modulus}"
stiffness_ratio = 2.5
tensile_strength = "{tension}"
shear_strength = "{shear}"
friction_coefficient = 0.7
"""
LABORATORY = (
    """\
workflow = "laboratory"
title = "Small granite"
seeds = 6

[specimen]
across = 10
"""
    + ROCK.format(name="", modulus="80 GPa", tension="15 MPa", shear="60 MPa")
    + """
[[test]]
kind = "direct-tension"
"""
)
TUNNEL = """\
workflow = "tunnel"
title = "Small tunnel"
particles = 500
wall_spacing = "0.7 m"
increments = 4
section.regions = [{material = "clay", polygon = [[-15, -10], [15, -10], [15, 12], [-15, 12]]}]
boundary = {left = "roller", right = "roller", bottom = "fixed"}
initial_stress.k0 = 0.7
excavation = [{name = "tunnel", circle = {centre = [0, 0], diameter = "4 m"}}]
stage = [{excavate = "tunnel", relax = 0.5}, {install = "shell"}, {relax = 1.0}]
lining = [{name = "shell", thickness = "20 cm", young_modulus = "15 GPa"}]
stability = {methods = ["strength-reduction"], tolerance = 0.1}

[material.clay]
law = "mohr_coulomb"
unit_weight = "20 kN/m3"
cohesion = "60 kPa"
friction_angle = "20 deg"
dilation_angle = "20 deg"
young_modulus = "50 MPa"
poisson_ratio = 0.3
tensile_strength = "none"
"""
"""Stages with a lining, the ground without it, a factor."""

BREAKING = (
    """\
workflow = "breaking"
title = "Small overhang"

[source]
regions = [{material = "rock", polygon = [[0, 0], [16, 0], [16, 2], [5, 2], [5, 8], [13, 8], [13, 11], [0, 11]]}]

[particles]
particles = 200
arrangement = "hexagonal"

[boundary]
left = "wall"
right = "wall"
bottom = "wall"
"""
    + ROCK.format(name=".rock", modulus="1 GPa", tension="5 MPa", shear="15 MPa")
    + """
[[stage]]
kind = "settle"
rest = 1e-3

[[stage]]
kind = "gravity-increase"
tolerance = 0.3
rest = 1e-3

[[stage]]
kind = "excavate"
name = "undercut"
polygon = [[3, 2.5], [6, 2.5], [6, 5], [3, 5]]
shares = 2
come_to_rest = false

[[stage]]
kind = "run"
name = "fall"
time = "0.3 s"
frames_every = "0.1 s"
"""
)
"""Settled, loaded until it breaks off, undercut, left to fall with frames on the way."""

CUTTING = """\
workflow = "cutting"
title = "Small cut"
frames = 5

[source]
box = ["24 mm", "15 mm"]

[particles]
radius = "0.8 mm"
size_ratio = 1.66

[boundary]
left = "fixed"
right = "fixed"
bottom = "fixed"

[loads]
gravity = "9.81 m/s2"

[tool]
rake = "15 deg"
clearance = "10 deg"
friction_angle = "20 deg"
depth = "4 mm"
speed = "8 m/s"
distance = "1.2 mm"
entry = "0.3 mm"
ramp = "0.2 mm"
""" + ROCK.format(name=".sandstone", modulus="6.8 GPa", tension="4 MPa", shear="10 MPa")
RUNOUT = """\
workflow = "runout"
title = "Small run-out"
particles = 250
tolerance = 0.1
seed = 3

[section]
regions = [{material = "silt", polygon = [[0,0],[24,0],[24,4],[16,4],[8,12],[0,12]]}]

[boundary]
left = "roller"
right = "roller"
bottom = "fixed"

[runout]
start = "failing"
discs = 120
beyond = "12 m"
residual_friction_angle = "16 deg"

[material.silt]
law = "mohr_coulomb"
density = "1900 kg/m3"
cohesion = "2 kPa"
friction_angle = "25 deg"
dilation_angle = "25 deg"
young_modulus = "20 MPa"
poisson_ratio = 0.3
"""
BANK = (
    SLOPE.replace("particles = 1650", "particles = 250")
    .replace(', "gravity-increase"', "")
    .replace('friction_angle = "20 deg"', 'friction_angle = "20 deg"\ndilation_angle = "20 deg"')
)
SWEEP = """\
workflow = "sweep"
title = "Small sweep"
case = "bank.toml"
processes = 2

[vary]
"material.soil.cohesion" = ["10 kPa", "20 kPa", "30 kPa"]
"""
"""Three of `BANK`, two at a time."""
