"""The stream's writer: what is written reads back, and nothing half-written stays."""

import os
import subprocess
import sys
from array import array

import pytest

from addon.core import stream
from hosts import ROOT


def test_recorded_frames_read_back_as_sent(tmp_path):
    path = tmp_path / "scene.stokes"
    positions, uv = array("f", range(9)), array("f", range(5))
    with stream.Recorder(path) as out:
        out.send(
            "mesh",
            name="Würfel",
            positions=stream.Blob(positions),
            uv=[{"name": "a", "data": stream.Blob(uv)}],
        )
        out.send("render", samples=[0, 4], film={"shared_fd": 3, "bytes": 4})
    hello, mesh, render = stream.read(path)
    assert hello[:2] == ("hello", {"version": 1, "client": stream.CLIENT})
    assert mesh[1]["name"] == "Würfel"
    for blob, sent in ((mesh[1]["positions"], positions), (mesh[1]["uv"][0]["data"], uv)):
        assert blob["at"] % 16 == 0
        assert bytes(mesh[2][blob["at"] : blob["at"] + blob["bytes"]]) == sent.tobytes()
    assert render[1] == {"samples": [0, 4]}, "a live film is no part of a scene file"


def test_every_part_of_a_frame_is_padded_to_16():
    for size in range(40):
        frame = b"".join(
            stream.encode("image", {"pixels": stream.Blob(bytes(size)), "name": "x" * size})
        )
        assert len(frame) % 16 == 0
        assert stream.decode(frame)[3] == len(frame)


def test_a_stream_cut_anywhere_but_between_frames_is_an_error(tmp_path):
    whole, cut = tmp_path / "whole.stokes", tmp_path / "cut.stokes"
    with stream.Recorder(whole) as out:
        out.send("mesh", name="m", positions=stream.Blob(bytes(36)))
    data = whole.read_bytes()
    between = {0, stream.decode(data)[3]}
    for length in range(len(data)):
        cut.write_bytes(data[:length])
        if length in between:
            stream.read(cut)
        else:
            with pytest.raises(stream.StreamError):
                stream.read(cut)


def test_a_failed_recording_leaves_nothing_behind_and_spares_the_old_file(tmp_path):
    path = tmp_path / "scene.stokes"
    path.write_bytes(b"old")
    with pytest.raises(RuntimeError), stream.Recorder(path) as out:
        out.send("world", kind="constant")
        raise RuntimeError
    assert os.listdir(tmp_path) == ["scene.stokes"]
    assert path.read_bytes() == b"old"


def test_a_full_disk_leaves_no_half_recording(tmp_path):
    """Full at the first write, or with the last one, which close() makes: here, a limit for each file."""
    script = (
        "import resource, signal, sys\n"
        "from addon.core import stream\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
        "with stream.Recorder(sys.argv[1]) as out:\n"
        "    out.send('mesh', name='M', positions=stream.Blob(bytes(int(sys.argv[2]))))\n"
    )
    path = tmp_path / "scene.stokes"
    for size in ("1100", "1000000"):
        done = subprocess.run(
            [sys.executable, "-c", script, str(path), size],
            cwd=ROOT, capture_output=True, text=True, timeout=20,
        )
        assert done.returncode == 1 and "OSError: [Errno 27]" in done.stderr, done.stderr
        assert os.listdir(tmp_path) == []


def test_a_recording_replaces_nothing_but_files(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    with pytest.raises(FileExistsError):
        stream.Recorder(path)
    assert path.is_fifo() and os.listdir(tmp_path) == ["pipe"]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), object(), b"bytes outside a Blob"])
def test_what_json_cannot_carry_names_the_message_and_the_object(value):
    with pytest.raises(stream.StreamError, match="light: Lamp"):
        stream.encode("light", {"name": "Lamp", "emission": value})


def test_a_number_that_is_not_finite_is_called_so_also_where_nothing_has_a_name():
    with pytest.raises(stream.StreamError, match="^camera: holds a number that is not finite$"):
        stream.encode("camera", {"transform": [float("nan")]})


def test_a_scene_of_three_lines_needs_no_blender(tmp_path):
    script = (
        "import sys; sys.modules['bpy'] = None\n"  # importing bpy fails
        "from addon.core import stream\n"
        "with stream.Recorder(sys.argv[1]) as out:\n"
        "    out.send('camera', kind='perspective', transform=stream.IDENTITY,\n"
        "             frame=[-1, 1, -1, 1], resolution=[8, 8])\n"
        "    out.send('render', samples=[0, 16])\n"
    )
    path = tmp_path / "three.stokes"
    subprocess.run([sys.executable, "-c", script, str(path)], cwd=ROOT, check=True, timeout=20)
    assert [frame[0] for frame in stream.read(path)] == ["hello", "camera", "render"]
