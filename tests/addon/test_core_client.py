"""The client of `stokes serve`, against a core in Python that can misbehave in every way."""

import gc
import json
import os
import stat
import time
import zlib

import pytest

from addon.core import find, stream
from addon.core.client import Client, CoreError
from clock import assert_in_time
from hosts import FAKE_CORE


@pytest.fixture(autouse=True)
def core(monkeypatch, tmp_path):
    monkeypatch.setenv("STOKES_CORE", str(FAKE_CORE))
    monkeypatch.setenv("FAKE_CORE_LOG", str(tmp_path / "log"))
    return monkeypatch


def frames(tmp_path):
    return [json.loads(line) for line in (tmp_path / "log").read_text().splitlines()]


def collect(client, name, seconds=10):
    """Events up to the first of this name."""
    events, end = [], time.monotonic() + seconds
    while time.monotonic() < end:
        for event in client.events(0.05):
            events.append(event)
            if event.name == name:
                return events
    raise AssertionError("no %s in %s" % (name, events))


def test_a_picture_comes_out_of_the_shared_film():
    with Client(film_bytes=16 * 8 * 4) as client:
        client.send("camera", resolution=[8, 4])
        client.send("render", samples=[0, 2], film=client.film_member)
        finished = collect(client, "finished")[-1]
        pixels = memoryview(client.film).cast("f").tolist()
    assert finished.members == {"samples": 2, "cancelled": False, "report": ["a ramp"]}
    assert pixels[0:2] == [0.0625, 0.125] and pixels[-4:-2] == [0.9375, 0.875]


def test_shared_memory_is_reused_only_after_the_core_has_read_it(tmp_path):
    blobs = [os.urandom(5000 + 1000 * i) for i in range(12)] * 4
    with Client(memory_bytes=1 << 16) as client:  # holds a few of them at a time
        for blob in blobs:
            client.send("image", pixels=stream.Blob(blob), thumbnail=stream.Blob(blob[:7]))
        client.wait_done()
    images = [frame for frame in frames(tmp_path) if frame["name"] == "image"]
    assert [frame["crc"] for frame in images] == [
        [zlib.crc32(blob), zlib.crc32(blob[:7])] for blob in blobs
    ]
    assert all("shared" in frame["members"]["pixels"] for frame in images)
    assert all("at" in frame["members"]["thumbnail"] for frame in images)


def test_a_frame_larger_than_the_memory_travels_in_the_pipe(tmp_path):
    first, second = os.urandom(1 << 16), os.urandom(1 << 21)
    with Client(memory_bytes=1 << 17) as client:
        client.send(
            "image", a=stream.Blob(first), b=stream.Blob(second), c=stream.Blob(second[: 1 << 17])
        )
        client.wait_done()
    frame = frames(tmp_path)[-1]
    assert frame["crc"] == [zlib.crc32(blob) for blob in (first, second, second[: 1 << 17])]


def test_a_flood_of_frames_and_answers_blocks_neither_side():
    with Client() as client:
        for number in range(20000):
            client.send("light", name=str(number))
        client.wait_done()


@pytest.mark.parametrize(
    "fault, said",
    [
        ("die-at=mesh", "The core ended with status 3: fake core: out of paper"),
        ("kill-at=mesh", "The core was killed by SIGKILL without a word"),
        ("error-at=mesh", "Cube: index: entry 7 is 9 of 8 vertices"),
    ],
)
def test_a_core_that_fails_says_why_in_one_line(core, fault, said):
    core.setenv("FAKE_CORE", fault)
    with Client() as client, pytest.raises(CoreError) as caught:
        client.send("mesh", name="Cube")
        client.wait_done()
    assert str(caught.value) == said


def test_a_core_killed_while_frames_are_written_raises(core):
    core.setenv("FAKE_CORE", "kill-at=mesh")
    with Client() as client, pytest.raises(CoreError, match="killed"):
        for number in range(100000):
            client.send("mesh", name=str(number), positions=stream.Blob(bytes(1 << 16)))


def test_what_is_no_core_is_named(core, tmp_path):
    babbler = tmp_path / "babbler"
    babbler.write_text(
        "#!/bin/sh\necho 'Usage: this is another program, it does not speak the stream at all'\n"
    )
    babbler.chmod(0o755)
    core.setenv("STOKES_CORE", str(babbler))
    with pytest.raises(CoreError, match="The core"), Client() as client:
        client.wait_done()


def test_cancel_is_answered_within_100_ms(core):
    core.setenv("FAKE_CORE", "slow")
    with Client(film_bytes=16 * 64) as client:
        client.send("render", samples=[0, 1000], film=client.film_member)
        collect(client, "tile")
        start = time.monotonic()
        client.cancel()
        finished = collect(client, "finished")[-1]
        took = time.monotonic() - start
        assert finished.members["cancelled"]
    assert_in_time([took], 0.1)


def test_clients_leave_no_process_and_no_descriptor(core):
    def held():
        gc.collect()
        return len(os.listdir("/proc/self/fd"))

    before = held()
    for fault in ("", "die-at=mesh", "kill-at=mesh", "hang-at=none"):
        core.setenv("FAKE_CORE", fault)
        for _ in range(3):
            client = Client(film_bytes=64)
            try:
                client.send("mesh", name="m", positions=stream.Blob(bytes(1 << 16)))
                client.wait_done()
            except CoreError:
                pass
            client.close()
            client.close()  # twice does no harm
            with pytest.raises(ProcessLookupError):
                os.kill(client.pid, 0)  # not even a zombie
    assert held() == before


def test_a_forgotten_client_ends_its_core():
    client = Client()
    pid = client.pid
    del client
    gc.collect()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_the_core_is_sought_in_the_documented_order(core, tmp_path):
    def make(*parts):
        path = tmp_path.joinpath(*parts)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("#!/bin/sh\n")
        path.chmod(0o755)
        return str(path)

    core.setattr(find, "ADDON", str(tmp_path / "addon"))
    preference, named = make("elsewhere", "core"), make("named", "core")
    beside, built, in_path = (
        make("addon", "bin", "stokes"),
        make("build", "stokes"),
        make("path", "stokes"),
    )
    core.setenv("STOKES_CORE", named)
    core.setenv("PATH", str(tmp_path / "path"))
    assert find.find_core(preference) == preference
    assert find.find_core() == named
    core.delenv("STOKES_CORE")
    for path in (beside, built, in_path):
        assert find.find_core() == path
        os.remove(path)
    with pytest.raises(find.CoreNotFound, match="missing"):
        find.find_core()
    with pytest.raises(find.CoreNotFound, match="preference names no file: /nowhere"):
        find.find_core("/nowhere")


def test_an_unzipped_core_gets_its_mode_back_at_first_use(core, tmp_path):
    path = tmp_path / "stokes"
    path.write_text("#!/bin/sh\n")
    path.chmod(0o644)
    find.find_core(str(path))
    assert path.stat().st_mode & stat.S_IXUSR
