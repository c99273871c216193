"""Panels, menus and operators: in the background what can be asked there, and every tab in a real window."""

import pytest

from hosts import ROOT, host_named, oldest_and_newest, output_in_window, told_in

CORE = ROOT / "build" / "stokes"

WINDOW = """
import traceback
from addon import nodes, ui
addon.unregister()
for file in ui._FILES:
    for item in file.CLASSES:
        if 'DEFAULT_CLOSED' in getattr(item, "bl_options", ()) and "preview" not in item.__name__:
            item.bl_options = set()
addon.register()
scene = bpy.context.scene
scene.render.engine = 'STOKES'
bpy.context.preferences.view.show_splash = False
cube = bpy.data.objects["Cube"]
tree = cube.data.materials[0].node_tree
for kind in nodes.KINDS:
    made = nodes.new(tree, kind)
paint = nodes.new(tree, "fluorescent", dye="rhodamine-6g_ethanol")
tree.nodes.active = paint
for owner, shader in ((tree, "ShaderNodeVolumeScatter"), (scene.world.node_tree, "ShaderNodeVolumeAbsorption")):
    haze = nodes.new(owner, "spectrum_gaussian")
    filling = owner.nodes.new(shader)
    owner.links.new(haze.outputs[0], filling.inputs["Color"])
    owner.links.new(filling.outputs[0], owner.get_output_node('CYCLES').inputs["Volume"])
bpy.ops.stokes.check_scene()
window = bpy.context.window_manager.windows[0]
seen = []

def area(kind):
    return next(a for a in window.screen.areas if a.type == kind)

def show(what):
    if what in {'NODES', 'UNDO'}:
        if what == 'NODES':
            area('VIEW_3D').ui_type = 'ShaderNodeTree'
            area('NODE_EDITOR').spaces[0].show_region_ui = True
        else:
            undo()
        return
    if what.startswith('LIGHT'):
        bpy.context.view_layer.objects.active = bpy.data.objects["Light"]
        bpy.data.lights[0].type = what[6:]
        with bpy.context.temp_override(window=window, area=area('PROPERTIES'), object=bpy.data.objects["Light"]):
            bpy.ops.stokes.light_spectrum(spectrum='UV365')
        what = 'DATA'
    area('PROPERTIES').spaces[0].context = what

def undo():
    editor = area('NODE_EDITOR')
    region = next(r for r in editor.regions if r.type == 'WINDOW')
    before = len(tree.nodes)
    with bpy.context.temp_override(window=window, area=editor, region=region):
        bpy.ops.ed.undo_push(message="before")
        bpy.ops.stokes.add_node(kind="spectrum_line")
        added = len(bpy.data.materials["Material"].node_tree.nodes) - before
        bpy.ops.ed.undo_push(message="after")
        bpy.ops.ed.undo()
    left = len(bpy.data.materials["Material"].node_tree.nodes) - before
    seen.append(["undo", added, left])

STEPS = ['RENDER', 'OUTPUT', 'VIEW_LAYER', 'SCENE', 'WORLD', 'OBJECT', 'MATERIAL', 'NODES', 'UNDO',
         'LIGHT POINT', 'LIGHT SUN', 'LIGHT SPOT', 'LIGHT AREA']

# While a preview is being made, in a thread of its own, Blender refuses writes and operators of every other script.
BUSY = ("can't modify blend data in this state", "Writing to ID classes in this context is not allowed")

def step():
    try:
        if not STEPS:
            tell(seen)
            bpy.ops.wm.quit_blender()
            return None
        show(STEPS[0])
        seen.append(STEPS.pop(0))
        return 0.4
    except Exception as error:
        if any(words in str(error) for words in BUSY):
            return 0.2
        traceback.print_exc()
        sys.stdout.flush()
        os._exit(1)

bpy.app.timers.register(step, first_interval=1)
"""


def test_registering_twice_leaves_no_trace(host, tmp_path):
    found = host.run("""
def marked():
    return sum('STOKES' in getattr(panel, "COMPAT_ENGINES", ()) for panel in bpy.types.Panel.__subclasses__()
               if not panel.__name__.startswith("STOKES"))

told = [marked()]
addon.unregister()
told += [marked(), hasattr(bpy.types.Scene, "stokes"), hasattr(bpy.types, "STOKES_PT_sampling")]
addon.register()
told += [marked(), hasattr(bpy.types.Scene, "stokes")]
tell(told)
""", tmp_path)
    assert found[0] > 50 and found[1:4] == [0, False, False] and found[4:] == [found[0], True]


@oldest_and_newest
def test_every_setting_reaches_the_stream_as_it_was_typed(host, tmp_path):
    found = host.run("""
from addon import properties
scene = empty_scene()
settings = scene.stokes
settings.shrink, settings.d0, settings.seed, settings.animate_seed = 0.3, 12.5, 7, True
settings.lambda_min, settings.lambda_max = 700, 600
scene.frame_set(5)
scene.render.filter_size = 2.2
settings.time_limit = 3
told = [properties.stream_settings(scene), properties.stream_settings(scene, preview=True)["time_limit"]]
settings.use_record, settings.record_path = True, "/x/a_###.stokes"
told.append(properties.record_path(scene))
tell(told)
""", tmp_path)
    message = found[0]
    assert (message["shrink"], message["d0"], message["seed"], message["filter_width"]) == (0.3, 12.5, 12, 2.2)
    assert message["lambda_max"] > message["lambda_min"]
    assert message["time_limit"] == 3 and found[1] == 0
    assert found[2] == "/x/a_005.stokes"


@oldest_and_newest
def test_presets_set_what_they_say(host, tmp_path):
    found = host.run("""
from addon import properties
settings = bpy.context.scene.stokes
told = []
for name, (_label, _tooltip, values) in properties.PRESETS.items():
    bpy.ops.stokes.preset(name=name)
    told.append(all(abs(getattr(settings, key) - value) < 1e-6 if not isinstance(value, str)
                    else getattr(settings, key) == value for key, value in values.items()))
tell(told)
""", tmp_path)
    assert found == [True] * 5


@pytest.mark.skipif(not CORE.exists(), reason="the core is not built")
@oldest_and_newest
def test_the_core_takes_every_preset_and_both_ends_of_every_setting(host, tmp_path):
    refused, tried = host.run("""
from addon import properties
from addon.core.client import Client, CoreError
settings = bpy.context.scene.stokes
refused, tried = [], 0

def offer(what):
    global tried
    tried += 1
    with Client() as core:
        try:
            core.send("settings", **properties.stream_settings(bpy.context.scene))
            core.wait_done()
        except CoreError as error:
            refused.append([what, str(error)])

for name in properties.PRESETS:
    bpy.ops.stokes.preset(name=name)
    offer(name)
for width in (0, 500):
    bpy.context.scene.render.filter_size = width
    offer(["filter_size", width])
for prop in settings.bl_rna.properties:
    if prop.type in {'INT', 'FLOAT'}:
        ends = [prop.hard_min, prop.hard_max]
    elif prop.type == 'ENUM' and not prop.is_readonly:
        ends = [item.identifier for item in prop.enum_items]
    else:
        continue
    for end in ends:
        for other in settings.bl_rna.properties:
            settings.property_unset(other.identifier)
        setattr(settings, prop.identifier, end)
        offer([prop.identifier, end])
tell([refused, tried])
""", tmp_path, env={"STOKES_CORE": str(CORE)})
    assert refused == [] and tried > 40


@oldest_and_newest
def test_the_check_lists_what_will_not_be_rendered_as_in_cycles(host, tmp_path):
    found = host.run("""
from addon.ui import report
scene = empty_scene()
plane = add_mesh()
material = add_material("Rough", plane.data)
material.use_nodes = True
tree = material.node_tree
shader = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled")
noise = tree.nodes.new("ShaderNodeTexNoise")
tree.links.new(noise.outputs[1], shader.inputs[0])
picture = tree.nodes.new("ShaderNodeTexImage")
picture.image = bpy.data.images.new("Sheer", 4, 4, alpha=True)
tree.links.new(picture.outputs[0], shader.inputs["Roughness"])
glow = tree.nodes.new("ShaderNodeEmission")
tree.links.new(glow.outputs[0], tree.get_output_node('CYCLES').inputs["Volume"])
told = [report.check(bpy.context)]
scene.render.use_motion_blur = True
scene.camera.data.type = 'PANO'
plane.hide_set(True)  # in the window alone: it is rendered
told.append(report.check(bpy.context))
plane.hide_render = True
scene.camera = None
told.append(report.check(bpy.context))
tell(told)
""", tmp_path)
    nodes, whole, left = ([entry[:2] for entry in part] for part in found)
    assert nodes == [["Rough", "Noise Texture"], ["Rough", "Emission"]]
    camera = ["Camera", "type"]
    assert sorted(whole) == sorted([["Scene", "use_motion_blur"], camera, *nodes])
    assert left == [["Scene", "camera"]]


def test_a_lamp_takes_a_spectrum_and_gives_it_back(host, tmp_path):
    found = host.run("""
from addon.ui import light_spectrum
from addon.export import nodes as translation
class Context:
    blender_version = bpy.app.version
    def warn(self, *words): print(words)
light = bpy.data.lights.new("L", 'POINT')
told = []
for name in ('UV365', 'SODIUM', 'D65', 'RGB'):
    light_spectrum.set_spectrum(light, name)
    told.append([translation.light_emission(light, Context()), len(light.node_tree.nodes)])
tell(told)
""", tmp_path)
    assert found[0][0]["shape"] == {"gaussian": {"mean": 365, "sigma": 5, "peak": 1}}
    assert found[1][0]["shape"] == {"line": {"center": 589.3, "width": 2}}
    assert found[2][0]["shape"] == {"illuminant": "D65"}
    assert found[3][0] == {"rgb": [1, 1, 1], "scale": 1}
    assert [count for _emission, count in found] == [3, 3, 3, 2]


def test_every_tab_draws_in_a_window_and_adding_a_node_can_be_undone(tmp_path):
    """A panel that fails draws nothing and says so on the console."""
    output = output_in_window(WINDOW, tmp_path, (1280, 1024), dict(STOKES_CORE=str(CORE)))
    assert "Error" not in output, output
    (seen,) = told_in(output)
    assert ["undo", 1, 0] in seen and "LIGHT AREA" in seen, output


# Stands for a layout, and for all that a layout gives: notes what is shown in it.
LAYOUT = """
class Layout:
    def __init__(self, shown=None):
        object.__setattr__(self, "shown", [] if shown is None else shown)
    def __getattr__(self, name):
        def call(*arguments, **named):
            self.shown.append([name, *(a if isinstance(a, str) else type(a).__name__ for a in arguments)])
            return Layout(self.shown)
        return call
    def __setattr__(self, name, value):
        if name in {"type", "kind"}:
            self.shown.append([name, value])

class Panel:
    def __init__(self):
        self.layout = Layout()
"""


@oldest_and_newest
def test_every_setting_has_a_place_in_the_render_tab_and_all_have_tooltips(host, tmp_path):
    missing, without, panels = host.run(LAYOUT + """
from addon.ui import render
scene = empty_scene()
shown, panels = set(), 0
for cls in render.CLASSES:
    if not issubclass(cls, bpy.types.Panel) or cls.bl_context != "render":
        continue
    panel = Panel()
    panels += 1
    for draw in (getattr(cls, "draw_header", None), cls.draw):
        draw and draw(panel, bpy.context)
    shown |= {entry[2] for entry in panel.layout.shown if entry[0] == "prop" and entry[1] == "StokesSettings"}
settings = [prop for prop in type(scene.stokes).bl_rna.properties
            if prop.identifier not in {"rna_type", "name"} and not prop.is_hidden]
from addon import nodes
tips = {"%s.%s" % (kind.name, prop.identifier): prop.description
        for kind in nodes.KINDS.values() if kind.Settings for prop in kind.Settings.bl_rna.properties
        if prop.identifier not in {"rna_type", "name"} and not prop.is_hidden and not prop.is_readonly}
tips.update((prop.identifier, prop.description) for prop in settings)
tips.update((kind.name, kind.tooltip) for kind in nodes.KINDS.values())
tell([[prop.identifier for prop in settings if prop.identifier not in shown],
      [name for name, tip in tips.items() if len(tip) < 10], panels])
""", tmp_path)
    assert panels >= 6 and missing == [] and without == []


def test_kernels_that_can_break_a_balance_say_which(tmp_path):
    """Eq. 6 of the supplemental and §2.2: energy with the whole diagonal or a box in both wavelengths, photons with a shift."""
    tips = host_named("3.4").run("""
scene = empty_scene()
items = scene.stokes.bl_rna.properties["kernel"].enum_items
tell({item.identifier: item.description for item in items})
""", tmp_path)
    can_make = {kernel: tip.partition("Can make ")[2] for kernel, tip in tips.items()}
    assert can_make["incident"].startswith("energy") and can_make["box"].startswith("energy")
    assert can_make["asymmetric"].startswith("photons")
    assert not can_make["constant"] and not can_make["incident_reflectance"]
    assert min(map(len, tips.values())) >= 10, tips


def test_the_add_menu_shows_what_blender_3_4_hides_from_other_engines(tmp_path):
    offered = host_named("3.4").run(LAYOUT + """
from addon.ui import node_editor
scene = empty_scene()
class Space:
    type, tree_type, edit_tree = 'NODE_EDITOR', 'ShaderNodeTree', True
class Context:
    space_data, scene, engine = Space, bpy.context.scene, 'STOKES'
menu = Panel()
node_editor.draw_add_menu(menu, Context)
shaders = Panel()
node_editor.STOKES_MT_add_shader.draw(shaders, Context)
ours = Panel()
node_editor.STOKES_MT_add.draw(ours, Context)
is_appended = node_editor.draw_add_menu in [f for f in bpy.types.NODE_MT_add.draw._draw_funcs]
tell([is_appended, *([entry[1] for entry in panel.layout.shown if entry[0] == name]
                     for panel, name in ((menu, "menu"), (shaders, "type"), (ours, "kind")))])
""", tmp_path)
    is_appended, menus, shaders, ours = offered
    assert is_appended and menus == ["STOKES_MT_add", "STOKES_MT_add_shader"]
    assert {"ShaderNodeBsdfPrincipled", "ShaderNodeBsdfDiffuse", "ShaderNodeMixShader", "ShaderNodeEmission",
            "ShaderNodeVolumeScatter", "ShaderNodeVolumeAbsorption"} <= set(shaders)
    assert {"fluorescent", "dispersive_glass", "conductor", "spectrum_file"} <= set(ours)
