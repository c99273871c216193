"""The lens scene (supplemental §4.3): a lens before the camera and one before the lamp, so that
neither a path from the camera nor a look at the lamp finds much light. No fluorescence: an orange
floor, grey walls, a lamp with the same power at every wavelength, strongly dispersive glass."""

import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import build  # noqa: E402
from mathutils import Matrix  # noqa: E402

LOW, HIGH = (-1.0, -1.0, 0.0), (1.0, 1.0, 2.0)
GREY, ORANGE = (0.2, 0.2, 0.2), (0.9, 0.7, 0.1)
IOR, ABBE = 1.3, 23.0
RADIANCE = 2000.0
EYE = (0.0, -0.92, 1.0)


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
    before_camera = Matrix.Translation((0.0, EYE[1] + 0.3, EYE[2])) @ Matrix.Rotation(
        math.pi / 2, 4, 'X'
    )
    lens("Eye lens", 0.2, 1.5, glass, before_camera)
    lens("Lamp lens", 0.25, 0.4, glass, Matrix.Translation((0.25, 0.2, 1.45)))
    lamp = build.area_lamp("Lamp", (0.25, 0.2, 1.98), (0.06, 0.06), RADIANCE)
    build.shine(lamp, nodes.new(lamp.data.node_tree, "spectrum_constant", location=(-400, 300)))
    build.camera(EYE, (0.0, 0.0, 0.9), 20.0)
    scene.view_settings.view_transform = 'Standard'
    build.render("lens", options)


main()
