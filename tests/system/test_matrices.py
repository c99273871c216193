"""Reradiation matrices: a measured one as a material, against the operator; and files of all kinds in and out."""

import numpy as np
import pytest

import exact
import exr
import scenes
import stats

EDGES = 5  # the note reflects up to 0.95 of the red: longer paths are left out on both sides
SETTINGS = {"d0": 2, "shrink": 0, "max_path": EDGES, "max_camera": EDGES, "max_light": EDGES, "roulette_start": 32}


@pytest.fixture(scope="module")
def note(core, tmp_path_factory):
    """The yellow note of the library, as the core hands it out."""
    path = tmp_path_factory.mktemp("matrix") / "note.csv"
    core.run("matrix", "import", "matrix/yellow_note", "-o", path)
    return exact.Matrix.read(path)


def spectrum_of(picture, rows):
    _, bins = picture.bins()
    return bins.reshape(len(bins), rows, -1).mean(axis=2, dtype=np.float64).T


# What the note looks like under daylight, and what it glows in under a black light.
CASES = {
    ("pt", "d65"): (250, (10, 400, 700), (4, 64)),
    ("pt", "uv"): (700, (3, 460, 580), (4, 64)),
    ("mbdpt", "uv"): (10, (2, 500, 580), (48, 1)),
    ("bdpt", "uv"): (10, (2, 500, 580), (48, 1)),
}


@pytest.mark.parametrize("integrator,light", CASES)
def test_a_furnace_of_the_yellow_note_matches_its_operator(core, tmp_path, note, integrator, light):
    samples, bins, (renders, rows) = CASES[integrator, light]
    path = tmp_path / "scene.stokes"
    scenes.furnace(path, note, scenes.LIGHTS[light], **SETTINGS)
    _, emitted = scenes.emission(scenes.LIGHTS[light])
    wanted = exact.per_bin(exact.furnace(note, emitted, EDGES), bins)
    found = core.batches(path, integrator, renders, samples, bins, lambda picture: spectrum_of(picture, rows))
    edges = np.linspace(bins[1], bins[2], bins[0] + 1)
    names = ["%g–%g nm" % pair for pair in zip(edges, edges[1:])]
    stats.assert_unbiased("yellow note, %s, %s" % (integrator, light), found, wanted, np.full(bins[0], 0.05), names=names)


# --- Files ------------------------------------------------------------------------------------------------------


def test_every_format_holds_the_same_matrix(core, tmp_path, note):
    """CSV to bispectral EXR and back; and the EXR as another reader sees it."""
    core.run("matrix", "import", "matrix/yellow_note", "-o", tmp_path / "note.exr")
    core.run("matrix", "import", tmp_path / "note.exr", "-o", tmp_path / "again.csv")
    assert exact.Matrix.read(tmp_path / "again.csv").share == pytest.approx(note.share, abs=1e-8)
    picture = exr.read(tmp_path / "note.exr")
    assert picture.texts["spectralLayoutVersion"] == "1.0"
    for nm in (390, 500, 620):
        share = note.share[(nm - 380) // 10, (nm - 300) // 10]
        assert picture.channels["T.%d,000000nm" % nm][0, 0] == pytest.approx(share)
    assert picture.channels["T.350,000000nm.520,000000nm"][0, 0] == pytest.approx(note.share[14, 5])


def test_a_materials_matrix_can_be_exported(core, tmp_path, note):
    path = tmp_path / "scene.stokes"
    paint = scenes.MATERIALS["fluorescent"]
    with scenes.stream.Recorder(path) as out:
        out.send("material", name="note", surface=note.message())
        out.send("material", name="paint", surface=paint.message())
        out.send("material", name="mirror", surface={"bsdf": "conductor", "metal": "Ag", "roughness": 0})
        scenes.camera(out)
    core.run("matrix", "export", path, "note", "-o", tmp_path / "note.csv", "--bands", "300,780,10")
    found = exact.Matrix.read(tmp_path / "note.csv")
    assert found.share[8:] == pytest.approx(note.share, abs=1e-6)
    core.run("matrix", "export", path, "paint", "-o", tmp_path / "paint.csv", "--bands", "310,820,20")
    found = exact.Matrix.read(tmp_path / "paint.csv")
    blocks = paint.operator()[: 26 * 40, : 26 * 40].reshape(26, 40, 26, 40).sum(axis=1).mean(axis=2)
    assert found.share == pytest.approx(blocks, abs=2e-3)
    result = core.run("matrix", "export", path, "mirror", "-o", tmp_path / "mirror.csv")
    assert "mirror: matrix: nothing leaves at 0°" in result.stderr and len(result.stderr.splitlines()) == 1
    result = core.run("matrix", "export", path, "nothing", "-o", tmp_path / "none.csv", check=False)
    assert result.returncode == 1 and "nothing: material: is not in the scene" in result.stderr


def test_a_measured_matrix_has_a_source_and_a_licence(core):
    assert core.run("matrix", "list").stdout.startswith("matrix/yellow_note  300–780 nm  3M fluorescent yellow note, measured by Labsphere")
    assert core.run("matrix", "list").stdout.endswith("(BSD-3-Clause)\n")


def test_what_a_measurement_lacks_is_said_in_a_line_each(core, tmp_path):
    result = core.run("matrix", "import", "matrix/yellow_note", "-o", tmp_path / "note.csv")
    lines = result.stderr.splitlines()
    assert len(lines) == 2
    assert "range: reflection was measured from 380 to 780 nm" in lines[0]
    assert "noise: 770 values are below zero" in lines[1]


@pytest.mark.parametrize(
    "text", ["", "nothing", "a,1,2\n", "a,400,410\n400,1\n", "a,400,410\n410,1,0\n400,0,1\n", "a\0b", "VEC_01 3\n1 2 3\n"]
)
def test_what_is_no_matrix_is_one_line(core, tmp_path, text):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    result = core.run("matrix", "show", path, check=False)
    assert result.returncode == 1
    assert len(result.stderr.splitlines()) == 1 and str(path) in result.stderr
