"""Library Spectrum: a measured reflectance, dye, metal or lamp, by drop-down."""

import re

import bpy
from bpy.props import EnumProperty, FloatProperty

from . import library
from .base import COLOR_OUT, NodeKind, on_change, unit_property

CATEGORIES = {
    "colorchecker": ("ColorChecker", "Measured patches of the chart that photographers use"),
    "dye": ("Dyes", "Absorption and emission of fluorescent dyes"),
    "illuminant": ("Illuminants", "Standard lights of the CIE"),
    "lamp": ("Lamps", "Measured lamps"),
}


_FIRST = {
    "colorchecker": "colorchecker/cyan",
    "dye": "dye/fluorescein_basic-ethanol/absorption",
    "illuminant": "illuminant/D65",
    "lamp": "lamp/LED-B4",
}
# CIE 015:2018
_LAMPS = {
    "HP1": "High-Pressure Sodium",
    "HP2": "High-Pressure Sodium, Better Colours",
    "HP3": "Metal Halide, Warm",
    "HP4": "Metal Halide, Neutral",
    "HP5": "Metal Halide, Cool",
    "LED-B1": "White LED 2700 K",
    "LED-B2": "White LED 3000 K",
    "LED-B3": "White LED 4000 K",
    "LED-B4": "White LED 5000 K",
    "LED-B5": "White LED 6600 K",
    "LED-BH1": "White LED with Red",
    "LED-RGB1": "RGB LED",
    "LED-V1": "Violet-Pumped LED 2700 K",
    "LED-V2": "Violet-Pumped LED 4000 K",
}


def entries(category):
    return library.names(category + "/")


def categories():
    found = {name.split("/")[0] for name in library.names()} & set(CATEGORIES)
    return sorted(found, key=list(CATEGORIES).index)


def label_of(name):
    category, entry, *part = name.split("/")
    if category == "dye":
        return "%s: %s" % (library.pretty(entry), *part)
    if category == "colorchecker":
        return re.sub(r"(\d) (\d)", r"\1.\2", entry.replace("_", " ")).title()
    return _LAMPS.get(entry, "Illuminant " + entry)


def _items(category):
    return library.enum_items((name, label_of(name), name) for name in entries(category))


def _entry_property(category):
    return EnumProperty(
        name="Spectrum",
        description=CATEGORIES[category][1],
        items=_items(category),
        default=_FIRST[category],
        update=on_change,
    )


def _settings_class():
    """One drop-down for each category, so that no list is longer than what an eye can search."""
    members = {
        "category": EnumProperty(
            name="Category",
            description="What kind of spectrum",
            items=library.enum_items((name, *CATEGORIES[name]) for name in categories()),
            default=categories()[0],
            update=on_change,
        )
    }
    members.update((name, _entry_property(name)) for name in categories())
    members["absorbance"] = FloatProperty(
        name="Absorbance",
        description="Turns the shape of a dye's absorption into the share of light absorbed, "
        "1 − 10^(−A · shape). 0 keeps the shape as it is",
        default=0.0,
        min=0.0,
        soft_max=3.0,
        max=10.0,
        precision=2,
        step=10,
        update=on_change,
    )
    members["unit"] = unit_property()
    return type(
        "StokesSpectrumLibrarySettings", (bpy.types.PropertyGroup,), {"__annotations__": members}
    )


class SpectrumLibrary(NodeKind):
    name = "spectrum_library"
    label = "Library Spectrum"
    tooltip = "A measured spectrum from the library"
    category = 'SPECTRUM'
    width = 240
    outputs = (COLOR_OUT,)
    Settings = _settings_class()

    def title(self, settings):
        return label_of(chosen(settings))

    def build(self, inside, settings):
        inside.result(inside.rgb(self._color(settings)))

    def _color(self, settings):
        if is_light(settings):
            return library.emitted(curve(settings))
        return library.reflected(curve(settings))

    def draw(self, layout, settings, node):
        layout.prop(settings, "category")
        layout.prop(settings, settings.category)
        if chosen(settings).endswith("/absorption"):
            layout.prop(settings, "absorbance")
        if is_light(settings):
            layout.prop(settings, "unit")


def chosen(settings):
    """The entry's name in the core."""
    return getattr(settings, settings.category)


def is_light(settings):
    return settings.category in {"illuminant", "lamp"} or chosen(settings).endswith("/emission")


def uses_absorbance(settings):
    return settings.absorbance > 0.0 and chosen(settings).endswith("/absorption")


def curve(settings):
    """Values on the library's grid."""
    values = library.values(chosen(settings))
    return library.absorbed(settings.absorbance, values) if uses_absorbance(settings) else values


KIND = SpectrumLibrary()
