"""The pictures that parity scenes look at, made by arithmetic and read back from files, as an artist's are."""

import atexit
import math
import os
import shutil
import struct
import tempfile
from array import array

from stage import bpy

FOLDER = tempfile.mkdtemp(prefix="stokes-parity-")
atexit.register(shutil.rmtree, FOLDER, ignore_errors=True)


def sky(sun=150.0):
    """A linear float map: blue-grey above, grey below, and a sun of 2 × 2 texels, by itself with most of the light."""
    width, height = 64, 32
    pixels = array("f")
    for row in range(height):
        for column in range(width):
            if row < height // 2:
                texel = (0.2, 0.2, 0.2)
            else:
                glow = 0.35 + 0.25 * math.sin(2 * math.pi * column / width)
                texel = (glow, glow, glow * 1.1)
            if 40 <= column < 42 and 24 <= row < 26:
                texel = (sun, sun, sun)
            pixels.extend((*texel, 1.0))
    path = os.path.join(FOLDER, "sky.exr")
    _write_exr(path, width, height, pixels)
    return bpy.data.images.load(path)


def chart(alpha=1.0):
    """An 8-bit sRGB picture without any symmetry: 24 × 16, muted colours, a bright corner, and `alpha` at the left."""
    width, height = 24, 16
    pixels = array("f")
    for row in range(height):
        for column in range(width):
            checker = 0.75 if (column // 3 + row // 4) % 2 else 0.4
            texel = (checker, checker * (0.8 + 0.2 * row / height), checker * (0.8 + 0.2 * column / width))
            if column > 17 and row > 11:
                texel = (0.95, 0.95, 0.95)
            pixels.extend((*texel, 1.0 if column > 5 else alpha))
    return _saved("chart", width, height, pixels)


def mask():
    """Grey data, not a colour: 0.1 to 0.8 from left to right, in steps."""
    width, height = 16, 16
    pixels = array("f")
    for _ in range(height):
        for column in range(width):
            level = 0.1 + 0.7 * (column // 2) / 7
            pixels.extend((level, level, level, 1.0))
    picture = _saved("mask", width, height, pixels)
    picture.colorspace_settings.name = "Non-Color"
    return picture


def bumps():
    """A normal map of slopes in all directions."""
    width, height = 16, 16
    pixels = array("f")
    for row in range(height):
        for column in range(width):
            x = 0.3 * math.sin(2 * math.pi * column / 8)
            y = 0.3 * math.cos(2 * math.pi * row / 8)
            pixels.extend((0.5 + x, 0.5 + y, 0.5 + math.sqrt(0.25 - x * x - y * y), 1.0))
    picture = _saved("bumps", width, height, pixels)
    picture.colorspace_settings.name = "Non-Color"
    return picture


def _saved(name, width, height, pixels):
    made = bpy.data.images.new(name, width, height, alpha=True)
    made.pixels.foreach_set(pixels)
    path = os.path.join(FOLDER, name + ".png")
    made.filepath_raw, made.file_format = path, 'PNG'
    made.save()
    bpy.data.images.remove(made)
    return bpy.data.images.load(path)


def _write_exr(path, width, height, pixels):
    """Uncompressed scanlines of 32-bit floats, RGB. Blender 3.4 would save its own float image after a curve."""
    def attribute(name, kind, data):
        return b"%s\0%s\0%s%s" % (name, kind, struct.pack("<i", len(data)), data)
    channels = b"".join(b"%s\0%s" % (name, struct.pack("<iB3xii", 2, 0, 1, 1)) for name in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    head = struct.pack("<ii", 20000630, 2) + b"".join((
        attribute(b"channels", b"chlist", channels), attribute(b"compression", b"compression", b"\0"),
        attribute(b"dataWindow", b"box2i", window), attribute(b"displayWindow", b"box2i", window),
        attribute(b"lineOrder", b"lineOrder", b"\0"), attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)),
        attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)),
        attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)), b"\0"))
    row_bytes = 12 * width
    start = len(head) + 8 * height
    with open(path, "wb") as out:
        out.write(head)
        out.write(struct.pack("<%dQ" % height, *(start + (8 + row_bytes) * row for row in range(height))))
        for row in range(height):
            texels = pixels[4 * width * (height - 1 - row):4 * width * (height - row)]
            out.write(struct.pack("<ii", row, row_bytes))
            for channel in (2, 1, 0):
                out.write(texels[channel::4].tobytes())
