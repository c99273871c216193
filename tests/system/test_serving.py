"""Serving, cancelling and killing: what holds while a render goes on, and what is left after it."""

import array
import mmap
import os
import pathlib
import random
import re
import signal
import struct
import subprocess
import time

import exr
import frames
import numpy as np
import pytest
import scenes
from clock import assert_in_time
from process import SECONDS, SLOWER, STOKES, Server, run

START = frames.hello() + frames.color() + frames.settings()
QUICK = 0.1 * SLOWER  # what a cancel may take
TRIES = 5


@pytest.fixture
def server():
    server = Server()
    yield server
    if server.process.poll() is None:
        server.process.kill()
        server.process.wait(SECONDS)
    for stream in (server.process.stdin, server.process.stdout, server.process.stderr):
        stream.close()


LONG = frames.scene(size=256, samples=2)[: -len(frames.render(0, 2))]


def start_long_render(server):
    server.send(LONG + frames.render(0, 1 << 20))
    server.wait("done", of=7)
    server.wait("progress")


def test_every_frame_gets_one_answer_in_order(server):
    bad = frames.mesh("Bad", triangles=[0, 1, 9])
    server.send(
        START
        + frames.mesh()
        + bad
        + frames.frame("hologram", mandatory=False)
        + frames.frame("quit")
    )
    answers = [
        server.wait(name)["of"]
        for name in ("done", "done", "done", "done", "error", "done", "done")
    ]
    assert answers == [0, 1, 2, 3, 4, 5, 6]
    assert server.process.wait(SECONDS) == 0


def test_a_frame_that_fails_changes_nothing(server):
    """The mesh of the first frame is still the one that is rendered."""
    server.send(
        LONG
        + frames.mesh(triangles=[0, 1, 9])
        + frames.settings(max_path=1, d0="x")
        + frames.render(0, 1)
    )
    server.wait("error", object="square", of=8)
    server.wait("error", object="settings", of=9)
    report = "\n".join(server.wait("finished")["report"])
    assert "2 triangles" in report
    server.wait("done", of=10)


def test_cancel_is_quick_and_the_process_stays(server):
    """The best of a few tries counts: other processes may hold the processor for longer."""
    start_long_render(server)
    times = []
    while len(times) < TRIES and min(times, default=QUICK) >= QUICK:
        if times:
            server.send(frames.render(0, 1 << 20))
            server.wait("progress")
        before = time.monotonic()
        server.send(frames.frame("cancel"))
        told = server.wait("finished")
        times.append(time.monotonic() - before)
        assert told["cancelled"] and told["samples"] >= 0
    server.send(frames.render(0, 1))
    told = server.wait("finished")
    assert not told["cancelled"] and told["samples"] == 1
    assert_in_time(times, QUICK)


@pytest.fixture(scope="module")
def heavy(tmp_path_factory):
    """Glass, metal and dyes in 1920 × 1080 by the dearest integrator, and half a million triangles: messages up to `render`."""
    path = tmp_path_factory.mktemp("heavy") / "box.stokes"
    scenes.box(path, resolution=(1920, 1080), integrator="mbdpt", threads=os.cpu_count())
    data = path.read_bytes()
    data = data[: data.rindex(b"STKS")]
    return data + crumbs(500000).replace(b'"square"', b'"crumbs"') + frames.instances("crumbs", "crumbs", ["glass"])


@pytest.mark.parametrize("when", ["first pass", "later"])
def test_cancel_is_quick_in_a_heavy_scene(heavy, when):
    """Within the first pass, which takes seconds, and after it; the picture in shared memory is the one that is kept."""
    size = 16 * 1920 * 1080
    fd, film = memory(size)
    server = Server("--film", fd, fds=(fd,))
    try:
        server.send(heavy)
        times = []
        while len(times) < TRIES and min(times, default=QUICK) >= QUICK:
            if when == "later":
                server.send(frames.settings(integrator="pt", max_path=2))  # a quick first pass; then the film is merged
            server.send(frames.render(0, 1 << 20, film={"shared_fd": fd, "bytes": size}))
            server.wait("tile", **({"samples": 0} if when == "first pass" else {}))
            while when == "later" and server.wait("progress")["sample"] < 1:
                pass
            before = time.monotonic()
            server.send(frames.frame("cancel"))
            told = server.wait("finished")
            times.append(time.monotonic() - before)
            assert told["cancelled"] and (told["samples"] == 0) == (when == "first pass")
        print("cancelled within %.0f ms" % (1e3 * min(times)))
        alphas = array.array("f", film[:])[3::4]
        assert set(alphas) == ({0, 1} if when == "first pass" else {1})
        assert_in_time(times, QUICK)
    finally:
        server.process.kill()
        server.close()
        os.close(fd)


def crumbs(count):
    """A mesh of small triangles at random places, whose tree takes its time."""
    area, chance = frames.Area(), random.Random(1).random
    positions = array.array("f")
    for _ in range(count):
        x, y, z = chance(), chance(), chance()
        positions.extend((x, y, z, x + 0.001, y, z, x, y + 0.001, z))
    members = {"name": "square", "positions": area.raw(positions.tobytes())}
    members["triangles"] = area.raw(array.array("I", range(3 * count)).tobytes())
    return frames.frame("mesh", members, area.data)


def test_cancel_is_quick_while_trees_are_built(server):
    server.send(LONG)
    mesh, times = crumbs(400000), []
    while len(times) < TRIES and min(times, default=QUICK) >= QUICK:
        server.send(mesh)
        server.send(frames.render(0, 1 << 20))
        server.wait("done", of=8 + 3 * len(times))  # the mesh is in; its tree is being built
        time.sleep(0.05)
        before = time.monotonic()
        server.send(frames.frame("cancel"))
        assert server.wait("finished")["cancelled"]
        times.append(time.monotonic() - before)
    server.send(frames.render(0, 1))
    assert server.wait("finished")["samples"] == 1
    assert_in_time(times, QUICK)


def test_cancel_reaches_a_render_that_has_not_begun(server):
    server.send(
        LONG + frames.render(0, 1 << 20) + frames.render(0, 1 << 20) + frames.frame("cancel")
    )
    assert server.wait("finished")["cancelled"]
    assert server.wait("finished")["cancelled"]


@pytest.mark.parametrize("end, status", [("quit", 0), ("stdin", 0), ("broken", 1)])
def test_the_end_of_input_ends_a_render_quickly(end, status):
    times = []
    while len(times) < TRIES and min(times, default=QUICK) >= QUICK:
        server = Server()
        try:
            start_long_render(server)
            before = time.monotonic()
            if end == "stdin":
                server.process.stdin.close()
            else:
                server.send(frames.frame("quit") if end == "quit" else b"X" * 48)
            assert server.process.wait(SECONDS) == status
            times.append(time.monotonic() - before)
        finally:
            server.process.kill()
            server.close()
    assert_in_time(times, QUICK)  # and the process is gone


def test_a_killed_parent_ends_the_core(tmp_path):
    """A sibling of the core still holds the pipe open: only the parent's death can tell."""
    scene = tmp_path / "frames"
    scene.write_bytes(LONG + frames.render(0, 1 << 20))
    script = (
        "import subprocess, sys, time\n"
        "r = subprocess.Popen([%r, 'serve'], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)\n"
        "r.stdin.write(open(%r, 'rb').read()); r.stdin.flush()\n"
        "s = subprocess.Popen(['sleep', '100'], pass_fds=[r.stdin.fileno()])\n"
        "print(r.pid, s.pid, flush=True); time.sleep(100)\n"
    ) % (str(STOKES), str(scene))
    parent = subprocess.Popen(["python3", "-c", script], stdout=subprocess.PIPE)
    core, sibling = map(int, parent.stdout.readline().split())
    try:
        time.sleep(0.5)
        assert is_alive(core)
        parent.kill()
        parent.wait(SECONDS)
        end = time.monotonic() + 3
        while is_alive(core) and time.monotonic() < end:
            time.sleep(0.01)
        assert not is_alive(core)
    finally:
        os.kill(sibling, signal.SIGKILL)
        parent.stdout.close()


def is_alive(pid):
    """A zombie that nobody fetches is not."""
    try:
        state = pathlib.Path("/proc/%d/stat" % pid).read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state not in "ZX"


def test_a_killed_core_leaves_nothing(tmp_path):
    """kill -9 in the midst of a render to a file: no file, no shared memory with a name."""
    scene, shared = tmp_path / "scene.stokes", pathlib.Path("/dev/shm")
    scene.write_bytes(LONG + frames.render(0, 1 << 20))
    before = set(shared.iterdir())
    process = subprocess.Popen([STOKES, "render", scene, "-o", tmp_path / "out.exr", "-q"])
    time.sleep(0.5)
    process.kill()
    process.wait(SECONDS)
    assert [path.name for path in tmp_path.iterdir()] == ["scene.stokes"]
    assert {path.name for path in set(shared.iterdir()) - before if "stokes" in path.name} == set()


def test_interrupt_keeps_whole_passes(tmp_path):
    scene, out = tmp_path / "scene.stokes", tmp_path / "out.exr"
    scene.write_bytes(frames.scene(size=64, samples=1 << 20))
    for seconds in (1, 2, 4, 8):  # on a busy machine it takes longer to begin
        process = subprocess.Popen([STOKES, "render", scene, "-o", out, "-q"])
        time.sleep(seconds)
        process.send_signal(signal.SIGINT)
        assert process.wait(SECONDS) == 130
        found = re.search(rb"samples: 0 to ([1-9]\d*) of", run("info", out).stdout)
        if found:
            break
    samples = int(found[1])
    again = tmp_path / "again.exr"
    assert run("render", scene, "-o", again, "-q", "-s", samples).returncode == 0
    assert again.read_bytes() == out.read_bytes()


def test_interrupt_in_the_first_pass_keeps_the_pixels_that_were_done(tmp_path):
    """They are those of a whole pass, by an integrator that splats nothing; the rest is transparent. Such a file is not merged."""
    scene, out, whole = tmp_path / "scene.stokes", tmp_path / "out.exr", tmp_path / "whole.exr"
    scene.write_bytes(frames.scene(size=1536 if SLOWER == 1 else 768, samples=4))
    for seconds in (0.5, 1, 2, 4):  # on a busy machine it takes longer to begin
        process = subprocess.Popen(
            [STOKES, "render", scene, "-o", out, "-o", tmp_path / "out.png", "-t", "1"], stderr=subprocess.PIPE, text=True)
        time.sleep(seconds)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=SECONDS)[1]
        if process.returncode == 130 and "before the first sample" not in said:
            break
    assert process.returncode == 130 and "cancelled within the first pass" in said, said
    assert (tmp_path / "out.png").stat().st_size > 1000
    assert run("render", scene, "-o", whole, "-q", "-s", 1).returncode == 0
    part, expected = exr.read(out), exr.read(whole)
    done = part.channels["A"] == 1
    assert 0 < done.mean() < 1 and not part.channels["A"][~done].any()
    for channel in "RGB":
        assert (part.channels[channel][done] == expected.channels[channel][done]).all()
        assert not part.channels[channel][~done].any()
    share = float(re.search(r"of which ([\d.e-]+) %", said)[1]) / 100
    assert share == pytest.approx(done.mean(), rel=0.01)
    assert b"samples: 0 to 0" in run("info", out).stdout
    merged = run("merge", out, whole, "-o", tmp_path / "merged.exr")
    assert merged.returncode == 1 and b"part of one pass" in merged.stderr and not (tmp_path / "merged.exr").exists()


def test_a_part_of_light_tracing_is_as_bright_as_the_whole(tmp_path):
    """All of it is splats: those of a share of the light paths count for all of them. A third or so is done, so their sum alone would
    miss the mean by much more than the six standard errors that are allowed."""
    width, whole = 1024 if SLOWER == 1 else 512, tmp_path / "whole.exr"
    size = 16 * width * width
    fd, film = memory(size)
    server = Server("--film", fd, fds=(fd,))
    scene = frames.scene(size=width, samples=1).replace(frames.settings(), frames.settings(integrator="lt", threads=1))
    (tmp_path / "scene.stokes").write_bytes(scene)
    try:
        server.send(scene[: scene.rindex(b"STKS")] + frames.render(0, 1, film={"shared_fd": fd, "bytes": size}))
        while np.frombuffer(film[:], "<f4")[3::4].mean() < 0.3:  # from the top row down
            server.wait("tile", samples=0)
        server.send(frames.frame("cancel"))
        assert server.wait("finished")["cancelled"]
        part = np.frombuffer(film[:], "<f4").reshape(width, width, 4)
    finally:
        server.process.kill()
        server.close()
        os.close(fd)
    assert run("render", tmp_path / "scene.stokes", "-o", whole, "-q", "-s", 1).returncode == 0
    done = part[..., 3] == 1
    found, mean = part[..., 1][done], exr.read(whole).channels["G"][done].mean()
    error = found.std() / len(found) ** 0.5
    share = done.mean()
    assert 0.3 <= share < 0.9 and 6 * error < (1 - share) * mean, (share, error, mean)
    assert abs(found.mean() - mean) < 6 * error


def test_renders_and_edits_one_after_another_take_no_more_memory(server):
    """Pages, descriptors and threads after 20 rounds and more are those of the last of 200; pages within 3 %. (The most of some rounds, for
    ThreadSanitizer gives pages back at times, and takes them again.)"""
    proc = pathlib.Path("/proc/%d" % server.process.pid)
    server.send(LONG)
    pages, others = [], []
    for i in range(200):
        red = {"bsdf": "diffuse", "reflectance": {"rgb": [i / 200, 0.5, 0.2]}}
        kind = ("pt", "lt", "mbdpt", "bdpt")[i % 4]
        edit = frames.mesh() + frames.material(red) + frames.settings(integrator=kind)
        server.send(edit + frames.camera(32, 32) + frames.render(i, i + 1))
        server.wait("finished", samples=1)
        pages.append(int((proc / "statm").read_text().split()[1]))
        others.append((len(list((proc / "fd").iterdir())), len(list((proc / "task").iterdir()))))
    assert max(pages[160:]) <= 1.03 * max(pages[20:60]), pages
    assert others[199] == others[20]


def test_a_time_limit_keeps_whole_passes(tmp_path):
    scene, out, again = tmp_path / "scene.stokes", tmp_path / "out.exr", tmp_path / "again.exr"
    scene.write_bytes(frames.scene(size=64, samples=1 << 20))
    assert run("render", scene, "-o", out, "-q", "--time-limit", "0.5").returncode == 0
    samples = int(re.search(rb"samples: 0 to (\d+) of", run("info", out).stdout)[1])
    assert 0 < samples < 1 << 20
    assert run("render", scene, "-o", again, "-q", "-s", samples).returncode == 0
    assert again.read_bytes() == out.read_bytes()


def test_a_time_limit_too_short_for_one_pass_gives_one(tmp_path):
    scene, out = tmp_path / "scene.stokes", tmp_path / "out.exr"
    scene.write_bytes(frames.scene(size=64, samples=100))
    assert run("render", scene, "-o", out, "-q", "--time-limit", "0.000001").returncode == 0
    assert b"samples: 0 to 1 of" in run("info", out).stdout


# --- Shared memory -------------------------------------------------------------------------------


def memory(size, flags=os.MFD_ALLOW_SEALING):
    fd = os.memfd_create("test", flags)
    os.ftruncate(fd, size)
    return fd, mmap.mmap(fd, size)


def shared_mesh(fd_map, at):
    """A mesh whose positions lie in the shared memory."""
    data = struct.pack("<12f", *frames.SQUARE)
    fd_map[at : at + len(data)] = data
    area = frames.Area()
    return frames.frame(
        "mesh",
        {
            "name": "square",
            "positions": {"shared": at, "bytes": len(data)},
            "triangles": area.whole(*frames.TRIANGLES),
        },
        area.data,
    )


def test_shared_blobs_and_the_film_go_through_memory():
    fd, shared = memory(1 << 16)
    film_fd, film = memory(16 * 16 * 16)
    server = Server("--memory", fd, "--film", film_fd, fds=(fd, film_fd))
    try:
        server.send(frames.scene(size=16)[: -len(frames.render(0, 2))] + shared_mesh(shared, 4096))
        server.wait("done", of=8)
        with pytest.raises(PermissionError):
            os.ftruncate(fd, 100)  # sealed by the core
        server.send(frames.render(0, 4, film={"shared_fd": film_fd, "bytes": 16 * 16 * 16}))
        server.wait("tile", rect=[0, 0, 16, 16], samples=4)
        server.wait("finished", samples=4, cancelled=False)
        pixels = struct.unpack("<1024f", film[:])
        assert all(
            abs(value) < 100 for value in pixels
        )  # few wavelengths: a colour may lie outside the gamut
        assert sum(pixels[1::4]) > 1 and set(pixels[3::4]) == {1}
        server.send(frames.render(0, 4, film={"shared_fd": film_fd, "bytes": 1 << 20}))
        server.wait("error", object="render", property="film.bytes")
        server.send(frames.render(0, 4, film={"shared_fd": 1, "bytes": 16}))
        server.wait("error", object="render", property="film.shared_fd")
        server.send(frames.render(0, 4, film={"shared_fd": film_fd, "bytes": 64}))
        server.wait("error", object="render", property="film")
        assert server.process.poll() is None
    finally:
        server.process.kill()
        server.close()
        os.close(fd)
        os.close(film_fd)


def test_memory_that_cannot_be_sealed_is_an_error():
    fd, shared = memory(1 << 16, 0)
    server = Server("--memory", fd, fds=(fd,))
    try:
        server.send(START + shared_mesh(shared, 0))
        assert "MFD_ALLOW_SEALING" in server.wait("error")["text"]
    finally:
        server.process.kill()
        server.close()
        os.close(fd)


def test_a_recording_has_the_fingerprint_of_what_was_shared(tmp_path):
    """Blobs count by their contents: other places, same scene."""
    plain = frames.scene()
    area = frames.Area()
    area.whole(*range(40))
    members = {
        "name": "square",
        "triangles": area.whole(*frames.TRIANGLES),
        "positions": area.floats(*frames.SQUARE),
    }
    moved = plain.replace(frames.mesh(), frames.frame("mesh", members, area.data))
    assert moved != plain
    for name, data in (("a", plain), ("b", moved)):
        (tmp_path / (name + ".stokes")).write_bytes(data)
        assert (
            run(
                "render", tmp_path / (name + ".stokes"), "-o", tmp_path / (name + ".exr"), "-q"
            ).returncode
            == 0
        )
    prints = [
        re.search(rb"fingerprint: (\w+)", run("info", tmp_path / (name + ".exr")).stdout)[1]
        for name in "ab"
    ]
    assert prints[0] == prints[1]
