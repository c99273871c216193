"""Gaussian Spectrum: a bell around a wavelength. An LED, a filter, a made-up dye."""

import math

import bpy

from . import library
from .base import COLOR_OUT, NodeKind, Socket, unit_property


class StokesSpectrumGaussianSettings(bpy.types.PropertyGroup):
    unit: unit_property()


class SpectrumGaussian(NodeKind):
    name = "spectrum_gaussian"
    label = "Gaussian Spectrum"
    tooltip = "A bell around a wavelength: an LED, a filter, a made-up dye"
    category = 'SPECTRUM'
    inputs = (
        Socket("Mean", 'FLOAT', 550.0, 200.0, 1000.0, "Wavelength of the peak, nm"),
        Socket(
            "Sigma", 'FLOAT', 20.0, 1.0, 300.0, "Standard deviation, nm. An LED has about 8 to 15"
        ),
        Socket(
            "Peak",
            'FLOAT',
            1.0,
            0.0,
            1e6,
            "Value at the peak. A light of given power does not look at it",
        ),
    )
    outputs = (COLOR_OUT,)
    Settings = StokesSpectrumGaussianSettings

    def build(self, inside, settings):
        color = inside.node("ShaderNodeWavelength")
        inside.link(inside.given("Mean"), color.inputs[0])
        inside.result(inside.mix('MULTIPLY', 1.0, color.outputs[0], inside.given("Peak")))


def curve(mean, sigma, peak):
    return [peak * math.exp(-0.5 * ((nm - mean) / sigma) ** 2) for nm in library.wavelengths()]


KIND = SpectrumGaussian()
