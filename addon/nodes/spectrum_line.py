"""Line Spectrum: light of almost one wavelength. A laser, a sodium lamp."""

import bpy

from . import library
from .base import COLOR_OUT, NodeKind, Socket, unit_property


class StokesSpectrumLineSettings(bpy.types.PropertyGroup):
    unit: unit_property()


class SpectrumLine(NodeKind):
    name = "spectrum_line"
    label = "Line Spectrum"
    tooltip = "Light of almost one wavelength: a laser, a sodium lamp"
    category = 'SPECTRUM'
    inputs = (
        Socket("Center", 'FLOAT', 589.3, 200.0, 1000.0, "Wavelength, nm"),
        Socket("Width", 'FLOAT', 2.0, 1.0, 300.0, "Full width of the line, nm; at least 1"),
    )
    outputs = (COLOR_OUT,)
    Settings = StokesSpectrumLineSettings

    def build(self, inside, settings):
        color = inside.node("ShaderNodeWavelength")
        inside.link(inside.given("Center"), color.inputs[0])
        inside.result(color.outputs[0])


def curve(center, width):
    """On the coarse grid a narrow line still shows: at least one step wide."""
    half = max(width / 2.0, 2.5)
    return [1.0 if abs(nm - center) <= half else 0.0 for nm in library.wavelengths()]


KIND = SpectrumLine()
