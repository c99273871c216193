"""What a Volume input says, as the W of csrc/stream/STREAM.md: homogeneous, by one function a node.

Measured with Cycles in Blender 3.4.1 and bpy 4.5.15, 5.2.3, by light through a cube:
    density is per metre of the world, whatever the object's scale; below 0 it is 0
    a mesh has no grids: what Principled Volume asks for by name changes nothing, and Attribute and
    Volume Info give 0; colour attributes and custom properties do not count either
    Principled Volume takes the root of its absorption colour
    volumes that overlap add up; Mix Shader mixes coefficients; BSDFs do nothing inside"""

import math

from ...nodes import library
from .graph import decimal, describe
from .registry import VOLUMES, fills, key_of
from .spectra import on_grid
from .stokes import table
from .values import Constant, Spectral, as_rgb, as_spectrum, rgb_spectrum

_DENSEST = 1e6  # 1/m; beyond it nothing is seen that a surface would not show
_FARTHEST = 0.999  # anisotropy; at 1 light would go straight on, as if there were nothing

# Nodes that ask for what only grids have.
NOTHING_INSIDE = {
    "ShaderNodeAttribute": 0.0,
    "ShaderNodeVertexColor": 0.0,
    "ShaderNodeVolumeInfo": 0.0,
}

# Phase functions that we do not have, and the anisotropy of what takes their place: nearly the mean
# cosine. None keeps the node's own.
_ANISOTROPY_INSTEAD = {'RAYLEIGH': 0.0, 'DRAINE': None, 'MIE': 0.85, 'FOURNIER_FORAND': 0.9}


def volume_of(socket, graph):
    """The volume that feeds a shader input; None where there is none."""
    node, output, path = graph.follow(socket, graph.path)
    if node is None:
        return None
    with graph.inside(path):
        if output.type != 'SHADER':  # Cycles turns a colour into light
            return glow(node, graph)
        translate = VOLUMES.get(key_of(node))
        if translate is None:
            graph.warn(node, "is no volume; it does nothing inside, as in Cycles")
            return None
        return translate(node, graph)


@fills("ShaderNodeVolumeScatter")
def scatter(node, graph):
    color, strength = _scattered(node, graph)
    return _unless_thin(
        {
            "volume": "scatter",
            "color": color,
            "density": min(_DENSEST, strength * _density(node, graph)),
            "anisotropy": _anisotropy(node, graph),
        }
    )


@fills("ShaderNodeVolumeAbsorption")
def absorption(node, graph):
    return _unless_thin(
        {
            "volume": "absorption",
            "color": as_spectrum(_share(node, graph, "Color")),
            "density": _density(node, graph),
        }
    )


@fills("ShaderNodeVolumePrincipled")
def principled(node, graph):
    if _is_lit(node, graph, "Emission Strength", "Emission Color"):
        graph.warn(node, "Emission is not supported yet and left out: it does not glow")
    if _is_lit(node, graph, "Blackbody Intensity", "Blackbody Tint"):
        graph.warn(node, "Blackbody is not supported yet and left out: it does not glow")
    return _unless_thin(
        {
            "volume": "principled",
            "color": as_spectrum(_share(node, graph, "Color")),
            "absorption_color": _rooted(_share(node, graph, "Absorption Color")),
            "density": _density(node, graph),
            "anisotropy": _anisotropy(node, graph),
        }
    )


@fills("ShaderNodeVolumeCoefficients")
def coefficients(node, graph):
    if _is_lit(node, graph, "Emission Coefficients"):
        graph.warn(node, "Emission is not supported yet and left out: it does not glow")
    return {
        "volume": "coefficients",
        "scattering": _coefficient(node, graph, "Scatter Coefficients"),
        "absorption": _coefficient(node, graph, "Absorption Coefficients"),
        "anisotropy": _anisotropy(node, graph),
    }


@fills("ShaderNodeEmission")
def glow(node, graph):
    graph.warn(node, "volumes that glow are not supported yet; its light is left out")


@fills("ShaderNodeAddShader")
def add_shader(node, graph):
    parts = [volume_of(socket, graph) for socket in node.inputs]
    found = [part for part in parts if part is not None]
    return {"add": found} if len(found) == 2 else found[0] if found else None


@fills("ShaderNodeMixShader")
def mix_shader(node, graph):
    share = min(1.0, max(0.0, graph.number(node, "Fac")))
    first, second = node.inputs[1], node.inputs[2]
    if share in (0.0, 1.0):
        return volume_of(second if share else first, graph)
    parts = [volume_of(first, graph), volume_of(second, graph)]
    return {"mix": parts, "factor": share} if any(parts) else None


def _unless_thin(volume):
    return volume if volume["density"] > 0.0 else None


def _density(node, graph):
    return graph.number(node, "Density", low=0.0, high=_DENSEST)


def _anisotropy(node, graph):
    """Of Henyey and Greenstein's phase function, the only one that we have."""
    phase = getattr(node, "phase", 'HENYEY_GREENSTEIN')  # others came with 4.3
    if phase == 'HENYEY_GREENSTEIN':
        return graph.number(node, "Anisotropy", low=-_FARTHEST, high=_FARTHEST)
    instead = _ANISOTROPY_INSTEAD.get(phase, 0.0)
    if instead is None:
        instead = graph.number(node, "Anisotropy", low=-_FARTHEST, high=_FARTHEST)
    graph.warn(
        node,
        "the phase function %s is not supported yet; Henyey-Greenstein with anisotropy %.3g is used"
        % (phase, instead),
    )
    return instead


def _is_lit(node, graph, *names):
    """Whether none of what is multiplied into a glow is 0."""
    values = [graph.plain_value(graph.input(node, name)) for name in names]
    return all(not isinstance(value, Constant) or max(as_rgb(value.value)) > 0 for value in values)


def _even(node, graph, name):
    """A Constant or Spectral input: the same all over the volume."""
    socket = graph.input(node, name)
    value = graph.plain_value(socket)
    if isinstance(value, Constant):
        return Constant(tuple(max(0.0, channel) for channel in as_rgb(value.value)))
    values = on_grid(as_spectrum(value)) if isinstance(value, Spectral) else None
    if values is None:
        return graph.instead(node, socket, graph.cannot_vary)
    if min(values) >= 0.0:
        return value
    return value._replace(spectrum=table(library.wavelengths(), [max(0.0, v) for v in values]))


def _top(value):
    values = value.value if isinstance(value, Constant) else on_grid(value.spectrum)
    return max(values, default=0.0)


def _scattered(node, graph):
    """(S within 0 and 1, what the density is to be multiplied by for it)."""
    value = _even(node, graph, "Color")
    top = min(_top(value), _DENSEST)
    if top <= 1.0:
        return as_spectrum(value), 1.0
    if isinstance(value, Constant):
        return rgb_spectrum(tuple(channel / top for channel in value.value)), top
    return {"scale": 1.0 / top, "of": value.spectrum}, top


def _share(node, graph, name):
    """A colour of which 1 minus itself absorbs; beyond 1 Cycles would make light."""
    value = _even(node, graph, name)
    top = _top(value)
    if top <= 1.0:
        return value
    graph.warn(node, "%s reaches %.3g; a volume cannot make light, and 1 is used" % (name, top))
    if isinstance(value, Constant):
        return Constant(tuple(min(1.0, channel) for channel in value.value))
    return value._replace(spectrum={"scale": 1.0 / top, "of": value.spectrum})


def _rooted(value):
    if isinstance(value, Constant):
        return rgb_spectrum(tuple(decimal(math.sqrt(channel)) for channel in value.value))
    return table(
        library.wavelengths(), [math.sqrt(max(0.0, v)) for v in on_grid(value.spectrum)]
    )


def _coefficient(node, graph, name):
    """S in 1/m of a vector, a channel of which may be large."""
    value = graph.plain_value(graph.input(node, name))
    if isinstance(value, Constant) and min(as_rgb(value.value)) < 0.0:
        graph.warn(node, "%s %s is negative somewhere; 0 is used there" % (name, describe(value)))
    value = _even(node, graph, name)
    top = min(_top(value), _DENSEST)
    if not isinstance(value, Constant) or top <= 1.0:
        return as_spectrum(value)
    return {"scale": top, "of": rgb_spectrum(tuple(channel / top for channel in value.value))}
