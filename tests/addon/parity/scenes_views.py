"""Parity scenes of worlds, cameras and films: what a picture is a picture of."""

import math

from stage import (
    bpy, camera, colour, diffuse, light, link, material, plane, scene, sphere, still_life, world, world_image,
)
import pictures


@scene(run="every")
def world_constant():
    still_life()
    world(0.7)


@scene()
def world_coloured():
    still_life()
    world(1.0, tint=(0.25, 0.5, 1.0))


@scene(samples=(128, 320), run="every")
def world_sun_image():
    """A sky, a ground and a sun of a few texels, turned about the vertical."""
    still_life()
    world_image(pictures.sky(), rotation=(0, 0, 70))


@scene(samples=(128, 256))
def world_tilted_in_view():
    """The map itself, seen directly and in a mirror ball, turned about all axes."""
    ball = link("Ball", sphere("Ball"), (0, 0, 0.6), scale=(1.6, 1.6, 1.6))
    ball.data.materials.append(material("Mirror", lambda tree: tree.node(
        ("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic"), Color=colour(0.8), Roughness=0.0)))
    camera(lens=28)
    world_image(pictures.sky(sun=4.0), rotation=(20, -35, 110))


@scene()
def camera_orthographic():
    still_life()
    world(0.4)
    light('SUN', 2, angle=0.2)
    data = bpy.context.scene.camera.data
    data.type = 'ORTHO'
    data.ortho_scale = 4.5


@scene()
def camera_shifted():
    still_life()
    world(0.4)
    light('SUN', 2, angle=0.2)
    data = bpy.context.scene.camera.data
    data.shift_x, data.shift_y, data.sensor_fit = 0.15, -0.2, 'VERTICAL'


@scene(size=(48, 80), run="long")
def camera_portrait():
    still_life()
    world(0.4)
    light('SUN', 2, angle=0.2)
    bpy.context.scene.render.pixel_aspect_x = 1.3


@scene(samples=(128, 256), run="long")
def camera_out_of_focus():
    still_life()
    world(0.4)
    light('SUN', 2, angle=0.2)
    dof = bpy.context.scene.camera.data.dof
    dof.use_dof = True
    dof.focus_distance, dof.aperture_fstop = 5.0, 0.15


@scene(samples=(128, 384))
def camera_orthographic_out_of_focus():
    still_life()
    world(0.4)
    light('SUN', 2, angle=0.2)
    data = bpy.context.scene.camera.data
    data.type, data.ortho_scale = 'ORTHO', 4.0
    data.dof.use_dof = True
    data.dof.focus_distance, data.dof.aperture_fstop = 5.0, 1.0


@scene(samples=(128, 1024), size=(80, 80))
def border():
    """A part of the frame; the rest of the picture stays empty."""
    still_life()
    world(0.4)
    light('SUN', 2, angle=0.2)
    render = bpy.context.scene.render
    render.use_border, render.use_crop_to_border = True, True
    render.border_min_x, render.border_max_x = 0.25, 0.875
    render.border_min_y, render.border_max_y = 0.125, 0.75


@scene()
def film_transparent():
    """No floor: the world lights the objects but its pixels stay empty, and alpha is compared too."""
    floor = still_life()[0]
    bpy.data.objects.remove(floor)
    world(0.8)
    bpy.context.scene.render.film_transparent = True


@scene(samples=(128, 384))
def holdout():
    """Holes in the picture, whole and in part, that still light, shade and mirror; the film is not transparent."""
    world(0.4)
    light('SUN', 2, angle=0.2)

    def half_a_hole(tree):
        part = tree.node("ShaderNodeMixShader", None, Fac=0.4, Shader=tree.node("ShaderNodeBsdfDiffuse", Color=(0.7, 0.6, 0.4, 1)),
                         Shader_001=tree.node("ShaderNodeHoldout"))
        return tree.node("ShaderNodeMixShader", None, Fac=0.3, Shader=part, Shader_001=tree.node("ShaderNodeBsdfTransparent"))

    def glow(tree):
        return tree.node("ShaderNodeEmission", Color=(0.3, 0.6, 1, 1), Strength=1.5)
    ball = still_life()[1]
    link("Veil", plane("Veil"), (0, -2.5, 2), (60, 0, 0)).data.materials.append(material("Half", half_a_hole))
    ball.data.materials[0] = material("Glow", glow)
    ball.is_holdout = True


@scene(run="long")
def layer_without_sky():
    still_life()
    world(0.8)
    light('AREA', 120, (2.0, -2.0, 3.5), shape='SQUARE', size=2.5)
    bpy.context.view_layer.use_sky = False


@scene(run="long")
def instances():
    """One mesh in many places, scaled and mirrored, and an empty that hands on its transform."""
    world(0.4)
    light('SUN', 2, angle=0.2)
    link("Floor", plane("Floor", 8.0)).data.materials.append(diffuse(0.5))
    ball = sphere("Ball", 24, 12)
    ball.materials.append(diffuse(0.7))
    parent = link("Empty", None, (0, 0, 0.2), (0, 0, 25), (1.2, 1.0, 0.8))
    for i in range(5):
        angle = 2 * math.pi * i / 5
        child = link("Ball", ball, (1.2 * math.cos(angle), 1.2 * math.sin(angle), 0.3), (10 * i, 0, 0),
                     (-0.3 if i % 2 else 0.4, 0.3, 0.2 + 0.1 * i))
        child.parent = parent
    camera()


@scene(run="long")
def unseen_by_diffuse_and_shadow_rays():
    """Lit by what only shadow rays reach: what rays of two kinds find in their way would have no right answer."""
    ball, crate = still_life()[1:]
    ball.visible_shadow = False
    crate.visible_diffuse = False
    light('SUN', 2, (1.5, -1.5, 3.0), angle=0.0)
    light('POINT', 100, (-1.5, -1.5, 2.5), shadow_soft_size=0.0)


@scene(samples=(128, 512), run="long")
def unseen_by_camera_and_glossy_rays():
    """One thing is in the mirror alone, another before it alone; both cast shadows."""
    still_life()
    mirror = link("Mirror", plane("Mirror", 4.0), (0, 2.0, 1.2), (80, 0, 0))
    mirror.data.materials.append(material("Mirror", lambda tree: tree.node("ShaderNodeBsdfGlossy", Roughness=0.0)))
    for name, place in (("Hidden", (-0.1, -0.9, 0.3)), ("Unmirrored", (0.2, 1.0, 0.4))):
        thing = link(name, sphere(name), place, scale=(0.3, 0.3, 0.3))
        thing.data.materials.append(diffuse((0.8, 0.4, 0.2)))
        thing.visible_camera, thing.visible_glossy = name != "Hidden", name != "Unmirrored"
    light('AREA', 120, (2.0, -2.0, 3.5), shape='SQUARE', size=2.5)


@scene()
def unseen_by_the_camera():
    """A wall before the camera that lights and shades what is behind it."""
    still_life()
    wall = link("Wall", plane("Wall"), (0, -3.0, 1.5), (70, 0, 0))
    wall.data.materials.append(diffuse(0.5))
    wall.visible_camera = False
    light('AREA', 120, (0.5, -0.5, 3.5), shape='SQUARE', size=1.0)
