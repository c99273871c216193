"""Lamps by their real spectra: one operator that puts a Spectrum node before the lamp's
Emission."""

import bpy

from .. import nodes

# (label, tooltip, node kind, settings, values of its sockets)
SPECTRA = {
    'RGB': ("RGB", "The lamp's colour, as in Cycles", None, {}, {}),
    'D65': (
        "Daylight D65",
        "Noon daylight, with its ultraviolet",
        "spectrum_illuminant",
        {"illuminant": "D65"},
        {},
    ),
    'A': ("Tungsten", "A light bulb, 2856 K", "spectrum_illuminant", {"illuminant": "A"}, {}),
    'HOT': (
        "Blackbody",
        "Anything that glows with heat",
        "spectrum_blackbody",
        {},
        {"Temperature": 3200.0},
    ),
    'UV365': (
        "Black Light 365 nm",
        "Invisible by itself; makes dyes glow",
        "spectrum_gaussian",
        {},
        {"Mean": 365.0, "Sigma": 5.0},
    ),
    'UV395': (
        "UV LED 395 nm",
        "A cheap ultraviolet lamp with a violet rim",
        "spectrum_gaussian",
        {},
        {"Mean": 395.0, "Sigma": 6.0},
    ),
    'BLUE': (
        "Blue LED 450 nm",
        "Drives green, yellow and orange dyes",
        "spectrum_gaussian",
        {},
        {"Mean": 450.0, "Sigma": 9.0},
    ),
    'SODIUM': (
        "Sodium Lamp",
        "Yellow light of one wavelength",
        "spectrum_line",
        {},
        {"Center": 589.3, "Width": 2.0},
    ),
    'LASER': ("Green Laser", "532 nm", "spectrum_line", {}, {"Center": 532.0, "Width": 1.0}),
}


def set_spectrum(light, name):
    """Gives a lamp one of SPECTRA: its strength and other nodes stay."""
    _label, _tooltip, kind, settings, sockets = SPECTRA[name]
    if not nodes.has_nodes(light):
        light.use_nodes = True
    tree = light.node_tree
    emission = _emission_of(tree)
    color = next(socket for socket in emission.inputs if socket.identifier == "Color")
    for link in list(color.links):
        before = link.from_node
        tree.links.remove(link)
        if nodes.kind_of(before) and not any(output.links for output in before.outputs):
            tree.nodes.remove(before)
    color.default_value = (1.0, 1.0, 1.0, 1.0)
    if kind is None:
        return
    x, y = emission.location
    node = nodes.new(tree, kind, location=(x - 280, y), sockets=sockets, **settings)
    tree.links.new(node.outputs[0], color)
    light.color = (1.0, 1.0, 1.0)


def _emission_of(tree):
    """The Emission node before the lamp's output; made if there is none."""
    output = tree.get_output_node('CYCLES') or tree.nodes.new("ShaderNodeOutputLight")
    surface = output.inputs[0]
    if surface.links and surface.links[0].from_node.bl_idname == "ShaderNodeEmission":
        return surface.links[0].from_node
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.location = (output.location.x - 220, output.location.y)
    tree.links.new(emission.outputs[0], surface)
    return emission


class STOKES_OT_light_spectrum(bpy.types.Operator):
    """Give the lamp the spectrum of a real light"""

    bl_idname = "stokes.light_spectrum"
    bl_label = "Set Spectrum"
    bl_options = {'REGISTER', 'UNDO'}

    spectrum: bpy.props.EnumProperty(
        name="Spectrum", items=[(name, entry[0], entry[1]) for name, entry in SPECTRA.items()]
    )

    @classmethod
    def poll(cls, context):
        return _light_of(context) is not None

    def execute(self, context):
        set_spectrum(_light_of(context), self.spectrum)
        return {'FINISHED'}


def _light_of(context):
    light = getattr(context, "light", None)
    if light is None and context.object is not None and context.object.type == 'LIGHT':
        light = context.object.data
    return light


CLASSES = (STOKES_OT_light_spectrum,)
