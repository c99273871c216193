"""Colour and number nodes. Constants are computed as Cycles does; spectra mix wavelength by wavelength; a factor
that varies may be scaled and shifted. Whatever else would be needed is named, and its nearest input used."""

import colorsys
import math

from .registry import evaluates
from .values import (
    Constant, Spectral, Textured, Varying, as_factor, as_number, as_rgb, as_spectrum, is_grey, scaled, scaled_offset,
)


def _nearest(node, values, graph):
    """What stays of an operation on something that is not constant: its first varying input, as it is."""
    graph.warn(node, "works on constants only so far; its input is used as it is")
    return next(value for value in values if not isinstance(value, Constant))


def _are_constant(*values):
    return all(isinstance(value, Constant) for value in values)


# --- Mix ------------------------------------------------------------------------------------------------------

def _overlay(a, b):
    return 2 * a * b if a < 0.5 else 1 - 2 * (1 - a) * (1 - b)


def _soft_light(a, b):
    return (1 - a) * b * a + a * (1 - (1 - b) * (1 - a))


def _dodge(a, b):
    return 0.0 if a == 0 else 1.0 if b >= 1 else min(1.0, a / (1 - b))


def _burn(a, b):
    return 0.0 if b <= 0 else min(1.0, max(0.0, 1 - (1 - a) / b))


# f(a, b) per channel; the node mixes a with it by the factor.
_BLENDS = {
    'MIX': lambda a, b: b, 'ADD': lambda a, b: a + b, 'SUBTRACT': lambda a, b: a - b,
    'MULTIPLY': lambda a, b: a * b, 'DIVIDE': lambda a, b: a / b if b else a,
    'SCREEN': lambda a, b: 1 - (1 - a) * (1 - b), 'DIFFERENCE': lambda a, b: abs(a - b),
    'EXCLUSION': lambda a, b: a + b - 2 * a * b, 'DARKEN': min, 'LIGHTEN': max,
    'OVERLAY': _overlay, 'SOFT_LIGHT': _soft_light, 'LINEAR_LIGHT': lambda a, b: a + 2 * b - 1,
    'DODGE': _dodge, 'BURN': _burn,
}


def _blend_hsv(kind, a, b):
    ha, hb = colorsys.rgb_to_hsv(*a), colorsys.rgb_to_hsv(*b)
    if kind == 'VALUE':
        return colorsys.hsv_to_rgb(ha[0], ha[1], hb[2])
    if kind == 'SATURATION':
        return a if ha[1] == 0 else colorsys.hsv_to_rgb(ha[0], hb[1], ha[2])
    if hb[1] == 0:  # hue of a grey: nothing to take
        return a
    return colorsys.hsv_to_rgb(hb[0], hb[1] if kind == 'COLOR' else ha[1], ha[2])


def blend(kind, factor, a, b):
    """Mix of two RGB colours as in Cycles."""
    if kind in _BLENDS:
        full = tuple(_BLENDS[kind](x, y) for x, y in zip(a, b))
    else:
        full = _blend_hsv(kind, a, b)
    return tuple(x + factor * (y - x) for x, y in zip(a, full))


def _mix(node, graph, kind, factor, a, b):
    """Mix of any two values by a factor that must be constant, or else the mix is cut at the factor's middle."""
    if not isinstance(factor, Constant):
        graph.warn(node, "a factor that varies mixes shaders, not colours, so far; half of each is used")
        factor = Constant(0.5)
    share = min(1.0, max(0.0, as_number(factor.value)))
    if _are_constant(a, b):
        return Constant(blend(kind, share, as_rgb(a.value), as_rgb(b.value)))
    if kind == 'MIX' and share in (0.0, 1.0):
        return b if share else a
    if isinstance(a, Textured) or isinstance(b, Textured):
        return _mix_texture(node, graph, kind, share, a, b)
    spectra = as_spectrum(a), as_spectrum(b)
    if kind not in {'MIX', 'ADD', 'MULTIPLY'} or None in spectra:
        return _nearest(node, (a, b), graph)
    unit = next(value.unit for value in (a, b) if isinstance(value, Spectral))
    return Spectral(_mix_spectra(kind, share, *spectra), unit)


def _mix_spectra(kind, share, a, b):
    if kind == 'MULTIPLY':
        product = {"product": [a, b]}
        return product if share == 1.0 else {"sum": [_times(1.0 - share, a), _times(share, product)]}
    return {"sum": [a if kind == 'ADD' else _times(1.0 - share, a), _times(share, b)]}


def _times(factor, spectrum):
    return spectrum if factor == 1.0 else {"scale": factor, "of": spectrum}


def _mix_texture(node, graph, kind, share, a, b):
    """An image times a grey stays an image; no other mix does."""
    texture, other = (a, b) if isinstance(a, Textured) else (b, a)
    if kind == 'MULTIPLY' and share == 1.0 and isinstance(other, Constant) and is_grey(as_rgb(other.value)):
        return scaled(texture, as_rgb(other.value)[0])
    return _nearest(node, (texture,), graph)


@evaluates("ShaderNodeMixRGB")
def mix_rgb(node, output, graph):
    a, b = graph.value(graph.input(node, "Color1")), graph.value(graph.input(node, "Color2"))
    return _clamped(_mix(node, graph, node.blend_type, graph.value(graph.input(node, "Fac")), a, b), node.use_clamp)


@evaluates("ShaderNodeMix")
def mix(node, output, graph):
    suffix = {'FLOAT': "Float", 'VECTOR': "Vector", 'RGBA': "Color"}.get(node.data_type)
    if suffix is None:
        graph.warn(node, "the data type %s is not supported; 0.5 is used" % node.data_type.lower())
        return Constant(0.5)
    factor_name = "Factor_Float"
    if suffix == "Vector" and node.factor_mode == 'NON_UNIFORM':
        graph.warn(node, "one factor for each axis is not supported; the first is used")
    factor = graph.value(graph.input(node, factor_name))
    a, b = (graph.value(graph.input(node, "%s_%s" % (side, suffix))) for side in "AB")
    if suffix == "Float":
        return _mix_numbers(node, graph, factor, a, b)
    kind = node.blend_type if suffix == "Color" else 'MIX'
    return _clamped(_mix(node, graph, kind, factor, a, b), suffix == "Color" and node.clamp_result)


def _mix_numbers(node, graph, factor, a, b):
    """a + f (b − a), where at most one of the three may vary."""
    if _are_constant(a, b):
        low, high = as_number(a.value), as_number(b.value)
        if isinstance(factor, Constant):
            return Constant(low + as_number(factor.value) * (high - low))
        return _varying(scaled_offset(as_factor(factor), high - low, low))
    if isinstance(factor, Constant):
        share = as_number(factor.value)
        if isinstance(a, Constant):
            return _varying(scaled_offset(as_factor(b), share, (1.0 - share) * as_number(a.value)))
        if isinstance(b, Constant):
            return _varying(scaled_offset(as_factor(a), 1.0 - share, share * as_number(b.value)))
    return _nearest(node, (a, b, factor), graph)


def _varying(factor):
    return Varying(factor) if isinstance(factor, dict) else Constant(factor)


def _clamped(value, is_wanted):
    if not is_wanted or not isinstance(value, Constant):
        return value  # what varies comes from images and spectra, which stay within 0 and 1 as reflectances
    if isinstance(value.value, tuple):
        return Constant(tuple(min(1.0, max(0.0, channel)) for channel in value.value))
    return Constant(min(1.0, max(0.0, value.value)))


# --- Colours --------------------------------------------------------------------------------------------------

def _on_constant_color(function):
    """Wraps f(node, graph, rgb) -> rgb for nodes with an input "Color"."""
    def evaluate(node, output, graph):
        color = graph.value(graph.input(node, "Color"))
        if not isinstance(color, Constant):
            return _nearest(node, (color,), graph)
        return Constant(tuple(function(node, graph, as_rgb(color.value))))
    return evaluate


@evaluates("ShaderNodeGamma")
@_on_constant_color
def gamma(node, graph, rgb):
    power = graph.number(node, "Gamma")
    return (channel ** power if channel > 0 else channel for channel in rgb)


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
    changed = colorsys.hsv_to_rgb((hue + graph.number(node, "Hue") + 0.5) % 1.0,
                                  min(1.0, max(0.0, saturation * graph.number(node, "Saturation"))),
                                  value * graph.number(node, "Value"))
    factor = graph.number(node, "Fac")
    return (max(0.0, old + factor * (new - old)) for old, new in zip(rgb, changed))


@evaluates("ShaderNodeRGBCurve")
@_on_constant_color
def rgb_curves(node, graph, rgb):
    mapping = node.mapping
    mapping.initialize()
    factor = graph.number(node, "Fac")
    combined = mapping.curves[3]
    return (old + factor * (mapping.evaluate(mapping.curves[i], mapping.evaluate(combined, old)) - old)
            for i, old in enumerate(rgb))


@evaluates("ShaderNodeInvert")
def invert(node, output, graph):
    color, factor = graph.value(graph.input(node, "Color")), graph.number(node, "Fac")
    if isinstance(color, Constant):
        return Constant(tuple(old + factor * (1.0 - 2.0 * old) for old in as_rgb(color.value)))
    if isinstance(color, Spectral):  # 1 − s is exact at every wavelength
        return color._replace(spectrum={"sum": [factor, {"scale": 1.0 - 2.0 * factor, "of": color.spectrum}]})
    return _varying(scaled_offset(as_factor(color), 1.0 - 2.0 * factor, factor))


@evaluates("ShaderNodeValToRGB")
def color_ramp(node, output, graph):
    at = graph.value(graph.input(node, "Fac"))
    if not isinstance(at, Constant):
        alpha_only = output.identifier == "Alpha"
        remapped = None if alpha_only else _linear_ramp(node, at)
        if remapped is not None:
            return remapped
        graph.warn(node, "a ramp over something that varies is not supported yet; its middle is used")
        at = Constant(0.5)
    color = node.color_ramp.evaluate(as_number(at.value))
    return Constant(color[3]) if output.identifier == "Alpha" else Constant(tuple(color[:3]))


def _linear_ramp(node, at):
    """A ramp of two greys at 0 and 1 is a scale and an offset."""
    elements = node.color_ramp.elements
    if len(elements) != 2 or node.color_ramp.interpolation != 'LINEAR' or as_factor(at) is None:
        return None
    low, high = elements[0], elements[1]
    if (low.position, high.position) != (0.0, 1.0) or not (is_grey(low.color[:3]) and is_grey(high.color[:3])):
        return None
    return _varying(scaled_offset(as_factor(at), high.color[0] - low.color[0], low.color[0]))


@evaluates("ShaderNodeRGBToBW")
def rgb_to_bw(node, output, graph):
    color = graph.value(graph.input(node, "Color"))
    if isinstance(color, Constant):
        return Constant(as_number(color.value))
    factor = as_factor(color)
    return _varying(factor) if factor is not None else _nearest(node, (color,), graph)


@evaluates("ShaderNodeSeparateRGB", "ShaderNodeSeparateColor", "ShaderNodeSeparateXYZ", "ShaderNodeSeparateHSV")
def separate(node, output, graph):
    color = graph.value(node.inputs[0])
    index = list(node.outputs).index(output)
    mode = _mode(node)
    if isinstance(color, Constant):
        return Constant(_from_rgb(mode, as_rgb(color.value))[index])
    if isinstance(color, Textured) and mode == 'RGB':
        texture = dict(color.texture, channel="rgb"[index])
        return _varying(scaled_offset({"texture": texture}, color.scale, 0.0))
    return _nearest(node, (color,), graph)


@evaluates("ShaderNodeCombineRGB", "ShaderNodeCombineColor", "ShaderNodeCombineXYZ", "ShaderNodeCombineHSV")
def combine(node, output, graph):
    parts = [graph.value(socket) for socket in node.inputs]
    if not _are_constant(*parts):
        return _nearest(node, parts, graph)
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


# --- Numbers --------------------------------------------------------------------------------------------------

def _safe(function):
    """Cycles' rule: what is not defined is 0."""
    def call(*arguments):
        try:
            result = function(*arguments)
        except (ValueError, ZeroDivisionError, OverflowError):
            return 0.0
        return result if isinstance(result, float) and math.isfinite(result) else float(result or 0.0)
    return call


def _sign(x):
    return (x > 0) - (x < 0)


def _smooth_min(a, b, c):
    if c == 0.0:
        return min(a, b)
    h = max(c - abs(a - b), 0.0) / c
    return min(a, b) - h * h * h * c / 6.0


def _wrap(value, high, low):
    return value - (high - low) * math.floor((value - low) / (high - low)) if high != low else low


def _ping_pong(a, b):
    return abs(((a - b) / (b * 2.0) - math.floor((a - b) / (b * 2.0))) * b * 2.0 - b) if b else 0.0


_MATH = {name: _safe(function) for name, function in {
    'ADD': lambda a, b, c: a + b, 'SUBTRACT': lambda a, b, c: a - b, 'MULTIPLY': lambda a, b, c: a * b,
    'DIVIDE': lambda a, b, c: a / b, 'MULTIPLY_ADD': lambda a, b, c: a * b + c,
    'POWER': lambda a, b, c: math.pow(a, b), 'LOGARITHM': lambda a, b, c: math.log(a) / math.log(b),
    'SQRT': lambda a, b, c: math.sqrt(a), 'INVERSE_SQRT': lambda a, b, c: 1.0 / math.sqrt(a),
    'ABSOLUTE': lambda a, b, c: abs(a), 'EXPONENT': lambda a, b, c: math.exp(a),
    'MINIMUM': lambda a, b, c: min(a, b), 'MAXIMUM': lambda a, b, c: max(a, b),
    'LESS_THAN': lambda a, b, c: float(a < b), 'GREATER_THAN': lambda a, b, c: float(a > b),
    'SIGN': lambda a, b, c: float(_sign(a)), 'COMPARE': lambda a, b, c: float(abs(a - b) <= max(c, 1e-5)),
    'SMOOTH_MIN': _smooth_min, 'SMOOTH_MAX': lambda a, b, c: -_smooth_min(-a, -b, c),
    'ROUND': lambda a, b, c: float(math.floor(a + 0.5)), 'FLOOR': lambda a, b, c: float(math.floor(a)),
    'CEIL': lambda a, b, c: float(math.ceil(a)), 'TRUNC': lambda a, b, c: float(math.trunc(a)),
    'FRACT': lambda a, b, c: a - math.floor(a), 'MODULO': lambda a, b, c: math.fmod(a, b),
    'FLOORED_MODULO': lambda a, b, c: a - math.floor(a / b) * b, 'WRAP': _wrap,
    'SNAP': lambda a, b, c: math.floor(a / b) * b, 'PINGPONG': lambda a, b, c: _ping_pong(a, b),
    'SINE': lambda a, b, c: math.sin(a), 'COSINE': lambda a, b, c: math.cos(a), 'TANGENT': lambda a, b, c: math.tan(a),
    'ARCSINE': lambda a, b, c: math.asin(a), 'ARCCOSINE': lambda a, b, c: math.acos(a),
    'ARCTANGENT': lambda a, b, c: math.atan(a), 'ARCTAN2': lambda a, b, c: math.atan2(a, b),
    'SINH': lambda a, b, c: math.sinh(a), 'COSH': lambda a, b, c: math.cosh(a), 'TANH': lambda a, b, c: math.tanh(a),
    'RADIANS': lambda a, b, c: math.radians(a), 'DEGREES': lambda a, b, c: math.degrees(a),
}.items()}


@evaluates("ShaderNodeMath")
def math_node(node, output, graph):
    values = [graph.value(socket) for socket in node.inputs]
    operation = node.operation
    if operation not in _MATH:
        graph.warn(node, "%s is not supported yet; its first input is used" % operation.lower())
        return values[0]
    if _are_constant(*(value for value, socket in zip(values, node.inputs) if socket.enabled)):
        numbers = [as_number(v.value) if isinstance(v, Constant) else 0.0 for v in values] + [0.0] * (3 - len(values))
        return _clamped(Constant(_MATH[operation](*numbers)), node.use_clamp)
    result = _linear(operation, *values[:2])
    return result if result is not None else _nearest(node, values, graph)


def _linear(operation, a, b):
    """Sums with and products by constants, and products, of what varies; None for anything else."""
    first, second = as_factor(a), as_factor(b)
    if first is None or second is None:
        return None
    if operation == 'MULTIPLY' and isinstance(first, dict) and isinstance(second, dict):
        return Varying({"product": [first, second]})
    if isinstance(second, dict):
        if isinstance(first, dict) or operation not in {'ADD', 'SUBTRACT', 'MULTIPLY'}:
            return None
        scale = {'ADD': 1.0, 'SUBTRACT': -1.0, 'MULTIPLY': first}[operation]
        return _varying(scaled_offset(second, scale, 0.0 if operation == 'MULTIPLY' else first))
    forms = {'ADD': (1.0, second), 'SUBTRACT': (1.0, -second), 'MULTIPLY': (second, 0.0),
             'DIVIDE': (1.0 / second if second else 0.0, 0.0)}
    return _varying(scaled_offset(first, *forms[operation])) if operation in forms else None


@evaluates("ShaderNodeClamp")
def clamp(node, output, graph):
    value = graph.value(graph.input(node, "Value"))
    low, high = graph.number(node, "Min"), graph.number(node, "Max")
    if not isinstance(value, Constant):
        return value if (low, high) == (0.0, 1.0) else _nearest(node, (value,), graph)
    if node.clamp_type == 'RANGE' and low > high:
        low, high = high, low
    return Constant(min(high, max(low, as_number(value.value))))


@evaluates("ShaderNodeMapRange")
def map_range(node, output, graph):
    if getattr(node, "data_type", 'FLOAT') != 'FLOAT' or node.interpolation_type != 'LINEAR':
        graph.warn(node, "only the linear map of a number is supported so far; it is used")
    value = graph.value(graph.input(node, "Value"))
    low, high, to_low, to_high = (graph.number(node, name) for name in ("From Min", "From Max", "To Min", "To Max"))
    if low == high:
        return Constant(to_low)
    slope = (to_high - to_low) / (high - low)
    offset = to_low - slope * low
    if not isinstance(value, Constant):
        factor = as_factor(value)
        return _varying(scaled_offset(factor, slope, offset)) if factor is not None else _nearest(node, (value,), graph)
    result = slope * as_number(value.value) + offset
    if node.clamp:
        result = min(max(to_low, to_high), max(min(to_low, to_high), result))
    return Constant(result)


@evaluates("ShaderNodeTexChecker", "ShaderNodeTexBrick")
def two_colors(node, output, graph):
    """Patterns of two colours: their mean is the nearest constant."""
    colors = [graph.value(graph.input(node, name)) for name in ("Color1", "Color2")]
    graph.warn(node, "is not supported yet; the mean of its colours is used")
    if _are_constant(*colors):
        return Constant(tuple(0.5 * (a + b) for a, b in zip(*(as_rgb(color.value) for color in colors))))
    return colors[0]
