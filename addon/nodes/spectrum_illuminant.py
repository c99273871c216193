"""Illuminant: a standard light of the CIE, or daylight of a colour temperature."""

import bpy
from bpy.props import EnumProperty

from . import library
from .base import COLOR_OUT, NodeKind, on_change, unit_property

ILLUMINANTS = (
    ("D65", "D65", "Noon daylight; the white of screens"),
    ("D50", "D50", "Warm daylight; the white of print"),
    ("D55", "D55", "Mid-morning daylight"),
    ("D75", "D75", "North sky daylight"),
    ("A", "A", "Tungsten lamp, 2856 K"),
    ("C", "C", "Old average daylight"),
    ("E", "E", "Equal energy at every wavelength"),
) + tuple(("F%d" % i, "F%d" % i, "Fluorescent tube") for i in range(1, 13))


class StokesSpectrumIlluminantSettings(bpy.types.PropertyGroup):
    illuminant: EnumProperty(
        name="Illuminant",
        description="Which light",
        items=library.enum_items(ILLUMINANTS),
        default="D65",
        update=on_change,
    )
    unit: unit_property()


class SpectrumIlluminant(NodeKind):
    name = "spectrum_illuminant"
    label = "Illuminant"
    tooltip = "A standard light of the CIE"
    category = 'SPECTRUM'
    outputs = (COLOR_OUT,)
    Settings = StokesSpectrumIlluminantSettings

    def title(self, settings):
        return "Illuminant " + settings.illuminant

    def build(self, inside, settings):
        inside.result(inside.rgb(library.emitted(curve(settings))))


def curve(settings):
    return library.values("illuminant/" + settings.illuminant)


KIND = SpectrumIlluminant()
