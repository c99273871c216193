"""Stokes' nodes are plain groups: they look right without the add-on, keep their settings, and copies are independent."""

import json
import os
import subprocess
import zlib

import pytest

from hosts import ROOT, oldest_and_newest

CORE = ROOT / "build" / "stokes"

TOOLS = """
from addon import nodes
material = bpy.data.materials.new("M")
material.use_nodes = True
material.use_fake_user = True
tree = material.node_tree
"""

# What a colleague's Blender sees, where nobody has heard of Stokes: no add-on is registered.
STRANGER = """
import bpy, json, os, sys
bpy.ops.wm.open_mainfile(filepath=os.path.join(os.environ["TMP_PATH"], "made.blend"))
tree = bpy.data.materials["M"].node_tree
told = {"types": [node.bl_idname for node in tree.nodes], "labels": [node.label for node in tree.nodes]}
scene = bpy.context.scene
scene.render.engine = 'CYCLES'
scene.cycles.samples, scene.cycles.use_denoising = 16, False
scene.render.resolution_x = scene.render.resolution_y = 8
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = 'OPEN_EXR'
scene.render.filepath = os.path.join(os.environ["TMP_PATH"], "approximation.exr")
bpy.ops.render.render(write_still=True)
image = bpy.data.images.load(scene.render.filepath)
image.colorspace_settings.is_data = True
values = list(image.pixels)
told["mean"] = [sum(values[channel::4]) / (len(values) // 4) for channel in range(3)]
bpy.ops.wm.save_as_mainfile(filepath=os.path.join(os.environ["TMP_PATH"], "saved.blend"))
print("\\nTOLD " + json.dumps(told), flush=True)
"""


def tell(host, tmp_path, code):
    return host.run(TOOLS + code, tmp_path)


def test_every_kind_is_a_group_with_its_sockets(host, tmp_path):
    found = tell(host, tmp_path, """
told = []
for kind in nodes.KINDS.values():
    made = nodes.new(tree, kind.name)
    told.append([made.bl_idname, [s.name for s in made.inputs] == [s.name for s in kind.inputs],
                 [s.name for s in made.outputs] == [s.name for s in kind.outputs], bool(made.label),
                 nodes.kind_of(made) is kind, bool(made.node_tree.nodes)])
tell(told)
""")
    assert len(found) == 12 and all(entry == ["ShaderNodeGroup", True, True, True, True, True] for entry in found)


def test_a_file_looks_right_and_loses_nothing_without_the_addon(host, tmp_path):
    """Made with the add-on, rendered by Cycles and saved without it, opened with it again."""
    tell(host, tmp_path, """
scene = empty_scene()
paint = None
material = bpy.data.materials.new("M")
material.use_nodes = True
tree = material.node_tree
paint = nodes.new(tree, "fluorescent", dye="rhodamine-6g_ethanol", absorbance=1.5)
nodes.set_input(paint, "Reflectance", (1, 1, 1))
glass = nodes.new(tree, "dispersive_glass", model='CAUCHY', cauchy_b=.0125)
tree.links.new(paint.outputs[0], tree.get_output_node('CYCLES').inputs[0])
plane = add_mesh("Plane", ((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)))
plane.data.materials.append(material)
sun = bpy.data.lights.new("Sun", 'SUN'); sun.energy = math.pi
add("Sun", sun, (0, 0, 3))
bpy.ops.wm.save_as_mainfile(filepath=os.path.join(TMP, "made.blend"))
tell(0)
""")
    script = tmp_path / "stranger.py"
    script.write_text(STRANGER)
    done = subprocess.run([*host.command, str(script)], timeout=60, text=True, cwd=tmp_path,
                          env=dict(os.environ, TMP_PATH=str(tmp_path)),
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    told = [json.loads(line[5:]) for line in done.stdout.splitlines() if line.startswith("TOLD ")]
    assert told, done.stdout
    assert "NodeUndefined" not in told[0]["types"]
    red, green, blue = told[0]["mean"]
    assert red > 0.8 and 0.3 < green < red and blue < 0.9 * red  # white, less what the dye takes, plus its orange
    found = host.run("""
from addon import nodes
bpy.ops.wm.open_mainfile(filepath=os.path.join(TMP, "saved.blend"))
kept = {nodes.kind_of(n).name: nodes.settings_of(n) for n in bpy.data.materials["M"].node_tree.nodes if nodes.kind_of(n)}
tell([kept["fluorescent"].dye, kept["fluorescent"].absorbance, kept["dispersive_glass"].model,
      kept["dispersive_glass"].cauchy_b])
""", tmp_path)
    assert found == ["rhodamine-6g_ethanol", 1.5, "CAUCHY", pytest.approx(0.0125)]


@oldest_and_newest
def test_a_copy_goes_its_own_way_once_it_is_edited(host, tmp_path):
    found = tell(host, tmp_path, """
def inside(node):
    return [tuple(n.outputs[0].default_value) for n in node.node_tree.nodes if n.bl_idname == "ShaderNodeRGB"]

first = nodes.new(tree, "spectrum_library", colorchecker="colorchecker/red")
before = inside(first)
twin = material.copy().node_tree.nodes[first.name]
same = twin.node_tree == first.node_tree
twin.stokes.spectrum_library.colorchecker = "colorchecker/blue"
tell([same, first.label, twin.label, inside(first) == before, inside(twin) == before,
      first.node_tree.stokes.spectrum_library.colorchecker, twin.node_tree.stokes.spectrum_library.colorchecker])
""")
    assert found == [True, "Red", "Blue", True, False, "colorchecker/red", "colorchecker/blue"]


@oldest_and_newest
def test_a_group_added_by_hand_is_known_by_its_tree(host, tmp_path):
    found = tell(host, tmp_path, """
made = nodes.new(tree, "conductor", metal="Cu")
by_hand = tree.nodes.new("ShaderNodeGroup")
by_hand.node_tree = made.node_tree
tell([nodes.kind_of(by_hand).name, nodes.settings_of(by_hand).metal, by_hand.stokes.kind])
""")
    assert found == ["conductor", "Cu", ""]


@oldest_and_newest
def test_a_wrong_setting_is_an_error_that_leaves_nothing_behind(host, tmp_path):
    found = tell(host, tmp_path, """
before = len(tree.nodes), len(bpy.data.node_groups)
told = []
for kind, settings, sockets in (("fluorescent", {"dye": "ink"}, {}), ("fluorescent", {"colour": 1}, {}),
                                ("conductor", {}, {"Rust": 1}), ("nothing", {}, {})):
    try:
        nodes.new(tree, kind, sockets=sockets, **settings)
        told.append("made")
    except (TypeError, AttributeError, KeyError) as error:
        told.append(type(error).__name__)
tell([told, before == (len(tree.nodes), len(bpy.data.node_groups))])
""")
    assert found == [["TypeError", "AttributeError", "KeyError", "KeyError"], True]


@oldest_and_newest
def test_numbers_of_menu_entries_are_unique_and_do_not_depend_on_their_order(host, tmp_path):
    found = tell(host, tmp_path, """
from addon.nodes import library, fluorescent
names = library.names() + fluorescent.dyes()
numbers = [library.number(name) for name in names]
tell([len(set(numbers)) == len(set(names)), library.number("dye/fluorescein_ph13/emission"), max(numbers) < 2 ** 31])
""")
    assert found == [True, 0x3fffffff & zlib.crc32(b"dye/fluorescein_ph13/emission"), True]


@pytest.mark.skipif(not CORE.exists(), reason="the core is not built")
def test_the_menus_list_what_the_core_knows():
    """library.json is made from the core; here it is held against it: names, and values on the grid."""
    library = json.loads((ROOT / "addon" / "nodes" / "library.json").read_text())

    def core(*arguments):
        return subprocess.run([CORE, "spectrum", *arguments], check=True, timeout=30, text=True,
                              capture_output=True).stdout.splitlines()
    assert set(library["entries"]) == {name for name in core("list") if not name.startswith("glass/")}
    for name in ("colorchecker/cyan", "illuminant/D65", "dye/rhodamine-b_ethanol/emission", "metal/Au/k", "lamp/LED-B4"):
        values = [float(line.split()[1]) for line in core("show", name, "300", "830", "5")]
        assert library["entries"][name] == pytest.approx(values, rel=1e-4, abs=1e-6), name


@oldest_and_newest
def test_the_swatches_are_colours_of_the_spectra(host, tmp_path):
    found = tell(host, tmp_path, """
from addon.nodes import library, conductor
tell([library.reflected([1.0] * 107), library.emitted(library.values("illuminant/D65")),
      library.reflected(library.values("colorchecker/red")), conductor.color_of("Au")])
""")
    assert found[0] == pytest.approx([1, 1, 1], abs=2e-3)  # the white of Rec. 709 is D65
    assert found[1] == pytest.approx([1, 1, 1], abs=2e-3)
    red, green, blue = found[2]
    assert red > 4 * green and red > 4 * blue
    red, green, blue = found[3]
    assert red > green > blue and red > 0.8
