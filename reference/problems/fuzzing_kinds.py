"""Small good cases of every kind, which have between them every table that a case may have, for spoiling."""

from __future__ import annotations

from .fuzzing_files import SOIL

_ROCK = """
[material.{name}]
law = "rock"
density = "2500 kg/m3"
effective_modulus = "2 GPa"
stiffness_ratio = 2.5
tensile_strength = "0.4 MPa"
shear_strength = "1.2 MPa"
friction_coefficient = 0.6
bonding_range = 1.2
strength_variation = 0.1
"""

_SLOPE_SECTION = """
[section]
length_unit = "m"
regions = [
  {material = "soil", polygon = [[0, 0], [40, 0], [40, 15], [25, 15], [10, 5], [0, 5]]},
  {material = "seam", polygon = [[0, 2], [40, 2], [40, 3.5], [0, 3.5]]},
]
refine = [{box = [[8, 3], [14, 7]], spacing = "1.5 m"}]
layers = 2
thin = "refine"

[boundary]
left = "roller"
right = "roller"
bottom = "fixed"
top = "free"

[loads]
horizontal_acceleration = "0.05 g"
surcharge = [{from = [28, 15], to = [34, 15], pressure = "20 kPa"}]
"""

_SOILS = SOIL.replace("{name}", "soil") + SOIL.replace("{name}", "seam") + 'dilation_angle = "10 deg"\n'

SLOPE = f"""\
workflow = "slope"
title = "Slope"
particles = 450
packing = "random"
methods = ["strength-reduction", "gravity-increase"]
tolerance = 0.05
seed = 2
allow_implausible = []
{_SLOPE_SECTION}
[reference]
factor = 1.3
source = "somebody, 1990"
{_SOILS}tensile_strength = "5 kPa"
"""

RUNOUT = f"""\
workflow = "runout"
title = "Run-out"
particles = 450
seed = 2
{_SLOPE_SECTION}
[runout]
mass = "failing"
start = "failing"
discs = 150
beyond = "30 m"
restitution = 0.4
residual_friction_angle = {{soil = "25 deg", seam = "15 deg"}}
{_SOILS}"""

_TUNNEL_HEAD = """\
workflow = "tunnel"
title = "Tunnel"
particles = 950
wall_spacing = "0.7 m"
seed = 1
increments = 6
ground_reaction = true

[section]
regions = [
  {material = "marl", polygon = [[-20, -15], [20, -15], [20, 15], [-20, 15]]},
  {material = "clay", polygon = [[-20, 11], [20, 11], [20, 15], [-20, 15]]},
]
"""
_TUNNEL_TAIL = SOIL.replace("{name}", "marl") + SOIL.replace("{name}", "clay")

TUNNEL = (
    _TUNNEL_HEAD
    + """
[boundary]
left = "roller"
right = "roller"
bottom = "fixed"

[loads]
surcharge = [{from = [-5, 15], to = [5, 15], pressure = "10 kPa"}]

[initial_stress]
k0 = 0.7

[[excavation]]
name = "heading"
horseshoe = {floor = [0, 0], width = "6 m", height = "5 m"}

[[excavation]]
name = "bench"
polygon = [[6, -3], [9, -3], [9, 0], [6, 0]]

[[stage]]
name = "heading passes"
excavate = "heading"
relax = 0.4

[[stage]]
name = "support"
install = ["shell", "bolts", "anchors"]
relax = 0.8
excavation = "heading"

[[stage]]
excavate = ["bench"]
relax = 1.0
pressure = "5 kPa"

[[lining]]
name = "shell"
excavation = "heading"
thickness = "25 cm"
young_modulus = "15 GPa"
poisson_ratio = 0.2
compressive_strength = "30 MPa"
tensile_strength = "3 MPa"

[[bolt]]
name = "bolts"
excavation = "heading"
angles = ["45 deg", "90 deg", "135 deg"]
length = "3 m"
kind = "grouted"
diameter = "25 mm"
young_modulus = "200 GPa"
yield_force = "200 kN"
spacing = "1.5 m"
grout_stiffness = "1 GPa"
grout_strength = "200 kN/m"

[[bolt]]
name = "anchors"
bars = [[[-3, 1], [-7, 1]], [[3, 1], [7, 1]]]
kind = "anchored"
diameter = "25 mm"
yield_force = "200 kN"
spacing = "1.5 m"

[stability]
methods = ["strength-reduction", "load-increase", "gravity-increase"]
tolerance = 0.05
"""
    + _TUNNEL_TAIL
)

DEEP_TUNNEL = (
    _TUNNEL_HEAD.replace("particles = 950", 'spacing = "3 m"')
    + """
[boundary]
left = "far"
right = "far"
bottom = "far"
top = "far"

[initial_stress]
horizontal = "20 kPa"
vertical = "25 kPa"
shear = "1 kPa"

[[excavation]]
name = "tunnel"
circle = {centre = [0, 0], diameter = "6 m"}

[[stage]]
excavate = "tunnel"
install = "lining"
relax = 1.0

[[lining]]
thickness = "20 cm"
young_modulus = "15 GPa"
"""
    + _TUNNEL_TAIL
)

_STRUCTURES = """
[[interface]]
between = ["rock", "seam"]
bonds = "bonded"
strength = 0.5
contact = {friction_coefficient = 0.3}

[[joint]]
name = "crack"
points = [[10, 2], [14, 8]]
friction_angle = "30 deg"
normal_stiffness = "1 GPa/m"
shear_stiffness = "0.5 GPa/m"
cohesion = "10 kPa"
tensile_strength = "5 kPa"
residual_cohesion = "0 kPa"
dilation_angle = "5 deg"

[[joint]]
centre = [5, 2]
angle = "60 deg"
radius = "2 m"
friction_angle = "35 deg"
normal_stiffness = "1 GPa/m"

[[joint_set]]
name = "bedding"
angle = "10 deg"
spacing = "3 m"
trace = "5 m"
gap = "1 m"
origin = [10, 5]
seed = 3
angle_scatter = "3 deg"
spacing_scatter = 0.1
trace_scatter = 0.1
cohesion = "20 kPa"
tensile_strength = "20 kPa"
friction_angle = "30 deg"
normal_stiffness = "1 GPa/m"

[[fault]]
material = "gouge"
thickness = "1 m"
points = [[15, 0], [18, 10]]

[[bolt]]
name = "roof"
from = [11, 10]
to = [11, 6]
count = 3
step = [2, 0]
diameter = "25 mm"
young_modulus = "200 GPa"
yield_strength = "500 MPa"
elongation = 0.1
pretension = "10 kN"
density_per_length = "4 kg/m"
grout_stiffness = "100 MPa"
grout_strength = "200 kN/m"
plate = true
out_of_plane = "1.5 m"

[[bolt]]
from = [17, 10]
to = [17, 7]
axial_stiffness = "98 MN"
yield_force = "200 kN"
grout_stiffness = "100 MPa"

[[lining]]
name = "ring"
centre = [6, 7.6]
radius = "2 m"
thickness = "0.2 m"
young_modulus = "20 GPa"
density = "2500 kg/m3"

[[lining]]
points = [[0, 10.5], [3.5, 10.5]]
thickness = "0.2 m"
young_modulus = "20 GPa"
closed = false
"""

_STRESS = """
[initial_stress]
k0 = 0.6
unit_weight = "25 kN/m3"
surface = "12 m"
"""

_GROUND_SECTION = """
[source]
length_unit = "m"
regions = [
  {material = "rock", polygon = [[0, 0], [20, 0], [20, 10], [8.5, 10], [8.5, 5], [3.5, 5], [3.5, 10], [0, 10]]},
  {material = "seam", polygon = [[0, 2], [20, 3], [20, 5], [0, 4]]},
]

[particles]
particles = 300
size_ratio = 1.5
seed = 2

[boundary]
left = "roller"
right = "fixed"
bottom = "{bottom}"
top = "free"

[loads]
gravity = ["0 m/s2", "-9.81 m/s2"]
"""

_ROCKS = (
    _ROCK.replace("{name}", "rock")
    + '\n[material.rock.contact]\nlaw = "effective_modulus"\nfriction_coefficient = 0.5\n'
    + _ROCK.replace("{name}", "seam")
)
_GOUGE = _ROCK.replace("{name}", "gouge")

GROUND = (
    'workflow = "ground"\ntitle = "Bonded ground"\ngrain_bonds = 0.5\n'
    + _GROUND_SECTION.replace("{bottom}", "fixed")
    + _ROCKS
    + _GOUGE
    + _STRUCTURES
    + _STRESS
)

BREAKING = (
    'workflow = "breaking"\ntitle = "Breaking"\nseed = 2\n'
    + _GROUND_SECTION.replace("{bottom}", "rough")
    + _ROCKS
    + """
[motion]
damping = 0.5
time_step_factor = 0.4

[[point]]
name = "crest"
at = [10, 10]

[[wall]]
name = "tray"
points = [[-5, -1], [0, -2], [25, -2]]
friction = 0.4

[[stage]]
kind = "settle"
factor = 0.9
rest = 1e-3
patience = 0.5

[[stage]]
kind = "gravity"
factor = 1.1

[[stage]]
kind = "strength"
material = "seam"
factor = 1.2

[[stage]]
kind = "excavate"
name = "cut"
polygon = [[0, 6], [5, 6], [5, 10], [0, 10]]
shares = 4
come_to_rest = true

[[stage]]
kind = "excavate"
centre = [14, 5]
radius = "1.5 m"
material = ["rock", "seam"]

[[stage]]
kind = "gravity-increase"
start = 1.0
step = 0.4
tolerance = 0.2
highest = 50
failed_diameters = 2
moving_share = 0.01
goes_on = "stable"

[[stage]]
kind = "strength-reduction"
tolerance = 0.2
goes_on = "failed"

[[stage]]
kind = "move-wall"
wall = "tray"
velocity = ["0 m/s", "-0.1 m/s"]
time = "2 s"
frames_every = "1 s"

[[stage]]
kind = "remove-wall"
wall = "bottom"
from = [5, 0]
to = [8, 0]

[[stage]]
kind = "run"
name = "slide"
time = "1 s"
until_rest = true
frames_every = "0.5 s"
"""
)

REINFORCED = (
    'workflow = "breaking"\ntitle = "Reinforced"\ngrain_bonds = 0.8\n'
    + _GROUND_SECTION.replace("{bottom}", "fixed")
    + _ROCKS
    + _GOUGE
    + _STRUCTURES
    + '\n[[stage]]\nkind = "settle"\n\n[[stage]]\nkind = "strength-reduction"\ntolerance = 0.2\n'
)

BLOCK = (
    """\
workflow = "breaking"
title = "Block of spheres"

[source]
box = ["8 m", "6 m", "5 m"]
layers = [{material = "seam", thickness = "2 m"}, {material = "rock"}]
origin = ["0 m", "-1 m", "2 m"]

[particles]
radius = "0.6 m"

[boundary]
left = "roller"
right = "fixed"
front = "roller"
back = "fixed"
bottom = "fixed"
top = "free"

[[joint]]
centre = [4, 2, 4]
dip = "40 deg"
dip_direction = "120 deg"
radius = "3 m"
friction_angle = "30 deg"
normal_stiffness = "1 GPa/m"

[[joint_set]]
dip = "70 deg"
dip_direction = "200 deg"
spacing = "2.5 m"
trace = "3 m"
persistence = 0.8
friction_angle = "30 deg"
normal_stiffness = "1 GPa/m"

[[bolt]]
from = [4, 2, 7]
to = [4, 2, 3]
diameter = "25 mm"
grout_stiffness = "100 MPa"

[initial_stress]
x = "0.2 MPa"
y = "0.3 MPa"
z = "0.1 MPa"

[[stage]]
kind = "excavate"
centre = [4, 0, 4]
radius = "1 m"

[[stage]]
kind = "run"
time = "0.1 s"
"""
    + _ROCK.replace("{name}", "rock")
    + _ROCK.replace("{name}", "seam")
)

SPALLING = """\
workflow = "breaking"
title = "Hole under stress"

[source]
box = ["16 m", "16 m"]
origin = ["-8 m", "-8 m"]

[particles]
particles = 300

[boundary]
left = "fixed"
right = "fixed"
top = "fixed"

[loads]
gravity = "0 m/s2"

[initial_stress]
x = "120 kPa"
y = "45 kPa"
xy = "5 kPa"

[[stage]]
kind = "excavate"
centre = [0, 0]
radius = "2 m"
shares = 5
""" + _ROCK.replace("{name}", "rock")

GRAINS = """\
workflow = "breaking"
title = "Grains of a picture"

[source]
image = "section.png"
scale = "0.5 m/px"
legend = {"#8c6d31" = "soil", "#d62728" = "seam"}

[particles]
particles = 250

[boundary]
left = "wall"
right = "wall"
bottom = "wall"

[material.soil]
bonds = "none"
density = "1900 kg/m3"

[material.soil.contact]
law = "linear_rolling"
normal_stiffness = "100 MN/m"
shear_stiffness = "100 MN/m"
friction_coefficient = 0.5
rolling_friction = 0.3
twisting_friction = 0.0
normal_viscosity = "0 s"
shear_viscosity = "0 s"

[material.seam]
bonds = "none"
density = "1900 kg/m3"

[material.seam.contact]
law = "linear_rolling"
normal_stiffness = "50 MN/m"
shear_stiffness = "50 MN/m"
friction_coefficient = 0.3
rolling_friction = 0.3
twisting_friction = 0.0
normal_viscosity = "0 s"
shear_viscosity = "0 s"

[[stage]]
kind = "settle"

[[stage]]
kind = "remove-wall"
wall = "left"
"""

SPRINGS = """\
workflow = "ground"
title = "Springs as in tables"

[source]
box = ["12 m", "6 m"]

[particles]
arrangement = "hexagonal"
radius = "0.4 m"

[material.base]
law = "two_springs"
density = "2000 kg/m3"
normal_stiffness = "1000 MN/m"
shear_stiffness = "300 MN/m"
tensile_strength = "100 kN"
cohesion = "200 kN"
friction_coefficient = 0.6
width_ratio = 0.1
normal_viscosity = "0 s"
shear_viscosity = "0 s"

[material.base.contact]
law = "linear_frictional"
normal_stiffness = "1000 MN/m"
shear_stiffness = "300 MN/m"
friction_coefficient = 0.6

[loads]
gravity = "9.81 m/s2"
"""

CUTTING = """\
workflow = "cutting"
title = "Cut"
seed = 1
frames = 3
local_damping = 0.3

[source]
box = ["30 mm", "18 mm"]

[particles]
radius = "0.9 mm"
size_ratio = 1.66
seed = 1

[material.sandstone]
law = "rock"
density = "2000 kg/m3"
effective_modulus = "6.78 GPa"
stiffness_ratio = 2.73
tensile_strength = "3.97 MPa"
shear_strength = "9.56 MPa"
friction_coefficient = 0.436
bonding_range = 1.05

[boundary]
left = "fixed"
right = "fixed"
bottom = "fixed"
top = "free"

[loads]
gravity = "9.81 m/s2"

[tool]
rake = "15 deg"
clearance = "10 deg"
friction_angle = "20 deg"
wear_flat = "0.5 mm"
tip_radius = "0.2 mm"
depth = "4 mm"
speed = "8 m/s"
distance = "2 mm"
height = "12 mm"
ramp = "0.2 mm"
entry = "0.5 mm"
"""

LABORATORY = """\
workflow = "laboratory"
title = "Small granite"
seed = 3
seeds = 2

[specimen]
dimension = 2
packing = "random"
width = "50 mm"
height = "100 mm"
across = 10
size_ratio = 1.5

[material]
law = "rock"
density = "2630 kg/m3"
effective_modulus = "80 GPa"
stiffness_ratio = 2.5
tensile_strength = "15 MPa"
shear_strength = "60 MPa"
friction_coefficient = 0.7

[[test]]
kind = "uniaxial-compression"

[[test]]
kind = "triaxial-compression"
confinement = ["5 MPa", "10 MPa"]

[[test]]
kind = "direct-shear"
normal_stress = "5 MPa"

[[test]]
kind = "brazilian"
"""

CALIBRATION = """\
workflow = "calibration"
title = "Small sandstone"
seed = 2

[specimen]
across = 10
width = "50 mm"
size_ratio = 1.5

[rock]
density = "2300 kg/m3"
young_modulus = "15 GPa"
poisson_ratio = 0.22
uniaxial_compressive_strength = "70 MPa"
tensile_strength = "6.5 MPa"
friction_angle = "41 deg"
friction_confinement = "30 MPa"
"""

SWEEP = """\
workflow = "sweep"
title = "Sweep"
case = "slope.toml"
runs = "runs.csv"
together = [["material.soil.cohesion", "material.soil.friction_angle"]]
processes = 2
threads = 1
allow_runs = 20

[vary]
"material.soil.cohesion" = ["10 kPa", "15 kPa"]
"material.soil.friction_angle" = {from = "20 deg", to = "30 deg", count = 2}
"section.regions[1].polygon[0]" = [[0, 2], [0, 1]]
"material.seam.young_modulus" = {from = "10 MPa", to = "100 MPa", count = 2, spacing = "log"}

[table]
"factor of safety [-]" = "factors[kind=strength-reduction].value"
"""
BESIDE = {
    "slope.toml": SLOPE,
    "runs.csv": "seed,material.seam.cohesion\n1,10 kPa\n2,12 kPa\n",
}
"""Files that a sweep names."""

SEEDS = (
    SLOPE, RUNOUT, TUNNEL, DEEP_TUNNEL, GROUND, BREAKING, REINFORCED, BLOCK, SPALLING, GRAINS, SPRINGS, CUTTING,
    LABORATORY, CALIBRATION, SWEEP,
)  # fmt: skip
"""One or more of each kind; `fuzzing_files.write_sources` makes what they name, with `BESIDE`."""
