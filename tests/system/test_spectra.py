"""`stokes spectrum`: the library with its sources, and users' own files."""

import json
import xml.etree.ElementTree as xml

import pytest

import scenes

ROWS = "nm;percent\n# a title\n500;20;1\n400;10;2\n600 90 3\n"


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "own.csv"
    path.write_text(ROWS)
    return path


def numbers(result):
    return [tuple(map(float, line.split())) for line in result.stdout.splitlines()]


def test_every_entry_has_a_source_a_licence_and_its_measured_range(core):
    names = core.run("spectrum", "list").stdout.splitlines()
    lines = core.run("spectrum", "list", "--long").stdout.splitlines()
    assert len(set(names)) == len(names) == len(lines) > 230
    for name, line in zip(names, lines):
        assert line.startswith(name + "  ") and " nm  " in line and "(" in line, line
    for shelf, count in {"colorchecker": 24, "illuminant": 19, "lamp": 14, "metal": 36, "glass": 28, "dye": 118}.items():
        assert sum(name.startswith(shelf + "/") for name in names) == count, shelf


def test_quantum_yields_come_with_who_measured_them(core):
    line = core.run("spectrum", "list", "-l", "dye/quinine-sulfate").stdout.splitlines()[0]
    assert "quantum yield 0.546: W. H. Melhuish" in line
    assert "quantum yield" not in core.run("spectrum", "list", "-l", "dye/calcein").stdout


def test_an_entry_is_shown_between_its_knots(core):
    found = core.run("spectrum", "show", "colorchecker/red", 500, 520, 5)
    assert [nm for nm, _ in numbers(found)] == [500, 505, 510, 515, 520]
    values = [value for _, value in numbers(found)]
    assert values[1] == pytest.approx((values[0] + values[2]) / 2, rel=1e-4)
    assert "ColorChecker" in found.stderr and "BSD-3-Clause" in found.stderr


@pytest.mark.parametrize(
    "name,nm,value,source",
    [
        ("illuminant/D65", 400, 0.827549, "CIE 015:2018"),
        ("illuminant/A", 400, 0.147080, "CIE 015:2018"),
        ("illuminant/D50", 500, 0.957243, "CIE 015:2018"),
        ("illuminant/E", 700, 1, "CIE 015:2018"),
        ("glass/BK7", 590, 1.51670, "SCHOTT"),  # n_D, at 589.3 nm, is 1.51673
    ],
)
def test_what_is_a_formula_is_listed_and_shown_like_the_rest(core, name, nm, value, source):
    """Illuminants as CIE 015:2018 prints them, over 100."""
    found = core.run("spectrum", "show", name, nm, nm + 5, 5)
    assert numbers(found)[0] == (nm, pytest.approx(value, rel=2e-5)) and source in found.stderr


def test_every_name_of_a_light_or_a_colour_is_what_the_stream_takes(core, tmp_path):
    names = [name for name in core.run("spectrum", "list").stdout.splitlines() if not name.startswith("glass/")]
    with scenes.stream.Recorder(tmp_path / "all.stokes") as out:
        for name in names:
            light = {"shape": {"library": name}, "scale": 1, "unit": "per_nm"}
            out.send("material", name=name, surface={"emission": light, "two_sided": True})
        scenes.camera(out)
        scenes.mesh(out, "box", *scenes.cube())
        scenes.instance(out, "box", [names[-1]])
    core.run("render", tmp_path / "all.stokes", "-o", tmp_path / "all.exr", "--spp", 1)


def test_a_file_is_shown_sorted_by_the_column_that_is_asked_for(core, table):
    assert numbers(core.run("spectrum", "show", table)) == [(400, 10), (500, 20), (600, 90)]
    assert numbers(core.run("spectrum", "show", table, "--column", 2)) == [(400, 2), (500, 1), (600, 3)]
    assert numbers(core.run("spectrum", "show", table, 450, 550, 50)) == [(450, 15), (500, 20), (550, 55)]


def test_beside_semicolons_a_comma_is_a_decimal_mark(core, tmp_path):
    path = tmp_path / "comma.csv"
    path.write_text("nm;a, b\n400;0,25\n500,5;0,75\n")
    assert numbers(core.run("spectrum", "show", path)) == [(400, 0.25), (500.5, 0.75)]


def test_an_imported_file_is_what_the_stream_takes(core, table, tmp_path):
    result = core.run("spectrum", "import", table, "--percent", "-o", tmp_path / "own.json")
    assert "3 values of 0.1 to 0.9, 400 to 600 nm" in result.stdout and not result.stderr
    found = json.loads((tmp_path / "own.json").read_text())
    assert found == {"table": {"lambda": [400, 500, 600], "value": [0.1, 0.2, 0.9]}}
    core.run("spectrum", "import", table, "-o", tmp_path / "sorted.csv")
    assert (tmp_path / "sorted.csv").read_text() == "nm,value\n400,10\n500,20\n600,90\n"


def test_noise_below_zero_is_cut_and_told(core, tmp_path):
    path = tmp_path / "noisy.csv"
    path.write_text("400 50\n500 -1\n600 -0.5\n")
    result = core.run("spectrum", "import", path, "-p", "-o", tmp_path / "own.json")
    assert "2 of 3 values are below zero, down to -0.01: taken as 0" in result.stderr.splitlines()[0]
    assert json.loads((tmp_path / "own.json").read_text())["table"]["value"] == [0.5, 0, 0]
    assert numbers(core.run("spectrum", "show", path))[1] == (500, -1)


def test_a_plot_holds_a_curve_for_each_spectrum(core, table, tmp_path):
    core.run("spectrum", "plot", "colorchecker/red", "dye/dsred/emission", table, "-o", tmp_path / "plot.svg")
    sheet = xml.fromstring((tmp_path / "plot.svg").read_text())
    curves = sheet.findall("{*}polyline")
    words = [text.text for text in sheet.findall("{*}text")]
    assert len(curves) == 3 and "wavelength (nm)" in words and str(table) in words
    points = [tuple(map(float, point.split(","))) for point in curves[2].get("points").split()]
    assert len(points) == 3 and points[0][1] > points[1][1] > points[2][1]  # up is small
    piped = core.run("spectrum", "plot", "colorchecker/red")
    assert xml.fromstring(piped.stdout).tag.endswith("svg")


def test_a_wrong_argument_and_its_option_are_named(core):
    for arguments, why in (
        (["spectrum", "plot", "lamp/HP1", "--range", "500,400"], "'500,400' is not what -r takes"),
        (["spectrum", "show", "lamp/HP1", "--column", "0"], "'0' is not what -c takes"),
        (["spectrum", "show", "lamp/HP1", "--nothing"], "'--nothing' is no option, or lacks its argument"),
        (["matrix", "show", "matrix/yellow_note", "--pixel", "1"], "'1' is not what -p takes"),
    ):
        result = core.run(*arguments, check=False)
        assert result.returncode == 2 and why in result.stderr and len(result.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    "text,why",
    [
        ("", "at least two"),
        ("400 1\n", "at least two"),
        ("400 1\n400 2\n", "wavelength 400 stands twice"),
        ("400 1\n500 abc\n", "line 2: no number in column 1: 'abc' (the wavelengths are column 0)"),
        ("400,1\n500,,3\n", "line 2: no number in column 1 (the wavelengths are column 0)"),
        ("400\t1\n500\t\t3\n", "line 2: no number in column 1 ("),
        ("400,1\n,3\n", "line 2: no number in column 0 ("),
        ("400,1\n500nm,3\n", "line 2: no number in column 0: '500nm'"),
        ("400,0x1\n500,0x2\n", "line 1: no number in column 1: '0x1'"),
        ('400,"1,125"\n500,2\n', "line 1: the comma in column 1 may be one of decimals or of thousands: '1,125'"),
        ('"400,1"\n"500,2"\n', "line 1: no number in column 1"),
        ("400,1\n500,\x1b[2J\n", "line 2: no number in column 1 ("),
        ("400 1\n500 nan\n", "line 2"),
        ("400 1\n-5 1\n", "line 2"),
        ("0.7 1\n0.4 1\n", "wavelengths end at 0.7: they are wanted in nm, not in µm"),
        ("0.2 1\n206 1\n", "wavelengths begin at 0.2: they are wanted in nm, not in µm"),
        ("3800 1\n7800 1\n", "wavelengths of 3800 to 7800: a title above them must say whether they are in nm or Å"),
        ("500 1\n9000 1\n", "wavelengths of 500 to 9000: a title above them must say"),
        ("Å,share\n380,1\n780,1\n", "line 1 says Å, but wavelengths of 380 to 780 look like nm"),
        ("wavenumber,share\n400,1\n4000,1\n", "line 1 names wavenumbers or frequencies"),
        ("ν (cm-1);share\n400;1\n700;1\n", "line 1 names wavenumbers or frequencies"),
    ],
)
def test_what_is_no_table_is_one_line(core, tmp_path, text, why):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    for arguments in (["show", path], ["plot", path], ["import", path, "-o", tmp_path / "out.csv"]):
        result = core.run("spectrum", *arguments, check=False)
        assert result.returncode == 1 and why in result.stderr and str(path) in result.stderr
        assert len(result.stderr.splitlines()) == 1
    assert not (tmp_path / "out.csv").exists()


SHEET = [(400, 0.25), (500.5, 0.75)]


@pytest.mark.parametrize(
    "text",
    [
        '"nm","a; b"\n"400","0.25"\n"500.5","0.75"\n',
        'nm,share\n400,"0,25"\n"500,5","0,75"\n',
        '"nm";"share"\n"400";"0,25";"a, b"\n"500,5";"0,75";""\n',
        'nm,share,who\n400,0.25,"one; two"\n500.5,0.75,"said ""so"", twice"\n,,\n',
        "nm\tshare\n400\t0,25\n500,5\t0,75\n",
        "400 0,25\n500,5 0,75\n",
        "400, 0,25\n500,5, 0,75\n",
        "400,0.25 1\n500.5,0.75 1\n",
        "400,0.25 # a remark, and 1 more\n500.5,0.75\n",
        "sep=;\r\nnm;share\r\n400;0,25\r\n500,5;0,75",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be-mark"])
def test_what_spreadsheets_write_is_read_as_it_was_meant(core, tmp_path, text, encoding):
    path = tmp_path / "sheet.csv"
    path.write_bytes(b"\xfe\xff" + text.encode("utf-16-be") if "mark" in encoding else text.encode(encoding))
    assert numbers(core.run("spectrum", "show", path)) == SHEET


def test_commas_that_were_taken_as_decimal_marks_without_semicolons_are_told(core, tmp_path):
    path = tmp_path / "sheet.csv"
    for text, line in (("nm share\n400 0,25\n500 1\n", 2), ('400,1\n500,"0,5"\n', 2)):
        path.write_text(text)
        result = core.run("spectrum", "show", path)
        assert result.stderr == (
            "stokes: %s: lines: commas within numbers, as in line %d, are taken as decimal marks\n" % (path, line)
        )
    for quiet in ("400;0,25\n500;1\n", "400,0.25\n500,1\n", "400, 25\n500, 1\n"):
        path.write_text(quiet)
        assert not core.run("spectrum", "show", path).stderr


@pytest.mark.parametrize(
    "title",
    ["Å,share", "\u212b,share", "A\u030a,share", "Wavelength (A),flux", "# lambda [A] flux", "WAVELENGTH/ÅNGSTRÖM;a",
     '"wavelength, angstroms","A"', "slit 2 nm\nÅ,W/m²/nm"],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
def test_wavelengths_in_angstrom_are_read_in_nm_and_told(core, tmp_path, title, encoding):
    path = tmp_path / "stars.csv"
    path.write_bytes((title + "\n3800,1\n5000,2\n7800,3\n").encode(encoding, errors="ignore"))
    if encoding == "latin-1" and title[0] in "\u212bA":  # it has no such letters
        return
    for arguments in (["show", path], ["plot", path], ["import", path, "-o", tmp_path / "out.csv"]):
        result = core.run("spectrum", *arguments)
        assert "wavelengths are in Å by line %d: a tenth of each is taken" % (1 + title.count("\n")) in result.stderr
    assert (tmp_path / "out.csv").read_text() == "nm,value\n380,1\n500,2\n780,3\n"


@pytest.mark.parametrize(
    "title", ["nm,A", "wavelength (nm),absorbance (A)", "wavelength,absorbance (A)", "nm,W/m²/Å", "A,B", "Armstrong 2019"]
)
def test_what_is_no_unit_of_wavelengths_changes_nothing(core, tmp_path, title):
    path = tmp_path / "lab.csv"
    path.write_text(title + "\n380,1\n780,3\n")
    result = core.run("spectrum", "show", path)
    assert numbers(result) == [(380, 1), (780, 3)] and not result.stderr


def test_a_title_that_says_nm_lets_infrared_tables_pass(core, tmp_path):
    path = tmp_path / "infrared.csv"
    path.write_text("nm,n\n900,1.5\n20000,1.4\n")
    assert numbers(core.run("spectrum", "show", path)) == [(900, 1.5), (20000, 1.4)]


@pytest.mark.parametrize(
    "data,why",
    [
        ("400,1\n500,2\n".encode("utf-16-le"), "is no text, or UTF-16 without its mark"),
        ("400,1\n500,2\n".encode("utf-16") + b"5", "is broken UTF-16"),
        ("400,1\n".encode("utf-16") + b"\x3d\xd8\x35\x00", "is broken UTF-16"),
        ("400,1\n".encode("utf-16") + b"\x3d\xd8", "is broken UTF-16"),
        ("400,1\n500,2\n".encode("utf-32"), "is no text"),
        (b"\xff\xfe", "at least two"),
        (b"\x00", "is no text"),
    ],
)
def test_what_is_no_text_is_one_line(core, tmp_path, data, why):
    path = tmp_path / "bad.csv"
    path.write_bytes(data)
    result = core.run("spectrum", "show", path, check=False)
    assert result.returncode == 1 and why in result.stderr and len(result.stderr.splitlines()) == 1


def test_messages_count_columns_as_the_option_does(core, tmp_path):
    path = tmp_path / "two.csv"
    path.write_text("400,1,x\n500,2,3\n")
    result = core.run("spectrum", "show", path, "--column", 2, check=False)
    assert "line 1: no number in column 2: 'x'" in result.stderr
    assert "the wavelengths are column 0" in core.run("spectrum", "--help").stdout
