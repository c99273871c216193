"""One add-on for every Blender: what it exports of one scene is the same bytes, and the picture the same. The scene holds what
means the same in each of them; what Cycles itself changed between two versions (area lamps, Principled, rough glass) is
exported as the running Blender means it, and compared with its Cycles in test_cycles_parity.py.

What is not the same is Blender's own arithmetic:
    color: the config that Blender ships, the name of its working space, and the matrix to XYZ that it computes from them
    corner_normals: Blender before 4.1 averages smooth normals in another order"""

import json
import subprocess
import sys
from array import array

import numpy as np
import pytest

import blenders
import hosts
from addon.core import stream
from hosts import NAMES, ROOT, host_named

sys.path.append(str(ROOT / "tests" / "system"))
import exr  # noqa: E402

CORE = ROOT / "build" / "stokes"
REFERENCE = "4.5"

SCENE = """
from addon import nodes

def material(name):
    made = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    made.node_tree.nodes.clear()
    return made, made.node_tree

def finish(tree, shader):
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])

scene = empty_scene(samples=8, size=(48, 32))
scene.view_settings.view_transform, scene.view_settings.look = 'Standard', 'None'
scene.render.filter_size = 1.5

glow, tree = material("Glow")
paint = nodes.new(tree, "fluorescent", dye="rhodamine-6g_ethanol", sockets={"Concentration": 0.7, "Yield": 0.9})
white = nodes.new(tree, "spectrum_library", colorchecker="colorchecker/white")
tree.links.new(white.outputs[0], nodes.input_of(paint, "Reflectance"))
finish(tree, paint)
glass, tree = material("Glass")
finish(tree, nodes.new(tree, "dispersive_glass", model='CAUCHY', cauchy_b=0.0125))
metal, tree = material("Metal")
finish(tree, nodes.new(tree, "conductor", metal="Cu", sockets={"Roughness": 0.3}))
lit, tree = material("Lit")
emission = tree.nodes.new("ShaderNodeEmission")
emission.inputs["Strength"].default_value = 3
heat = nodes.new(tree, "spectrum_blackbody", sockets={"Temperature": 4000})
tree.links.new(heat.outputs[0], emission.inputs["Color"])
finish(tree, emission)
mixed, tree = material("Mixed")
diffuse, clear, mix = (tree.nodes.new("ShaderNode" + kind) for kind in ("BsdfDiffuse", "BsdfTransparent", "MixShader"))
diffuse.inputs["Color"].default_value = (0.8, 0.3, 0.1, 1)
picture = bpy.data.images.new("Picture", 4, 4)
picture.pixels = [((7 * i) % 11) / 10 if i % 4 < 3 else 1 for i in range(64)]
texture = tree.nodes.new("ShaderNodeTexImage")
texture.image = picture
tree.links.new(texture.outputs[0], diffuse.inputs["Color"])
mix.inputs[0].default_value = 0.25
tree.links.new(diffuse.outputs[0], mix.inputs[1])
tree.links.new(clear.outputs[0], mix.inputs[2])
finish(tree, mix)
haze, tree = material("Haze")
filling = tree.nodes.new("ShaderNodeVolumeScatter")
filling.inputs["Density"].default_value, filling.inputs["Anisotropy"].default_value = 0.7, 0.4
blue = nodes.new(tree, "spectrum_gaussian", sockets={"Mean": 450, "Sigma": 80, "Peak": 0.9})
tree.links.new(blue.outputs[0], filling.inputs["Color"])
tree.links.new(filling.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Volume"])

floor = add_mesh("Floor", ((-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)))
floor.data.materials.append(glow)
layer = floor.data.uv_layers.new(name="Map")
for i, corner in enumerate(layer.data):
    corner.uv = (i % 2, i // 2)
CUBE = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
block = add_mesh("Block", CUBE, FACES)
block.location, block.rotation_euler = (-2, -1, 0.1), (0.1, 0.2, 0.3)
block.data.materials.append(glass)
fog = add_mesh("Fog", CUBE, FACES)
fog.location, fog.scale = (0.8, -2.2, 0.05), (1.2, 1, 1.5)
fog.data.materials.append(haze)
for number in range(3):
    copy = add("Copy%d" % number, block.data, (number - 1, 1, 0.5))
    copy.scale = (0.5, 0.5, 0.5 + number / 4)
    copy.rotation_euler.z = number
bent = add_mesh("Bent", ((0, -2, 0), (1, -2, 1), (2, -2, 0.2), (0, -1, 0), (1, -1, 1), (2, -1, 0)), ((0, 1, 4, 3), (1, 2, 5, 4)))
bent.data.polygons.foreach_set("use_smooth", [True, True])
bent.data.materials.append(metal)
bent.data.materials.append(mixed)
bent.data.polygons[1].material_index = 1
layer = bent.data.uv_layers.new(name="Map")
for i, corner in enumerate(layer.data):
    corner.uv = (i / 7, (i * 3 % 8) / 7)
lamp = add_mesh("Lamp", ((-0.5, -0.5, 3), (-0.5, 0.5, 3), (0.5, 0.5, 3), (0.5, -0.5, 3)))
lamp.data.materials.append(lit)
child, parent = add_mesh("Child", CUBE, FACES), add_mesh("Parent", ((-1, -2.5, 0), (0, -2.5, 0), (0.5, -2.5, 0)), ((0, 1, 2),))
child.scale = (0.3, 0.3, 0.3)
child.parent = parent
parent.instance_type = 'VERTS'
modified = add_mesh("Modified")
modified.location = (1.5, 1.5, 0.2)
modified.modifiers.new("array", 'ARRAY').count = 3
for name, kind, place, values in (("Point", 'POINT', (2, -2, 2), {"shadow_soft_size": 0}),
                                  ("Sphere", 'POINT', (-2, 2, 2), {"shadow_soft_size": 0.3}),
                                  ("Sun", 'SUN', (0, 0, 4), {"angle": 0})):
    light = bpy.data.lights.new(name, kind)
    light.energy = 1 if kind == 'SUN' else 40
    light.color = (1, 0.8, 0.6)
    for key, value in values.items():
        setattr(light, key, value)
    add(name, light, place).rotation_euler = (0.3, 0.2, 0)
world = scene.world = bpy.data.worlds.new("World")
if bpy.app.version < (5, 0, 0):
    world.use_nodes = True
world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.5, 1)
scene.camera.location, scene.camera.rotation_euler = (4, -5, 3.5), (1.1, 0.05, 0.65)
scene.camera.data.lens, scene.camera.data.shift_x = 40, 0.05
scene.camera.data.dof.use_dof, scene.camera.data.dof.focus_distance = True, 6.5
os.environ["STOKES_RECORD"] = os.path.join(TMP, "scene.stokes")
scene.render.image_settings.exr_codec = 'ZIP'
tell(save_exr("picture.exr"))
"""


@pytest.fixture(scope="session")
def record(tmp_path_factory):
    """record(name): where that Blender left scene.stokes and picture.exr."""
    done = {}

    def of(name):
        if name not in done:
            host, place = host_named(name), tmp_path_factory.mktemp("blender")
            host.run(SCENE, place, env={"STOKES_CORE": str(CORE)})
            done[name] = place
        return done[name]

    return of


def split(path):
    """The scene's frames without `color`, which is Blender's own, and the members of that."""
    frames = stream.read(path)
    colors = [members for message, members, _ in frames if message == "color"]
    assert len(colors) == 1
    return [frame for frame in frames if frame[0] != "color"], colors[0]


def without_normals(frames):
    """(frames as text and bytes with all corner normals taken out, those normals)."""
    kept, normals = [], array("f")
    for message, members, area in frames:
        area = bytearray(area)
        if "corner_normals" in members:
            at, size = members["corner_normals"]["at"], members["corner_normals"]["bytes"]
            normals.frombytes(bytes(area[at : at + size]))
            area[at : at + size] = bytes(size)
        kept.append((message, json.dumps(members), bytes(area)))
    return kept, normals


def render(path, out):
    subprocess.run([CORE, "render", path, "-o", out, "-q"], check=True, timeout=100)
    return exr.read(out)


def with_color(path, color, out):
    """The scene file with the colours of another Blender."""
    with stream.Recorder(out) as recorder:
        for message, members, area in stream.read(path)[1:]:
            recorder.file.writelines(frame(message, color if message == "color" else members, area))
    return out


def frame(message, members, area):
    """As bytes; `members` name places in `area` already."""
    head, *text = stream.encode(message, members)
    return [stream.HEAD.pack(*stream.HEAD.unpack(head)[:4], len(area)), *text, bytes(area)]


pytestmark = pytest.mark.skipif(not CORE.exists(), reason="build/stokes is not built")
others = pytest.mark.parametrize("name", [name for name in NAMES if name != REFERENCE])


@others
def test_every_blender_exports_the_same_bytes_and_renders_the_same_bits(record, name, tmp_path):
    """3.4 has other last digits in its smooth normals, and so has its picture. Where the bytes are the same the picture's bits
    are, once both are given one Blender's colours."""
    mine, expected = record(name), record(REFERENCE)
    frames, color = split(mine / "scene.stokes")
    reference, reference_color = split(expected / "scene.stokes")
    assert color.keys() == reference_color.keys()
    (bytes_, normals), (reference_bytes, reference_normals) = without_normals(frames), without_normals(reference)
    assert bytes_ == reference_bytes
    assert np.allclose(normals, reference_normals, rtol=0, atol=1e-6) and len(normals) == len(reference_normals) > 0
    assert name == "3.4" or normals == reference_normals

    recolored = with_color(mine / "scene.stokes", reference_color, tmp_path / "scene.stokes")
    picture, reference_picture = render(recolored, tmp_path / "a.exr"), render(expected / "scene.stokes", tmp_path / "b.exr")
    if normals == reference_normals:
        assert np.array_equal(picture.sums(), reference_picture.sums()) and picture.sums().any()
    else:
        assert_close(picture, reference_picture, 1e-5)


@others
def test_the_picture_in_every_blender_is_the_same(record, name):
    """Their matrices to XYZ differ by 0.02 %, which colours it by as much."""
    assert_close(*(exr.read(record(which) / "picture.exr") for which in (name, REFERENCE)), 1e-3)


def assert_close(first, second, limit):
    """Pixels differ by less than so much of the picture's mean, on average: the few paths that a last digit sends elsewhere may
    differ by more."""
    for channel in "RGBA":
        a, b = first.channels[channel], second.channels[channel]
        assert a.shape == b.shape
        assert np.abs(a - b).mean() < limit * max(abs(b.mean()), 1e-3), channel


def test_a_recorded_scene_is_the_blenders_own_picture(record, tmp_path):
    shown = exr.read(record(REFERENCE) / "picture.exr")
    replayed = render(record(REFERENCE) / "scene.stokes", tmp_path / "a.exr")
    for channel in "RGBA":
        assert np.array_equal(shown.channels[channel], replayed.channels[channel])


def test_a_blender_that_cannot_be_had_is_skipped_by_name(monkeypatch, tmp_path):
    """5.1 and later need Python 3.13, which not every system has; the newest is then the one before."""
    monkeypatch.setattr(blenders, "HOME", tmp_path)
    monkeypatch.setattr(blenders, "_pythons", lambda version: [])
    for name in ("_find", "blender"):  # not what they remember
        monkeypatch.setattr(blenders, name, getattr(blenders, name).__wrapped__)
    with pytest.raises(pytest.skip.Exception, match="Blender 5.2 is missing: there is no Python 3.13 to load it"):
        host_named("5.2")
    monkeypatch.setattr(hosts, "_command", lambda name: _missing(name) if name == "5.2" else [name])
    assert hosts.newest().name == "5.0"


def _missing(name):
    raise blenders.Missing(name)
