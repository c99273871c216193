"""Reads what the core writes: single-part scanline EXR, uncompressed or ZIP, with NumPy. Written from the file format's
description, apart from the core's own reader, so that the two check each other."""

import struct
import zlib

import numpy as np

TYPES = {0: np.dtype("<u4"), 1: np.dtype("<f2"), 2: np.dtype("<f4")}


class Picture:
    """`channels`: name → array [row, column], first row at the bottom. `texts`: the text attributes."""

    def __init__(self, channels, texts, data_window, display_window):
        self.channels, self.texts = channels, texts
        self.data_window, self.display_window = data_window, display_window

    def bins(self):
        """Wavelengths in nm (ascending) and radiance per nm, [bin, row, column] (Fichet et al. 2021)."""
        found = sorted(
            (float(name[3:-2].replace(",", ".")), name) for name in self.channels if name.startswith("S0.")
        )
        return np.array([nm for nm, _ in found]), np.array([self.channels[name] for _, name in found])

    def sums(self):
        """The fixed-point sums, [sum, row, column]."""
        low = sorted(name for name in self.channels if name.startswith("sum") and name.endswith("low"))
        return np.array(
            [
                self.channels[name].astype(np.int64) | self.channels[name[:-3] + "high"].astype(np.int64) << 32
                for name in low
            ]
        )

    def samples(self):
        return tuple(int(number) for number in self.texts["stokesSamples"].split())


def text_at(data, at):
    end = data.index(0, at)
    return data[at:end].decode("utf-8"), end + 1


def read_attributes(data):
    attributes, at = {}, 8
    while data[at]:
        name, at = text_at(data, at)
        kind, at = text_at(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        attributes[name] = (kind, data[at + 4 : at + 4 + size])
        at += 4 + size
    return attributes, at + 1


def read_channels(value):
    channels, at = [], 0
    while value[at]:
        name, at = text_at(value, at)
        channels.append((name, TYPES[struct.unpack_from("<i", value, at)[0]]))
        at += 16
    return channels


def unpack(block, size):
    """ZIP: deflate, then byte differences, then the two halves interleaved."""
    if len(block) == size:
        return block
    delta = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    delta[1:] -= 128
    flat = (np.cumsum(delta) & 255).astype(np.uint8)
    out = np.empty(size, np.uint8)
    half = (size + 1) // 2
    out[0::2], out[1::2] = flat[:half], flat[half:]
    return out.tobytes()


def read(path):
    with open(path, "rb") as file:
        data = file.read()
    assert struct.unpack_from("<II", data) == (20000630, 2), "not a single-part scanline EXR"
    attributes, at = read_attributes(data)
    compression = attributes["compression"][1][0]
    assert compression in (0, 3), "neither uncompressed nor ZIP"
    lines = 16 if compression else 1
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"][1])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels = read_channels(attributes["channels"][1])
    pixels = {name: np.empty((height, width), kind) for name, kind in channels}
    row_bytes = width * sum(kind.itemsize for _, kind in channels)
    for (start,) in struct.iter_unpack("<Q", data[at : at + 8 * -(-height // lines)]):
        y, size = struct.unpack_from("<ii", data, start)
        rows = min(lines, y1 - y + 1)
        block = unpack(data[start + 8 : start + 8 + size], rows * row_bytes)
        place = 0
        for row in range(y - y0, y - y0 + rows):
            for name, kind in channels:
                pixels[name][row] = np.frombuffer(block, kind, width, place)
                place += width * kind.itemsize
    texts = {name: value.decode("utf-8") for name, (kind, value) in attributes.items() if kind == "string"}
    return Picture(
        {name: array[::-1] for name, array in pixels.items()},
        texts,
        (x0, y0, x1, y1),
        struct.unpack("<4i", attributes["displayWindow"][1]),
    )
