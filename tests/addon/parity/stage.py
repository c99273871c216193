"""The words that parity scenes are written in: meshes, materials, lights and a camera, made by code alone.
A scene is a function decorated with @scene; pytest reads only their names, without Blender."""

import math

try:
    import bpy
    from mathutils import Euler, Vector
except ImportError:  # pytest lists the scenes
    bpy = None

SCENES = {}


class Scene:
    """`samples` are Cycles' of one render and Stokes' wavelengths a pixel (two renders of each are made); `size` is in
    pixels. All is rendered in bundles of four wavelengths, half the time for the noise, but what every Blender sees: the
    oldest sees it with a wavelength a path."""

    def __init__(self, build, samples, size, run):
        self.build = build
        self.name = build.__name__
        self.lanes = 1 if run == "always" and bpy and bpy.app.version < (4, 0, 0) else 4
        self.cycles_samples, self.stokes_samples = samples[0], samples[1] // self.lanes
        self.size = size
        self.run = run


def scene(samples=(64, 256), size=(64, 64), run="normal"):
    """`run`: "always" (in each Blender), "every" (in each, all but the system's on demand), "normal" (in the system's)
    or "long" (in the system's, on demand)."""
    def register(build):
        SCENES[build.__name__] = Scene(build, samples, size, run)
        return build
    return register


def clear():
    for kind in (bpy.data.objects, bpy.data.meshes, bpy.data.materials, bpy.data.lights, bpy.data.cameras):
        for item in list(kind):
            kind.remove(item)
    world(0.0)


def link(name, data, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    """`rotation` is in degrees, XYZ."""
    made = bpy.data.objects.new(name, data)
    made.location = location
    made.rotation_euler = [math.radians(angle) for angle in rotation]
    made.scale = scale
    bpy.context.scene.collection.objects.link(made)
    return made


def camera(location=(0.0, -6.0, 4.0), target=(0.0, -0.1, 0.55), lens=68.0):
    made = link("Camera", bpy.data.cameras.new("Camera"), location)
    made.rotation_euler = (Vector(target) - Vector(location)).to_track_quat('-Z', 'Y').to_euler()
    made.data.lens = lens
    bpy.context.scene.camera = made
    return made


# Meshes ----------------------------------------------------------------------------------------------------------

def mesh(name, vertices, faces, uvs=None, smooth=False):
    """`uvs` holds one pair per corner, in the order of the faces."""
    made = bpy.data.meshes.new(name)
    made.from_pydata(vertices, [], faces)
    if uvs:
        layer = made.uv_layers.new(name="UVMap")
        for place, uv in zip(layer.data, uvs):
            place.uv = uv
    made.polygons.foreach_set("use_smooth", [smooth] * len(made.polygons))
    made.update()
    return made


def plane(name, size=6.0):
    half = size / 2
    corners = [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)]
    return mesh(name, corners, [(0, 1, 2, 3)], [(0, 0), (1, 0), (1, 1), (0, 1)])


def box(name):
    """From −1 to 1, each face with the whole of the UV square."""
    vertices = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return mesh(name, vertices, faces, [(0, 0), (1, 0), (1, 1), (0, 1)] * 6)


def sphere(name, segments=48, rings=24):
    """Radius 1, smooth, UV as longitude and latitude."""
    vertices, faces, uvs = [], [], []
    for ring in range(rings + 1):
        polar = math.pi * ring / rings
        for segment in range(segments):
            angle = 2 * math.pi * segment / segments
            vertices.append((math.sin(polar) * math.cos(angle), math.sin(polar) * math.sin(angle), math.cos(polar)))
    for ring in range(rings):
        for segment in range(segments):
            after = (segment + 1) % segments
            faces.append((ring * segments + segment, (ring + 1) * segments + segment,
                          (ring + 1) * segments + after, ring * segments + after))
            u, v = segment / segments, 1 - ring / rings
            du, dv = 1 / segments, 1 / rings
            uvs += [(u, v), (u, v - dv), (u + du, v - dv), (u + du, v)]
    return mesh(name, vertices, faces, uvs, smooth=True)


# Nodes -----------------------------------------------------------------------------------------------------------

class Tree:
    """A node tree that is empty but for its output."""

    def __init__(self, owner, output):
        if not owner.node_tree:
            owner.use_nodes = True
        self.tree = owner.node_tree
        self.tree.nodes.clear()
        self.output = self.tree.nodes.new(output)

    def node(self, kinds, settings=None, **inputs):
        """The first of `kinds` that this Blender knows. `inputs` by identifier, "_" for a space; a socket is linked,
        a value set, and a name that this Blender has not is passed over if `settings` has it under another."""
        made = None
        for kind in kinds if isinstance(kinds, tuple) else (kinds,):
            try:
                made = self.tree.nodes.new(kind)
                break
            except RuntimeError:
                continue
        for name, value in (settings or {}).items():
            setattr(made, name, value)
        for name, value in inputs.items():
            self.put(socket(made, name), value)
        return made

    def put(self, target, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, target)
        elif isinstance(value, bpy.types.Node):
            self.tree.links.new(value.outputs[0], target)
        else:
            target.default_value = value

    def finish(self, shader):
        self.put(self.output.inputs["Surface"], shader)


# Names of the Principled BSDF before and after 4.0.
RENAMED = {"Transmission": "Transmission Weight", "Specular": "Specular IOR Level", "Clearcoat": "Coat Weight",
           "Sheen": "Sheen Weight", "Subsurface": "Subsurface Weight"}


def socket(node, name):
    name = name.replace("_", " ")
    for item in node.inputs:
        if item.identifier in (name, name.replace(" ", "_"), RENAMED.get(name)):
            return item
    raise KeyError("%s has no input %s" % (node.bl_idname, name))


def material(name, build):
    """`build(tree)` returns the surface's shader node."""
    made = bpy.data.materials.new(name)
    tree = Tree(made, "ShaderNodeOutputMaterial")
    tree.finish(build(tree))
    return made


def diffuse(reflectance=0.6, roughness=0.0):
    return material("Diffuse", lambda tree: tree.node(
        "ShaderNodeBsdfDiffuse", Color=colour(reflectance), Roughness=roughness))


def emission(strength, tint=1.0):
    return material("Emission", lambda tree: tree.node(
        "ShaderNodeEmission", Color=colour(tint), Strength=strength))


def colour(value):
    return (*value, 1.0) if isinstance(value, tuple) else (value, value, value, 1.0)


# Lights ----------------------------------------------------------------------------------------------------------

def world(strength, tint=1.0):
    made = bpy.data.worlds.new("World")
    bpy.context.scene.world = made
    tree = Tree(made, "ShaderNodeOutputWorld")
    tree.finish(tree.node("ShaderNodeBackground", Color=colour(tint), Strength=strength))
    return made


def world_image(picture, rotation=(0, 0, 0), strength=1.0):
    made = bpy.data.worlds.new("World")
    bpy.context.scene.world = made
    tree = Tree(made, "ShaderNodeOutputWorld")
    place = tree.node("ShaderNodeTexCoord").outputs["Generated"]
    turned = tree.node("ShaderNodeMapping", Vector=place, Rotation=Euler([math.radians(a) for a in rotation]))
    found = tree.node("ShaderNodeTexEnvironment", {"image": picture}, Vector=turned)
    tree.finish(tree.node("ShaderNodeBackground", Color=found, Strength=strength))
    return made


def light(kind, energy, location=(1.5, -1.5, 3.0), target=(0.0, 0.0, 0.3), **settings):
    """Shines towards `target`."""
    data = bpy.data.lights.new("Light", kind)
    data.energy = energy
    for name, value in settings.items():
        setattr(data, name, value)
    made = link("Light", data, location)
    made.rotation_euler = (Vector(target) - Vector(location)).to_track_quat('-Z', 'Y').to_euler()
    return made


# What the lamps shine on -----------------------------------------------------------------------------------------

def still_life(surface=None, floor=None):
    """A floor, a sphere and a turned box: every direction of a normal, contact, shadow and a gap."""
    surface = surface or diffuse()
    placed = [
        link("Floor", plane("Floor", 8.0)),
        link("Sphere", sphere("Sphere"), (-0.9, 0.2, 0.8), (0, 20, 0), (0.8, 0.8, 0.8)),
        link("Box", box("Box"), (0.9, 0.0, 0.61), (0, 0, 30), (0.5, 0.6, 0.6)),
    ]
    for item in placed:
        item.data.materials.append(surface)
    placed[0].data.materials[0] = floor or diffuse(0.5)
    camera()
    return placed
