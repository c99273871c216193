"""What is written, compared: a PNG is the EXR as the display shows it; the film memory holds the
EXR's own floats."""

import mmap
import os
import pathlib
import struct
import zlib

import exr
import frames
import numpy as np
import pytest
from process import Server, run

CONFIG = pathlib.Path("/usr/share/blender/datafiles/colormanagement/config.ocio")
NEEDS_CONFIG = pytest.mark.skipif(not CONFIG.exists(), reason="Blender's config is not here")


def read_png(path):
    """RGBA in [0, 1], [row, column, channel], first row at the bottom."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8 : at + 8 + size]
        assert zlib.crc32(kind + body) == struct.unpack_from(">I", data, at + 8 + size)[0]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack_from(">IIBB", body)
            assert (depth, color) == (8, 6)
        packed += body if kind == b"IDAT" else b""
        at += 12 + size
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 4 * width)
    picture, above = [], np.zeros((width, 4), np.int64)
    for row in rows:
        above = unfilter(row[0], row[1:].reshape(width, 4).astype(np.int64), above)
        picture.append(above)
    return np.array(picture[::-1]) / 255


def unfilter(kind, row, above):
    """One line of a PNG, by the five filters of its specification."""
    out, left, corner = np.zeros_like(row), np.zeros(4, np.int64), np.zeros(4, np.int64)
    for x, value in enumerate(row):
        up = above[x]
        guess = left + up - corner
        far = [abs(guess - left), abs(guess - up), abs(guess - corner)]
        nearest = np.where(
            (far[0] <= far[1]) & (far[0] <= far[2]), left, np.where(far[1] <= far[2], up, corner)
        )
        predicted = (0, left, up, (left + up) // 2, nearest)[kind]
        out[x] = (value + predicted) % 256
        left, corner = out[x], up
    return out


def rendered(folder, **color):
    """(PNG, EXR's RGBA) of a square on a transparent ground, with some exposure."""
    scene = frames.hello() + frames.color(**color) + frames.settings(film_transparent=True)
    scene += frames.camera(24, 16) + frames.mesh() + frames.instances() + frames.light()
    paint = frames.material({"bsdf": "diffuse", "reflectance": {"rgb": [0.7, 0.4, 0.2]}})
    (folder / "scene.stokes").write_bytes(scene + paint + frames.render(0, 64))
    out = [folder / "out.exr", folder / "out.png"]
    result = run("render", folder / "scene.stokes", "-o", out[0], "-o", out[1], "-q")
    assert result.returncode == 0, result.stderr
    picture = exr.read(out[0])
    return read_png(out[1]), np.stack([picture.channels[name] for name in "RGBA"], axis=-1)


def srgb(value):
    value = np.clip(value, 0, 1)
    return np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)


@pytest.mark.parametrize("config", ["", pytest.param(str(CONFIG), marks=NEEDS_CONFIG)])
def test_a_png_is_the_exr_as_the_display_shows_it(tmp_path, config):
    """Straight alpha, the curve applied to the colour itself; within a step of 255, one more for
    the config's own tables."""
    space = {"config": config, "working_space": "Linear", "display": "sRGB", "view": "Standard"}
    png, rgba = rendered(tmp_path, exposure=1, **(space if config else {}))
    alpha = np.clip(rgba[..., 3], 0, 1)
    assert 0 < np.count_nonzero((alpha > 0.05) & (alpha < 0.95))  # there are edges
    color = srgb(2 * rgba[..., :3] / np.where(alpha > 0, alpha, 1)[..., None])
    assert np.abs(png[..., 3] - alpha).max() <= 0.51 / 255
    seen = alpha > 0
    assert np.abs(png[..., :3] - color)[seen].max() <= (1.6 if config else 0.6) / 255


def test_the_film_memory_holds_the_floats_of_the_exr(tmp_path):
    scene = frames.scene(size=16, samples=9)
    (tmp_path / "scene.stokes").write_bytes(scene)
    out = tmp_path / "out.exr"
    assert run("render", tmp_path / "scene.stokes", "-o", out, "-q").returncode == 0
    channels = exr.read(out).channels
    expected = np.stack([channels[name] for name in "RGBA"], axis=-1)
    size = 16 * 16 * 16
    fd = os.memfd_create("film", os.MFD_ALLOW_SEALING)
    os.ftruncate(fd, size)
    server = Server("--film", fd, fds=(fd,))
    try:
        server.send(scene[: -len(frames.render(0, 9))])
        server.send(frames.render(0, 9, film={"shared_fd": fd, "bytes": size}))
        server.wait("finished", samples=9)
        with mmap.mmap(fd, size) as film:
            found = np.frombuffer(film[:], "<f4").reshape(16, 16, 4)
        assert np.array_equal(found, expected)
    finally:
        server.process.kill()
        server.close()
        os.close(fd)
