"""Conductor: a metal by its measured complex index of refraction."""

import bpy
from bpy.props import EnumProperty

from . import library
from .base import BSDF_OUT, NORMAL, NodeKind, Socket, on_change

_LABELS = {
    "Ag": "Silver",
    "Al": "Aluminium",
    "Au": "Gold",
    "Be": "Beryllium",
    "Co": "Cobalt",
    "Cr": "Chromium",
    "Cu": "Copper",
    "Fe": "Iron",
    "Hg": "Mercury",
    "Ir": "Iridium",
    "Li": "Lithium",
    "Mg": "Magnesium",
    "Mo": "Molybdenum",
    "Ni": "Nickel",
    "Nb": "Niobium",
    "Os": "Osmium",
    "Pd": "Palladium",
    "Pt": "Platinum",
    "Rh": "Rhodium",
    "Ta": "Tantalum",
    "Ti": "Titanium",
    "V": "Vanadium",
    "W": "Tungsten",
    "Zn": "Zinc",
    "Zr": "Zirconium",
    "TiN": "Titanium Nitride",
    "brass": "Brass",
}


def metals():
    return [name[len("metal/") : -len("/k")] for name in library.names("metal/", "/k")]


def label_of(metal):
    return _LABELS.get(metal, metal)


class StokesConductorSettings(bpy.types.PropertyGroup):
    metal: EnumProperty(
        name="Metal",
        description="A measured metal",
        items=library.enum_items(
            (name, label_of(name), "%s (%s)" % (label_of(name), name))
            for name in sorted(metals(), key=label_of)
        ),
        default="Ag",
        update=on_change,
    )


class Conductor(NodeKind):
    name = "conductor"
    label = "Conductor"
    tooltip = "A real metal"
    inputs = (Socket("Roughness", 'FACTOR', 0.1, 0.0, 1.0, "0 is a perfect mirror"), NORMAL)
    outputs = (BSDF_OUT,)
    Settings = StokesConductorSettings

    def title(self, settings):
        return label_of(settings.metal)

    def build(self, inside, settings):
        glossy = getattr(bpy.types, "ShaderNodeBsdfGlossy", bpy.types.ShaderNodeBsdfAnisotropic)
        inside.surface(
            glossy.__name__, Color=color_of(settings.metal), Roughness=inside.given("Roughness")
        )


def color_of(metal):
    """RGB of the reflectance at normal incidence."""
    pairs = zip(library.values("metal/%s/eta" % metal), library.values("metal/%s/k" % metal))
    return library.reflected([((n - 1) ** 2 + k * k) / ((n + 1) ** 2 + k * k) for n, k in pairs])


KIND = Conductor()
