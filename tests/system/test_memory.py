"""What valgrind says of the executable: no leak, no read of what was never written, no step beyond a block; whether it
renders, serves, is cancelled or is fed something broken."""

import pathlib
import subprocess

import exr
import frames
import pytest
import scenes
from process import STOKES, Server

SUPPRESSIONS = pathlib.Path(__file__).with_name("instruments.supp")
FAULT = 99  # the status of a process in which valgrind found something
VALGRIND = [
    "valgrind",
    "--quiet",
    "--leak-check=full",
    "--errors-for-leak-kinds=definite,indirect,possible",
    "--error-exitcode=%d" % FAULT,
    "--suppressions=%s" % SUPPRESSIONS,
]


def watched(*arguments):
    return subprocess.run([*VALGRIND, STOKES, *map(str, arguments)], capture_output=True, text=True, timeout=300)


@pytest.mark.parametrize("integrator,lanes", [("mbdpt", 4), ("bdpt", 1), ("bdpt", 8)])
def test_a_render_leaks_nothing_and_reads_only_what_was_written(tmp_path, integrator, lanes):
    scene, out = tmp_path / "box.stokes", tmp_path / "out.exr"
    scenes.box(scene, resolution=(12, 8))
    settings = ("--integrator", integrator, "--lanes", lanes, "-s", 1, "--spectral-bins", "4:400:700", "--threads", 2)
    result = watched("render", scene, "-o", out, "--quiet", *settings)
    assert (result.returncode, result.stderr) == (0, ""), result.stderr
    assert exr.read(out).sums().any()


def test_a_session_of_edits_errors_and_a_cancel_leaks_nothing():
    """Every kind of message, faults in some, a render that is stopped and one that ends."""
    server = Server(before=VALGRIND)
    try:
        whole = frames.scene(frames.image(), frames.world({"rgb": [0.2, 0.3, 0.4]}), size=16, integrator="mbdpt")
        server.send(whole)
        server.wait("finished", samples=2)
        server.send(frames.mesh("Bad", triangles=[0, 1, 9]) + frames.material({"bsdf": "wool"}))
        server.wait("error", object="Bad")
        server.wait("error", object="material")
        server.send(frames.mesh() + frames.settings(integrator="bdpt") + frames.render(0, 1 << 20))
        server.wait("progress")
        server.send(frames.frame("cancel"))
        server.wait("finished", cancelled=True)
        server.send(frames.light(kind="sphere") + frames.render(0, 1))
        server.wait("finished", samples=1)
        server.send(frames.frame("quit"))
        said = server.process.stderr.read()
        assert (server.process.wait(60), said) == (0, b""), said.decode()
    finally:
        server.process.kill()
        server.close()


@pytest.mark.parametrize("broken", ["cut", "index", "settings"])
def test_a_refused_scene_leaks_nothing(tmp_path, broken):
    scene = tmp_path / "scene.stokes"
    scene.write_bytes(
        {
            "cut": frames.scene(frames.image())[:-100],
            "index": frames.scene(frames.mesh("Bad", triangles=[0, 1, 9])),
            "settings": frames.scene(frames.settings(d0="x")),
        }[broken]
    )
    result = watched("render", scene, "-o", tmp_path / "out.exr", "--quiet")
    assert result.returncode == 1 and len(result.stderr.splitlines()) == 1, result.stderr


def test_valgrind_sees_a_leak_of_another_program(tmp_path):
    """The same command line and suppressions, on a program that leaks and reads what it never wrote."""
    source, program = tmp_path / "leak.c", tmp_path / "leak"
    source.write_text(
        "#include <stdlib.h>\n"
        "int main(int count, char **words)\n"
        "{\n"
        "    int *block = malloc(4 * sizeof *block);\n"
        "    int bad = count > 1 && words[1][0] == 'r' ? block[2] > 0 : 0;\n"
        "    if (count == 1)\n"
        "        block = NULL;\n"
        "    free(block);\n"
        "    return bad ? 2 : 0;\n"
        "}\n"
    )
    subprocess.run(["cc", "-g", "-O0", "-o", program, source], check=True, timeout=60)
    for arguments, status in (([], FAULT), (["read"], FAULT), (["well"], 0)):
        assert subprocess.run([*VALGRIND, program, *arguments], capture_output=True, timeout=60).returncode == status
