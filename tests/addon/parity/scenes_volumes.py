"""Parity scenes of homogeneous volumes: in glass, in the open, all around, and with the camera inside.
Colours are muted: light that is absorbed wavelength by wavelength is not what RGB makes of it, the less so the deeper it goes."""

from stage import Tree, bpy, box, camera, colour, diffuse, light, link, plane, scene, socket, sphere, world

TEA = (0.8, 0.72, 0.62)


def filled(name, volume, surface=None):
    """A material of `volume(tree)` behind `surface(tree)`; without one it is a boundary that refracts nothing."""
    made = bpy.data.materials.new(name)
    tree = Tree(made, "ShaderNodeOutputMaterial")
    if surface:
        tree.finish(surface(tree))
    tree.put(socket(tree.output, "Volume"), volume(tree))
    return made


def fill_world(volume):
    owner = bpy.context.scene.world
    output = owner.node_tree.get_output_node('CYCLES')
    tree = Tree.__new__(Tree)
    tree.tree = owner.node_tree
    tree.put(socket(output, "Volume"), volume(tree))


def scatter(tree, tint=1.0, density=1.0, anisotropy=0.0):
    return tree.node("ShaderNodeVolumeScatter", Color=colour(tint), Density=density, Anisotropy=anisotropy)


def absorption(tree, tint=0.0, density=1.0):
    return tree.node("ShaderNodeVolumeAbsorption", Color=colour(tint), Density=density)


def both(tree, scattering, absorbing):
    return tree.node("ShaderNodeAddShader", None, Shader=scattering, Shader_001=absorbing)


def glass(tree):
    return tree.node("ShaderNodeBsdfGlass", {"distribution": 'GGX'}, Roughness=0.0, IOR=1.5)


def on_a_floor(*shown):
    """A floor and a turned box for each material, lit by a large lamp and a dim world."""
    link("Floor", plane("Floor", 8.0)).data.materials.append(diffuse(0.5))
    for i, filling in enumerate(shown):
        place = (1.3 * (i - (len(shown) - 1) / 2), 0.0, 0.71)
        link("Box", box("Box"), place, (0, 0, 30), (0.55, 0.7, 0.7)).data.materials.append(filling)
    light('AREA', 120, (2.0, -2.0, 3.5), shape='SQUARE', size=2.5)
    world(0.35)
    camera()


@scene(samples=(128, 384))
def volume_absorbing_glass():
    on_a_floor(filled("Tea", lambda tree: absorption(tree, TEA, 2.0), glass))


@scene(samples=(128, 256), run="every")
def volume_scattering_boxes():
    """Forward and backward, under a sun."""
    on_a_floor(filled("Forward", lambda tree: scatter(tree, TEA, 1.5, 0.6)),
               filled("Backward", lambda tree: scatter(tree, 0.8, 3.0, -0.4)))
    light('SUN', 2, angle=0.2)


@scene(samples=(128, 256), run="long")
def volume_principled():
    """Its density is that of a metre of the world: the box is scaled."""
    on_a_floor(
        filled("Dye", lambda tree: tree.node("ShaderNodeVolumePrincipled", Color=colour(TEA), Density=1.5, Anisotropy=0.3)),
        filled("Dyed", lambda tree: tree.node("ShaderNodeVolumePrincipled", Color=colour(0.3), Density=2.0,
                                              Absorption_Color=colour(0.25))))


@scene(samples=(128, 256), run="long")
def volume_mixed():
    """A quarter of haze among soot; and a ball within that adds to it."""
    def haze(tree):
        return tree.node("ShaderNodeMixShader", None, Fac=0.25, Shader=absorption(tree, 0.3, 1.5),
                         Shader_001=scatter(tree, TEA, 4.0))
    on_a_floor(filled("Haze", haze))
    ball = link("Ball", sphere("Ball"), (0, 0, 0.7), scale=(0.4, 0.4, 0.4))
    ball.data.materials.append(filled("Core", lambda tree: absorption(tree, 0.2, 3.0)))


@scene(samples=(256, 512), run="long")
def volume_milky_glass():
    """Light finds the way in and out through smooth glass alone: by chance, off the world and the floor."""
    on_a_floor(filled("Milk", lambda tree: both(tree, scatter(tree, TEA, 3.0, 0.3), absorption(tree, 0.7, 1.0)), glass))
    bpy.data.objects.remove(bpy.data.objects["Light"])
    world(1.0)


@scene(samples=(512, 2048), size=(48, 48), run="long")
def volume_world_with_spot():
    """A beam of light in fog: what comes from the world itself never arrives. The spot is small: Cycles draws disks (export/lights.py)."""
    link("Floor", plane("Floor", 8.0)).data.materials.append(diffuse(0.5))
    link("Box", box("Box"), (0.4, 0.3, 0.5), (0, 0, 30), (0.5, 0.5, 0.5)).data.materials.append(diffuse(0.6))
    light('SPOT', 1500, (1.8, -1.2, 3.2), (0.0, 0.0, 0.2), shadow_soft_size=0.1, spot_size=0.7, spot_blend=0.3)
    world(0.03)
    fill_world(lambda tree: both(tree, scatter(tree, TEA, 0.08, 0.5), absorption(tree, 0.5, 0.06)))
    camera()


@scene(samples=(512, 1024), size=(48, 48), run="long")
def volume_camera_inside():
    """From within a room full of haze: the near clip must not matter, so it is next to nothing."""
    link("Floor", plane("Floor", 8.0)).data.materials.append(diffuse(0.5))
    link("Ball", sphere("Ball"), (-0.5, 0.3, 0.7), scale=(0.7, 0.7, 0.7)).data.materials.append(diffuse(0.7))
    room = link("Room", box("Room"), (0, -1.0, 2.51), scale=(3.5, 6.0, 2.5))
    room.data.materials.append(filled("Haze", lambda tree: both(
        tree, scatter(tree, TEA, 0.15, 0.7), absorption(tree, 0.5, 0.06))))
    light('AREA', 300, (1.5, -1.0, 3.5), shape='SQUARE', size=1.5)
    world(0.35)
    camera().data.clip_start = 0.001


@scene(samples=(128, 256), run="long")
def volume_unseen_by_scattering():
    """A lamp that lights the floor but not the haze before it, and a floor that the haze does not see. To Cycles before 4.5
    such light is diffuse; and what one way to the sky alone finds in its way, not a shadow, has no right answer."""
    on_a_floor(filled("Haze", lambda tree: scatter(tree, 0.9, 2.0)))
    bpy.data.objects.remove(bpy.data.objects["Light"])
    floor = bpy.context.scene.objects["Floor"]
    floor.visible_volume_scatter = floor.visible_diffuse = floor.visible_shadow = False
    light('AREA', 120, (2.0, -2.0, 3.5), shape='SQUARE', size=2.5).visible_volume_scatter = False
    light('SUN', 1, angle=0.2)
