"""Constant Spectrum: the same at every wavelength, ultraviolet included."""

import bpy

from .base import COLOR_OUT, NodeKind, Socket, unit_property


class StokesSpectrumConstantSettings(bpy.types.PropertyGroup):
    unit: unit_property()


class SpectrumConstant(NodeKind):
    name = "spectrum_constant"
    label = "Constant Spectrum"
    tooltip = "The same at every wavelength"
    category = 'SPECTRUM'
    inputs = (
        Socket("Value", 'FLOAT', 0.5, 0.0, 1e6, "Grey is the same share of every wavelength"),
    )
    outputs = (COLOR_OUT,)
    Settings = StokesSpectrumConstantSettings

    def build(self, inside, settings):
        inside.result(inside.mix('MULTIPLY', 1.0, (1.0, 1.0, 1.0), inside.given("Value")))


KIND = SpectrumConstant()
