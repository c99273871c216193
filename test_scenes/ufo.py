"""The UFO scene (supplemental §4.2, figure 6): a room full of a homogeneous medium whose extinction
and albedo depend on the wavelength, a saucer of silver with a dome of strongly dispersive glass and
its lamp inside, and below it, in the saucer's beam, a fluorescent coral. The left and right wall glow
as the right wall of the spheres scene does, the rest is grey.

The medium is Blender's: Volume Scatter and Volume Absorption with spectra in their colours, on a
box that fills the room, camera and all."""

import math
import os
import random
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import build  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

LOW, HIGH = (-2.0, -3.0, 0.0), (2.0, 2.0, 3.0)
GREY = (0.2, 0.2, 0.2)
WALL = ("red", "dcm_ethanol", 1.2)  # ColorChecker reflectance, dye, absorbance at the dye's peak
CORAL = ("yellow_green", "wild-type-gfp", 1.5)
YIELD = 0.9  # the scene's choice, as in spheres.py
DOME_IOR, DOME_ABBE = 1.3, 10.0
SAUCER = (0.0, 0.5, 1.75)
SAUCER_RADIUS, DOME_RADIUS = 0.85, 0.42
LAMP_RADIUS, RADIANCE = 0.15, 54.0
BEAM_RADIUS, BEAM_RADIANCE, BEAM_ANGLE = 0.07, 1500.0, 62.0
VIOLET = {"Mean": 400.0, "Sigma": 12.0, "Peak": 10.0}  # beside daylight; it excites the coral

# The medium, 1/m: scattering is SCATTERING · a Gaussian, absorption ABSORPTION · (1 − a Gaussian).
SCATTERING, SCATTERED = 0.25, {"Mean": 440.0, "Sigma": 130.0, "Peak": 1.0}
ABSORPTION, PASSED = 0.06, {"Mean": 490.0, "Sigma": 90.0, "Peak": 1.0}


def fluorescent(nodes, name, paint):
    patch, dye, absorbance = paint

    def make(tree):
        surface = nodes.new(
            tree, "fluorescent", dye=dye, absorbance=absorbance, sockets={"Yield": YIELD}
        )
        reflectance = nodes.new(
            tree, "spectrum_library", colorchecker="colorchecker/" + patch, location=(-350, 250)
        )
        tree.links.new(reflectance.outputs[0], nodes.input_of(surface, "Reflectance"))
        return surface

    return build.material(name, make)


def medium(nodes):
    """A material that has a volume alone."""
    result = build.material("Medium", lambda tree: tree.nodes.new("ShaderNodeAddShader"))
    tree = result.node_tree
    output = tree.get_output_node('CYCLES')
    total = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeAddShader")
    for link in list(tree.links):
        tree.links.remove(link)
    parts = (
        ("ShaderNodeVolumeScatter", SCATTERING, SCATTERED),
        ("ShaderNodeVolumeAbsorption", ABSORPTION, PASSED),
    )
    for slot, (kind, density, color) in enumerate(parts):
        part = tree.nodes.new(kind)
        part.location = (-300, 200 - 200 * slot)
        part.inputs["Density"].default_value = density
        source = nodes.new(tree, "spectrum_gaussian", sockets=color)
        source.location = (-600, 200 - 200 * slot)
        tree.links.new(source.outputs[0], part.inputs["Color"])
        tree.links.new(part.outputs[0], total.inputs[slot])
    tree.links.new(total.outputs[0], next(s for s in output.inputs if s.identifier == "Volume"))
    return result


def lathe(name, profile, surface, center, segments=160):
    """The profile [(radius, height)] turned about the Z axis; it begins and ends on the axis."""
    rings = [point for point in profile if point[0] > 0]
    points = [(0.0, 0.0, profile[0][1])]
    for radius, height in rings:
        points += [
            (radius * math.cos(a), radius * math.sin(a), height)
            for a in (2.0 * math.pi * k / segments for k in range(segments))
        ]
    points.append((0.0, 0.0, profile[-1][1]))
    last = len(points) - 1
    faces = []
    for k in range(segments):
        n = (k + 1) % segments
        faces.append((0, 1 + n, 1 + k))
        for i in range(len(rings) - 1):
            a, b = 1 + i * segments, 1 + (i + 1) * segments
            faces.append((a + k, a + n, b + n, b + k))
        faces.append((last, last - segments + k, last - segments + n))
    shown = build.mesh(name, points, faces, surface, smooth=True)
    shown.matrix_world = Matrix.Translation(center)


def saucer(nodes):
    """From below: hull and deck of silver, on it the dome, half a ball of glass, and the lamp within
    the glass."""
    silver = build.material(
        "Silver",
        lambda tree: nodes.new(tree, "conductor", metal="Ag", sockets={"Roughness": 0.0}),
    )
    glass = build.material(
        "Dome",
        lambda tree: nodes.new(
            tree, "dispersive_glass", sockets={"IOR": DOME_IOR, "Abbe Number": DOME_ABBE}
        ),
    )
    steps = 48
    hull = [
        (SAUCER_RADIUS * math.sin(a), -0.22 * math.cos(a))
        for a in (math.pi / 2 * i / steps for i in range(steps + 1))
    ]
    deck = [
        (SAUCER_RADIUS * math.cos(a), 0.14 * math.sin(a))
        for a in (math.pi / 2 * i / steps for i in range(1, steps + 1))
    ]
    lathe("Saucer", hull + deck[:-1] + [(0.0, 0.14)], silver, SAUCER)
    top = (SAUCER[0], SAUCER[1], SAUCER[2] + 0.16)
    dome = [(0.0, 0.0), (0.98 * DOME_RADIUS, 0.0)] + [
        (DOME_RADIUS * math.cos(a), 0.02 + DOME_RADIUS * math.sin(a))
        for a in (math.pi / 2 * i / steps for i in range(steps))
    ]
    lathe("Dome", dome + [(0.0, 0.02 + DOME_RADIUS)], glass, top)
    lamp = ball_lamp(nodes, 'POINT', "Dome lamp", LAMP_RADIUS, RADIANCE)
    lamp.matrix_world = Matrix.Translation((top[0], top[1], top[2] + 0.45 * DOME_RADIUS))


def ball_lamp(nodes, kind, name, radius, radiance):
    """A ball of light; its power is what gives the radiance (Cycles' ball lamps: P/(4π²r²))."""
    data = build.bpy.data.lights.new(name, kind)
    data.shadow_soft_size = radius
    data.energy = radiance * 4 * math.pi**2 * radius**2
    build.use_nodes(data)
    shown = build.place(name, data)
    build.shine(shown, daylight(nodes, data.node_tree))
    return shown


def beam(nodes):
    """From the belly straight down: the medium shows it."""
    shown = ball_lamp(nodes, 'SPOT', "Beam", BEAM_RADIUS, BEAM_RADIANCE)
    shown.data.spot_size, shown.data.spot_blend = math.radians(BEAM_ANGLE), 0.25
    below = SAUCER[2] - 0.22  # a half of the ball looks out
    shown.matrix_world = Matrix.Translation((SAUCER[0], SAUCER[1], below))


def daylight(nodes, tree):
    both = tree.nodes.new("ShaderNodeMixRGB")
    both.blend_type = 'ADD'
    both.inputs[0].default_value = 1.0
    both.location = (-200, 300)
    white = nodes.new(tree, "spectrum_illuminant", illuminant="D65", location=(-500, 400))
    violet = nodes.new(tree, "spectrum_gaussian", sockets=VIOLET, location=(-500, 200))
    tree.links.new(white.outputs[0], both.inputs[1])
    tree.links.new(violet.outputs[0], both.inputs[2])
    return both


def branch(points, faces, start, end, radii, sides=10):
    """A cone stump from start to end with a round tip."""
    axis = (end - start).normalized()
    side = axis.orthogonal().normalized()
    other = axis.cross(side)
    rings = [(start, radii[0]), (end, radii[1]), (end + axis * radii[1] * 0.6, radii[1] * 0.7)]
    first = len(points)
    for center, radius in rings:
        for k in range(sides):
            a = 2.0 * math.pi * k / sides
            points.append(center + radius * (math.cos(a) * side + math.sin(a) * other))
    points.append(end + axis * radii[1])
    for i in range(2):
        for k in range(sides):
            a, n = first + i * sides, (k + 1) % sides
            faces.append((a + k, a + n, a + sides + n, a + sides + k))
    top = first + 2 * sides
    faces.extend((top + k, top + (k + 1) % sides, first + 3 * sides) for k in range(sides))


def coral(surface):
    """Arms that fork; the same every time."""
    chance = random.Random(14)
    points, faces = [], []

    def grow(start, direction, length, radius, level):
        end = start + direction * length
        branch(points, faces, start, end, (radius, 0.78 * radius))
        if level == 0:
            return
        for turn in range(3 if level > 2 else 2):
            around = 2.0 * math.pi * (turn + chance.random()) / 3
            side = Vector((math.cos(around), math.sin(around), 0.0))
            lean = chance.uniform(0.45, 0.8)
            new = (direction + lean * side + Vector((0.0, 0.0, 0.15))).normalized()
            grow(end, new, length * chance.uniform(0.72, 0.9), 0.72 * radius, level - 1)

    for k in range(5):
        around = 2.0 * math.pi * k / 5
        lean = Vector((0.32 * math.cos(around), 0.32 * math.sin(around), 1.0)).normalized()
        foot = Vector((0.12 * math.cos(around), 0.12 * math.sin(around), -0.02))
        grow(foot, lean, 0.27, 0.07, 4)
    build.mesh("Coral", points, faces, surface, smooth=True).matrix_world = Matrix.Translation(
        (SAUCER[0], SAUCER[1] - 0.1, 0.0)
    )


def main():
    options = build.arguments("ufo", (960, 720), 256)
    scene = build.empty_scene()
    nodes = build.enable_addon()
    grey = build.diffuse("Grey", GREY)
    glowing = fluorescent(nodes, "Red with dcm", WALL)
    walls = dict.fromkeys(("floor", "ceiling", "back", "front"), grey)
    build.box(LOW, HIGH, dict(walls, left=glowing, right=glowing))
    inside = [[c + s * 0.001 for c in corner] for corner, s in ((LOW, 1), (HIGH, -1))]
    build.block("Medium", *inside, medium(nodes))
    saucer(nodes)
    coral(fluorescent(nodes, "Coral", CORAL))
    beam(nodes)
    build.camera((0.0, -2.9, 1.35), (0.0, 0.5, 1.3), 30.0)
    scene.view_settings.view_transform = 'Standard'
    build.render("ufo", options)


main()
