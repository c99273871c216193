"""The boxes of the colour bias tests (supplemental §4.4, figures 4 and 8): an empty box, a lamp of
the same power at every wavelength, and one of seven reflectances on all walls, on all but the back
wall, or on the back wall alone. The others are grey."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import build  # noqa: E402

RGB = {
    "grey": (0.2, 0.2, 0.2),
    "red": (0.8, 0.05, 0.15),
    "green": (0.05, 0.8, 0.15),
    "blue": (0.05, 0.15, 0.8),
}
PATCHES = {"checker-cyan": "cyan", "checker-green": "green", "checker-red": "red"}
SIDES = ("floor", "ceiling", "left", "right", "back")
COLOURED = {"all": set(SIDES), "others": set(SIDES) - {"back"}, "back": {"back"}}
RADIANCE = 20.0


def more(parser):
    parser.add_argument("--reflectance", choices=(*RGB, *PATCHES), default="green")
    parser.add_argument("--walls", choices=tuple(COLOURED), default="all", help="which have it")


def paint(nodes, name):
    if name in RGB:
        return build.diffuse(name, RGB[name])

    def make(tree):
        diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
        patch = "colorchecker/" + PATCHES[name]
        measured = nodes.new(tree, "spectrum_library", colorchecker=patch, location=(-250, 250))
        tree.links.new(measured.outputs[0], diffuse.inputs[0])
        return diffuse

    return build.material(name, make)


def main():
    options = build.arguments("bias", (320, 320), 256, more)
    scene = build.empty_scene()
    nodes = build.enable_addon()
    grey, coloured = paint(nodes, "grey"), paint(nodes, options.reflectance)
    chosen = COLOURED[options.walls]
    walls = {side: coloured if side in chosen else grey for side in SIDES}
    build.box((-1.0, -1.0, 0.0), (1.0, 1.0, 2.0), walls)
    lamp = build.area_lamp("Lamp", (0.0, 0.0, 1.98), (0.6, 0.6), RADIANCE)
    build.shine(lamp, nodes.new(lamp.data.node_tree, "spectrum_constant", location=(-400, 300)))
    build.camera((0.0, -3.4, 1.0), (0.0, 0.0, 1.0), 40.0)
    scene.view_settings.view_transform = 'Standard'
    build.render("bias-%s-%s" % (options.reflectance, options.walls), options)


main()
