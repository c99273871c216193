"""The scripts of test_scenes build their scenes in every Blender, and render them by its own operator."""

import os
import subprocess
import sys

import numpy as np
import pytest

from hosts import ROOT, oldest_and_newest

sys.path.append(str(ROOT / "tests" / "system"))
import exr  # noqa: E402

from addon.core import stream  # noqa: E402

CORE = ROOT / "build" / "stokes"
SCENES = {
    "spheres": ("spheres", ()),
    "lens": ("lens", ()),
    "ufo": ("ufo", ("--samples", "16")),  # a lamp in sight, and few samples are of one colour
    "bias": ("bias-checker-cyan-back", ("--reflectance", "checker-cyan", "--walls", "back")),
}

# Runs the script as Blender would, then looks at its EXR.
LAUNCH = """
import runpy, sys
import bpy
sys.argv = sys.argv[sys.argv.index("--"):]
path, sys.argv = sys.argv[1], ["blender", "--"] + sys.argv[2:]
runpy.run_path(path, run_name="__main__")
image = bpy.data.images.load(EXR)
image.colorspace_settings.is_data = True
values = list(image.pixels)
print("MEAN", sum(values[0::4]) / image.size[0] / image.size[1], sum(values[1::4]) / image.size[0] / image.size[1])
"""


@pytest.mark.skipif(not CORE.exists(), reason="the core is not built")
@pytest.mark.parametrize("script", SCENES)
@oldest_and_newest
def test_a_scene_script_writes_its_picture_and_its_scene_file(host, tmp_path, script):
    name, more = SCENES[script]
    launch = tmp_path / "launch.py"
    launch.write_text(LAUNCH.replace("EXR", repr(str(tmp_path / (name + ".exr")))))
    done = subprocess.run(
        [*host.command, str(launch), "--", str(ROOT / "test_scenes" / (script + ".py")), "--output", str(tmp_path),
         "--resolution", "24", "18", "--samples", "2", *more],
        env=dict(os.environ, STOKES_CORE=str(CORE)), timeout=100, text=True, cwd=tmp_path,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0 and "Traceback" not in done.stdout, done.stdout
    mean = next(line.split()[1:] for line in done.stdout.splitlines() if line.startswith("MEAN"))
    assert all(0.005 < float(value) < 10 for value in mean), mean
    assert (tmp_path / (name + ".png")).stat().st_size > 500
    info = subprocess.run([CORE, "info", tmp_path / (name + ".stokes")], check=True, timeout=30, text=True,
                          capture_output=True).stdout
    assert "Lamp" in info or "light" in info
    assert_same_picture(tmp_path / (name + ".exr"), tmp_path / (name + ".stokes"), tmp_path / "replayed.exr")


@pytest.mark.parametrize("host", ["3.4"], indirect=True)
def test_the_ufo_scene_is_full_of_the_medium_that_is_shown(host, tmp_path):
    """Figure 6 of the supplemental is drawn from the script's constants; the stream has the same medium, and the coral in it.
    Saucer and dome are smooth, of silver and of a glass of Abbe number 10 (§4.2)."""
    sys.path.append(str(ROOT / "tests" / "figures"))
    from spectra import constants, gaussian, medium
    nm = np.arange(300.0, 831.0)
    subprocess.run(
        [*host.command, str(ROOT / "test_scenes" / "ufo.py"), "--", "--output", str(tmp_path), "--resolution", "8", "6",
         "--samples", "1", "--integrator", "pt_nee"],
        env=dict(os.environ, STOKES_CORE=str(CORE)), timeout=100, check=True, cwd=tmp_path, stdout=subprocess.DEVNULL)
    sent = {members["name"]: members for message, members, _ in stream.read(tmp_path / "ufo.stokes") if message == "material"}
    scatter, absorption = sent["Medium"]["volume"]["add"]
    assert (scatter["volume"], absorption["volume"]) == ("scatter", "absorption")
    curves = [gaussian({name.capitalize(): value for name, value in part["color"]["gaussian"].items()}, nm)
              for part in (scatter, absorption)]
    scattering = scatter["density"] * curves[0]
    extinction = scattering + absorption["density"] * (1 - curves[1])
    assert extinction.min() > 0.05 and np.ptp(extinction) > 0.05
    assert np.allclose(extinction, medium(nm)[0]) and np.allclose(scattering / extinction, medium(nm)[1])
    assert constants("ufo")["CORAL"][1] in sent["Coral"]["surface"]["emission"]["library"]
    assert sent["Silver"]["surface"] == {"bsdf": "conductor", "metal": "Ag", "roughness": 0}
    assert sent["Dome"]["surface"]["ior"] == {"n_d": 1.3, "abbe": 10} and sent["Dome"]["surface"]["roughness"] == 0
    assert sent["Coral"]["volume"] is None and sent["Medium"]["surface"]["bsdf"] == "transparent"


SIDES = {"Floor": (2, 0), "Ceiling": (2, 2), "Left": (0, -1), "Right": (0, 1), "Back": (1, 1)}  # wall: axis and place on it


@pytest.mark.parametrize("walls, coloured", [
    ("all", set(SIDES)), ("others", {"Floor", "Ceiling", "Left", "Right"}), ("back", {"Back"})])
@pytest.mark.parametrize("host", ["3.4"], indirect=True)
def test_each_box_of_the_colour_bias_tests_has_its_colour_where_figure_8_says(host, tmp_path, walls, coloured):
    """§4.4: on all walls (a), on all but a grey back wall (b), on the back wall alone (c); and each wall is where its name
    says, as the stream's vertices have it."""
    subprocess.run(
        [*host.command, str(ROOT / "test_scenes" / "bias.py"), "--", "--output", str(tmp_path), "--resolution", "8", "6",
         "--samples", "1", "--walls", walls],
        env=dict(os.environ, STOKES_CORE=str(CORE)), timeout=100, check=True, cwd=tmp_path, stdout=subprocess.DEVNULL)
    sent = list(stream.read(tmp_path / ("bias-green-%s.stokes" % walls)))
    rgb = {members["name"]: members["surface"]["reflectance"]["rgb"] for message, members, _ in sent
           if message == "material"}
    shown = {members["name"]: rgb[members["materials"][0]] for message, members, _ in sent if message == "instances"}
    assert shown == {side: pytest.approx([0.05, 0.8, 0.15] if side in coloured else [0.2] * 3) for side in SIDES}
    for message, members, blobs in sent:
        if message == "mesh":
            place = members["positions"]
            points = np.frombuffer(blobs[place["at"]:place["at"] + place["bytes"]], np.float32).reshape(-1, 3)
            axis, at = SIDES[members["name"]]
            assert points[:, axis] == pytest.approx(at) and (np.ptp(points, axis=0) > 1.9).sum() == 2


def assert_same_picture(shown, scene, out):
    """What came through Blender, which stores halves, is what `stokes render` makes of the recorded stream."""
    subprocess.run([CORE, "render", scene, "-o", out, "-q"], check=True, timeout=100)
    through, replayed = exr.read(shown), exr.read(out)
    for channel in "RGB":
        expected = replayed.channels[channel].astype(through.channels[channel].dtype)
        assert expected.any() and np.array_equal(through.channels[channel], expected)
