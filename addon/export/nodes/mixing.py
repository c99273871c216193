"""Mix nodes. Spectra mix wavelength by wavelength, numbers by a factor that varies; colours by
constant factors."""

import colorsys

from .constant import are_constant, clamped, nearest, varying
from .registry import evaluates
from .values import (
    Constant,
    Spectral,
    Textured,
    as_factor,
    as_number,
    as_rgb,
    as_spectrum,
    is_grey,
    scaled,
    scaled_offset,
)


def _overlay(a, b):
    return 2 * a * b if a < 0.5 else 1 - 2 * (1 - a) * (1 - b)


def _soft_light(a, b):
    return (1 - a) * b * a + a * (1 - (1 - b) * (1 - a))


def _dodge(a, b, factor):
    rest = 1 - factor * b
    return 0.0 if a == 0 else 1.0 if rest <= 0 else min(1.0, a / rest)


def _burn(a, b, factor):
    rest = 1 - factor + factor * b
    return 0.0 if rest <= 0 else min(1.0, max(0.0, 1 - (1 - a) / rest))


# f(a, b) per channel; the node mixes a with it by the factor.
_BLENDS = {
    'MIX': lambda a, b: b,
    'ADD': lambda a, b: a + b,
    'SUBTRACT': lambda a, b: a - b,
    'MULTIPLY': lambda a, b: a * b,
    'DIVIDE': lambda a, b: a / b if b else a,
    'SCREEN': lambda a, b: 1 - (1 - a) * (1 - b),
    'DIFFERENCE': lambda a, b: abs(a - b),
    'EXCLUSION': lambda a, b: a + b - 2 * a * b,
    'DARKEN': min,
    'LIGHTEN': max,
    'OVERLAY': _overlay,
    'SOFT_LIGHT': _soft_light,
    'LINEAR_LIGHT': lambda a, b: a + 2 * b - 1,
}

_SCALED_BLENDS = {'DODGE': _dodge, 'BURN': _burn}  # the factor is inside these


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
    if kind in _SCALED_BLENDS:
        return tuple(_SCALED_BLENDS[kind](x, y, factor) for x, y in zip(a, b))
    if kind in _BLENDS:
        full = tuple(_BLENDS[kind](x, y) for x, y in zip(a, b))
    else:
        full = _blend_hsv(kind, a, b)
    return tuple(x + factor * (y - x) for x, y in zip(a, full))


def _mix(node, graph, kind, factor, a, b):
    """Mix of any two values. By a factor that varies, and of images, the closure is mixed
    instead."""
    if kind not in _SCALED_BLENDS and not isinstance(factor, Constant):
        mixed = graph.choose(
            node, as_factor(factor), lambda: a, lambda: _mix(node, graph, kind, Constant(1.0), a, b)
        )
        if mixed is not None:
            return mixed
    if not isinstance(factor, Constant):
        graph.warn(node, "its factor cannot vary here; half of each is used")
        factor = Constant(0.5)
    share = min(1.0, max(0.0, as_number(factor.value)))
    if are_constant(a, b):
        return Constant(blend(kind, share, as_rgb(a.value), as_rgb(b.value)))
    if kind == 'MIX' and share in (0.0, 1.0):
        return b if share else a
    if isinstance(a, Textured) or isinstance(b, Textured):
        mixed = graph.choose(node, share, lambda: a, lambda: b) if kind == 'MIX' else None
        return mixed or _mix_texture(node, graph, kind, share, a, b)
    spectra = as_spectrum(a), as_spectrum(b)
    if kind not in {'MIX', 'ADD', 'MULTIPLY'} or None in spectra:
        return nearest(node, (a, b), graph)
    unit = next(value.unit for value in (a, b) if isinstance(value, Spectral))
    return Spectral(_mix_spectra(kind, share, *spectra), unit)


def _mix_spectra(kind, share, a, b):
    if kind == 'MULTIPLY':
        product = {"product": [a, b]}
        return (
            product if share == 1.0 else {"sum": [_times(1.0 - share, a), _times(share, product)]}
        )
    return {"sum": [a if kind == 'ADD' else _times(1.0 - share, a), _times(share, b)]}


def _times(factor, spectrum):
    return spectrum if factor == 1.0 else {"scale": factor, "of": spectrum}


def _mix_texture(node, graph, kind, share, a, b):
    """An image times a grey stays an image; no other mix does."""
    texture, other = (a, b) if isinstance(a, Textured) else (b, a)
    if (
        kind == 'MULTIPLY'
        and share == 1.0
        and isinstance(other, Constant)
        and is_grey(as_rgb(other.value))
    ):
        return scaled(texture, as_rgb(other.value)[0])
    return nearest(node, (texture,), graph)


@evaluates("ShaderNodeMixRGB")
def mix_rgb(node, output, graph):
    a, b = graph.value(graph.input(node, "Color1")), graph.value(graph.input(node, "Color2"))
    return clamped(
        _mix(node, graph, node.blend_type, graph.plain_value(graph.input(node, "Fac")), a, b),
        node.use_clamp,
    )


@evaluates("ShaderNodeMix")
def mix(node, output, graph):
    suffix = {'FLOAT': "Float", 'VECTOR': "Vector", 'RGBA': "Color"}.get(node.data_type)
    if suffix is None:
        graph.warn(node, "the data type %s is not supported; 0.5 is used" % node.data_type.lower())
        return Constant(0.5)
    factor_name = "Factor_Float"
    if suffix == "Vector" and node.factor_mode == 'NON_UNIFORM':
        graph.warn(node, "one factor for each axis is not supported; the first is used")
    factor = graph.plain_value(graph.input(node, factor_name))
    a, b = (graph.value(graph.input(node, "%s_%s" % (side, suffix))) for side in "AB")
    if suffix == "Float":
        return _mix_numbers(node, graph, factor, a, b)
    kind = node.blend_type if suffix == "Color" else 'MIX'
    return clamped(_mix(node, graph, kind, factor, a, b), suffix == "Color" and node.clamp_result)


def _mix_numbers(node, graph, factor, a, b):
    """a + f (b − a), where at most one of the three may vary."""
    if are_constant(a, b):
        low, high = as_number(a.value), as_number(b.value)
        if isinstance(factor, Constant):
            return Constant(low + as_number(factor.value) * (high - low))
        return varying(scaled_offset(as_factor(factor), high - low, low))
    if isinstance(factor, Constant):
        share = as_number(factor.value)
        if isinstance(a, Constant):
            return varying(scaled_offset(as_factor(b), share, (1.0 - share) * as_number(a.value)))
        if isinstance(b, Constant):
            return varying(scaled_offset(as_factor(a), 1.0 - share, share * as_number(b.value)))
    return nearest(node, (a, b, factor), graph)
