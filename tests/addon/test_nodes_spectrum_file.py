"""The node Measured Spectrum: the core reads the file, the .blend keeps it, the stream carries it."""

import pytest

from hosts import ROOT, oldest_and_newest

CORE = ROOT / "build" / "stokes"
REAL = {"STOKES_CORE": str(CORE)}
pytestmark = [oldest_and_newest, pytest.mark.skipif(not CORE.exists(), reason="the core is not built")]

TOOLS = """
from addon import nodes
from addon.nodes import spectrum_file
from addon.export.nodes import stokes
from addon.export.nodes.graph import Graph

class Context:
    def __init__(self): self.warnings = []
    def warn(self, owner, prop, text): self.warnings.append(text)

context = Context()
material = bpy.data.materials.new("M")
material.use_nodes = True
made = nodes.new(material.node_tree, "spectrum_file")
settings = made.stokes.spectrum_file

def read(name, column=1):
    settings.column = column
    settings.filepath = os.path.join(TMP, name + ".csv")
    return [spectrum_file.table_of(settings), settings.problem, settings.notes]
"""


def test_a_table_is_read_whatever_parts_its_columns_and_stays_in_the_file(host, tmp_path):
    (tmp_path / "good.csv").write_text("nm;percent;other\n# a title\n700;50;1\n400;10;2\n\n500,5;90,5;3\n600 80, 5\n")
    found = host.run(TOOLS + """
settings.percent = True
told = [read("good")]
os.remove(settings.filepath)
tell(told + [len(spectrum_file.table_of(settings))])
""", tmp_path, env=REAL)
    rows = [[400, 0.1], [500.5, 0.905], [600, 0.8], [700, 0.5]]
    assert found[0] == [[pytest.approx(row) for row in rows], "", ""] and found[1] == 4


def test_what_spreadsheets_write_is_read_and_what_was_taken_for_granted_is_a_warning(host, tmp_path):
    """As tests/system/test_spectra.py has it of the core, which is who reads here, too."""
    (tmp_path / "quoted.csv").write_text('"nm","a","b"\n"400","0.1","0.25"\n"500","0.1","0.75"\n', encoding="utf-8-sig")
    (tmp_path / "unicode.csv").write_text("Å\tshare\r\n4000\t0,25\r\n5000\t0,75\r\n", encoding="utf-16")
    (tmp_path / "noisy.csv").write_text("400 50\n500 -1\n600 20\n")
    found = host.run(TOOLS + """
told = [read("quoted", 2), read("unicode"), read("noisy")]
settings.percent = True
stokes.from_file(made, made.outputs[0], Graph(material, context))
tell(told + [context.warnings])
""", tmp_path, env=REAL)
    assert found[0] == [[[400, 0.25], [500, 0.75]], "", ""]
    assert found[1][:2] == [[[400, 0.25], [500, 0.75]], ""]
    angstrom, commas = found[1][2].splitlines()
    assert "wavelengths are in Å by line 1" in angstrom and "commas within numbers, as in line 2" in commas
    assert found[2][0] == [[400, 50], [500, 0], [600, 20]]
    assert found[3] == ["1 of 3 values are below zero, down to -1: taken as 0"]


def test_why_a_file_was_not_read_is_one_line_without_its_path(host, tmp_path):
    for name, text in {
        "twice": "400 1\n400 2\n",
        "micrometres": "0.4 1\n0.7 2\n",
        "negative": "-400 1\n700 2\n",
        "unsaid": "3800,1\n7800,2\n",
        "words": "400,1\n500,abc\n",
        "long": "".join("%.3f 1\n" % (300 + i / 200) for i in range(70000)),
    }.items():
        (tmp_path / (name + ".csv")).write_text(text)
    found = host.run(TOOLS + """
tell([read(name)[:2] for name in ("twice", "missing", "micrometres", "negative", "unsaid", "words", "long")])
""", tmp_path, env=REAL)
    assert found == [[[], problem] for problem in (
        "lines: wavelength 400 stands twice",
        "open: No such file or directory",
        "lines: wavelengths end at 0.7: they are wanted in nm, not in µm",
        "lines: line 1: wavelength -400, value 1: out of range",
        "lines: wavelengths of 3800 to 7800: a title above them must say whether they are in nm or Å",
        "lines: line 2: no number in column 1: 'abc' (the wavelengths are column 0)",
        "lines: more than 65534",
    )]


def test_a_file_is_not_taken_for_an_entry_of_the_library_nor_for_an_option(host, tmp_path):
    (tmp_path / "illuminant").mkdir()
    for name in ("illuminant/A", "--help"):
        (tmp_path / name).write_text("400 1\n500 2\n")
    found = host.run(TOOLS + """
told = []
for settings.filepath in ("illuminant/A", "--help"):
    told.append([spectrum_file.table_of(settings), settings.problem])
tell(told)
""", tmp_path, env=REAL)
    assert found == [[[[400, 1], [500, 2]], ""]] * 2


def test_without_a_core_the_node_says_so(host, tmp_path):
    found = host.run(TOOLS + 'tell(read("any"))', tmp_path, env={"STOKES_CORE": str(tmp_path / "nowhere")})
    assert found[0] == [] and "names no file" in found[1]
