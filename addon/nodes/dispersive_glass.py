"""Dispersive Glass: a dielectric whose index of refraction depends on the wavelength."""

import bpy
from bpy.props import EnumProperty, FloatProperty

from . import library
from .base import BSDF_OUT, NORMAL, NodeKind, Socket, on_change

MODELS = (
    ('ABBE', "IOR and Abbe Number", "The index at 587.6 nm and how strongly it varies, as in glass catalogues"),
    ('PRESET', "Preset", "A real glass, crystal or liquid"),
    ('CAUCHY', "Cauchy", "n = A + B/λ² + C/λ⁴, λ in µm"),
    ('SELLMEIER', "Sellmeier", "n² = 1 + Σ Bλ²/(λ² − C), λ in µm"),
)

# Name in the core, label, n_D and Abbe number: for the approximation and the tooltip.
PRESETS = (
    ("BK7", "Crown Glass N-BK7", 1.5168, 64.2),
    ("SF11", "Flint Glass SF11", 1.7847, 25.8),
)


class StokesDispersiveGlassSettings(bpy.types.PropertyGroup):
    model: EnumProperty(
        name="Dispersion", description="How the index of refraction is given", items=MODELS,
        default='ABBE', update=on_change)
    preset: EnumProperty(
        name="Glass", description="A measured material",
        items=library.enum_items(
            (name, label, "n = %.3f, Abbe number %.1f" % (n_d, abbe)) for name, label, n_d, abbe in PRESETS),
        default=PRESETS[0][0], update=on_change)
    cauchy_a: FloatProperty(name="A", default=1.5046, min=1.0, max=5.0, precision=5, update=on_change)
    cauchy_b: FloatProperty(name="B (µm²)", default=0.0042, min=-1.0, max=1.0, precision=5, update=on_change)
    cauchy_c: FloatProperty(name="C (µm⁴)", default=0.0, min=-1.0, max=1.0, precision=6, update=on_change)
    b1: FloatProperty(name="B1", default=1.03961212, min=0.0, max=10.0, precision=6, update=on_change)
    c1: FloatProperty(name="C1 (µm²)", default=0.00600069867, min=0.0, max=1e4, precision=6, update=on_change)
    b2: FloatProperty(name="B2", default=0.231792344, min=0.0, max=10.0, precision=6, update=on_change)
    c2: FloatProperty(name="C2 (µm²)", default=0.0200179144, min=0.0, max=1e4, precision=6, update=on_change)
    b3: FloatProperty(name="B3", default=1.01046945, min=0.0, max=10.0, precision=6, update=on_change)
    c3: FloatProperty(name="C3 (µm²)", default=103.560653, min=0.0, max=1e4, precision=6, update=on_change)


class DispersiveGlass(NodeKind):
    name = "dispersive_glass"
    label = "Dispersive Glass"
    tooltip = "Glass that splits light into its colours"
    width = 200
    inputs = (
        Socket("Color", 'COLOR', (1.0, 1.0, 1.0), tooltip="Tints what is refracted"),
        Socket("Roughness", 'FACTOR', 0.0, 0.0, 1.0, "0 is perfectly smooth"),
        Socket("IOR", 'FLOAT', 1.5168, 1.0, 5.0, "Index of refraction at 587.6 nm, n_D"),
        Socket("Abbe Number", 'FLOAT', 40.0, 5.0, 200.0,
               "Small numbers spread colours strongly: flint glass 25, crown glass 64"),
        NORMAL,
    )
    outputs = (BSDF_OUT,)
    Settings = StokesDispersiveGlassSettings

    def title(self, settings):
        if settings.model != 'PRESET':
            return self.label
        return next(label for name, label, *_ in PRESETS if name == settings.preset)

    def changed(self, node, settings):
        for socket in node.inputs:
            if socket.name in {"IOR", "Abbe Number"}:
                socket.hide = settings.model != 'ABBE'

    def build(self, inside, settings):
        bsdf = inside.node("ShaderNodeBsdfGlass")
        inside.link(inside.given("Color"), inside.socket(bsdf, "Color"))
        inside.link(inside.given("Roughness"), inside.socket(bsdf, "Roughness"))
        if settings.model == 'ABBE':
            inside.link(inside.given("IOR"), inside.socket(bsdf, "IOR"))
        else:
            inside.socket(bsdf, "IOR").default_value = index_at_d(settings)
        inside.result(bsdf.outputs[0])

    def draw(self, layout, settings, node):
        layout.prop(settings, "model")
        column = layout.column(align=True)
        for name in _SHOWN[settings.model]:
            column.prop(settings, name)


_SHOWN = {
    'ABBE': (), 'PRESET': ("preset",), 'CAUCHY': ("cauchy_a", "cauchy_b", "cauchy_c"),
    'SELLMEIER': ("b1", "c1", "b2", "c2", "b3", "c3"),
}


def index_at_d(settings):
    """The index at the sodium-like line d, 587.56 nm."""
    squared = 0.58756 ** 2
    if settings.model == 'PRESET':
        return next(n_d for name, _label, n_d, _abbe in PRESETS if name == settings.preset)
    if settings.model == 'CAUCHY':
        return settings.cauchy_a + settings.cauchy_b / squared + settings.cauchy_c / squared ** 2
    terms = ((settings.b1, settings.c1), (settings.b2, settings.c2), (settings.b3, settings.c3))
    return max(1.0, 1.0 + sum(b * squared / (squared - c) for b, c in terms if squared != c)) ** 0.5


KIND = DispersiveGlass()
