"""RGB Spectrum: a colour made into a smooth spectrum (Jakob & Hanika 2019), so that it can go where
spectra go."""

from .base import COLOR_OUT, NodeKind, Socket


class SpectrumRgb(NodeKind):
    name = "spectrum_rgb"
    label = "RGB Spectrum"
    tooltip = "A colour made into a smooth spectrum"
    category = 'SPECTRUM'
    inputs = (Socket("Color", 'COLOR', (0.2, 0.2, 0.2), tooltip="Linear RGB"),)
    outputs = (COLOR_OUT,)

    def build(self, inside, settings):
        inside.result(inside.given("Color"))


KIND = SpectrumRgb()
