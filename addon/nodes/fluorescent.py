"""Fluorescent BSDF: a diffuse surface that absorbs at some wavelengths and glows at longer ones
(JHD18)."""

import bpy
from bpy.props import EnumProperty, FloatProperty

from . import library
from .base import BSDF_OUT, NORMAL, NodeKind, Socket, on_change

CUSTOM = 'CUSTOM'

YIELD_KINDS = (
    (
        'quantum',
        "Quantum",
        "Yield is the share of absorbed photons that come out again, as data sheets say it",
    ),
    ('energy', "Energy", "Yield is the share of absorbed energy that comes out again"),
)


def dyes():
    """Names of dyes with both spectra, from violet to red glow."""
    entries = set(library.names("dye/"))
    found = [name[len("dye/") : -len("/emission")] for name in library.names("dye/", "/emission")]
    found = [name for name in found if "dye/%s/absorption" % name in entries]
    return sorted(found, key=lambda name: library.peak(library.values("dye/%s/emission" % name)))


def _dye_items():
    def item(name):
        absorbs = library.peak(library.values("dye/%s/absorption" % name))
        glows = library.peak(library.values("dye/%s/emission" % name))
        return (
            name,
            "%s   %d → %d nm" % (library.pretty(name), absorbs, glows),
            "Absorbs most at %d nm, glows most at %d nm" % (absorbs, glows),
        )

    custom = (CUSTOM, "From Sockets", "Absorption and emission are what is linked to the sockets")
    return library.enum_items([custom] + [item(name) for name in dyes()])


class StokesFluorescentSettings(bpy.types.PropertyGroup):
    dye: EnumProperty(
        name="Dye",
        description="A measured dye; or spectra of your own, by the sockets",
        items=_dye_items(),
        default=CUSTOM,
        update=on_change,
    )
    absorbance: FloatProperty(
        name="Absorbance",
        description="How strongly the paint is dyed: the light that gets past the dye "
        "at its peak is 10^(−A). About 1 for a strong paint, 0.1 for a hint of it",
        default=1.0,
        min=0.001,
        soft_max=3.0,
        max=10.0,
        precision=2,
        step=10,
        update=on_change,
    )
    yield_kind: EnumProperty(
        name="Yield Is",
        description="What the socket Yield is a share of",
        items=YIELD_KINDS,
        default='quantum',
        update=on_change,
    )


class Fluorescent(NodeKind):
    name = "fluorescent"
    label = "Fluorescent BSDF"
    tooltip = "Diffuse surface with a fluorescent dye"
    width = 220
    inputs = (
        Socket(
            "Reflectance",
            'COLOR',
            (0.5, 0.5, 0.5),
            tooltip="What the surface reflects without the dye",
        ),
        Socket(
            "Absorption",
            'COLOR',
            (0.7, 0.1, 0.02),
            tooltip="The share of light that the dye takes in, by wavelength",
        ),
        Socket(
            "Emission",
            'COLOR',
            (0.2, 1.0, 0.1),
            tooltip="The spectrum of the glow; only its shape counts",
        ),
        Socket("Concentration", 'FACTOR', 1.0, 0.0, 1.0, "Scales the absorption. May be a texture"),
        Socket("Yield", 'FACTOR', 0.9, 0.0, 1.0, "How much of what is absorbed comes out as glow"),
        NORMAL,
    )
    outputs = (BSDF_OUT,)
    Settings = StokesFluorescentSettings

    def title(self, settings):
        return (
            self.label if settings.dye == CUSTOM else "Fluorescent " + library.pretty(settings.dye)
        )

    def changed(self, node, settings):
        for socket in node.inputs:
            if socket.name in {"Absorption", "Emission"}:
                socket.hide = settings.dye != CUSTOM

    def build(self, inside, settings):
        """Diffuse: R (1 − c a) + c Q · (share of daylight absorbed) · (colour of the glow), at most
        white."""
        absorption, emission, share = self._dye(inside, settings)
        concentration = inside.given("Concentration")
        kept = inside.mix('SUBTRACT', concentration, (1.0, 1.0, 1.0), absorption)
        elastic = inside.mix('MULTIPLY', 1.0, inside.given("Reflectance"), kept)
        gain = inside.math(
            'MULTIPLY', inside.math('MULTIPLY', concentration, inside.given("Yield")), share
        )
        glow = inside.mix('MULTIPLY', 1.0, emission, gain)
        total = inside.mix('DARKEN', 1.0, inside.mix('ADD', 1.0, elastic, glow), (1.0, 1.0, 1.0))
        inside.surface("ShaderNodeBsdfDiffuse", Color=total)

    def _dye(self, inside, settings):
        if settings.dye == CUSTOM:
            absorption = inside.given("Absorption")
            bw = inside.node("ShaderNodeRGBToBW")
            inside.link(absorption, bw.inputs[0])
            return absorption, inside.given("Emission"), bw.outputs[0]
        absorbed = library.absorbed(
            settings.absorbance, library.values("dye/%s/absorption" % settings.dye)
        )
        emission = library.values("dye/%s/emission" % settings.dye)
        return (
            inside.rgb(library.reflected(absorbed)),
            inside.rgb(library.emitted(emission)),
            library.share_of_daylight(absorbed),
        )

    def draw(self, layout, settings, node):
        layout.prop(settings, "dye")
        column = layout.column()
        column.active = settings.dye != CUSTOM
        column.prop(settings, "absorbance")
        layout.prop(settings, "yield_kind")


KIND = Fluorescent()
