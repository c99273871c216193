"""What the translators say, the core takes: every node of this Blender, and nodes set beyond what makes sense."""

import pytest

from hosts import ROOT, oldest_and_newest

CORE = ROOT / "build" / "stokes"

SCENE = """
from addon import nodes
scene = empty_scene(samples=1, size=(16, 16))
picture = bpy.data.images.new("Picture", 4, 4)
picture.pack()
count = 0

def show(name, make, identifier="Surface"):
    \"\"\"A square of a material whose surface, or volume, is what make(tree) returns.\"\"\"
    global count
    x, y = divmod(count, 12)
    count += 1
    plane = add_mesh(name, ((x, y, 0), (x + 1, y, 0), (x + 1, y + 1, 0), (x, y + 1, 0)))
    material = add_material(name, plane.data)
    material.use_nodes = True
    tree = material.node_tree
    socket = make(tree)
    end = next(s for s in tree.get_output_node('CYCLES').inputs if s.identifier == identifier)
    tree.links.new(socket, end)

def through(tree, bl_idname, source, *identifiers):
    shader = tree.nodes.new(bl_idname)
    for socket in shader.inputs:
        if socket.identifier in identifiers:
            tree.links.new(source, socket)
    return shader.outputs[0]

def node_of(tree, bl_idname, value):
    made = tree.nodes.new(bl_idname)
    if hasattr(made, "image"):
        made.image = picture
    for socket in made.inputs:
        if value is not None and socket.type == 'VALUE':
            socket.default_value = value
        elif value is not None and socket.type == 'RGBA':
            socket.default_value = (value, value / 2, value, 1)
    return made

def add_kind(name, make, value):
    node = make(bpy.data.materials["Probe"].node_tree)
    if not node.outputs:
        return
    for i, output in enumerate(node.outputs):
        title = "%s %d %s" % (name, i, value)
        if output.type == 'SHADER':
            show(title, lambda tree: make(tree).outputs[i])
            show(title + " V", lambda tree: make(tree).outputs[i], "Volume")
        elif output.enabled:
            show(title + " D", lambda tree: through(tree, "ShaderNodeBsdfDiffuse", make(tree).outputs[i],
                                                    "Color", "Roughness", "Normal"))
            show(title + " P", lambda tree: through(tree, "ShaderNodeBsdfPrincipled", make(tree).outputs[i],
                                                    "Base Color", "Metallic", "Emission", "Emission Color", "Alpha"))
            show(title + " S", lambda tree: through(tree, "ShaderNodeVolumeScatter", make(tree).outputs[i],
                                                    "Color", "Density", "Anisotropy"), "Volume")
            show(title + " E", lambda tree: through(tree, "ShaderNodeEmission", make(tree).outputs[i],
                                                    "Color", "Strength"))

probe = bpy.data.materials.new("Probe")
probe.use_nodes = True
kinds = []
for bl_idname in sorted(dir(bpy.types)):
    if bl_idname.startswith("ShaderNode"):
        try:
            probe.node_tree.nodes.new(bl_idname)
        except RuntimeError:
            continue
        kinds.append(bl_idname)
for value in VALUES:
    for bl_idname in kinds:
        add_kind(bl_idname, lambda tree: node_of(tree, bl_idname, value), value)
    for kind in nodes.KINDS:
        def make(tree):
            made = nodes.new(tree, kind)
            for socket in made.inputs:
                if value is not None and socket.type in {'VALUE', 'RGBA'}:
                    socket.default_value = value if socket.type == 'VALUE' else (value, value / 2, value, 1)
            return made
        add_kind(kind, make, value)
bpy.ops.render.render()
tell([count, len(kinds)])
"""

CHOICES = """
def choices(kind):
    \"\"\"Settings that make each item of each drop-down count: a drop-down may itself be picked in another one.\"\"\"
    drops = [prop for prop in kind.Settings.bl_rna.properties if prop.type == 'ENUM']
    for prop in drops:
        above = {drop.identifier: item.identifier for drop in drops for item in drop.enum_items
                 if item.identifier.lower() == prop.identifier}
        for item in prop.enum_items:
            yield dict(above, **{prop.identifier: item.identifier})

for kind in nodes.KINDS.values():
    for settings in choices(kind) if kind.Settings else ():
        add_kind("%s %s" % (kind.name, settings), lambda tree: nodes.new(tree, kind.name, **settings), None)
bpy.ops.render.render()
tell(count)
"""


@pytest.mark.skipif(not CORE.exists(), reason="the core is not built")
@pytest.mark.parametrize("values", ["(None, 0.0)", "(-3.0, 1e6)"])
@oldest_and_newest
def test_the_core_takes_whatever_a_node_may_say(host, tmp_path, values):
    """A frame that the core refuses ends the render with an error that names the material."""
    count, kinds = host.run(SCENE.replace("VALUES", values), tmp_path, env={"STOKES_CORE": str(CORE)})
    assert kinds > 80 and count > 500


@pytest.mark.skipif(not CORE.exists(), reason="the core is not built")
@oldest_and_newest
def test_the_core_takes_every_choice_of_every_drop_down(host, tmp_path):
    scene = SCENE[: SCENE.index("probe = ")] + 'probe = bpy.data.materials.new("Probe")\nprobe.use_nodes = True\n'
    assert host.run(scene + CHOICES, tmp_path, env={"STOKES_CORE": str(CORE)}) > 500
