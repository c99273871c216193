"""What the scene scripts share: the add-on of this checkout, their arguments, simple shapes, and
the render. Each script is run as  blender -b --python test_scenes/NAME.py -- --output DIR
--resolution W H --samples N"""

import argparse
import math
import os
import sys
import time

import bpy
from mathutils import Matrix, Vector

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def enable_addon():
    """Registers the checkout's add-on, without installing it; returns its room `nodes`."""
    if not hasattr(bpy.types.Scene, "stokes"):
        sys.path.insert(0, ROOT)
        import addon

        addon.register()
    return sys.modules[
        bpy.types.Scene.stokes.keywords["type"].__module__.rpartition(".")[0] + ".nodes"
    ]


def arguments(name, resolution, samples, more=None):
    """What stands behind "--"; more(parser) adds a scene's own."""
    parser = argparse.ArgumentParser(prog=name)
    parser.add_argument(
        "--output", default=os.path.join(ROOT, "build", "demo"), help="folder for the pictures"
    )
    parser.add_argument("--resolution", nargs=2, type=int, default=resolution, metavar=("W", "H"))
    parser.add_argument("--samples", type=int, default=samples)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--integrator", default="mbdpt", help="as published, if not said otherwise")
    parser.add_argument("--lanes", default="1", help="wavelengths of a path: 1, 4 or 8")
    parser.add_argument(
        "--engine", default="STOKES", help="CYCLES or an EEVEE shows the approximation"
    )
    parser.add_argument("--d0", type=float, default=50.0, help="mollification's half-width, nm")
    parser.add_argument("--shrink", type=float, default=0.2)
    parser.add_argument("--save", action="store_true", help="also write the .blend file")
    if more is not None:
        more(parser)
    words = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    return parser.parse_args(words)


def empty_scene():
    """A scene with nothing in it and a black world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("Black")
    use_nodes(scene.world)
    background = next(
        node for node in scene.world.node_tree.nodes if node.bl_idname == "ShaderNodeBackground"
    )
    background.inputs[0].default_value = (0.0, 0.0, 0.0, 1.0)
    return scene


def use_nodes(owner):
    """From 5.0 on materials and worlds have a tree from the start, and asking for one warns of its
    end."""
    if owner.node_tree is None:
        owner.use_nodes = True


def place(name, data, matrix=None):
    thing = bpy.data.objects.new(name, data)
    if matrix is not None:
        thing.matrix_world = matrix
    bpy.context.scene.collection.objects.link(thing)
    return thing


def material(name, make):
    """A material whose surface is the node that make(tree) returns."""
    result = bpy.data.materials.new(name)
    use_nodes(result)
    tree = result.node_tree
    for node in list(tree.nodes):
        if node.bl_idname != "ShaderNodeOutputMaterial":
            tree.nodes.remove(node)
    output = tree.get_output_node('CYCLES')
    node = make(tree)
    node.location = (output.location.x - 300, output.location.y)
    tree.links.new(node.outputs[0], next(s for s in output.inputs if s.identifier == "Surface"))
    return result


def diffuse(name, rgb):
    def make(tree):
        node = tree.nodes.new("ShaderNodeBsdfDiffuse")
        node.inputs[0].default_value = (*rgb, 1.0)
        return node

    return material(name, make)


def mesh(name, points, faces, surface, smooth=False):
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(point) for point in points], [], faces)
    data.polygons.foreach_set("use_smooth", [smooth] * len(faces))
    data.materials.append(surface)
    return place(name, data)


def quad(name, corners, surface):
    """A flat wall; its front is where the corners run counter-clockwise."""
    return mesh(name, corners, [(0, 1, 2, 3)], surface)


def corners(low, high):
    """The four corners of each side of a box, so that its front looks inward."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    return {
        "floor": ((x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)),
        "ceiling": ((x0, y0, z1), (x0, y1, z1), (x1, y1, z1), (x1, y0, z1)),
        "left": ((x0, y0, z0), (x0, y1, z0), (x0, y1, z1), (x0, y0, z1)),
        "right": ((x1, y0, z0), (x1, y0, z1), (x1, y1, z1), (x1, y1, z0)),
        "back": ((x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)),
        "front": ((x0, y0, z0), (x0, y0, z1), (x1, y0, z1), (x1, y0, z0)),
    }


def box(low, high, walls):
    """Walls of a box that look inward; `walls` maps floor, ceiling, left, right, back, front to a
    material, or leaves a side open. X runs to the right, Y to the back, Z up."""
    for side, surface in walls.items():
        quad(side.capitalize(), corners(low, high)[side], surface)


def block(name, low, high, surface):
    """A closed box in one piece whose sides look outward."""
    points = [point for side in corners(low, high).values() for point in reversed(side)]
    return mesh(name, points, [tuple(range(i, i + 4)) for i in range(0, 24, 4)], surface)


def sphere(name, center, radius, surface, segments=160):
    """A smooth ball, fine enough that its caustics show no facets."""
    rings = segments // 2
    points = [(0.0, 0.0, 1.0)]
    for i in range(1, rings):
        theta = math.pi * i / rings
        points += [
            (math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta))
            for phi in (2.0 * math.pi * k / segments for k in range(segments))
        ]
    points.append((0.0, 0.0, -1.0))
    faces = [(0, 1 + k, 1 + (k + 1) % segments) for k in range(segments)]
    for i in range(rings - 2):
        a, b = 1 + i * segments, 1 + (i + 1) * segments
        faces += [
            (a + k, b + k, b + (k + 1) % segments, a + (k + 1) % segments) for k in range(segments)
        ]
    last = 1 + (rings - 2) * segments
    faces += [(last + k, len(points) - 1, last + (k + 1) % segments) for k in range(segments)]
    points = [tuple(radius * c for c in point) for point in points]
    shown = mesh(name, points, faces, surface, smooth=True)
    shown.matrix_world = Matrix.Translation(center)
    return shown


def area_lamp(name, center, size, radiance):
    """A lamp that looks down. Its power in watts is what gives this radiance in the running
    Blender's Cycles."""
    light = bpy.data.lights.new(name, 'AREA')
    light.shape = 'RECTANGLE'
    light.size, light.size_y = size
    factor = 4.0 if bpy.app.version < (4, 0, 0) else math.pi
    light.energy = radiance * factor * size[0] * size[1]
    use_nodes(light)
    return place(name, light, Matrix.Translation(center))


def shine(lamp, source):
    """Gives a lamp the colour or spectrum of a node of its tree."""
    tree = lamp.data.node_tree
    emission = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeEmission")
    tree.links.new(source.outputs[0], emission.inputs[0])


def camera(position, target, lens_mm):
    data = bpy.data.cameras.new("Camera")
    data.lens = lens_mm
    away = (Vector(position) - Vector(target)).to_track_quat('Z', 'Y')
    thing = place("Camera", data, Matrix.Translation(position) @ away.to_matrix().to_4x4())
    bpy.context.scene.camera = thing
    return thing


def render(name, options):
    """Renders by Blender's own operator: NAME.png, NAME.exr and, for `stokes render`, NAME.stokes
    in the folder."""
    scene = bpy.context.scene
    folder = os.path.abspath(options.output)
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, name)
    scene.render.engine = options.engine
    scene.render.resolution_x, scene.render.resolution_y = options.resolution
    scene.render.resolution_percentage = 100
    scene.stokes.samples = options.samples
    scene.stokes.seed = options.seed
    scene.stokes.d0 = options.d0
    scene.stokes.shrink = options.shrink
    scene.stokes.integrator = options.integrator
    scene.stokes.lanes = options.lanes
    scene.stokes.use_record = True
    scene.stokes.record_path = path + ".stokes"
    if hasattr(scene, "cycles"):
        scene.cycles.samples = options.samples
    scene.render.image_settings.file_format = 'PNG'
    scene.render.filepath = path + ".png"
    if options.save:
        bpy.ops.wm.save_as_mainfile(filepath=path + ".blend")
    print(
        "%s: rendering %d × %d, %d samples" % (name, *options.resolution, options.samples),
        flush=True,
    )
    start = time.monotonic()
    bpy.ops.render.render(write_still=True)
    scene.render.image_settings.file_format = 'OPEN_EXR'
    bpy.data.images["Render Result"].save_render(path + ".exr", scene=scene)
    print(
        "%s: %.1f s, wrote %s.png, .exr and .stokes" % (name, time.monotonic() - start, path),
        flush=True,
    )
