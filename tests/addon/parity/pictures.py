"""The pictures that parity scenes look at, made by arithmetic and read back from files, as an artist's are."""

import math
import os
import tempfile
from array import array

from stage import bpy

FOLDER = tempfile.mkdtemp(prefix="stokes-parity-")


def sky():
    """A linear float map: blue-grey above, grey below, and a sun of 2 × 2 texels with most of the light."""
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
                texel = (150.0, 150.0, 150.0)
            pixels.extend((*texel, 1.0))
    return _written("sky", width, height, pixels, 'OPEN_EXR', "exr", True)


def chart():
    """An 8-bit sRGB picture without any symmetry: 24 × 16, muted colours and a bright corner."""
    width, height = 24, 16
    pixels = array("f")
    for row in range(height):
        for column in range(width):
            checker = 0.75 if (column // 3 + row // 4) % 2 else 0.4
            texel = (checker, checker * (0.8 + 0.2 * row / height), checker * (0.8 + 0.2 * column / width))
            if column > 17 and row > 11:
                texel = (0.95, 0.95, 0.95)
            pixels.extend((*texel, 1.0 if column > 5 else 0.5))
    return _written("chart", width, height, pixels, 'PNG', "png", False)


def mask():
    """Grey data, not a colour: 0.1 to 0.8 from left to right, in steps."""
    width, height = 16, 16
    pixels = array("f")
    for _ in range(height):
        for column in range(width):
            level = 0.1 + 0.7 * (column // 2) / 7
            pixels.extend((level, level, level, 1.0))
    picture = _written("mask", width, height, pixels, 'PNG', "png", False)
    picture.colorspace_settings.name = "Non-Color"
    return picture


def _written(name, width, height, pixels, kind, ending, is_float):
    made = bpy.data.images.new(name, width, height, alpha=True, float_buffer=is_float)
    made.pixels.foreach_set(pixels)
    path = os.path.join(FOLDER, "%s.%s" % (name, ending))
    made.filepath_raw, made.file_format = path, kind
    made.save()
    bpy.data.images.remove(made)
    return bpy.data.images.load(path)
