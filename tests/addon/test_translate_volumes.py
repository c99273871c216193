"""The Volume socket of materials and worlds becomes a W of STREAM.md; what varies, glows or scatters otherwise is named."""

import pytest

from hosts import oldest_and_newest
from test_translate import TOOLS

TOOLS += """
def volume(shader, owner=material, end=output):
    owner.node_tree.links.new(shader.outputs[0], socket(end, "Volume"))
    return translation.volume(owner, context)

def scatter(**values):
    return give(node("ShaderNodeVolumeScatter"), **values)

def absorption(**values):
    return give(node("ShaderNodeVolumeAbsorption"), **values)

def principled(**values):
    return give(node("ShaderNodeVolumePrincipled"), **values)

def join(bl_idname, *shaders):
    made = node(bl_idname)
    for slot, shader in zip((s for s in made.inputs if s.type == 'SHADER'), shaders):
        link(shader, slot)
    return made
"""

WHITE = {"rgb": [1, 1, 1]}
SCATTER = {"volume": "scatter", "color": {"rgb": [0.8] * 3}, "density": 1, "anisotropy": 0}
ABSORPTION = {"volume": "absorption", "color": {"rgb": [0.8] * 3}, "density": 1}


def tell(host, tmp_path, code):
    return host.run(TOOLS + code, tmp_path)


def test_volumes_keep_their_inputs(host, tmp_path):
    found = tell(host, tmp_path, """
told = [volume(scatter(Color=(1, .5, .25, 1), Density=3, Anisotropy=.7)),
        volume(absorption(Color=(.1, .2, .3, 1), Density=.5)),
        volume(principled(Color=(.2, .4, .6, 1), Absorption_Color=(.25, .04, 0, 1), Density=2, Anisotropy=-.5))]
tell([told, context.warnings])
""")
    assert found == [[
        {"volume": "scatter", "color": {"rgb": [1, 0.5, 0.25]}, "density": 3, "anisotropy": 0.7},
        {"volume": "absorption", "color": {"rgb": [0.1, 0.2, 0.3]}, "density": 0.5},
        {"volume": "principled", "color": {"rgb": [0.2, 0.4, 0.6]}, "absorption_color": {"rgb": [0.5, 0.2, 0]},
         "density": 2, "anisotropy": -0.5},
    ], []]


def test_coefficients_are_as_large_as_they_are(host, tmp_path):
    if host.version < (4, 5):
        pytest.skip("Volume Coefficients came with 4.5")
    found = tell(host, tmp_path, """
given = node("ShaderNodeVolumeCoefficients")
socket(given, "Scatter Coefficients").default_value = (2, 8, 4)
socket(given, "Absorption Coefficients").default_value = (.1, .2, .4)
give(given, Anisotropy=.25)
told = [volume(given), list(context.warnings)]
socket(given, "Absorption Coefficients").default_value = (-1, .2, .4)
socket(given, "Emission Coefficients").default_value = (0, 0, 1)
told += [volume(given)["absorption"]] + [text for _, _, text in context.warnings]
tell(told)
""")
    assert found[0] == {
        "volume": "coefficients", "scattering": {"scale": 8, "of": {"rgb": [0.25, 1, 0.5]}},
        "absorption": {"rgb": [0.1, 0.2, 0.4]}, "anisotropy": 0.25}
    assert found[1] == [] and found[2] == {"rgb": [0, 0.2, 0.4]}
    assert "Emission" in found[3] and "negative" in found[4] and len(found) == 5


@oldest_and_newest
def test_volumes_mix_and_add_as_a_tree_and_what_is_empty_folds(host, tmp_path):
    found = tell(host, tmp_path, """
told = [volume(join("ShaderNodeAddShader", scatter(), absorption())),
        volume(give(join("ShaderNodeMixShader", scatter(), absorption()), Fac=.25)),
        volume(give(join("ShaderNodeMixShader", scatter(), absorption()), Fac=1)),
        volume(give(join("ShaderNodeMixShader", scatter()), Fac=.25)),
        volume(join("ShaderNodeAddShader", scatter(Density=0), absorption())),
        volume(scatter(Density=0)), volume(node("ShaderNodeVolumeScatter", mute=True)),
        volume(give(node("ShaderNodeMixShader"), Fac=.25))]
tell([told, context.warnings])
""")
    assert found == [[
        {"add": [SCATTER, ABSORPTION]}, {"mix": [SCATTER, ABSORPTION], "factor": 0.25}, ABSORPTION,
        {"mix": [SCATTER, None], "factor": 0.25}, ABSORPTION, None, None, None,
    ], []]


@oldest_and_newest
def test_groups_reroutes_and_nodes_of_numbers_are_walked_through(host, tmp_path):
    found = tell(host, tmp_path, """
made = bpy.data.node_groups.new("Fog", "ShaderNodeTree")
if hasattr(made, "interface"):
    made.interface.new_socket("Thick", in_out='INPUT', socket_type="NodeSocketFloat")
    made.interface.new_socket("Out", in_out='OUTPUT', socket_type="NodeSocketShader")
else:
    made.inputs.new("NodeSocketFloat", "Thick"); made.outputs.new("NodeSocketShader", "Out")
start, end = made.nodes.new("NodeGroupInput"), made.nodes.new("NodeGroupOutput")
inner = made.nodes.new("ShaderNodeVolumeScatter")
link(start.outputs[0], socket(inner, "Density"), made); link(inner, end.inputs[0], made)
use, reroute = node("ShaderNodeGroup", node_tree=made), node("NodeReroute")
half = node("ShaderNodeMath", operation='MULTIPLY')
half.inputs[0].default_value, half.inputs[1].default_value = 0.5, 3
link(half, use.inputs[0]); link(use, reroute.inputs[0])
tell([volume(reroute), context.warnings])
""")
    assert found == [dict(SCATTER, density=1.5), []]


@oldest_and_newest
def test_spectra_of_stokes_colour_a_volume(host, tmp_path):
    found = tell(host, tmp_path, """
def spectrum(kind, **values):
    return nodes.new(tree, kind, sockets=values)
told = []
blue = scatter()
link(spectrum("spectrum_gaussian", Mean=450, Sigma=30, Peak=2), socket(blue, "Color"))
told.append(volume(blue))
clear = absorption()
link(spectrum("spectrum_gaussian", Mean=500, Sigma=50, Peak=1), socket(clear, "Color"))
told.append(volume(clear))
both = principled()
link(spectrum("spectrum_constant", Value=.25), socket(both, "Absorption Color"))
told.append(max(volume(both)["absorption_color"]["table"]["value"]))
told.append(context.warnings[:])
link(spectrum("spectrum_gaussian", Mean=500, Sigma=50, Peak=4), socket(clear, "Color"))
told.append(volume(clear)["color"]["scale"])
told.append(context.warnings[-1])
tell(told)
""")
    peaked, passed, rooted, warnings, scale, warning = found
    gaussian = {"gaussian": {"mean": 450, "sigma": 30, "peak": 2}}
    assert peaked["color"]["of"] == gaussian and peaked["color"]["scale"] * peaked["density"] == pytest.approx(1)
    assert peaked["density"] == pytest.approx(2, rel=0.02)  # as near the peak as the grid of the add-on comes
    assert passed == {"volume": "absorption", "color": {"gaussian": {"mean": 500, "sigma": 50, "peak": 1}}, "density": 1}
    assert rooted == pytest.approx(0.5) and warnings == []
    assert scale == pytest.approx(0.25, rel=0.02) and "Color reaches 4" in warning[2]


# Node, what is done to it, what its warning says, what it says of the volume.
NAMED = """
given = []

def check(shader, *wanted):
    context.warnings.clear()
    given.append([volume(shader), context.warnings[:], list(wanted)])

noisy = scatter(Density=7)
noise = node("ShaderNodeTexNoise")
link(noise, socket(noisy, "Density"))
check(noisy, "Noise Texture", "0.5 is used")
pictured = scatter(Density=7)
link(textured(), socket(pictured, "Density"))
check(pictured, "Volume Scatter", "Density cannot vary inside a volume; 7 is used")
coloured = absorption()
link(textured(), socket(coloured, "Color"))
check(coloured, "Volume Absorption", "Color cannot vary inside a volume; grey 0.8 is used")
grid = scatter(Density=7)
link(node("ShaderNodeVolumeInfo").outputs[1], socket(grid, "Density"))
check(grid, "Volume Info", "0 is used")
named = scatter(Density=7)
link(node("ShaderNodeAttribute").outputs[2], socket(named, "Density"))
check(named, "Attribute", "0 is used")
check(principled(Emission_Strength=2), "Principled Volume", "Emission")
check(principled(Blackbody_Intensity=2), "Principled Volume", "Blackbody")
check(node("ShaderNodeEmission"), "Emission", "light is left out")
check(node("ShaderNodeRGB"), "", "light is left out")  # named Color in 5.0
check(node("ShaderNodeBsdfDiffuse"), "Diffuse BSDF", "no volume")
check(absorption(Color=(1.5, .5, .5, 1)), "Volume Absorption", "Color reaches 1.5")
check(scatter(Anisotropy=1), "Volume Scatter", "0.999 is used")
factored = join("ShaderNodeMixShader", scatter(), absorption())
link(node("ShaderNodeFresnel"), factored.inputs[0])
check(factored, "Mix Shader", "cannot vary inside a volume")
if hasattr(noisy, "phase"):
    for phase in ('FOURNIER_FORAND', 'DRAINE', 'RAYLEIGH', 'MIE'):
        made = scatter(Anisotropy=.4)
        made.phase = phase
        check(made, "Volume Scatter", "phase function " + phase)
tell(given)
"""


def test_what_a_volume_here_cannot_do_is_named_by_node_and_setting(host, tmp_path):
    found = tell(host, tmp_path, NAMED)
    for told, warnings, (name, text) in found:
        assert len(warnings) == 1 and warnings[0][1].startswith(name) and text in warnings[0][2], (warnings, name, text)
    densities = [told and told.get("density") for told, _, _ in found]
    assert densities[:13] == [0.5, 7, 1, None, None, 1, 1, None, None, None, 1, 1, None]
    if host.version >= (4, 5):
        assert [told["anisotropy"] for told, _, _ in found[13:]] == [0.9, 0.4, 0, 0.85]


@oldest_and_newest
def test_default_colours_and_glows_of_strength_zero_pass_in_silence(host, tmp_path):
    found = tell(host, tmp_path, """
dark = principled(Emission_Strength=2, Emission_Color=(0, 0, 0, 1))
cold = principled(Blackbody_Intensity=1, Blackbody_Tint=(0, 0, 0, 1))
tell([volume(principled()), volume(dark), volume(cold), volume(absorption(Color=(-1, 0, 1, 1))), context.warnings])
""")
    plain, dark, cold, clamped, warnings = found
    assert plain == dark == cold and plain["absorption_color"] == {"rgb": [0, 0, 0]}
    assert clamped["color"] == {"rgb": [0, 0, 1]} and warnings == []


def test_the_scene_carries_volumes_of_materials_and_of_the_world(host, tmp_path):
    """A fluorescent object inside a volume: both are in the stream, and the skin of the volume is not seen."""
    found = host.run("""
from addon import nodes
scene = empty_scene()
scene.world = bpy.data.worlds.new("World")
scene.world.use_nodes = True

def material_of(mesh, name, bl_idname, identifier):
    made = add_material(name, mesh.data)
    made.use_nodes = True
    tree = made.node_tree
    end = tree.get_output_node('CYCLES')
    for link in list(tree.links):
        tree.links.remove(link)
    shader = nodes.new(tree, "fluorescent") if bl_idname is None else tree.nodes.new(bl_idname)
    tree.links.new(shader.outputs[0], next(s for s in end.inputs if s.identifier == identifier))

fog, coral, lamp = add_mesh("Fog"), add_mesh("Coral"), add("Lamp", bpy.data.lights.new("Lamp", 'POINT'))
fog.visible_volume_scatter = fog.visible_diffuse = False
coral.visible_volume_scatter = lamp.visible_volume_scatter = False
material_of(fog, "Fog", "ShaderNodeVolumeScatter", "Volume")
material_of(coral, "Coral", None, "Surface")
tree = scene.world.node_tree
end = tree.get_output_node('CYCLES')
tree.links.new(tree.nodes.new("ShaderNodeVolumeAbsorption").outputs[0],
               next(s for s in end.inputs if s.identifier == "Volume"))
scene.stokes.max_volume = 5
frames = render_frames()
materials = {m["name"]: m for m in messages(frames, "material")}
tell([materials["Fog"], [materials["Coral"][k] for k in ("surface", "volume")], messages(frames, "world")[0],
      {m["name"]: m["visible"] for kind in ("instances", "light") for m in messages(frames, kind)},
      messages(frames, "settings")[0]["max_volume"]])
""", tmp_path)
    fog, (coral, empty), world, visible, bounces = found
    assert fog["surface"] == {"bsdf": "transparent", "color": 1} and fog["volume"] == SCATTER
    assert coral["bsdf"] == "fluorescent" and empty is None
    assert world["volume"] == ABSORPTION and world["kind"] == "constant"
    assert visible["Fog"]["volume"] is False and visible["Fog"]["camera"] is True and visible["Lamp"]["volume"] is False
    assert visible["Coral"]["volume"] is (host.version < (4, 5)), "to Cycles of before, light from a volume is diffuse"
    assert bounces == 5


@oldest_and_newest
def test_grids_and_smoke_are_named(host, tmp_path):
    warnings = host.run("""
from addon import export
scene = empty_scene()
add("Cloud", bpy.data.volumes.new("Cloud"))
box = add_mesh("Smoke")
fluid = box.modifiers.new("Fluid", 'FLUID')
fluid.fluid_type = 'DOMAIN'
bpy.context.view_layer.update()
tell([export.record(os.path.join(TMP, "out.stokes"))])
""", tmp_path)[0]
    named = {owner: text for owner, _, text in warnings}
    assert named["Cloud"] == "volume is not rendered" and "smoke is not rendered" in named["Smoke"], warnings
