"""Dispersive Glass: a dielectric whose index of refraction depends on the wavelength."""

import bpy
from bpy.props import EnumProperty, FloatProperty

from . import library
from .base import BSDF_OUT, NORMAL, NodeKind, Socket, on_change

MODELS = (
    (
        'ABBE',
        "IOR and Abbe Number",
        "The index at 589.3 nm and how strongly it varies, as in glass catalogues",
    ),
    ('PRESET', "Preset", "A real glass, crystal or liquid"),
    ('CAUCHY', "Cauchy", "n = A + B/λ² + C/λ⁴, λ in µm"),
    ('SELLMEIER', "Sellmeier", "n² = 1 + Σ Bλ²/(λ² − C), λ in µm"),
)

# Name in the core (csrc/spectrum/library/glasses.inc), label, n_D and Abbe number computed from it.
PRESETS = (
    ("acrylic", "Acrylic", 1.4905, 53.2),
    ("BAK4", "Barium Crown N-BAK4", 1.5687, 56.0),
    ("BAF10", "Barium Flint N-BAF10", 1.6699, 47.1),
    ("calcite", "Calcite", 1.6583, 49.9),
    ("BK7", "Crown Glass N-BK7", 1.5167, 64.2),
    ("K5", "Crown Glass N-K5", 1.5224, 59.5),
    ("cubic_zirconia", "Cubic Zirconia", 2.1585, 33.5),
    ("SF66", "Dense Flint N-SF66", 1.9225, 20.9),
    ("SF10", "Dense Flint SF10", 1.7280, 28.4),
    ("SF11", "Dense Flint SF11", 1.7845, 25.7),
    ("SF2", "Dense Flint SF2", 1.6475, 33.8),
    ("SF5", "Dense Flint SF5", 1.6725, 32.2),
    ("SF6", "Dense Flint SF6", 1.8049, 25.4),
    ("diamond", "Diamond", 2.4173, 55.3),
    ("F2", "Flint Glass F2", 1.6199, 36.4),
    ("F5", "Flint Glass F5", 1.6033, 38.0),
    ("FK51A", "Fluor Crown N-FK51A", 1.4865, 84.5),
    ("CaF2", "Fluorite", 1.4338, 95.0),
    ("fused_silica", "Fused Silica", 1.4584, 67.8),
    ("LAK9", "Lanthanum Crown N-LAK9", 1.6909, 54.7),
    ("LASF31A", "Lanthanum Flint N-LASF31A", 1.8828, 40.8),
    ("LASF9", "Lanthanum Flint N-LASF9", 1.8500, 32.2),
    ("MgF2", "Magnesium Fluoride", 1.3777, 106.2),
    ("polycarbonate", "Polycarbonate", 1.5846, 27.8),
    ("polystyrene", "Polystyrene", 1.5915, 29.5),
    ("quartz", "Quartz", 1.5442, 69.7),
    ("sapphire", "Sapphire", 1.7681, 72.3),
    ("water", "Water", 1.3333, 55.8),
)


def _cauchy(name, default, low, high, precision):
    return FloatProperty(
        name=name,
        description="%s of n = A + B/λ² + C/λ⁴, λ in µm" % name[0],
        default=default,
        min=low,
        max=high,
        precision=precision,
        update=on_change,
    )


def _strength(number, default):
    return FloatProperty(
        name="B%d" % number,
        description="Strength of the glass' resonance %d: n² = 1 + Σ B λ²/(λ² − C)" % number,
        default=default,
        min=0.0,
        max=10.0,
        precision=6,
        update=on_change,
    )


def _resonance(number, default):
    return FloatProperty(
        name="C%d (µm²)" % number,
        description="Square of the wavelength of the glass' resonance %d" % number,
        default=default,
        min=0.0,
        max=1e4,
        precision=6,
        update=on_change,
    )


class StokesDispersiveGlassSettings(bpy.types.PropertyGroup):
    model: EnumProperty(
        name="Dispersion",
        description="How the index of refraction is given",
        items=MODELS,
        default='ABBE',
        update=on_change,
    )
    preset: EnumProperty(
        name="Glass",
        description="A measured material",
        items=library.enum_items(
            (name, label, "n = %.3f, Abbe number %.1f" % (n_d, abbe))
            for name, label, n_d, abbe in PRESETS
        ),
        default="BK7",
        update=on_change,
    )
    cauchy_a: _cauchy("A", 1.5046, 1.0, 5.0, 5)
    cauchy_b: _cauchy("B (µm²)", 0.0042, -1.0, 1.0, 5)
    cauchy_c: _cauchy("C (µm⁴)", 0.0, -1.0, 1.0, 6)
    b1: _strength(1, 1.03961212)
    c1: _resonance(1, 0.00600069867)
    b2: _strength(2, 0.231792344)
    c2: _resonance(2, 0.0200179144)
    b3: _strength(3, 1.01046945)
    c3: _resonance(3, 103.560653)


class DispersiveGlass(NodeKind):
    name = "dispersive_glass"
    label = "Dispersive Glass"
    tooltip = "Glass that splits light into its colours"
    width = 200
    inputs = (
        Socket("Color", 'COLOR', (1.0, 1.0, 1.0), tooltip="Tints what is refracted"),
        Socket("Roughness", 'FACTOR', 0.0, 0.0, 1.0, "0 is perfectly smooth"),
        Socket("IOR", 'FLOAT', 1.5168, 1.0, 5.0, "Index of refraction at 589.3 nm, n_D"),
        Socket(
            "Abbe Number",
            'FLOAT',
            40.0,
            5.0,
            200.0,
            "Small numbers spread colours strongly: flint glass 25, crown glass 64",
        ),
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
        is_abbe = settings.model == 'ABBE'
        inside.surface(
            "ShaderNodeBsdfGlass",
            Color=inside.given("Color"),
            Roughness=inside.given("Roughness"),
            IOR=inside.given("IOR") if is_abbe else index_at_d(settings),
        )

    def draw(self, layout, settings, node):
        layout.prop(settings, "model")
        column = layout.column(align=True)
        for name in _SHOWN[settings.model]:
            column.prop(settings, name)


_SHOWN = {
    'ABBE': (),
    'PRESET': ("preset",),
    'CAUCHY': ("cauchy_a", "cauchy_b", "cauchy_c"),
    'SELLMEIER': ("b1", "c1", "b2", "c2", "b3", "c3"),
}


def index_at_d(settings):
    """The index at the sodium line D."""
    squared = 0.589294**2
    if settings.model == 'PRESET':
        return next(n_d for name, _label, n_d, _abbe in PRESETS if name == settings.preset)
    if settings.model == 'CAUCHY':
        return settings.cauchy_a + settings.cauchy_b / squared + settings.cauchy_c / squared**2
    terms = ((settings.b1, settings.c1), (settings.b2, settings.c2), (settings.b3, settings.c3))
    return max(1.0, 1.0 + sum(b * squared / (squared - c) for b, c in terms if squared != c)) ** 0.5


KIND = DispersiveGlass()
