"""What mixing, colour and number nodes share: they compute constants as Cycles does, and name what
they cannot do."""

from .values import Constant, Varying


def nearest(node, values, graph):
    """What stays of an operation on something that is not constant: its first varying input, as it
    is."""
    graph.warn(node, "works on constants only so far; its input is used as it is")
    return next(value for value in values if not isinstance(value, Constant))


def are_constant(*values):
    return all(isinstance(value, Constant) for value in values)


def varying(factor):
    return Varying(factor) if isinstance(factor, dict) else Constant(factor)


def clamped(value, is_wanted):
    if not is_wanted or not isinstance(value, Constant):
        return value  # images and spectra stay within 0 and 1 as reflectances
    if isinstance(value.value, tuple):
        return Constant(tuple(min(1.0, max(0.0, channel)) for channel in value.value))
    return Constant(min(1.0, max(0.0, value.value)))
