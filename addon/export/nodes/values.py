"""What a socket may carry on its way to a closure: a constant, a spectrum, a texture, or a factor
that varies. They turn into the S, V and L of csrc/stream/STREAM.md in graph.py."""

from collections import namedtuple

Constant = namedtuple("Constant", "value")  # a float, or a tuple of three
Spectral = namedtuple("Spectral", "spectrum unit")  # S; unit "total" or "per_nm" if it shines
Textured = namedtuple("Textured", "texture scale")  # T of a colour, times a number
Varying = namedtuple("Varying", "factor")  # V
Environment = namedtuple("Environment", "image transform scale")  # a map of all directions

# Rec. 709; Cycles' own conversion from colour to number in its default working space.
_LUMINANCE = (0.2126729, 0.7151522, 0.0721750)


def as_number(value):
    return luminance(value) if isinstance(value, tuple) else value


def as_rgb(value):
    return value if isinstance(value, tuple) else (value, value, value)


def luminance(rgb):
    return sum(weight * channel for weight, channel in zip(_LUMINANCE, rgb))


def is_grey(rgb):
    return max(rgb) - min(rgb) < 1e-6


def rgb_spectrum(value):
    return {"rgb": list(as_rgb(value))}


def scaled(value, factor):
    """`factor` times a value of any kind."""
    if isinstance(value, Constant):
        if isinstance(value.value, tuple):
            return Constant(tuple(factor * channel for channel in value.value))
        return Constant(factor * value.value)
    if isinstance(value, Spectral):
        return (
            value
            if factor == 1
            else value._replace(spectrum={"scale": factor, "of": value.spectrum})
        )
    if isinstance(value, Varying):
        return Varying(scaled_offset(value.factor, factor, 0.0))
    return value._replace(scale=value.scale * factor)


def scaled_offset(factor, scale, offset):
    """scale · V + offset, kept flat."""
    if isinstance(factor, (int, float)):
        return scale * factor + offset
    if scale == 1 and offset == 0:
        return factor
    if "of" in factor:
        inner_scale, inner_offset = factor.get("scale", 1.0), factor.get("offset", 0.0)
        return {
            "scale": scale * inner_scale,
            "offset": scale * inner_offset + offset,
            "of": factor["of"],
        }
    return {"scale": scale, "offset": offset, "of": factor}


def as_factor(value):
    """V of a value that can be one, or None (a spectrum, a map of directions)."""
    if isinstance(value, Constant):
        return as_number(value.value)
    if isinstance(value, Varying):
        return value.factor
    if isinstance(value, Textured):
        texture = dict(value.texture)
        if texture.get("channel", "color") == "color":
            texture["channel"] = "luminance"
        return scaled_offset({"texture": texture}, value.scale, 0.0)
    return None


def as_spectrum(value):
    """S of a value that can be one, or None."""
    if isinstance(value, Constant):
        return rgb_spectrum(value.value)
    if isinstance(value, Spectral):
        return value.spectrum
    if isinstance(value, Textured):
        plain = {"texture": value.texture}
        return plain if value.scale == 1 else {"scale": value.scale, "of": plain}
    if isinstance(value, Varying) and isinstance(value.factor, dict):
        if "texture" in value.factor:
            return {"texture": value.factor["texture"]}
        if value.factor.get("offset", 0.0) == 0.0 and "texture" in value.factor.get("of", {}):
            return {
                "scale": value.factor["scale"],
                "of": {"texture": value.factor["of"]["texture"]},
            }
    return None
