"""Colour nodes: of constants exactly; of spectra and images where the result is still one."""

import colorsys

from .constant import are_constant, nearest, varying
from .graph import decimal
from .registry import evaluates
from .values import (
    Constant,
    Spectral,
    Textured,
    as_factor,
    as_number,
    as_rgb,
    is_grey,
    scaled_offset,
)


def _on_constant_color(function):
    """Wraps f(node, graph, rgb) -> rgb for nodes with an input "Color"."""

    def evaluate(node, output, graph):
        color = graph.plain_value(graph.input(node, "Color"))
        if not isinstance(color, Constant):
            return nearest(node, (color,), graph)
        return Constant(tuple(function(node, graph, as_rgb(color.value))))

    return evaluate


@evaluates("ShaderNodeGamma")
@_on_constant_color
def gamma(node, graph, rgb):
    power = graph.number(node, "Gamma")
    return (channel**power if channel > 0 else channel for channel in rgb)


@evaluates("ShaderNodeBrightContrast")
@_on_constant_color
def bright_contrast(node, graph, rgb):
    contrast = graph.number(node, "Contrast")
    offset = graph.number(node, "Bright") - 0.5 * contrast
    return (max(0.0, (1.0 + contrast) * channel + offset) for channel in rgb)


@evaluates("ShaderNodeHueSaturation")
@_on_constant_color
def hue_saturation(node, graph, rgb):
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb)
    changed = colorsys.hsv_to_rgb(
        (hue + graph.number(node, "Hue") + 0.5) % 1.0,
        min(1.0, max(0.0, saturation * graph.number(node, "Saturation"))),
        value * graph.number(node, "Value"),
    )
    factor = graph.number(node, "Fac")
    return (max(0.0, old + factor * (new - old)) for old, new in zip(rgb, changed))


@evaluates("ShaderNodeRGBCurve")
@_on_constant_color
def rgb_curves(node, graph, rgb):
    mapping = node.mapping
    mapping.initialize()
    factor = graph.number(node, "Fac")
    combined = mapping.curves[3]
    return (
        old + factor * (mapping.evaluate(mapping.curves[i], mapping.evaluate(combined, old)) - old)
        for i, old in enumerate(rgb)
    )


@evaluates("ShaderNodeInvert")
def invert(node, output, graph):
    color, factor = graph.value(graph.input(node, "Color")), graph.number(node, "Fac")
    if isinstance(color, Constant):
        return Constant(tuple(old + factor * (1.0 - 2.0 * old) for old in as_rgb(color.value)))
    if isinstance(color, Spectral):  # 1 − s is exact at every wavelength
        return color._replace(
            spectrum={"sum": [factor, {"scale": 1.0 - 2.0 * factor, "of": color.spectrum}]}
        )
    return varying(scaled_offset(as_factor(color), 1.0 - 2.0 * factor, factor))


@evaluates("ShaderNodeValToRGB")
def color_ramp(node, output, graph):
    at = graph.plain_value(graph.input(node, "Fac"))
    if not isinstance(at, Constant):
        remapped = None if output.identifier == "Alpha" else _linear_ramp(node, graph, at)
        if remapped is not None:
            return remapped
        graph.warn(
            node, "a ramp over something that varies is not supported yet; its middle is used"
        )
        at = Constant(0.5)
    color = node.color_ramp.evaluate(as_number(at.value))
    return Constant(color[3]) if output.identifier == "Alpha" else Constant(tuple(color[:3]))


def _linear_ramp(node, graph, at):
    """A ramp straight from 0 to 1 is a mix of its two colours; of two greys a scale and an
    offset."""
    ramp, factor = node.color_ramp, as_factor(at)
    if factor is None or len(ramp.elements) != 2 or ramp.interpolation != 'LINEAR':
        return None
    low, high = ramp.elements
    if (low.position, high.position) != (0.0, 1.0) or ramp.color_mode != 'RGB':
        return None
    ends = [tuple(decimal(channel) for channel in end.color[:3]) for end in (low, high)]
    mixed = graph.choose(node, factor, lambda: Constant(ends[0]), lambda: Constant(ends[1]))
    if mixed is None and all(is_grey(end) for end in ends):
        return varying(scaled_offset(factor, ends[1][0] - ends[0][0], ends[0][0]))
    return mixed


@evaluates("ShaderNodeRGBToBW")
def rgb_to_bw(node, output, graph):
    color = graph.value(graph.input(node, "Color"))
    if isinstance(color, Constant):
        return Constant(as_number(color.value))
    factor = as_factor(color)
    return varying(factor) if factor is not None else nearest(node, (color,), graph)


@evaluates(
    "ShaderNodeSeparateRGB",
    "ShaderNodeSeparateColor",
    "ShaderNodeSeparateXYZ",
    "ShaderNodeSeparateHSV",
)
def separate(node, output, graph):
    color = graph.value(node.inputs[0])
    index = list(node.outputs).index(output)
    mode = _mode(node)
    if isinstance(color, Constant):
        return Constant(_from_rgb(mode, as_rgb(color.value))[index])
    if isinstance(color, Textured) and mode == 'RGB':
        texture = dict(color.texture, channel="rgb"[index])
        return varying(scaled_offset({"texture": texture}, color.scale, 0.0))
    return nearest(node, (color,), graph)


@evaluates(
    "ShaderNodeCombineRGB", "ShaderNodeCombineColor", "ShaderNodeCombineXYZ", "ShaderNodeCombineHSV"
)
def combine(node, output, graph):
    parts = [graph.value(socket) for socket in node.inputs]
    if not are_constant(*parts):
        return nearest(node, parts, graph)
    return Constant(tuple(_to_rgb(_mode(node), [as_number(part.value) for part in parts])))


def _mode(node):
    if node.bl_idname.endswith("HSV"):
        return 'HSV'
    return getattr(node, "mode", 'RGB')


def _from_rgb(mode, rgb):
    if mode == 'HSV':
        return colorsys.rgb_to_hsv(*rgb)
    if mode == 'HSL':
        hue, lightness, saturation = colorsys.rgb_to_hls(*rgb)
        return hue, saturation, lightness
    return rgb


def _to_rgb(mode, parts):
    if mode == 'HSV':
        return colorsys.hsv_to_rgb(*parts)
    if mode == 'HSL':
        return colorsys.hls_to_rgb(parts[0], parts[2], parts[1])
    return parts


@evaluates("ShaderNodeTexChecker", "ShaderNodeTexBrick")
def two_colors(node, output, graph):
    """Patterns of two colours: their mean is the nearest constant."""
    colors = [graph.value(graph.input(node, name)) for name in ("Color1", "Color2")]
    graph.warn(node, "is not supported yet; the mean of its colours is used")
    if are_constant(*colors):
        return Constant(
            tuple(0.5 * (a + b) for a, b in zip(*(as_rgb(color.value) for color in colors)))
        )
    return colors[0]
