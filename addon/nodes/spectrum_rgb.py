"""RGB Spectrum: a colour made into a smooth spectrum, so that it can go where spectra go."""

import bpy
from bpy.props import EnumProperty

from .base import COLOR_OUT, NodeKind, Socket, on_change

METHODS = (
    (
        'sigmoid',
        "Sigmoid",
        "A smooth curve of three coefficients (Jakob & Hanika 2019). Takes images, too",
    ),
    (
        'moments',
        "Moments",
        "The bounded signal of three trigonometric moments (Peters et al. 2019): flat toward the "
        "ends of the visible range. For one colour, not for images",
    ),
)


class StokesSpectrumRgbSettings(bpy.types.PropertyGroup):
    method: EnumProperty(
        name="Method",
        description="How the colour becomes a reflectance",
        items=METHODS,
        default='sigmoid',
        update=on_change,
    )


class SpectrumRgb(NodeKind):
    name = "spectrum_rgb"
    label = "RGB Spectrum"
    tooltip = "A colour made into a smooth spectrum"
    category = 'SPECTRUM'
    inputs = (Socket("Color", 'COLOR', (0.2, 0.2, 0.2), tooltip="Linear RGB"),)
    outputs = (COLOR_OUT,)
    Settings = StokesSpectrumRgbSettings

    def build(self, inside, settings):
        inside.result(inside.given("Color"))


KIND = SpectrumRgb()
