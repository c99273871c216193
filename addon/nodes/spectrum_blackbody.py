"""Blackbody Spectrum: the glow of something hot."""

import math

import bpy

from . import library
from .base import COLOR_OUT, NodeKind, Socket, unit_property


class StokesSpectrumBlackbodySettings(bpy.types.PropertyGroup):
    unit: unit_property()


class SpectrumBlackbody(NodeKind):
    name = "spectrum_blackbody"
    label = "Blackbody Spectrum"
    tooltip = "Light of a hot body, ultraviolet and all"
    category = 'SPECTRUM'
    inputs = (Socket("Temperature", 'FLOAT', 2856.0, 800.0, 40000.0, "In kelvin"),)
    outputs = (COLOR_OUT,)
    Settings = StokesSpectrumBlackbodySettings

    def build(self, inside, settings):
        blackbody = inside.node("ShaderNodeBlackbody")
        inside.link(inside.given("Temperature"), blackbody.inputs[0])
        inside.result(blackbody.outputs[0])


def curve(kelvin):
    """Planck's law, with a peak of 1 on the grid. hc/k is in nm·K."""
    values = [
        nm**-5.0 / math.expm1(min(700.0, 1.438776877e7 / (nm * kelvin)))
        for nm in library.wavelengths()
    ]
    top = max(values)
    return [value / top for value in values]


KIND = SpectrumBlackbody()
