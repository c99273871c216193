"""Cameras, lights, colour, images and settings: the numbers that Blender and Cycles mean."""

import json
import math

import pytest

from hosts import oldest_and_newest

CAMERA = """
from bpy_extras.object_utils import world_to_camera_view
POINTS = [Vector(p) for p in ((0, 0, 0), (0.5, 0.3, 0.2), (-1, 1, 1))]

def through(members, point):
    rows = [members["transform"][i:i + 4] for i in (0, 4, 8)]
    p = Matrix(rows + [[0, 0, 0, 1]]).inverted() @ point
    left, right, bottom, top = members["frame"]
    depth = -p.z if members["kind"] == "perspective" else 1
    return [(p.x / depth - left) / (right - left), (p.y / depth - bottom) / (top - bottom)]

told = []
for size, code in json.loads(%r):
    scene = empty_scene(size=size)
    camera = scene.camera.data
    place, turn = Matrix.Translation((1, -4, 2)), Matrix.Rotation(1.2, 4, 'X')
    scene.camera.matrix_world = place @ turn @ Matrix.Diagonal((2, 3, 4, 1))
    exec(code)
    bpy.context.view_layer.update()
    members = messages(render_frames(), "camera")[0]
    told.append([code, [through(members, p) for p in POINTS],
                 [list(world_to_camera_view(scene, scene.camera, p))[:2] for p in POINTS]])
tell([told])
"""

CAMERAS = [
    [[16, 8], ""],
    [[8, 16], "camera.lens = 24"],
    [[16, 8], "camera.sensor_fit = 'VERTICAL'; camera.sensor_height = 20"],
    [[16, 8], "camera.shift_x = 0.3; camera.shift_y = -0.2"],
    [[16, 8], "camera.type = 'ORTHO'; camera.ortho_scale = 7; camera.shift_x = 0.1"],
    [[16, 16], "scene.render.pixel_aspect_x = 2"],
    [[16, 8], "scene.camera.matrix_world = place @ turn @ Matrix.Diagonal((-1, 1, 2, 1))"],
]


def test_points_project_where_blender_projects_them(host, tmp_path):
    told = host.run(CAMERA % json.dumps(CAMERAS), tmp_path)[0]
    assert len(told) == len(CAMERAS)
    for code, found, expected in told:
        for ours, blenders in zip(found, expected):
            assert ours == pytest.approx(blenders, abs=1e-5), code


@oldest_and_newest
def test_border_resolution_and_lens_are_in_pixels_and_metres(host, tmp_path):
    members = host.run(
        """
scene = empty_scene(size=(200, 100))
scene.render.resolution_percentage = 50
scene.render.use_border = True
scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
scene.render.border_min_y, scene.render.border_max_y = 0.5, 1
camera = scene.camera.data
camera.lens, camera.dof.use_dof, camera.dof.aperture_fstop = 50, True, 2.5
camera.dof.focus_object = add("Focus", None, (3, 3, 1))
camera.dof.aperture_blades, camera.dof.aperture_ratio = 6, 1.5
tell(messages(render_frames(), "camera")[0])
""",
        tmp_path,
    )
    assert members["resolution"] == [100, 50] and members["border"] == [25, 25, 75, 50]
    assert members["lens_radius"] == pytest.approx(0.01) and members[
        "focus_distance"
    ] == pytest.approx(4)
    assert members["blades"] == 6 and members["aspect"] == pytest.approx(1.5)


@oldest_and_newest
def test_a_panoramic_camera_is_named_in_a_warning(host, tmp_path):
    done = host.start(
        "empty_scene().camera.data.type = 'PANO'; tell(len(render_frames()))", tmp_path
    )
    assert "Camera: type: a panoramic camera is rendered as a perspective one" in done.stdout


LIGHTS = """
def setup(engine, kind, scale, values):
    scene = empty_scene(size=(8, 8))
    scene.render.engine = engine
    plane = add_mesh("Plane", ((-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0)))
    material = add_material("White", plane.data)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    diffuse, output = nodes.new('ShaderNodeBsdfDiffuse'), nodes.new('ShaderNodeOutputMaterial')
    diffuse.inputs['Color'].default_value = (1, 1, 1, 1)
    material.node_tree.links.new(diffuse.outputs[0], output.inputs[0])
    light = bpy.data.lights.new("Light", kind)
    light.energy = 100
    for name, value in values.items():
        setattr(light, name, value)
    add("Light", light, (0, 0, 3)).scale = scale
    camera = scene.camera.data
    camera.type, camera.ortho_scale = 'ORTHO', 0.02
    scene.camera.location.z = 2
    return scene

told = []
for kind, scale, values in json.loads('''%s'''):
    if 'normalize' in values and not hasattr(bpy.types.Light, 'normalize'):
        continue
    has_spheres = hasattr(bpy.types.PointLight, 'use_soft_falloff')
    if values.pop('needs_spheres', False) and not has_spheres:
        continue
    if has_spheres and kind in ('POINT', 'SPOT'):
        values = dict(values, use_soft_falloff=False)
    scene = setup('CYCLES', kind, scale, values)
    scene.cycles.samples, scene.cycles.max_bounces, scene.cycles.use_denoising = 256, 0, False
    scene.cycles.use_adaptive_sampling = False
    rgba = pixels(save_exr("cycles.exr"))[2]
    setup('STOKES', kind, scale, values)
    light = messages(render_frames(), "light")[0]
    told.append([kind, values, math.pi * sum(rgba[0::4]) / 64, light])
tell([told])
"""


def irradiance(light, height=3.0):
    """Of a light's message, straight below it."""
    strength = light["emission"]["scale"] * max(light["emission"]["rgb"])
    kind = light["kind"]
    if kind == "sun":
        return strength
    if kind == "point" or (kind == "spot" and light["radius"] == 0):
        return strength / height**2
    if kind in ("sphere", "spot"):
        return strength * math.pi * (light["radius"] / height) ** 2
    a, b = (side / 2 for side in light["size"])
    if kind == "ellipse":
        assert a == b
        return strength * math.pi * a * a / (a * a + height**2)
    x, y = (
        math.hypot(a, height),
        math.hypot(b, height),
    )  # Lambert's form factor of a rectangle, four quarters
    return strength * 2 * (a / x * math.atan(b / x) + b / y * math.atan(a / y))


def test_lights_give_the_irradiance_that_cycles_of_the_same_blender_renders(host, tmp_path):
    """256 samples of light 3 m above: noise stays below 0.3 % for the soft ones (8×8 pixels,
    stratified). Soft points and spots are compared where Cycles has real spheres (use_soft_falloff
    off), for it draws turning disks otherwise."""
    cases = """[
        ["POINT", [1, 1, 1], {"shadow_soft_size": 0}],
        ["POINT", [2, 3, 4], {"shadow_soft_size": 0.5, "needs_spheres": true}],
        ["POINT", [1, 1, 1], {"shadow_soft_size": 0.5, "normalize": false}],
        ["SPOT", [1, 1, 1], {"shadow_soft_size": 0, "spot_size": 1.0, "spot_blend": 0}],
        ["SUN", [1, 1, 1], {"angle": 0}],
        ["SUN", [1, 1, 1], {"angle": 1.5}],
        ["SUN", [1, 1, 1], {"angle": 1.5, "normalize": false}],
        ["AREA", [1, 1, 1], {"shape": "SQUARE", "size": 2}],
        ["AREA", [2, 3, 1], {"shape": "RECTANGLE", "size": 0.5, "size_y": 1}],
        ["AREA", [1, 1, 1], {"shape": "SQUARE", "size": 2, "normalize": false, "exposure": 1}],
        ["AREA", [1, 1, 1], {"shape": "DISK", "size": 1.5}]]"""
    told = host.run(LIGHTS % cases, tmp_path)[0]
    assert len(told) >= 7
    for kind, values, cycles, light in told:
        assert irradiance(light) == pytest.approx(cycles, rel=4e-3), (kind, values)


@oldest_and_newest
def test_lights_shine_along_their_axis_and_unsupported_settings_are_named(host, tmp_path):
    done = host.start(
        """
scene = empty_scene()
light = bpy.data.lights.new("Lamp", 'AREA')
light.spread = 1
for name, scale in (("Lamp", 1), ("Mirrored", -1)):
    shown = add(name, light, (1, 2, 3))
    shown.rotation_euler, shown.scale.x = (math.pi / 2, 0, 0), scale
tell([[light["kind"], light["transform"][2::4]] for light in messages(render_frames(), "light")])
""",
        tmp_path,
    )
    assert "Lamp: spread: is not rendered" in done.stdout
    told = next(line for line in done.stdout.splitlines() if line.startswith("TOLD "))
    for kind, z_axis in json.loads(told[len("TOLD ") :]):
        assert kind == "rectangle" and z_axis == pytest.approx([0, -1, 0], abs=1e-6)


def test_the_colour_config_is_the_running_blenders_and_white_is_d65(host, tmp_path):
    color, settings, least_gamma = host.run(
        """
scene = empty_scene()
scene.view_settings.exposure = 1.5
scene.render.filter_size = 2
scene.render.film_transparent = True
frames = render_frames()
scene.view_settings.gamma = 0
told = [messages(frames, "color")[0], messages(frames, "settings")[0]]
tell([*told, messages(render_frames(), "color")[0]["gamma"]])
""",
        tmp_path,
    )
    assert color["gamma"] == 1 and 0 < least_gamma < 0.01  # 0 is no exponent
    assert (
        color["config"].endswith("config.ocio")
        and "ocio_profile_version" in open(color["config"]).read()
    )
    matrix = color["rgb_to_xyz"]
    white = [sum(matrix[3 * row : 3 * row + 3]) for row in range(3)]
    assert white == pytest.approx([0.9505, 1, 1.089], abs=1e-3)
    assert matrix[3:6] == pytest.approx([0.2126, 0.7152, 0.0722], abs=1e-3)
    assert (
        color["exposure"] == 1.5
        and color["display"] == "sRGB"
        and color["view"]
        and color["look"] == ""
    )
    assert color["working_space"] == (
        "Linear Rec.709" if host.version >= (5, 0) else "scene_linear"
    )
    assert settings["filter_width"] == 2 and settings["film_transparent"] is True
    assert settings["threads"] == 0  # in the background all processors


@oldest_and_newest
def test_ocio_of_the_environment_wins_as_in_blender(host, tmp_path):
    color = host.run(
        """
scene = empty_scene()
mine = os.path.join(TMP, "config.ocio")
open(mine, "w").write("ocio_profile_version: 1")
os.environ["OCIO"] = mine
tell(messages(render_frames(), "color")[0]["config"])
""",
        tmp_path,
    )
    assert color == str(tmp_path / "config.ocio")


IMAGES = """
scene = empty_scene()
import addon.export
class Collect:
    def __init__(self):
        self.frames = []
    def send(self, message, /, **members):
        def plain(value):
            return list(array("f", bytes(value.view))) if isinstance(value, stream.Blob) else value
        self.frames.append([message, {name: plain(value) for name, value in members.items()}])
out = Collect()
context = addon.export.ExportContext(out, bpy.context.evaluated_depsgraph_get())
"""


def test_images_are_sent_once_with_their_pixels_and_colour_space(host, tmp_path):
    byte, linear, data, sheer = host.run(
        IMAGES
        + """
byte = bpy.data.images.new("byte", 2, 1)
byte.pixels = [1, 0, 0, 1, 0, 1, 0, 0.2]
linear = bpy.data.images.new("linear", 1, 1, float_buffer=True)
linear.pixels = [5, 6, 7, 1]
data = bpy.data.images.new("data", 1, 1, is_data=True)
data.pixels = [0.4, 0.6, 0.8, 0.2]
data.alpha_mode = 'NONE'
sheer = bpy.data.images.new("sheer", 1, 1, alpha=True, float_buffer=True)
sheer.pixels = [0.1, 0.2, 0.3, 0.5]
for image in (byte, linear, data, byte, sheer):
    context.image(image)
tell([[frame[1] for frame in out.frames]])
""",
        tmp_path,
    )[0]
    assert (byte["width"], byte["height"], byte["channels"], byte["format"]) == (2, 1, 4, "f32")
    assert byte["colorspace"] == "sRGB" and byte["pixels"] == pytest.approx(
        [1, 0, 0, 1, 0, 1, 0, 0.2], abs=1e-3
    )
    assert linear["colorspace"] == "" and linear["pixels"] == [5, 6, 7, 1]
    assert data["colorspace"] == "data" and data["pixels"][3] == 1
    assert sheer["pixels"] == pytest.approx([0.2, 0.4, 0.6, 0.5])


@oldest_and_newest
def test_an_image_without_pixels_is_named(host, tmp_path):
    told = host.run(
        IMAGES
        + """
image = bpy.data.images.new("lost", 1, 1)
image.source, image.filepath = 'FILE', "//nowhere.png"
name = context.image(image)
context.image(image)
tell([name, context.warnings, out.frames])
""",
        tmp_path,
    )
    assert told[0] is None and told[2] == []
    assert told[1] == [["lost", "filepath", "has no pixels: //nowhere.png"]]


def test_filters_of_the_view_layer_apply_and_passes_that_are_missing_are_named(host, tmp_path):
    done = host.start(
        """
scene = empty_scene()
add_mesh()
light = bpy.data.lights.new("Lamp", 'POINT')
shown = add("Lamp", light)
if hasattr(shown, "light_linking"):
    shown.light_linking.receiver_collection = bpy.data.collections.new("Few")
scene.world = bpy.data.worlds.new("World")
scene.world.color = (0.5, 0.5, 0.5)
layer = scene.view_layers[0]
told = []
for solid, sky in ((True, True), (False, True), (True, False)):
    layer.use_solid, layer.use_sky = solid, sky
    layer.use_pass_z = layer.use_pass_normal = not sky
    frames = render_frames()
    world = messages(frames, "world")[0]
    told.append([len(messages(frames, "mesh")), max(world["emission"]["rgb"]) > 0, len(messages(frames, "light"))])
tell(told)
""",
        tmp_path,
    )
    assert "TOLD [[1, true, 1], [0, true, 1], [1, false, 1]]" in done.stdout, done.stdout
    named = [line for line in done.stdout.splitlines() if "passes: not rendered" in line]
    depth = "Depth" if host.version >= (5, 0) else "Z"
    assert set(named) == {"ViewLayer: passes: not rendered: %s, Normal; only Combined is" % depth}, done.stdout
    assert ("Lamp: light_linking: is not rendered" in done.stdout) == (host.version >= (4, 0))
