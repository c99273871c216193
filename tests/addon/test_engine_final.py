"""The engine in Blender, with the tests' own core: pictures, failures, cancel, layers, previews."""

import json
import os
import subprocess

import pytest

from clock import assert_in_time
from hosts import FAKE_CORE, ROOT, host_named, oldest_and_newest

CORE = ROOT / "build" / "stokes"

RAMP = """
def error_of_ramp(told, full, border=None):
    width, height, values = told
    x0, y0, x1, y1 = border or (0, 0, *full)
    assert (width, height) == (x1 - x0, y1 - y0), (width, height)
    return max(max(abs(values[4 * (y * width + x)] - (x0 + x + 0.5) / full[0]),
                   abs(values[4 * (y * width + x) + 1] - (y0 + y + 0.5) / full[1]))
               for y in range(height) for x in range(width))
"""


def test_the_picture_is_upright_and_whole(host, tmp_path):
    assert (
        host.run(
            RAMP
            + """
empty_scene(size=(33, 17))
tell(error_of_ramp(pixels(save_exr("a.exr")), (33, 17)))
""",
            tmp_path,
        )
        < 1e-5
    )


def test_a_border_is_a_part_of_the_full_frame(host, tmp_path):
    cropped, full = host.run(
        RAMP
        + """
scene = empty_scene(size=(40, 20))
scene.render.use_border = True
scene.render.border_min_x, scene.render.border_max_x = 0.26, 0.77
scene.render.border_min_y, scene.render.border_max_y = 0.12, 0.61
scene.render.use_crop_to_border = True
cropped = error_of_ramp(pixels(save_exr("crop.exr")), (40, 20), (10, 2, 30, 12))
scene.render.use_crop_to_border = False
width, height, values = pixels(save_exr("full.exr"))
inside = values[4 * (5 * width + 15)]
tell([cropped, [width, height, inside, values[0]]])
""",
        tmp_path,
    )
    assert cropped < 1e-5
    assert full[:2] == [40, 20] and full[2] == pytest.approx(15.5 / 40) and full[3] == 0


def test_every_border_has_blenders_own_size(host, tmp_path):
    """Sizes and borders that round differently: the picture must fit Blender's, whatever its
    rule."""
    assert (
        host.run(
            """
scene = empty_scene(samples=1)
scene.render.use_border = scene.render.use_crop_to_border = True
number = 0
for size in ((97, 53), (100, 100), (203, 101)):
    scene.render.resolution_x, scene.render.resolution_y = size
    for percent in (100, 33):
        scene.render.resolution_percentage = percent
        for low, high in ((0.1, 0.9), (1 / 3, 2 / 3), (0.29, 0.57)):
            scene.render.border_min_x = scene.render.border_min_y = low
            scene.render.border_max_x = scene.render.border_max_y = high
            bpy.ops.render.render()
            number += 1
tell(number)
""",
            tmp_path,
        )
        == 18
    )


def test_each_view_layer_is_rendered(host, tmp_path):
    told = host.run(
        """
scene = empty_scene()
scene.view_layers.new("Second")
os.environ["STOKES_RECORD"] = os.path.join(TMP, "layers.stokes")
bpy.ops.render.render()
tell(sorted(messages(stream.read(os.path.join(TMP, name)), "render")[0]["layer"]
            for name in os.listdir(TMP) if name.endswith(".stokes")))
""",
        tmp_path,
    )
    assert told == ["Second", "ViewLayer"]


@oldest_and_newest
def test_an_animation_renders_each_frame_at_its_time(host, tmp_path):
    told = host.run(
        """
scene = empty_scene(size=(4, 4))
scene.frame_start, scene.frame_end = 1, 3
shown = add_mesh()
for frame in (1, 3):
    shown.location.x = frame
    shown.keyframe_insert("location", frame=frame)
scene.stokes.use_record, scene.stokes.record_path = True, os.path.join(TMP, "f##.stokes")
scene.render.filepath = os.path.join(TMP, "frame")
bpy.ops.render.render(animation=True)
tell([blob(stream.read(os.path.join(TMP, "f%02d.stokes" % frame)), "instances", "Quad",
"transforms", "f")[3]
      for frame in (1, 2, 3)])
""",
        tmp_path,
    )
    assert told == pytest.approx([1, 2, 3])


@oldest_and_newest
def test_progress_and_the_time_that_remains_are_told(host, tmp_path):
    """A batch render prints what Blender's status bar shows: the line that the fake core's seconds make, and the samples."""
    done = host.start("empty_scene(samples=20); bpy.ops.render.render(); tell(1)", tmp_path, env={"FAKE_CORE": "slow"})
    assert "TOLD 1" in done.stdout
    if host.version == (3, 4):  # bpy as a module prints nothing
        assert "Remaining 00:01 | fake" in done.stdout, done.stdout
    told = host.run(
        """
from addon.engine import final
class Engine:
    def __init__(self):
        self.said = []
    def update_progress(self, share):
        self.said.append(share)
    def update_stats(self, stats, info):
        self.said.append(info)
engine = Engine()
final._show_progress(engine, {"sample": 3, "samples": 4, "seconds": 9, "remaining": 3723.5, "text": ""})
final._show_progress(engine, {"sample": 4, "samples": 4, "seconds": 9, "remaining": -1, "text": ""})
tell([engine.said])
""",
        tmp_path,
    )[0]
    assert told == [0.75, "Remaining 1:02:03 | Sample 3/4", 0.999, "Sample 4/4"]


@oldest_and_newest
def test_blenders_output_settings_apply(host, tmp_path):
    """Format, view transform and exposure: a PNG is what Blender itself makes of the picture's floats."""
    differences = host.run(
        """
scene = empty_scene(size=(32, 16))
scene.render.image_settings.color_mode = 'RGBA'
told = []
for view, exposure in (('Standard', 0), ('Raw', 0), ('Standard', 1.5)):
    scene.view_settings.view_transform, scene.view_settings.exposure = view, exposure
    scene.render.image_settings.file_format = 'PNG'
    scene.render.filepath = os.path.join(TMP, "shown.png")
    bpy.ops.render.render(write_still=True)
    shown = bpy.data.images.load(os.path.join(TMP, "shown.png"))
    shown.colorspace_settings.is_data = True
    values = list(shown.pixels)
    bpy.data.images.remove(shown)
    worst = 0
    for x in range(32):
        linear = (x + 0.5) / 32 * 2 ** exposure
        curve = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
        worst = max(worst, abs(values[4 * x] - min(1, linear if view == 'Raw' else curve)))
    told.append(worst)
tell([told])
""",
        tmp_path,
    )[0]
    assert max(differences) < 0.01, differences


FAULTS = [
    ["die-at=mesh", "The core ended with status 3: fake core: out of paper"],
    ["kill-at=render", "The core was killed by SIGKILL"],
    ["error-at=mesh", "Quad: index: entry 7 is 9 of 8 vertices"],
    ["", "rendered"],
]


def test_a_failing_core_is_one_error_and_no_file_and_the_next_render_works(host, tmp_path):
    told = host.run(
        """
empty_scene()
add_mesh()
told = []
for fault, _ in json.loads(%r):
    os.environ["FAKE_CORE"] = fault
    try:
        save_exr("never.exr")
        said = "rendered"
    except RuntimeError as error:
        said = str(error)
    told.append([said, os.path.exists(os.path.join(TMP, "never.exr"))])
tell([told])
"""
        % json.dumps(FAULTS),
        tmp_path,
        status=None,
    )[0]
    for (fault, expected), (said, is_written) in zip(FAULTS, told):
        assert expected in said and is_written == (not fault), fault


@oldest_and_newest
def test_a_missing_core_is_one_error(host, tmp_path):
    told = host.run(
        """
empty_scene()
try:
    bpy.ops.render.render()
except RuntimeError as error:
    tell(str(error))
""",
        tmp_path,
        env={"STOKES_CORE": "/nowhere/stokes"},
        status=None,
    )
    assert "$STOKES_CORE names no file: /nowhere/stokes" in told


@oldest_and_newest
def test_a_scene_that_cannot_be_recorded_is_one_error_that_names_the_file(host, tmp_path):
    told = host.run(
        """
scene = empty_scene()
scene.stokes.use_record, scene.stokes.record_path = True, os.path.join(TMP, "missing", "a.stokes")
try:
    save_exr("never.exr")
except RuntimeError as error:
    tell([str(error).strip(), sorted(os.listdir(TMP))])
""",
        tmp_path,
        status=None,
    )
    path = tmp_path / "missing" / "a.stokes"
    assert told[0].endswith("%s: the scene cannot be recorded: No such file or directory" % path)
    assert "never.exr" not in told[1]


@oldest_and_newest
@pytest.mark.parametrize("when", ["at once", "while the core is busy"])
def test_esc_before_the_render_ends_it_without_an_error(host, tmp_path, when):
    """While the scene is sent: at the first look, or while a core that is deep in thought lets the pipe fill up."""
    told = host.run(
        """
import time
from addon.core import shared
from addon.engine import final
shared.available = lambda: False  # all of it through the pipe, which is soon full
scene = empty_scene()
bpy.ops.mesh.primitive_grid_add(x_subdivisions=100, y_subdivisions=100)
for number in range(4):
    add("Copy%d" % number, bpy.context.object.data.copy(), (number, 0, 0))
start = time.time()
class Pressed:  # Blender's own test_break() cannot be replaced
    def test_break(self):
        return time.time() > start + LATER
check = final._check
final._check = lambda engine: check(Pressed())
bpy.ops.render.render()
children = open("/proc/self/task/%d/children" % os.getpid()).read().split()
tell([time.time() - start, children])
""".replace("LATER", "0" if when == "at once" else "1"),
        tmp_path,
        env={"FAKE_CORE": "" if when == "at once" else "hang-at=mesh"},
    )
    assert told[0] < 20 and told[1] == []


@oldest_and_newest
def test_strict_makes_a_warning_an_error(host, tmp_path):
    told = host.run(
        """
empty_scene().camera.data.type = 'PANO'
try:
    bpy.ops.render.render()
except RuntimeError as error:
    tell(str(error))
""",
        tmp_path,
        env={"STOKES_STRICT": "1"},
        status=None,
    )
    assert "Camera: type: a panoramic camera" in told


def test_a_batch_render_that_fails_ends_with_status_1_and_no_file(tmp_path):
    blender = host_named("3.4")
    told = blender.run(
        """
empty_scene()
bpy.ops.wm.save_as_mainfile(filepath=os.path.join(TMP, "scene.blend"))
tell("saved")
""",
        tmp_path,
    )
    assert told == "saved"
    register = tmp_path / "register.py"
    register.write_text(
        "import sys; sys.path.insert(0, %r); import addon; addon.register()" % str(ROOT)
    )
    for fault, status in (("", 0), ("die-at=render", 1)):
        done = subprocess.run(
            [
                blender.command[0],
                "-b",
                str(tmp_path / "scene.blend"),
                "--python",
                str(register),
                "-E",
                "STOKES",
                "-o",
                str(tmp_path / ("out" + str(status))),
                "-F",
                "PNG",
                "-f",
                "1",
            ],
            env=dict(os.environ, STOKES_CORE=str(FAKE_CORE), FAKE_CORE=fault),
            timeout=60,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        assert done.returncode == status, done.stdout
        assert (tmp_path / ("out%d0001.png" % status)).exists() == (status == 0), done.stdout


def test_a_material_preview_is_quick_and_upright(host, tmp_path):
    """Debian's 3.4.1 crashes after any preview with -b, with Cycles too; test_engine_window.py has its own."""
    if host.version == (3, 4):
        pytest.skip("Blender 3.4.1 crashes after any preview with -b")
    told = host.run(
        """
import time
scene = empty_scene()
material = bpy.data.materials.new("Shown")
material.use_nodes = True
os.environ["FAKE_CORE_LOG"] = os.path.join(TMP, "log")
start = time.time()
material.asset_generate_preview()
log = os.path.join(TMP, "log")
while not (os.path.exists(log) and '"render"' in open(log).read()) and time.time() - start < 20:
    time.sleep(0.05)
frames = [json.loads(line) for line in open(os.path.join(TMP, "log"))]
settings = [f["members"] for f in frames if f["name"] == "settings"][-1]
camera = [f["members"] for f in frames if f["name"] == "camera"][-1]
tell([time.time() - start, list(material.preview.image_size), settings["integrator"], settings["lanes"],
camera["resolution"]])
""",
        tmp_path,
    )
    seconds, size, integrator, lanes, resolution = told
    assert size[0] > 0 and seconds < 10 and (integrator, lanes) == ("bdpt", 4)
    assert resolution[0] == resolution[1] <= 256


REGISTER = """
import os, sys, time
import bpy
sys.path.insert(0, os.environ["ROOT"])
start = time.process_time()
import addon
addon.register()
print("TOLD", time.process_time() - start)
"""


def test_registering_takes_no_time_and_starts_nothing(host, tmp_path):
    """From the first import on, compiled before as in any Blender but the first; of the processor's time, since others may be
    at work. The best of a few counts."""
    script = tmp_path / "register.py"
    script.write_text(REGISTER)
    environment = dict(
        os.environ,
        ROOT=str(ROOT),
        STOKES_CORE=str(FAKE_CORE),
        FAKE_CORE_LOG=str(tmp_path / "log"),
        PYTHONPYCACHEPREFIX=str(tmp_path / "compiled"),
    )
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    times = []
    while len(times) < 2 or (len(times) < 6 and min(times) >= 0.05):
        said = subprocess.run(
            [*host.command, str(script)], env=environment, timeout=60, capture_output=True, text=True
        ).stdout
        times.append(float(next(line.split()[1] for line in said.splitlines() if line.startswith("TOLD"))))
    assert not (tmp_path / "log").exists()
    assert_in_time(times, 0.05)


def test_a_process_with_the_engine_registered_exits_clean(host, tmp_path):
    assert host.run("empty_scene(); bpy.ops.render.render(); tell(1)", tmp_path, status=0) == 1


KILLS = """
import random, signal, threading, time
from addon.core import client

class Killer:
    \"\"\"Kills every core that is started, after a random part of `seconds`.\"\"\"
    def __init__(self, seconds, seed):
        self.seconds, self.random, self.timers = seconds, random.Random(seed), []
        self.start, client.Client._start = client.Client._start, lambda *arguments: self.begin(*arguments)

    def begin(self, started, *arguments):
        self.start(started, *arguments)
        timer = threading.Timer(self.random.uniform(0, self.seconds), self.kill, (started.pid,))
        self.timers.append(timer)
        timer.start()

    def kill(self, pid):
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass

    def stop(self):
        client.Client._start = self.start
        for timer in self.timers:
            timer.join()

def outcome(**arguments):
    try:
        bpy.ops.render.render(**arguments)
    except RuntimeError as error:
        return str(error).strip()
    return "rendered"

def kill_and_count(renders, seconds, seed):
    before, outcomes = len(os.listdir("/proc/self/fd")), {}
    killer = Killer(seconds, seed)
    for _ in range(renders):
        said = outcome()
        outcomes[said] = outcomes.get(said, 0) + 1
    killer.stop()
    children = open("/proc/self/task/%d/children" % os.getpid()).read().split()
    return outcomes, len(os.listdir("/proc/self/fd")) - before, children, outcome()
"""
KILLED = "Error: The core was killed by SIGKILL without a word"


def assert_outlived(told, killed):
    """Each render ended well or with one error, nothing is left, and the next one works."""
    outcomes, descriptors, children, last = told
    assert set(outcomes) <= {"rendered", KILLED} and outcomes.get(KILLED, 0) >= killed, outcomes
    assert descriptors == 0 and children == [] and last == "rendered"


@oldest_and_newest
def test_blender_outlives_a_core_killed_at_any_moment(host, tmp_path):
    told = host.run(
        KILLS
        + """
scene = empty_scene(samples=6)
add_mesh()
bpy.ops.render.render()
tell([kill_and_count(30, 0.3, 1)])
""",
        tmp_path,
        env={"FAKE_CORE": "slow"},
        status=None,
    )
    assert_outlived(told[0], 5)


REAL_KILLS = (
    KILLS
    + """
scene = empty_scene(samples=1 << 20, size=(320, 240))
scene.stokes.time_limit = 0.2
scene.world = bpy.data.worlds.new("World")
for number in range(40):
    shown = add_mesh("Mesh%d" % number)
    shown.location, shown.rotation_euler = (number % 7 - 3, number // 7 - 3, 0), (number, 1, 2)
    add_material("Material%d" % number, shown.data)
bpy.ops.render.render()
start = time.time()
bpy.ops.render.render()
tell([kill_and_count(RENDERS, time.time() - start, SEED)])
"""
)


def kill_the_real_core(host, tmp_path, renders, seed, seconds):
    if not CORE.exists():
        pytest.skip("build/stokes is not built")
    code = REAL_KILLS.replace("RENDERS", str(renders)).replace("SEED", str(seed))
    told = host.run(code, tmp_path, env={"STOKES_CORE": str(CORE)}, status=None, seconds=seconds)
    assert_outlived(told[0], renders // 4)


@oldest_and_newest
def test_blender_outlives_the_real_core_killed_at_any_moment(host, tmp_path):
    """Anywhere from its start to its end: while it reads, builds its trees, renders, or leaves."""
    kill_the_real_core(host, tmp_path, 10, 2, 60)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_blender_outlives_a_thousand_kills(host, tmp_path, seed):
    """A thousand over five Blenders."""
    kill_the_real_core(host, tmp_path, 50, 3 + seed, 400)


def test_a_killed_core_leaves_the_part_of_the_picture_that_there_is(host, tmp_path):
    if not CORE.exists():
        pytest.skip("build/stokes is not built")
    told = host.run(
        KILLS
        + """
scene = empty_scene(samples=1 << 20, size=(64, 48))
scene.world = bpy.data.worlds.new("World")
scene.world.color = (0.5, 0.5, 0.5)
seen = client.Client.events
def events(self, timeout=0.0):
    told = seen(self, timeout)
    if any(event.name == "tile" and event.members["samples"] > 0 for event in told):
        os.kill(self.pid, signal.SIGKILL)
    return told
client.Client.events = events
said = outcome()
scene.render.image_settings.file_format = 'OPEN_EXR'
bpy.data.images["Render Result"].save_render(os.path.join(TMP, "kept.exr"))
values = pixels(os.path.join(TMP, "kept.exr"))[2]
tell([said, sum(values[0::4]) / len(values[0::4])])
""",
        tmp_path,
        env={"STOKES_CORE": str(CORE)},
        status=None,
    )
    assert told[0] == KILLED and 0.01 < told[1] < 5
