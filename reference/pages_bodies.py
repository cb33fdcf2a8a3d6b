"""What bodies and their particles are held to: groups of results on docs/verification.md."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from reference.pages_particles import Group, group_sections

GROUPS = (
    Group(
        "ground-bodies",
        "Pictures, slices, grids, terrain",
        "What the source holds, what the body made of it holds, what its particles stand for and weigh in an "
        "assembly, of every material. Drawing and slices are drawn from closed forms; the photographs come with "
        "scikit-image, the channels with pyvista, the elevations with matplotlib.\n\n"
        "![Drawing](pictures/body_drawing.png)\n\n![Slices](pictures/body_slices.png)\n\n"
        "![Channels](pictures/body_channels.png)\n\n![Terrain](pictures/body_terrain.png)\n\n"
        "![Gravel](pictures/body_gravel.png)\n\n![Bricks](pictures/body_brick.png)",
    ),
    Group(
        "ground-terrain",
        "Factor of safety of a surveyed valley side",
        "A line across the steepest side of a valley, in matplotlib's elevation model. Strength is not surveyed: it is "
        "chosen so that the slope is near its limit. Weathered layer 80 m: 2200 kg/m3, 80 kPa, 28 degrees; rock: 2400 "
        "kg/m3, 600 kPa, 38 degrees; as one material: 2300 kg/m3, 150 kPa, 30 degrees.\n\n"
        "![Map and section](pictures/terrain_section.png)",
    ),
    Group(
        "ground-meshes",
        "Meshes, geometry, closed surfaces",
        "A section of three materials in both versions of gmsh's files, a block with a tunnel from a STEP file, what "
        "an STL file encloses: sizes and masses, as in the source. A round hole in rock under 10 MPa from the sides "
        "and 30 MPa from above and below (P14), on the nodes of a graded mesh and with particles filled into its "
        "outline. A volume filled with 200,000 spheres.\n\n![Stresses around the hole](pictures/mesh_hole.png)",
    ),
    Group(
        "ground-joints",
        "Joints, bolts, initial stress",
        "Specimens with one joint against Jaeger's closed form (1960), Priest's block on a smooth joint, dry and with "
        "water, a grouted bar pulled out, a lining bent and stretched, and the stress of bonded ground before "
        "anything is built.",
    ),
    Group(
        "tunnels",
        "Tunnels in ground that yields",
        "A round hole in a Mohr-Coulomb medium under even stress: its whole reaction curve, yielded zone and "
        "lining beside the closed form of Salencon, at several numbers of particles, for psi = phi and for "
        "psi = 0, whose answer depends on the mesh, and with other sides of the section. Yielding bars: their "
        "pull is spread over the wall in the closed form and stands at single places in the ground. Tunnels "
        "in clay to their collapse by the load, by strength reduction and by relaxation, beside the middle of "
        "bounds by limit analysis.",
    ),
    Group(
        "cutting",
        "Cutting rock",
        "A drag tool in weak and in brittle rock, and DICE2D's cutter. The direction of the force on the face follows "
        "friction where the rock slides up on it; at rakes of 0 and below much of it is crushed without sliding. Chips "
        "break at forces within a factor of three of the formulae, at every rake and at both speeds; means are a third "
        "of that and less, rise nearly along a line with the depth and halve with the speed. In sandstone the specific "
        "energy does not fall with the depth. With a local damping of 0.8 mean forces are proportional to speed: an "
        "agreement with the formulae is then one of a chosen speed.",
    ),
    Group(
        "cutting-clay",
        "Cutting ground that flows",
        "Ground whose grains stick wherever they touch, four times as much against pull as against shear, "
        "shears into a chip that runs up the face. The force falls off in a sixth of the looks only, falls "
        "with the rake, and changes less with half the speed than from packing to packing. Over 24 packings a"
        " depth its peaks lie along a line with the depth; its means rise less than in proportion, from two "
        "grains deep to six, so that their line and the specific energy miss their bounds. A local damping of"
        " 0.8 nearly doubles the mean: damping resists what flows, too. Where the face is slid on, which is "
        "told from motion alone, the direction of the force is that of friction, in clay and in weak rock, at"
        " every rake; what sticks to the face bears the rest, most at -15 degrees.",
    ),
    Group(
        "cutting-energy",
        "Specific energy over depth",
        "Two packings a depth, from ground that flows to rock that chips. Peaks are 0.6 to 1 times the depth "
        "times the compressive strength, in rock 1.3 to 550 of its lengths (toughness/strength)^2 deep: no "
        "fall with the root of that depth is seen between rocks. Within one rock the specific energy of marl "
        "falls by the power -0.6; that of sandstone falls from 25 to 11 MJ/m3 between 2.5 and 8 mm, but a cut"
        " of 1.25 mm, hardly more than a grain, costs less: the tool then meets single grains, which spoils "
        "the line through all four depths. Clay and weak rock change less than from packing to packing."
        "\n\n![Specific energy and peaks over depth, on log axes](pictures/cutting_energy.png)",
    ),
    Group(
        "dice2d-slope",
        "DICE2D's slope",
        "A slope over a weak layer as gravity grows, without and with bolts (Zhao 2015, section 4.3.3), rebuilt from "
        "its text: what is assumed stands in workflows/rock_slope. It fails by the buckling of the rock bridge at its "
        "foot, which no strength decides: hence a factor by strength reduction above that of gravity, where friction "
        "should make it the lower one.",
    ),
    Group(
        "dice2d-cavern",
        "DICE2D's frame and cavern",
        "A frame on jointed rock as gravity grows, without and with a cavern below it (Zhao 2015, section 4.3.4), "
        "rebuilt from its text: what is assumed stands in workflows/frame_on_rock.",
    ),
    Group(
        "tunnels-spalling",
        "A tunnel in hard rock that spalls",
        "Discs under 10 MPa from the sides and 5 MPa from above, a circle excavated in stages. Hoop stress is the "
        "force that contacts carry across rays, by its second harmonic, the mean of 16, 8 and 4 arrangements of 3,000, "
        "12,000 and 48,000 discs, 7, 13 and 27 across the radius; one alone is up to 4 % off beside the wall, even "
        "with the smallest. The wall is as rough as its grains are large, and grains that stand out of it bear little, "
        "those behind them more: what is missing there is the thrust of a layer of a quarter of a grain at every size, "
        "-16, -11 and -4 % of the first ring. With 13 grains across the radius and fewer the bounds are not kept.\n\n"
        "Then the far field grows until bonds break: where the first do, and at which of Kirsch's largest hoop "
        "stresses. Specimens of the same grains and bonds tell how many cracks a grain has at which difference of the "
        "principal stresses; summed over Kirsch's stresses that is how many a tunnel should have. Real tunnels have "
        "hundreds of grains across: their first cracks come at the crack initiation stress of specimens, 0.4 of the "
        "strength (Martin 1997). Twenty cracks come later than that sum says: cracks of a specimen bring others "
        "about, those of twenty grains hardly.",
    ),
    Group(
        "caving",
        "Caving ground",
        "Dry discs, 60 wide and 66 deep, are drawn through an opening of eight: velocities downwards are Gauss curves "
        "that widen upwards as those of Nedderman and Tuzun do, with one length B, and what is drawn comes from the "
        "zone that follows from them. B grows a little upwards, so the zone is somewhat lower and wider. Then the "
        "workflows block_caving and longwall: bonded rock on a held floor, which does not break under its weight, "
        "caves where it is undercut. How much it swells is measured in boxes within it: by 5 %, less than real "
        "rock, for discs in a plane lie dense however they fall. The trough over the long wall and that swelling make "
        "up nine tenths of the seam; the loosest rock lies at the edge of the panel, outside the box.",
    ),
)


def body_sections(read: Callable[[str], Any], header: Callable[[Any], str], not_run: str) -> list[str]:
    """Texts of all groups; `read` gives what is stored under a name, `header` its origin."""
    return ["## Bodies\n", *group_sections(GROUPS, read, header, not_run)]
