"""The lens scene (supplemental §4.3): the camera looks through a lens, and all light leaves its lamp
through another, so that neither a path from the camera nor a look at the lamp finds much light. No
fluorescence: an orange floor, grey walls, a lamp with the same power at every wavelength, strongly
dispersive glass."""

import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import build  # noqa: E402
from mathutils import Matrix  # noqa: E402

LOW, HIGH = (-1.0, -1.0, 0.0), (1.0, 1.0, 2.0)
GREY, ORANGE, BLACK = (0.2, 0.2, 0.2), (0.9, 0.7, 0.1), (0.0, 0.0, 0.0)
IOR, ABBE = 1.3, 23.0
RADIANCE = 30000.0
EYE = (0.0, -0.92, 1.0)
# A lamp, a tube around it and a lens in the tube's mouth. Its beam falls straight down, before what
# the camera sees of the floor: light that goes lens, floor, lens no connection can make.
TORCH = (0.25, -0.35, 1.8)
TORCH_RADIUS, TORCH_LENGTH = 0.2, 0.3


def lens(name, radius, curvature, surface, matrix, rings=48, segments=128):
    """A biconvex lens: two caps of spheres of radius `curvature`, about the local Z axis."""
    sag = curvature - math.sqrt(curvature**2 - radius**2)
    points, faces = [], []
    for side in (1, -1):
        first = len(points)
        points.append((0.0, 0.0, side * sag))
        for i in range(1, rings + 1):
            r = radius * i / rings
            z = side * (math.sqrt(curvature**2 - r * r) - (curvature - sag))
            points += [
                (r * math.cos(a), r * math.sin(a), z)
                for a in (2.0 * math.pi * k / segments for k in range(segments))
            ]
        for k in range(segments):
            n = (k + 1) % segments
            faces.append((first, first + 1 + k, first + 1 + n)[::side])
            for i in range(rings - 1):
                a = first + 1 + i * segments
                b = a + segments
                faces.append((a + k, b + k, b + n, a + n)[::side])
    shown = build.mesh(name, points, faces, surface, smooth=True)
    shown.matrix_world = matrix
    return shown


def tube(name, radius, length, surface, matrix, segments=64):
    """Open below, closed above; from its top down the local Z axis."""
    points = [(0.0, 0.0, 0.0)] + [
        (radius * math.cos(a), radius * math.sin(a), z)
        for z in (0.0, -length)
        for a in (2.0 * math.pi * k / segments for k in range(segments))
    ]
    faces = []
    for k in range(segments):
        a, b = 1 + k, 1 + (k + 1) % segments
        faces += [(0, a, b), (a, a + segments, b + segments, b)]
    build.mesh(name, points, faces, surface).matrix_world = matrix


def torch(nodes, glass):
    """The lens gathers the lamp's light into a beam."""
    place = Matrix.Translation(TORCH)
    tube("Tube", TORCH_RADIUS, TORCH_LENGTH, build.diffuse("Black", BLACK), place)
    mouth = Matrix.Translation((0.0, 0.0, -TORCH_LENGTH))
    lens("Lamp lens", TORCH_RADIUS, 0.22, glass, place @ mouth)
    lamp = build.area_lamp("Lamp", (0.0, 0.0, 0.0), (0.06, 0.06), RADIANCE)
    lamp.matrix_world = place @ Matrix.Translation((0.0, 0.0, -0.02))
    build.shine(lamp, nodes.new(lamp.data.node_tree, "spectrum_constant", location=(-400, 300)))


def main():
    options = build.arguments("lens", (640, 640), 256)
    scene = build.empty_scene()
    nodes = build.enable_addon()
    grey, orange = (build.diffuse(name, rgb) for name, rgb in (("Grey", GREY), ("Orange", ORANGE)))
    walls = dict.fromkeys(("ceiling", "left", "right", "back", "front"), grey)
    build.box(LOW, HIGH, dict(walls, floor=orange))
    glass = build.material(
        "Glass",
        lambda tree: nodes.new(tree, "dispersive_glass", sockets={"IOR": IOR, "Abbe Number": ABBE}),
    )
    before_eye = Matrix.Translation((0.0, EYE[1] + 0.2, EYE[2]))
    lens("Eye lens", 0.27, 0.8, glass, before_eye @ Matrix.Rotation(math.pi / 2, 4, 'X'))
    torch(nodes, glass)
    build.camera(EYE, (0.0, 0.0, 0.9), 26.0)
    scene.view_settings.view_transform = 'Standard'
    build.render("lens", options)


main()
