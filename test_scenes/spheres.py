"""The scene with spheres (supplemental §4.1, figures 4 and 5): a box of grey and fluorescent walls,
balls of glass and metal in it, a lamp below the ceiling. The ceiling and the left wall are grey,
the other planes glow."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import build  # noqa: E402

LOW, HIGH = (-2.0, -4.0, 0.0), (2.0, 2.0, 3.0)

# Wall: ColorChecker reflectance, dye, absorbance of the paint at the dye's peak.
PAINTS = {
    "back": ("cyan", "coumarin-30_acetonitrile", 1.0),
    "floor": ("green", "coumarin-6_ethanol", 1.2),
    "right": ("red", "dcm_ethanol", 1.2),
}
GREY = (0.2, 0.2, 0.2)
# Quantum yield, the same of all three: this scene's choice, so that its walls glow; §4.1 and figure
# 5 name none. Measured in solution it is less: coumarin 30 0.67 and coumarin 6 0.78 (`stokes spectrum
# show` says by whom), DCM 0.43 in the index of the measured spectra, which does not say by whom.
YIELD = 0.9

# The lamp: daylight, and a violet LED that excites the dyes and is all but invisible by itself.
RADIANCE = 21.0
VIOLET = {"Mean": 400.0, "Sigma": 10.0, "Peak": 14.0}


def painted_wall(nodes, side):
    patch, dye, absorbance = PAINTS[side]

    def make(tree):
        paint = nodes.new(
            tree, "fluorescent", dye=dye, absorbance=absorbance, sockets={"Yield": YIELD}
        )
        reflectance = nodes.new(
            tree, "spectrum_library", colorchecker="colorchecker/" + patch, location=(-350, 250)
        )
        tree.links.new(reflectance.outputs[0], nodes.input_of(paint, "Reflectance"))
        return paint

    return build.material("%s with %s" % (patch.capitalize(), dye.partition("_")[0]), make)


def glass(nodes, preset):
    return build.material(
        "Glass " + preset,
        lambda tree: nodes.new(tree, "dispersive_glass", model='PRESET', preset=preset),
    )


def metal(nodes, name, roughness):
    return build.material(
        "Metal " + name,
        lambda tree: nodes.new(tree, "conductor", metal=name, sockets={"Roughness": roughness}),
    )


def lamp(nodes):
    shown = build.area_lamp("Lamp", (0.0, 0.2, HIGH[2] - 0.02), (1.4, 0.8), RADIANCE)
    tree = shown.data.node_tree
    both = tree.nodes.new("ShaderNodeMixRGB")
    both.blend_type = 'ADD'
    both.inputs[0].default_value = 1.0
    both.location = (-200, 300)
    daylight = nodes.new(tree, "spectrum_illuminant", illuminant="D65", location=(-500, 400))
    violet = nodes.new(tree, "spectrum_gaussian", sockets=VIOLET, location=(-500, 200))
    tree.links.new(daylight.outputs[0], both.inputs[1])
    tree.links.new(violet.outputs[0], both.inputs[2])
    build.shine(shown, both)


def main():
    options = build.arguments("spheres", (960, 720), 256)
    scene = build.empty_scene()
    nodes = build.enable_addon()
    grey = build.diffuse("Grey", GREY)
    walls = {"ceiling": grey, "left": grey}
    walls.update((side, painted_wall(nodes, side)) for side in PAINTS)
    walls["front"] = walls["back"]  # behind the camera
    build.box(LOW, HIGH, walls)
    build.sphere("Silver", (-0.95, 0.85, 0.85), 0.85, metal(nodes, "Ag", 0.0))
    build.sphere("Flint", (0.62, -0.15, 0.70), 0.70, glass(nodes, "SF11"))
    build.sphere("Gold", (-0.72, -0.85, 0.40), 0.40, metal(nodes, "Au", 0.2))
    build.sphere("Copper", (1.42, -0.95, 0.34), 0.34, metal(nodes, "Cu", 0.1))
    build.sphere("Crown", (-0.02, -1.30, 0.26), 0.26, glass(nodes, "BK7"))
    lamp(nodes)
    build.camera((0.0, -3.9, 1.55), (0.05, 0.5, 0.98), 30.0)
    scene.view_settings.view_transform = 'Standard'
    scene.view_settings.exposure = 0.0
    build.render("spheres", options)


main()
