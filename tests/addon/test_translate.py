"""Node trees become the closures, emissions and worlds of STREAM.md; what cannot is named in a warning."""

import pytest

from hosts import oldest_and_newest

TOOLS = """
from addon import nodes
from addon.export import nodes as translation

class Context:
    blender_version = tuple(bpy.app.version)
    def __init__(self): self.warnings = []
    def warn(self, owner, prop, text): self.warnings.append([owner.name, prop, text])
    def image(self, image): return image.name

context = Context()
material = bpy.data.materials.new("M")
material.use_nodes = True
tree = material.node_tree
output = tree.get_output_node('CYCLES')

def node(bl_idname, into=tree, **values):
    made = into.nodes.new(bl_idname)
    for name, value in values.items():
        setattr(made, name, value)
    return made

def socket(owner, identifier):
    return next(s for s in owner.inputs if s.identifier == identifier)

def give(owner, **values):
    for name, value in values.items():
        known = {s.identifier for s in owner.inputs}
        socket(owner, name if name in known else name.replace("_", " ")).default_value = value
    return owner

def link(source, target, into=tree):
    into.links.new(source.outputs[0] if hasattr(source, "outputs") else source, target)

def surface(shader):
    link(shader, socket(output, "Surface"))
    return translation.surface(material, context)

def diffuse_of(source):
    shader = node("ShaderNodeBsdfDiffuse")
    link(source, shader.inputs[0])
    return surface(shader)["reflectance"]

def factor_of(source):
    shader = node("ShaderNodeBsdfDiffuse")
    link(source, socket(shader, "Roughness"))
    return surface(shader)["roughness"]

def picture(name="P"):
    return bpy.data.images.new(name, 4, 4)

def textured(**values):
    return node("ShaderNodeTexImage", image=picture(), **values)
"""


def tell(host, tmp_path, code):
    return host.run(TOOLS + code, tmp_path)


def test_bsdfs_keep_their_inputs(host, tmp_path):
    found = tell(host, tmp_path, """
told = {}
told["diffuse"] = surface(give(node("ShaderNodeBsdfDiffuse"), Color=(1, .5, .25, 1), Roughness=.3))
told["glass"] = surface(give(node("ShaderNodeBsdfGlass"), Color=(1, 1, .5, 1), IOR=1.7, Roughness=0))
told["refraction"] = surface(give(node("ShaderNodeBsdfRefraction"), IOR=1.3, Roughness=0))
told["translucent"] = surface(node("ShaderNodeBsdfTranslucent"))
told["holdout"] = surface(node("ShaderNodeHoldout"))
told["transparent"] = surface(give(node("ShaderNodeBsdfTransparent"), Color=(.5, .5, .5, 1)))
told["emission"] = surface(give(node("ShaderNodeEmission"), Color=(1, .5, 0, 1), Strength=3))
glossy = node("ShaderNodeBsdfAnisotropic", distribution='GGX')
told["glossy"] = surface(give(glossy, Anisotropy=0, Roughness=.25))
many = node("ShaderNodeBsdfAnisotropic", distribution='MULTI_GGX')
told["many"] = surface(give(many, Anisotropy=0))
told["warnings"] = context.warnings
tell(told)
""")
    model = {} if host.version >= (4, 0) else {"model": 3}
    assert found["diffuse"] == {
        "bsdf": "diffuse", "reflectance": {"rgb": [1, 0.5, 0.25]}, "roughness": 0.3}
    assert found["glass"]["ior"] == 1.7 and found["glass"]["lobes"] == "both"
    assert found["glass"]["reflect_color"] == found["glass"]["transmit_color"] == {"rgb": [1, 1, 0.5]}
    assert found["refraction"]["lobes"] == "refract" and found["refraction"]["ior"] == 1.3
    assert found["translucent"] == {"bsdf": "translucent", "reflectance": {"rgb": [0.8, 0.8, 0.8]}}
    assert found["holdout"] == {"bsdf": "holdout"}
    assert found["transparent"] == {"bsdf": "transparent", "color": {"rgb": [0.5, 0.5, 0.5]}}
    assert found["emission"] == {"emission": {"rgb": [1, 0.5, 0], "scale": 3}, "two_sided": True}
    assert found["glossy"] == {"bsdf": "glossy", "color": {"rgb": [0.8, 0.8, 0.8]}, "roughness": 0.25, **model}
    assert found["many"]["multi_scatter"] is True
    assert found["warnings"] == []


def test_shaders_mix_and_add_as_a_tree_and_constant_ends_fold(host, tmp_path):
    found = tell(host, tmp_path, """
a, b = node("ShaderNodeBsdfDiffuse"), node("ShaderNodeBsdfTransparent")
mix = node("ShaderNodeMixShader")
link(a, mix.inputs[1]); link(b, mix.inputs[2])
told = []
for factor in (0.25, 0, 1):
    give(mix, Fac=factor)
    told.append(surface(mix))
link(give(node("ShaderNodeFresnel"), IOR=1.4), mix.inputs[0])
told.append(surface(mix))
facing = node("ShaderNodeLayerWeight")
facing.inputs[0].default_value = 0.75
link(facing.outputs[1], mix.inputs[0]); told.append(surface(mix)["factor"])
link(facing.outputs[0], mix.inputs[0]); told.append(surface(mix)["factor"])
geometry = node("ShaderNodeNewGeometry")
link(next(o for o in geometry.outputs if o.identifier == "Backfacing"), mix.inputs[0])
told.append(surface(mix)["factor"])
add = node("ShaderNodeAddShader")
link(a, add.inputs[0]); told.append(surface(add))
link(b, add.inputs[1]); told.append(surface(add))
tell(told)
""")
    diffuse = {"bsdf": "diffuse", "reflectance": {"rgb": [0.8] * 3}, "roughness": 0}
    transparent = {"bsdf": "transparent", "color": {"rgb": [1, 1, 1]}}
    assert found[0] == {"mix": [diffuse, transparent], "factor": 0.25}
    assert found[1] == diffuse and found[2] == transparent
    assert found[3]["factor"] == {"fresnel": 1.4}
    assert found[4] == {"facing": 0.75}
    assert found[5] == {"fresnel": pytest.approx(4.0)}
    assert found[6] == {"backfacing": 1}
    assert found[7] == diffuse
    assert found[8] == {"add": [diffuse, transparent]}


def test_principled_speaks_the_model_of_its_blender(host, tmp_path):
    found = tell(host, tmp_path, """
shader = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeBsdfPrincipled")
told = [surface(shader), list(context.warnings)]
give(shader, Alpha=.5)
name = "Emission" if socket_missing(shader) else "Emission Color"
socket(shader, name).default_value = (1, .5, 0, 1)
give(shader, Emission_Strength=2)
told.append(surface(shader))
give(shader, Alpha=1, Emission_Strength=0)
socket(shader, "Coat Weight" if name == "Emission Color" else "Clearcoat").default_value = 1
told.append(surface(shader))
tell(told)
""".replace("socket_missing(shader)", 'all(s.identifier != "Emission Color" for s in shader.inputs)'))
    plain, warnings, glowing, coated = found
    is_new = host.version >= (4, 0)
    assert plain["bsdf"] == "principled" and plain["model"] == (4 if is_new else 3)
    assert plain["base_color"] == {"rgb": [0.8] * 3} and plain["roughness"] == 0.5
    assert plain["specular"] == 0.5 and plain["transmission"] == 0 and plain["metallic"] == 0
    assert plain["specular_tint"] == ({"rgb": [1, 1, 1]} if is_new else 0)
    assert warnings == []
    assert glowing["factor"] == 0.5 and glowing["mix"][0]["bsdf"] == "transparent"
    assert glowing["mix"][1]["add"][1]["emission"] == {"rgb": [1, 0.5, 0], "scale": 2}
    assert coated["mix"][1]["bsdf"] == "glossy"
    assert coated["factor"]["product"] == ([1, {"fresnel": 1.5}] if is_new else [0.25, {"fresnel": 1.5}])


def test_groups_reroutes_and_muted_nodes_are_walked_through(host, tmp_path):
    found = tell(host, tmp_path, """
def group(name, make):
    made = bpy.data.node_groups.new(name, "ShaderNodeTree")
    if hasattr(made, "interface"):
        made.interface.new_socket("In", in_out='INPUT', socket_type="NodeSocketColor")
        made.interface.new_socket("Out", in_out='OUTPUT', socket_type="NodeSocketShader")
    else:
        made.inputs.new("NodeSocketColor", "In"); made.outputs.new("NodeSocketShader", "Out")
    start, end = made.nodes.new("NodeGroupInput"), made.nodes.new("NodeGroupOutput")
    make(made, start, end)
    return made

def inner(made, start, end):
    shader = made.nodes.new("ShaderNodeBsdfDiffuse")
    link(start.outputs[0], shader.inputs[0], made); link(shader, end.inputs[0], made)
inner = group("Inner", inner)

def outer(made, start, end):
    nested = made.nodes.new("ShaderNodeGroup"); nested.node_tree = inner
    link(start.outputs[0], nested.inputs[0], made); link(nested, end.inputs[0], made)
outer = group("Outer", outer)

use = node("ShaderNodeGroup", node_tree=outer)
use.inputs[0].default_value = (.1, .2, .3, 1)
told = [surface(use)["reflectance"]]
other = node("ShaderNodeGroup", node_tree=outer)
rgb = node("ShaderNodeRGB"); rgb.outputs[0].default_value = (.4, .5, .6, 1)
reroute = node("NodeReroute")
link(rgb, reroute.inputs[0]); link(reroute, other.inputs[0])
told.append(surface(other)["reflectance"])
gamma = node("ShaderNodeGamma", mute=True); give(gamma, Gamma=7)
link(rgb, gamma.inputs[0])
told.append(diffuse_of(gamma))
told.append(context.warnings)
tell(told)
""")
    assert found == [{"rgb": [0.1, 0.2, 0.3]}, {"rgb": [0.4, 0.5, 0.6]}, {"rgb": [0.4, 0.5, 0.6]}, []]


@oldest_and_newest
def test_nothing_comes_out_of_muted_nodes_that_nothing_is_linked_to(host, tmp_path):
    """As Cycles of Blender 3.4 has it: 0, not what their sockets say; a link that no socket takes on counts as none."""
    found = tell(host, tmp_path, """
def color_of(source):
    shader = give(node("ShaderNodeBsdfDiffuse"), Color=(.1, .2, .3, 1))
    link(source, shader.inputs[0])
    return surface(shader)["reflectance"]

line = nodes.new(tree, "spectrum_line"); line.mute = True
gamma = give(node("ShaderNodeGamma", mute=True), Color=(.4, .5, .6, 1))
told = [color_of(line), color_of(gamma), color_of(node("NodeReroute")), color_of(node("ShaderNodeRGB", mute=True))]
link(node("ShaderNodeRGB", mute=True), gamma.inputs[0]); told.append(color_of(gamma))
empty = bpy.data.node_groups.new("Empty", "ShaderNodeTree")
if hasattr(empty, "interface"):
    empty.interface.new_socket("Out", in_out='OUTPUT', socket_type="NodeSocketColor")
else:
    empty.outputs.new("NodeSocketColor", "Out")
told.append(color_of(node("ShaderNodeGroup", node_tree=empty)))
rough = node("ShaderNodeMath", mute=True); rough.inputs[0].default_value = .7
told.append(factor_of(rough))
told.append(context.warnings)
tell(told)
""")
    black, own = {"rgb": [0, 0, 0]}, {"rgb": [0.1, 0.2, 0.3]}
    assert found == [black, black, black, own, black, black, 0, []]


def test_image_textures_carry_their_mapping(host, tmp_path):
    found = tell(host, tmp_path, """
mapping = give(node("ShaderNodeMapping"), Location=(.5, .25, 0), Rotation=(0, 0, math.pi / 2), Scale=(2, 3, 1))
coordinates = node("ShaderNodeTexCoord")
link(next(o for o in coordinates.outputs if o.identifier == "UV"), socket(mapping, "Vector"))
image = textured(interpolation='Closest', extension='EXTEND')
link(mapping, socket(image, "Vector"))
told = [diffuse_of(image)]
mapping.vector_type = 'TEXTURE'
told.append(diffuse_of(image))
uv = node("ShaderNodeUVMap", uv_map="Second")
link(uv, socket(image, "Vector")); told.append(diffuse_of(image))
link(next(o for o in coordinates.outputs if o.identifier == "Generated"), socket(image, "Vector"))
told.append(diffuse_of(image))
told.append(factor_of(image.outputs[1])); told.append(factor_of(image.outputs[0]))
separate = node("ShaderNodeSeparateColor")
link(image, separate.inputs[0]); told.append(factor_of(separate.outputs[1]))
told.append(context.warnings)
tell(told)
""")
    point, inverse, uv, generated, alpha, grey, green, warnings = found
    point = point["texture"]
    assert point["image"] == "P" and point["interpolation"] == "closest" and point["extension"] == "extend"
    assert point["transform"] == pytest.approx([0, -3, 0, 0.5, 2, 0, 0, 0.25, 0, 0, 1, 0], abs=1e-6)
    assert inverse["texture"]["transform"] == pytest.approx(
        [0, 0.5, 0, -0.125, -1 / 3, 0, 0, 1 / 6, 0, 0, 1, 0], abs=1e-6)
    assert uv["texture"]["uv"] == "Second" and uv["texture"]["projection"] == "uv"
    assert generated["texture"]["projection"] == "generated"
    assert alpha["texture"]["channel"] == "alpha" and grey["texture"]["channel"] == "luminance"
    assert green["texture"]["channel"] == "g"
    assert warnings == []


def test_normal_maps_go_along_and_bumps_are_named(host, tmp_path):
    found = tell(host, tmp_path, """
shader, image = node("ShaderNodeBsdfDiffuse"), textured()
normal = give(node("ShaderNodeNormalMap"), Strength=.5)
link(image, socket(normal, "Color")); link(normal, socket(shader, "Normal"))
told = [surface(shader)["normal"]]
bump = node("ShaderNodeBump")
link(normal, socket(bump, "Normal")); link(bump, socket(shader, "Normal"))
told.append(surface(shader)["normal"])
tell(told + context.warnings)
""")
    assert found[0]["strength"] == 0.5 and found[0]["texture"]["image"] == "P"
    assert found[1] == found[0]
    assert found[2:] == [["M", "Bump", "bumps are not supported yet and left out"]]


CONSTANTS = """
made = {}
for blend in ('MIX', 'ADD', 'SUBTRACT', 'MULTIPLY', 'SCREEN', 'DIFFERENCE', 'DARKEN', 'LIGHTEN', 'OVERLAY',
              'SOFT_LIGHT', 'LINEAR_LIGHT', 'DIVIDE', 'DODGE', 'BURN', 'HUE', 'SATURATION', 'VALUE', 'COLOR'):
    mix = node("ShaderNodeMixRGB", blend_type=blend)
    made["mix " + blend] = give(mix, Fac=.6, Color1=(.7, .4, .2, 1), Color2=(.3, .5, .9, 1))
for operation in ('ADD', 'MULTIPLY_ADD', 'POWER', 'SQRT', 'MINIMUM', 'SMOOTH_MIN', 'WRAP', 'SNAP', 'PINGPONG',
                  'MODULO', 'COMPARE', 'FRACT', 'ROUND', 'ARCTAN2', 'SIGN', 'COSINE', 'RADIANS'):
    maths = node("ShaderNodeMath", operation=operation)
    for s, value in zip(maths.inputs, (.85, .3, .1)):
        s.default_value = value
    made["math " + operation] = maths
color = (.7, .4, .2, 1)
made["gamma"] = give(node("ShaderNodeGamma"), Color=color, Gamma=2.2)
made["bright"] = give(node("ShaderNodeBrightContrast"), Color=color, Bright=.2, Contrast=.5)
made["hue"] = give(node("ShaderNodeHueSaturation"), Color=color, Hue=.6, Saturation=1.2, Value=.9, Fac=.8)
made["invert"] = give(node("ShaderNodeInvert"), Color=color, Fac=.75)
ramp = node("ShaderNodeValToRGB")
ramp.color_ramp.elements[0].color = (1, .5, 0, 1)
made["ramp"] = give(ramp, Fac=.3)
curves = give(node("ShaderNodeRGBCurve"), Color=color)
curves.mapping.curves[3].points.new(.5, .7)
curves.mapping.curves[0].points.new(.5, .2)
curves.mapping.update()
made["curves"] = curves
made["blackbody"] = give(node("ShaderNodeBlackbody"), Temperature=4000)
made["map range"] = give(node("ShaderNodeMapRange"), Value=.4, From_Min=.1, From_Max=.9, To_Min=.2, To_Max=.3)
made["bw"] = give(node("ShaderNodeRGBToBW"), Color=color)
made["clamp"] = give(node("ShaderNodeClamp"), Value=1.7)
mix = node("ShaderNodeMix", data_type='RGBA', blend_type='MULTIPLY')
made["new mix"] = give(mix, Factor_Float=.5, A_Color=color, B_Color=(.3, .5, .9, 1))

scene = bpy.context.scene
for thing in list(scene.objects):
    bpy.data.objects.remove(thing)
scene.camera = add("Camera", bpy.data.cameras.new("Camera"), (0, 0, 5))
scene.camera.data.type, scene.camera.data.ortho_scale = 'ORTHO', len(made)
scene.render.engine = 'CYCLES'
scene.cycles.samples, scene.cycles.use_denoising = 1, False
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 5 * len(made), 5, 100
ours = []
for i, (name, source) in enumerate(made.items()):
    x = i - len(made) / 2
    plane = add_mesh(name, ((x, -1, 0), (x + 1, -1, 0), (x + 1, 1, 0), (x, 1, 0)))
    shown = material.copy()
    plane.data.materials.append(shown)
    inside = shown.node_tree
    twin = inside.nodes[source.name]
    result = next((o for o in twin.outputs if o.identifier == "Result_Color"), twin.outputs[0])
    emission = inside.nodes.new("ShaderNodeEmission")
    inside.links.new(result, emission.inputs[0])
    inside.links.new(emission.outputs[0], inside.get_output_node('CYCLES').inputs[0])
    ours.append(translation.surface(shown, context)["emission"]["rgb"])
_width, _height, values = pixels(save_exr("constants.exr"))
middle = [4 * (2 * _width + 5 * i + 2) for i in range(len(made))]
tell([list(made), ours, [values[at:at + 3] for at in middle]])
"""


def test_constants_are_computed_as_cycles_computes_them(host, tmp_path):
    """Each node lights one square of a Cycles render; light cannot be negative, in ours as in the film."""
    names, ours, cycles = tell(host, tmp_path, CONSTANTS)
    for name, own, theirs in zip(names, ours, cycles):
        assert own == pytest.approx([max(0, v) for v in theirs], abs=2e-3 if name != "blackbody" else 0.03), name


@oldest_and_newest
def test_factors_that_vary_may_be_scaled_and_shifted(host, tmp_path):
    found = tell(host, tmp_path, """
def math_of(operation, *values):
    made = node("ShaderNodeMath", operation=operation)
    for s, value in zip(made.inputs, values):
        if isinstance(value, (int, float)): s.default_value = value
        else: link(value, s)
    return made

image = textured()
told = [factor_of(math_of('MULTIPLY', image, .5)), factor_of(math_of('SUBTRACT', 1, image)),
        factor_of(math_of('ADD', math_of('MULTIPLY', image, 2), .25)),
        factor_of(math_of('MULTIPLY', image, node("ShaderNodeFresnel")))]
invert = node("ShaderNodeInvert"); link(image, socket(invert, "Color"))
told.append(factor_of(invert))
told.append(len(context.warnings))
told.append(factor_of(math_of('POWER', image, 2)))
told.append(context.warnings)
tell(told)
""")
    half, negative, both, product, inverted, none, power, warnings = found
    assert half["scale"] == 0.5 and half["offset"] == 0 and half["of"]["texture"]["channel"] == "luminance"
    assert (negative["scale"], negative["offset"]) == (-1, 1) and (inverted["scale"], inverted["offset"]) == (-1, 1)
    assert (both["scale"], both["offset"]) == (2, 0.25)
    assert product["product"][1] == {"fresnel": 1.45} or product["product"][1] == {"fresnel": 1.5}
    assert "texture" in power
    assert none == 0 and [warning[1].split(".")[0] for warning in warnings] == ["Math"]


def test_colours_that_mix_by_a_mask_become_a_mix_of_closures(host, tmp_path):
    """Exact, as a BSDF is linear in its colours; where nothing can be split, half of each is used and named."""
    found = tell(host, tmp_path, """
mask = textured()
mix = give(node("ShaderNodeMixRGB"), Color1=(1, 0, 0, 1), Color2=(0, 0, 1, 1))
link(mask, mix.inputs[0])
shader = node("ShaderNodeBsdfDiffuse"); link(mix, shader.inputs[0])
told = [surface(shader)]
ramp = node("ShaderNodeValToRGB"); ramp.color_ramp.elements[0].color = (0, 1, 0, 1)
link(mask, ramp.inputs[0]); link(ramp, shader.inputs[0])
told.append(surface(shader))
link(ramp, mix.inputs[1]); link(mix, shader.inputs[0])
told.append(surface(shader))
other = textured(); plain = give(node("ShaderNodeMixRGB"), Fac=.25)
link(mask, plain.inputs[1]); link(other, plain.inputs[2]); link(plain, shader.inputs[0])
told.append(surface(shader))
told.append(len(context.warnings))
for l in list(mix.inputs[1].links): tree.links.remove(l)
gamma = node("ShaderNodeGamma"); link(mix, gamma.inputs[0]); link(gamma, shader.inputs[0])
told.append(surface(shader)["reflectance"])
told.append([warning[1:] for warning in context.warnings])
tell(told)
""")
    mask = {"texture": {**found[0]["factor"]["texture"], "channel": "luminance"}}
    colors = [side["reflectance"]["rgb"] for side in found[0]["mix"]]
    assert found[0]["factor"] == mask and colors == [[1, 0, 0], [0, 0, 1]]
    assert [side["reflectance"]["rgb"] for side in found[1]["mix"]] == [[0, 1, 0], [1, 1, 1]]
    first, second = found[2]["mix"]
    assert [side["reflectance"]["rgb"] for side in first["mix"]] == [[0, 1, 0], [0, 0, 1]]
    assert [side["reflectance"]["rgb"] for side in second["mix"]] == [[1, 1, 1], [0, 0, 1]]
    assert found[3]["factor"] == 0.25 and "texture" in found[3]["mix"][1]["reflectance"]
    assert found[4] == 0
    assert found[5] == {"rgb": [0.5, 0, 0.5]}
    assert [warning[1] for warning in found[6]] == ["its factor cannot vary here; half of each is used"]


@oldest_and_newest
def test_a_surface_with_too_many_lobes_is_cut_to_its_stronger_parts(host, tmp_path):
    found = tell(host, tmp_path, """
def leaves(closure):
    if "mix" not in closure: return [closure["reflectance"]["rgb"][0]]
    return leaves(closure["mix"][0]) + leaves(closure["mix"][1])

def leaf(value):
    return give(node("ShaderNodeBsdfDiffuse"), Color=(value, value, value, 1))

told = []
for factor in (.25, .75):
    shader = leaf(0)
    for i in range(1, 10):
        mix = give(node("ShaderNodeMixShader"), Fac=factor)
        link(shader, mix.inputs[1]); link(leaf(i / 16), mix.inputs[2])
        shader = mix
    told.append([round(16 * value) for value in leaves(surface(shader))])
tell(told + [[warning[1:] for warning in context.warnings]])
""")
    assert found[0] == [0, 3, 4, 5, 6, 7, 8, 9] and found[1] == [2, 3, 4, 5, 6, 7, 8, 9]
    assert found[2] == 2 * [["Material Output", "the surface has more than 8 lobes; the weakest are cut"]]


def test_what_is_not_supported_is_named_with_what_is_used(host, tmp_path):
    found = tell(host, tmp_path, """
noise = node("ShaderNodeTexNoise")
told = [diffuse_of(noise.outputs[1]), surface(node("ShaderNodeSubsurfaceScattering"))["bsdf"]]
wireframe = node("ShaderNodeWireframe")
shader = give(node("ShaderNodeBsdfDiffuse"), Roughness=.125)
link(wireframe, socket(shader, "Roughness")); told.append(surface(shader)["roughness"])
told.append([warning[:2] for warning in context.warnings])
told.append(all(warning[2] for warning in context.warnings))
tell(told)
""")
    assert found[0] == {"rgb": [0.5, 0.5, 0.5]} and found[1] == "diffuse" and found[2] == 0.125
    assert found[3] == [["M", "Noise Texture"], ["M", "Subsurface Scattering"], ["M", "Wireframe"]]
    assert found[4]


def test_materials_without_nodes_or_output_are_what_cycles_shows(host, tmp_path):
    found = tell(host, tmp_path, """
told = []
plain = bpy.data.materials.new("Plain")
if bpy.app.version < (5, 0, 0):
    plain.diffuse_color = (.1, .2, .3, 1)
    told.append(translation.surface(plain, context))
empty = bpy.data.materials.new("Empty"); empty.use_nodes = True; empty.node_tree.nodes.clear()
told.append(translation.surface(empty, context))
tell(told)
""")
    if host.version < (5, 0):
        assert found[0] == {"bsdf": "diffuse", "reflectance": {"rgb": [0.1, 0.2, 0.3]}}
    assert found[-1] is None


def test_the_output_is_the_one_that_cycles_uses(host, tmp_path):
    found = tell(host, tmp_path, """
link(node("ShaderNodeBsdfTransparent"), socket(output, "Surface"))
other = node("ShaderNodeOutputMaterial", target='EEVEE')
link(node("ShaderNodeBsdfTranslucent"), socket(other, "Surface"))
own = node("ShaderNodeOutputMaterial", target='CYCLES')
link(node("ShaderNodeBsdfDiffuse"), socket(own, "Surface"))
tell(translation.surface(material, context))
""")
    assert found["bsdf"] == "diffuse"


def test_worlds_are_a_constant_or_a_map(host, tmp_path):
    found = tell(host, tmp_path, """
told = [translation.world(None, context)]
world = bpy.data.worlds.new("W"); world.use_nodes = True
sky = world.node_tree
background = next(n for n in sky.nodes if n.bl_idname == "ShaderNodeBackground")
give(background, Color=(.5, .25, 1, 1), Strength=2)
told.append(translation.world(world, context))
environment = node("ShaderNodeTexEnvironment", sky, image=picture("Sky"))
mapping = give(node("ShaderNodeMapping", sky), Rotation=(0, 0, math.pi / 2))
coordinates = node("ShaderNodeTexCoord", sky)
link(coordinates.outputs[0], socket(mapping, "Vector"), sky)
link(mapping, socket(environment, "Vector"), sky)
link(environment, socket(background, "Color"), sky)
told.append(translation.world(world, context))
told.append(context.warnings)
tell(told)
""")
    assert found[0] == {"kind": "constant", "emission": {"rgb": [0, 0, 0], "scale": 1}}
    assert found[1] == {"kind": "constant", "emission": {"rgb": [0.5, 0.25, 1], "scale": 2}, "volume": None}
    assert found[2]["kind"] == "image" and found[2]["image"] == "Sky" and found[2]["scale"] == 2
    assert found[2]["transform"] == pytest.approx([0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0], abs=1e-6)
    assert found[3] == []


@oldest_and_newest
def test_worlds_that_hide_behind_another_light_the_scene(host, tmp_path):
    """Is Camera Ray mixes what is seen with what lights: the light is kept, and the node named."""
    found = tell(host, tmp_path, """
world = bpy.data.worlds.new("W"); world.use_nodes = True
sky = world.node_tree
lights, seen = node("ShaderNodeBackground", sky), node("ShaderNodeBackground", sky)
give(lights, Color=(1, .5, .25, 1)); give(seen, Color=(0, 0, 1, 1))
mix, path = node("ShaderNodeMixShader", sky), node("ShaderNodeLightPath", sky)
link(path, mix.inputs[0], sky); link(lights, mix.inputs[1], sky); link(seen, mix.inputs[2], sky)
link(mix, socket(sky.get_output_node('CYCLES'), "Surface"), sky)
told = [translation.world(world, context), [warning[1] for warning in context.warnings]]
image = node("ShaderNodeTexImage", sky, image=picture("Flat"))
link(image, socket(lights, "Color"), sky)
told.append(translation.world(world, context))
tell(told)
""")
    assert found[0] == {"kind": "constant", "emission": {"rgb": [1, 0.5, 0.25], "scale": 1}, "volume": None}
    assert found[1] == ["Light Path"]
    assert found[2]["emission"]["rgb"] == [0.5, 0.5, 0.5]


def test_lamps_multiply_their_colour_into_their_nodes(host, tmp_path):
    found = tell(host, tmp_path, """
light = bpy.data.lights.new("L", 'POINT'); light.color = (1, .5, .25)
light.use_nodes = True
lamp = light.node_tree
emission = next(n for n in lamp.nodes if n.bl_idname == "ShaderNodeEmission")
give(emission, Color=(.5, 1, 1, 1), Strength=4)
told = [translation.light_emission(light, context)]
light.color = (1, 1, 1)
spectrum = nodes.new(lamp, "spectrum_gaussian", sockets={"Mean": 365, "Sigma": 5})
link(spectrum, socket(emission, "Color"), lamp)
told.append(translation.light_emission(light, context))
for l in list(lamp.links): lamp.links.remove(l)
told.append(translation.light_emission(light, context))
tell(told)
""")
    assert found[0] == {"rgb": [0.5, 0.5, 0.25], "scale": 4}
    assert found[1] == {"shape": {"gaussian": {"mean": 365, "sigma": 5, "peak": 1}}, "scale": 4, "unit": "total"}
    assert found[2]["rgb"] == [0, 0, 0]


def test_stokes_nodes_say_more_than_rgb(host, tmp_path):
    found = tell(host, tmp_path, """
told = {}
paint = nodes.new(tree, "fluorescent", dye="rhodamine-6g_ethanol", absorbance=1.0, sockets={"Yield": .75})
cyan = nodes.new(tree, "spectrum_library", category="colorchecker", colorchecker="colorchecker/cyan")
link(cyan, paint.inputs[0])
told["dye"] = surface(paint)
own = nodes.new(tree, "fluorescent", yield_kind='energy')
a = nodes.new(tree, "spectrum_line", sockets={"Center": 405, "Width": 10})
b = nodes.new(tree, "spectrum_gaussian", sockets={"Mean": 600, "Sigma": 20})
link(a, nodes.input_of(own, "Absorption")); link(b, nodes.input_of(own, "Emission"))
told["own"] = surface(own)
told["abbe"] = surface(nodes.new(tree, "dispersive_glass", sockets={"IOR": 1.3, "Abbe Number": 10}))
told["preset"] = surface(nodes.new(tree, "dispersive_glass", model='PRESET', preset="SF11"))
told["cauchy"] = surface(nodes.new(tree, "dispersive_glass", model='CAUCHY', cauchy_a=1.5, cauchy_b=.005))
told["metal"] = surface(nodes.new(tree, "conductor", metal="Au", sockets={"Roughness": .2}))
told["d65"] = diffuse_of(nodes.new(tree, "spectrum_illuminant"))
mix = node("ShaderNodeMixRGB", blend_type='ADD'); mix.inputs[0].default_value = 1
link(nodes.new(tree, "spectrum_constant", sockets={"Value": .25}), mix.inputs[1]); link(b, mix.inputs[2])
emission = node("ShaderNodeEmission"); link(mix, emission.inputs[0])
told["sum"] = surface(emission)
told["warnings"] = context.warnings
tell(told)
""")
    dye = found["dye"]
    assert dye["reflectance"] == {"library": "colorchecker/cyan"} and dye["yield"] == 0.75
    assert dye["emission"] == {"library": "dye/rhodamine-6g_ethanol/emission"} and dye["yield_kind"] == "quantum"
    assert max(dye["absorption"]["table"]["value"]) == pytest.approx(0.9, abs=2e-3)  # 1 − 10^(−1)
    assert found["own"]["absorption"] == {"line": {"center": 405, "width": 10}}
    assert found["own"]["emission"]["gaussian"]["mean"] == 600 and found["own"]["yield_kind"] == "energy"
    assert found["abbe"]["ior"] == {"n_d": 1.3, "abbe": 10}
    assert found["preset"]["ior"] == {"library": "SF11"}
    assert found["cauchy"]["ior"]["cauchy"] == pytest.approx([1.5, 0.005, 0])
    assert found["metal"] == {"bsdf": "conductor", "metal": "Au", "roughness": 0.2}
    assert found["d65"]["of"] == {"illuminant": "D65"} and found["d65"]["scale"] < 1
    assert found["sum"]["emission"]["shape"] == {
        "sum": [0.25, {"gaussian": {"mean": 600, "sigma": 20, "peak": 1}}]}
    assert [warning[1] for warning in found["warnings"]] == ["Diffuse BSDF"]
