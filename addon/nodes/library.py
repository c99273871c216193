"""The spectrum library as the interface needs it: names for drop-downs, values for plots and
colours. library.json is made from the core's own library by library_make.py; rendering uses the
core's."""

import json
import os
import zlib

import mathutils

_data = None

# Linear Rec. 709 from XYZ (ITU-R BT.709 primaries, D65).
_REC709 = (
    (3.2404542, -1.5371385, -0.4985314),
    (-0.9692660, 1.8760108, 0.0415560),
    (0.0556434, -0.2040259, 1.0572252),
)


def _library():
    global _data
    if _data is None:
        path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "library.json")
        with open(path, encoding="utf-8") as source:
            _data = json.load(source)
    return _data


def names(prefix="", suffix=""):
    return [
        name for name in _library()["entries"] if name.startswith(prefix) and name.endswith(suffix)
    ]


def values(name):
    """On the grid of `wavelengths`; KeyError if there is no such entry."""
    return _library()["entries"][name]


def wavelengths():
    data = _library()
    return [data["first"] + data["step"] * i for i in range(len(data["d65"]))]


def on_grid(table, hold):
    """A table [(nm, value)] in ascending order, on the grid; outside its ends 0, or the end's
    value."""
    result, at = [], 0
    for nm in wavelengths():
        while at + 2 < len(table) and table[at + 1][0] < nm:
            at += 1
        if not table or (not hold and not table[0][0] <= nm <= table[-1][0]):
            result.append(0.0)
            continue
        (x0, y0), (x1, y1) = table[at], table[min(at + 1, len(table) - 1)]
        share = 0.0 if x1 <= x0 else min(1.0, max(0.0, (nm - x0) / (x1 - x0)))
        result.append(y0 + share * (y1 - y0))
    return result


def absorbed(absorbance, shape):
    """The share of light absorbed by a dye of that absorbance at its peak: 1 − 10^(−A·shape)."""
    return [1.0 - 10.0 ** (-absorbance * value) for value in shape]


def peak(shape):
    """Wavelength of the largest value."""
    return wavelengths()[max(range(len(shape)), key=shape.__getitem__)]


def reflected(reflectance):
    """RGB of a reflectance in daylight."""
    data = _library()
    return _rgb([r * e for r, e in zip(reflectance, data["d65"])], data["d65"])


def share_of_daylight(absorption):
    """The share of daylight's power, over all of the grid, that this absorbs."""
    data = _library()
    return sum(a * e for a, e in zip(absorption, data["d65"])) / sum(data["d65"])


def emitted(shape):
    """RGB of a light of this shape with the power of a white light of RGB 1."""
    data = _library()
    power = sum(shape)
    if power <= 0.0:
        return (0.0, 0.0, 0.0)
    scale = sum(data["d65"]) / power
    return _rgb([scale * value for value in shape], data["d65"])


def monochromatic(nm):
    """Linear Rec. 709 of the colour-matching functions at a wavelength, negative parts cut."""
    data = _library()
    at = (nm - data["first"]) / data["step"]
    if not 0.0 <= at < len(data["d65"]) - 1:
        return (0.0, 0.0, 0.0)
    low, share = int(at), at - int(at)
    xyz = [curve[low] + share * (curve[low + 1] - curve[low]) for curve in data["observer"]]
    return tuple(max(0.0, sum(row[i] * xyz[i] for i in range(3))) for row in _REC709)


def _rgb(light, white):
    """Colour of a light in the scene's working space, Y = 1 for the white. What lies outside the
    gamut is cut."""
    observer = _library()["observer"]
    luminance = sum(y * e for y, e in zip(observer[1], white))
    xyz = [sum(c * e for c, e in zip(curve, light)) / luminance for curve in observer]
    rgb = [max(0.0, sum(row[i] * xyz[i] for i in range(3))) for row in _REC709]
    color = mathutils.Color(rgb)
    if hasattr(color, "from_rec709_linear_to_scene_linear"):
        color = color.from_rec709_linear_to_scene_linear()
    return tuple(max(0.0, channel) for channel in color)


def number(name):
    """A number for an enum item that stays the same when the library grows: files store the
    number."""
    return zlib.crc32(name.encode()) & 0x3FFFFFFF


# Names of dyes whose capitals no rule gives.
_CAPITALS = {
    "atto": "ATTO",
    "bodipy": "BODIPY",
    "bpea": "BPEA",
    "dapi": "DAPI",
    "dcm": "DCM",
    "dna": "DNA",
    "dsred": "DsRed",
    "ecfp": "ECFP",
    "egfp": "EGFP",
    "eyfp": "EYFP",
    "fl": "FL",
    "gfp": "GFP",
    "h2so4": "H₂SO₄",
    "pbs": "PBS",
    "ph13": "pH 13",
    "popop": "POPOP",
    "r": "R",
    "r6g": "R6G",
    "6g": "6G",
    "b": "B",
    "o": "O",
    "y": "Y",
}


def pretty(dye):
    """ "rhodamine-6g_ethanol" → "Rhodamine 6G in ethanol"."""
    name, _, solvent = dye.partition("_")
    title = " ".join(_CAPITALS.get(part, part.capitalize()) for part in name.split("-"))
    medium = " ".join(_CAPITALS.get(part, part) for part in solvent.split("-"))
    return "%s in %s" % (title, medium) if solvent else title


def enum_items(pairs):
    """Items of an EnumProperty from (name, label, tooltip)."""
    return [(name, label, tooltip, 'NONE', number(name)) for name, label, tooltip in pairs]
