"""Number nodes: of constants exactly; what varies may be scaled, shifted and multiplied."""

import math

from .constant import are_constant, clamped, nearest, varying
from .registry import evaluates
from .values import Constant, Varying, as_factor, as_number, scaled_offset


def _safe(function):
    """Cycles' rule: what is not defined is 0."""

    def call(*arguments):
        try:
            result = function(*arguments)
        except (ValueError, ZeroDivisionError, OverflowError):
            return 0.0
        return (
            result if isinstance(result, float) and math.isfinite(result) else float(result or 0.0)
        )

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


_MATH = {
    name: _safe(function)
    for name, function in {
        'ADD': lambda a, b, c: a + b,
        'SUBTRACT': lambda a, b, c: a - b,
        'MULTIPLY': lambda a, b, c: a * b,
        'DIVIDE': lambda a, b, c: a / b,
        'MULTIPLY_ADD': lambda a, b, c: a * b + c,
        'POWER': lambda a, b, c: math.pow(a, b),
        'LOGARITHM': lambda a, b, c: math.log(a) / math.log(b),
        'SQRT': lambda a, b, c: math.sqrt(a),
        'INVERSE_SQRT': lambda a, b, c: 1.0 / math.sqrt(a),
        'ABSOLUTE': lambda a, b, c: abs(a),
        'EXPONENT': lambda a, b, c: math.exp(a),
        'MINIMUM': lambda a, b, c: min(a, b),
        'MAXIMUM': lambda a, b, c: max(a, b),
        'LESS_THAN': lambda a, b, c: float(a < b),
        'GREATER_THAN': lambda a, b, c: float(a > b),
        'SIGN': lambda a, b, c: float(_sign(a)),
        'COMPARE': lambda a, b, c: float(abs(a - b) <= max(c, 1e-5)),
        'SMOOTH_MIN': _smooth_min,
        'SMOOTH_MAX': lambda a, b, c: -_smooth_min(-a, -b, c),
        'ROUND': lambda a, b, c: float(math.floor(a + 0.5)),
        'FLOOR': lambda a, b, c: float(math.floor(a)),
        'CEIL': lambda a, b, c: float(math.ceil(a)),
        'TRUNC': lambda a, b, c: float(math.trunc(a)),
        'FRACT': lambda a, b, c: a - math.floor(a),
        'MODULO': lambda a, b, c: math.fmod(a, b),
        'FLOORED_MODULO': lambda a, b, c: a - math.floor(a / b) * b,
        'WRAP': _wrap,
        'SNAP': lambda a, b, c: math.floor(a / b) * b,
        'PINGPONG': lambda a, b, c: _ping_pong(a, b),
        'SINE': lambda a, b, c: math.sin(a),
        'COSINE': lambda a, b, c: math.cos(a),
        'TANGENT': lambda a, b, c: math.tan(a),
        'ARCSINE': lambda a, b, c: math.asin(a),
        'ARCCOSINE': lambda a, b, c: math.acos(a),
        'ARCTANGENT': lambda a, b, c: math.atan(a),
        'ARCTAN2': lambda a, b, c: math.atan2(a, b),
        'SINH': lambda a, b, c: math.sinh(a),
        'COSH': lambda a, b, c: math.cosh(a),
        'TANH': lambda a, b, c: math.tanh(a),
        'RADIANS': lambda a, b, c: math.radians(a),
        'DEGREES': lambda a, b, c: math.degrees(a),
    }.items()
}


@evaluates("ShaderNodeMath")
def math_node(node, output, graph):
    values = [graph.value(socket) for socket in node.inputs]
    operation = node.operation
    if operation not in _MATH:
        graph.warn(node, "%s is not supported yet; its first input is used" % operation.lower())
        return values[0]
    if are_constant(*(value for value, socket in zip(values, node.inputs) if socket.enabled)):
        numbers = [as_number(v.value) if isinstance(v, Constant) else 0.0 for v in values] + [
            0.0
        ] * (3 - len(values))
        return clamped(Constant(_MATH[operation](*numbers)), node.use_clamp)
    result = _linear(operation, *values[:2])
    return result if result is not None else nearest(node, values, graph)


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
        return varying(scaled_offset(second, scale, 0.0 if operation == 'MULTIPLY' else first))
    forms = {
        'ADD': (1.0, second),
        'SUBTRACT': (1.0, -second),
        'MULTIPLY': (second, 0.0),
        'DIVIDE': (1.0 / second if second else 0.0, 0.0),
    }
    return varying(scaled_offset(first, *forms[operation])) if operation in forms else None


@evaluates("ShaderNodeClamp")
def clamp(node, output, graph):
    value = graph.value(graph.input(node, "Value"))
    low, high = graph.number(node, "Min"), graph.number(node, "Max")
    if not isinstance(value, Constant):
        return value if (low, high) == (0.0, 1.0) else nearest(node, (value,), graph)
    if node.clamp_type == 'RANGE' and low > high:
        low, high = high, low
    return Constant(min(high, max(low, as_number(value.value))))


@evaluates("ShaderNodeMapRange")
def map_range(node, output, graph):
    if getattr(node, "data_type", 'FLOAT') != 'FLOAT' or node.interpolation_type != 'LINEAR':
        graph.warn(node, "only the linear map of a number is supported so far; it is used")
    value = graph.value(graph.input(node, "Value"))
    low, high, to_low, to_high = (
        graph.number(node, name) for name in ("From Min", "From Max", "To Min", "To Max")
    )
    if low == high:
        return Constant(to_low)
    slope = (to_high - to_low) / (high - low)
    offset = to_low - slope * low
    if not isinstance(value, Constant):
        factor = as_factor(value)
        return (
            varying(scaled_offset(factor, slope, offset))
            if factor is not None
            else nearest(node, (value,), graph)
        )
    result = slope * as_number(value.value) + offset
    if node.clamp:
        result = min(max(to_low, to_high), max(min(to_low, to_high), result))
    return Constant(result)
