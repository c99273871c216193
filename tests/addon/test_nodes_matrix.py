"""The node Reradiation Matrix: the core reads the file, the .blend keeps it, the stream carries it."""

import pytest

from hosts import ROOT, oldest_and_newest

CORE = ROOT / "build" / "stokes"
REAL = {"STOKES_CORE": str(CORE)}
pytestmark = [oldest_and_newest, pytest.mark.skipif(not CORE.exists(), reason="the core is not built")]

CSV = """outgoing,400,420,440,460
400,0.5,0,0,0
420,0.1,0.5,0,0
440,0.1,0.1,0.5,0
460,0.1,0.1,,0.5
480,0.1,0.1,0.1,0.1
"""

TOOLS = """
from addon import nodes
from addon.nodes import reradiation_matrix
material = bpy.data.materials.new("M")
material.use_nodes = True
tree = material.node_tree
made = nodes.new(tree, "reradiation_matrix")
settings = made.stokes.reradiation_matrix
"""


def test_a_file_is_read_by_the_core_and_stays_in_the_blend(host, tmp_path):
    (tmp_path / "paint.csv").write_text(CSV)
    (tmp_path / "bad.csv").write_text("nothing here")
    found = host.run(TOOLS + """
told = [reradiation_matrix.matrix_of(settings)]
settings.filepath = os.path.join(TMP, "paint.csv")
told += [settings.problem, settings.notes, made.label]
os.remove(settings.filepath)
told.append(reradiation_matrix.matrix_of(settings))
settings.filepath = os.path.join(TMP, "bad.csv")
told += [settings.problem, reradiation_matrix.matrix_of(settings)]
settings.filepath = os.path.join(TMP, "missing.csv")
told.append(settings.problem)
tell(told)
""", tmp_path, env=REAL)
    assert found[0] is None and found[1] == "" and found[3] == "paint"
    assert "1 of 20 bands were not measured" in found[2]
    matrix = found[4]
    assert matrix["incident"] == [400, 4] and matrix["outgoing"] == [400, 5] and matrix["step"] == 20
    assert matrix["share"][4] == pytest.approx(0.1) and len(matrix["share"]) == 20
    assert "bad.csv" in found[5] and found[6] is None
    assert "No such file" in found[7]


def test_without_a_core_the_node_says_so(host, tmp_path):
    found = host.run(TOOLS + """
settings.measurement = "matrix/yellow_note"
tell([settings.problem, reradiation_matrix.matrix_of(settings)])
""", tmp_path, env={"STOKES_CORE": str(tmp_path / "nowhere")})
    assert "names no file" in found[0]
    assert found[1] == {"library": "matrix/yellow_note"}  # the core that renders knows it


def test_the_yellow_note_is_yellow_without_stokes_and_a_matrix_with_it(host, tmp_path):
    found = host.run(TOOLS + """
settings.measurement = "matrix/yellow_note"
settings.diagonal = "elastic"
tree.links.new(made.outputs[0], tree.get_output_node('CYCLES').inputs[0])
inside = [n for n in made.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfDiffuse"][0]
from addon.export.nodes import stokes
from addon.export.nodes.graph import Graph
class Context:
    def __getattr__(self, name):
        return lambda *a, **k: None
tell([list(inside.inputs[0].default_value), stokes.measured(made, Graph(material, Context())), made.label])
""", tmp_path, env=REAL)
    red, green, blue, _ = found[0]
    assert red > 0.7 and green > 0.7 and blue < 0.35
    assert found[1] == {"bsdf": "reradiation_matrix", "matrix": {"library": "matrix/yellow_note"}, "diagonal": "elastic"}
    assert found[2] == "Yellow Note"


def test_a_measured_plane_renders(host, tmp_path):
    (tmp_path / "paint.csv").write_text(CSV)
    found = host.run(TOOLS + """
settings.filepath = os.path.join(TMP, "paint.csv")
scene = empty_scene()
material = bpy.data.materials.new("Paint"); material.use_nodes = True
tree = material.node_tree
made = nodes.new(tree, "reradiation_matrix", filepath=os.path.join(TMP, "paint.csv"))
tree.links.new(made.outputs[0], tree.get_output_node('CYCLES').inputs[0])
plane = add_mesh("Plane", ((-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)))
plane.data.materials.append(material)
sun = bpy.data.lights.new("Sun", 'SUN'); sun.energy = math.pi
add("Sun", sun, (0, 0, 3))
scene.render.engine = 'STOKES'
scene.stokes.samples = 4
scene.render.resolution_x = scene.render.resolution_y = 8
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = 'OPEN_EXR'
scene.render.filepath = os.path.join(TMP, "plane.exr")
bpy.ops.render.render(write_still=True)
image = bpy.data.images.load(scene.render.filepath)
values = list(image.pixels)
tell(sum(values) / len(values))
""", tmp_path, env=REAL)
    assert found > 0.3


def test_a_colour_becomes_moments_if_asked_and_stays_a_colour_as_a_light(host, tmp_path):
    found = host.run("""
from addon import nodes
from addon.export.nodes import stokes
from addon.export.nodes.graph import Graph
material = bpy.data.materials.new("M"); material.use_nodes = True
tree = material.node_tree
made = nodes.new(tree, "spectrum_rgb", sockets={"Color": (0.5, 0.25, 0.125)}, method='moments')
class Context:
    def __getattr__(self, name):
        return lambda *a, **k: None
graph = Graph(material, Context())
value = stokes.rgb(made, made.outputs[0], graph)
told = [value.spectrum, graph.light(value, 2.0, made)]
made.stokes.spectrum_rgb.method = 'sigmoid'
told.append(list(stokes.rgb(made, made.outputs[0], graph).value))
tell(told)
""", tmp_path)
    assert found[0] == {"rgb": [0.5, 0.25, 0.125], "method": "moments"}
    assert found[1] == {"rgb": [0.5, 0.25, 0.125], "scale": 2.0}
    assert found[2][:3] == [0.5, 0.25, 0.125]
