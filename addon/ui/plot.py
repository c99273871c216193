"""Curves of spectra in the sidebar: a small picture drawn in Python, over the colours of the
wavelengths."""

import array

import bpy

from .. import nodes
from ..nodes import (
    fluorescent,
    library,
    spectrum_blackbody,
    spectrum_file,
    spectrum_gaussian,
    spectrum_illuminant,
)
from ..nodes import spectrum_library, spectrum_line

SIZE = 128
SCALE = 9.0

_pictures = None  # bpy.utils.previews collection
_ABSORBED = (0.35, 0.6, 1.0)
_GLOW = (1.0, 0.55, 0.25)
_PLAIN = (1.0, 1.0, 1.0)


def curves(node):
    """[(values on the library's grid, colour)] of a Stokes node; empty if it has none to show."""
    kind, settings = nodes.kind_of(node), nodes.settings_of(node)
    if kind.name == "fluorescent":
        if settings.dye == fluorescent.CUSTOM:
            return []
        absorption = library.values("dye/%s/absorption" % settings.dye)
        return [
            (library.absorbed(settings.absorbance, absorption), _ABSORBED),
            (library.values("dye/%s/emission" % settings.dye), _GLOW),
        ]
    return [(values, _PLAIN) for values in _spectrum(kind.name, settings, node)]


def _spectrum(kind, settings, node):
    given = {socket.name: socket.default_value for socket in node.inputs}
    if kind == "spectrum_library":
        return [spectrum_library.curve(settings)]
    if kind == "spectrum_file":
        return [spectrum_file.curve(settings)]
    if kind == "spectrum_illuminant":
        return [spectrum_illuminant.curve(settings)]
    if kind == "spectrum_blackbody":
        return [spectrum_blackbody.curve(given["Temperature"])]
    if kind == "spectrum_gaussian":
        return [spectrum_gaussian.curve(given["Mean"], given["Sigma"], given["Peak"])]
    if kind == "spectrum_line":
        return [spectrum_line.curve(given["Center"], given["Width"])]
    return []


def draw(layout, node):
    if _pictures is None:
        return
    shown = curves(node)
    if not shown:
        return
    layout.template_icon(_icon(shown), scale=SCALE)
    grid = library.wavelengths()
    row = layout.row()
    row.alignment = 'CENTER'
    row.label(text="%d – %d nm" % (grid[0], grid[-1]))


def _icon(shown):
    """Made once per set of curves; keyed by what it shows."""
    key = str(hash(tuple((color, tuple(values)) for values, color in shown)))
    if key not in _pictures:
        picture = _pictures.new(key)
        picture.image_size = (SIZE, SIZE)
        picture.image_pixels_float = paint(shown)
    return _pictures[key].icon_id


def paint(shown):
    """RGBA floats, bottom row first."""
    pixels = array.array("f", bytes(16 * SIZE * SIZE))
    columns = [_curve_heights(values) for values, _color in shown]
    for x in range(SIZE):
        nm = 300.0 + 530.0 * (x + 0.5) / SIZE
        back = _background(nm)
        for y in range(SIZE):
            at = 4 * (y * SIZE + x)
            color = back if y > 1 else tuple(0.5 + 0.5 * channel for channel in back)
            for heights, (_values, line) in zip(columns, shown):
                color = _over(color, line, _coverage(heights, x, y))
            pixels[at : at + 4] = array.array("f", (*color, 1.0))
    return pixels


def _curve_heights(values):
    """Height of the curve at each pixel edge, 0 … 1 for the largest value of at least 1e-9."""
    top = max(max(values), 1e-9) if max(values) > 1.0 or max(values) < 0.3 else 1.0
    heights = []
    for x in range(SIZE + 1):
        at = (len(values) - 1) * x / SIZE
        low = min(int(at), len(values) - 2)
        value = values[low] + (at - low) * (values[low + 1] - values[low])
        heights.append(max(0.0, value / top) * (SIZE - 6) + 2.0)
    return heights


def _coverage(heights, x, y):
    """How much of a pixel the line covers: it runs through every height between its two edges."""
    low, high = sorted(heights[x : x + 2])
    distance = max(low - (y + 0.5), (y + 0.5) - high, 0.0)
    line = max(0.0, min(1.0, 1.6 - distance))
    return max(line, 0.16 if y < low else 0.0)


def _over(color, line, share):
    return tuple(a + share * (b - a) for a, b in zip(color, line))


def _background(nm):
    """The wavelength's own colour, dark; grey where the eye sees nothing."""
    rgb = library.monochromatic(nm)
    return tuple(0.05 + 0.22 * min(1.0, channel) ** 0.6 for channel in rgb)


def register():
    global _pictures
    if not bpy.app.background:  # nobody looks, and icons need a window
        from bpy.utils import previews

        _pictures = previews.new()


def unregister():
    global _pictures
    if _pictures is not None:
        from bpy.utils import previews

        previews.remove(_pictures)
        _pictures = None
