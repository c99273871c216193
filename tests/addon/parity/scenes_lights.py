"""Parity scenes: one for each kind of light, on grey surfaces, so that only the light is compared."""

from stage import camera, diffuse, emission, light, link, plane, scene, still_life


@scene(samples=(64, 1152), run="always")
def default_cube():
    """The file that Blender starts with: a Principled cube, a point light and a grey world."""


@scene(run="every")
def point_hard():
    still_life()
    light('POINT', 150, shadow_soft_size=0.0)


@scene(samples=(96, 1152), run="every")
def point_soft():
    still_life()
    light('POINT', 150, shadow_soft_size=0.25)


@scene()
def spot_hard():
    still_life()
    light('SPOT', 600, shadow_soft_size=0.0, spot_size=0.9, spot_blend=0.2)


@scene(samples=(64, 640), run="every")
def spot_soft():
    still_life()
    light('SPOT', 600, shadow_soft_size=0.15, spot_size=1.0, spot_blend=0.6)


@scene()
def sun_hard():
    still_life()
    light('SUN', 3, angle=0.0)


@scene(run="every")
def sun_soft():
    still_life()
    light('SUN', 3, angle=0.35)


@scene(run="always")
def area_square():
    still_life()
    light('AREA', 80, shape='SQUARE', size=1.0)


@scene()
def area_rectangle():
    still_life()
    light('AREA', 80, shape='RECTANGLE', size=1.8, size_y=0.5)


@scene()
def area_disk():
    still_life()
    light('AREA', 80, shape='DISK', size=1.2)


@scene()
def area_ellipse():
    still_life()
    light('AREA', 80, shape='ELLIPSE', size=2.0, size_y=0.7)


@scene(run="long")
def area_scaled():
    """The object's scale is part of the lamp's size."""
    still_life()
    light('AREA', 80, shape='RECTANGLE', size=1.0, size_y=0.5).scale = (1.5, 0.7, 2.0)


@scene(run="every")
def mesh_emitter():
    still_life()
    panel = link("Panel", plane("Panel", 1.5), (1.5, -1.0, 3.0), (150, 30, 0))
    panel.data.materials.append(emission(6.0))


@scene(samples=(64, 512), run="long")
def mesh_emitter_in_view():
    """Seen by the camera, lit from both sides."""
    still_life()
    panel = link("Panel", plane("Panel", 0.8), (0.2, -0.8, 1.6), (60, 20, 0))
    panel.data.materials.append(emission(8.0))


@scene()
def coloured_lamp():
    still_life()
    light('AREA', 80, shape='SQUARE', size=1.0, color=(1.0, 0.45, 0.12))


@scene(samples=(64, 512), run="long")
def lamps_in_view():
    """What lamps look like to the camera, which does not see them unless asked to."""
    link("Floor", plane("Floor", 8.0)).data.materials.append(diffuse(0.5))
    camera()
    lamps = (light('AREA', 30, (-0.9, 1.0, 0.9), (0, -4, 1), shape='RECTANGLE', size=1.0, size_y=0.6),
             light('AREA', 20, (0.3, -1.0, 0.5), (-1, -4, 3), shape='DISK', size=0.5),
             light('POINT', 30, (1.0, 0.5, 0.9), shadow_soft_size=0.3))
    for lamp in lamps:
        lamp.visible_camera = True


@scene(samples=(128, 1024), run="long")
def three_lamps():
    still_life()
    light('POINT', 60, (-2, -2, 2), shadow_soft_size=0.1)
    light('AREA', 30, (2, -1, 2), shape='DISK', size=0.8)
    light('SUN', 0.7, angle=0.1)


@scene(samples=(96, 1536), run="long")
def lamp_with_strength_node():
    """A light's own nodes multiply its power."""
    still_life()
    data = light('POINT', 75, shadow_soft_size=0.2).data
    data.use_nodes = True
    shader = next(node for node in data.node_tree.nodes if node.bl_idname == "ShaderNodeEmission")
    shader.inputs["Strength"].default_value = 2.0

