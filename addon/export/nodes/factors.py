"""Inputs that vary with the view or are plain values: Fresnel, Layer Weight, Geometry, Light Path,
RGB, Value."""

from ...nodes import library, spectrum_blackbody
from .graph import own_value
from .registry import evaluates
from .values import Constant, Varying, luminance


@evaluates("ShaderNodeRGB", "ShaderNodeValue")
def plain(node, output, graph):
    return own_value(output)


@evaluates("ShaderNodeFresnel")
def fresnel(node, output, graph):
    return Varying({"fresnel": graph.number(node, "IOR", low=1e-3, high=1e3)})


@evaluates("ShaderNodeLayerWeight")
def layer_weight(node, output, graph):
    blend = graph.number(node, "Blend")
    if output.identifier == "Fresnel":
        return Varying({"fresnel": 1.0 / max(1.0 - blend, 1e-3)})
    return Varying({"facing": min(1.0, max(0.0, blend))})


@evaluates("ShaderNodeNewGeometry")
def geometry(node, output, graph):
    if output.identifier == "Backfacing":
        return Varying({"backfacing": 1})
    graph.warn(node, "%s is not supported yet; 0.5 is used" % output.name)
    return Constant(0.5)


@evaluates("ShaderNodeLightPath")
def light_path(node, output, graph):
    known = {"Is Camera Ray": graph.camera_ray, "Ray Length": 1.0}
    value = known.get(output.identifier, 0.0)
    graph.warn(
        node, "%s is %g for every ray: light has one path, from both ends" % (output.name, value)
    )
    return Constant(value)


@evaluates("ShaderNodeBlackbody")
def blackbody(node, output, graph):
    """Cycles' colour of a hot body: luminance 1."""
    color = library.emitted(spectrum_blackbody.curve(max(800.0, graph.number(node, "Temperature"))))
    return Constant(tuple(channel / luminance(color) for channel in color))


@evaluates("ShaderNodeWavelength")
def wavelength(node, output, graph):
    """Cycles scales the colour-matching functions at one wavelength by 1/2.52, to fit into 0 …
    1."""
    return Constant(
        tuple(channel / 2.52 for channel in library.monochromatic(graph.number(node, "Wavelength")))
    )


@evaluates("ShaderNodeLightFalloff")
def light_falloff(node, output, graph):
    if output.identifier != "Quadratic":
        graph.warn(node, "light falls off with the square of the distance, as it does in nature")
    return Constant(graph.number(node, "Strength"))


@evaluates("ShaderNodeObjectInfo", "ShaderNodeParticleInfo")
def object_info(node, output, graph):
    instead = Constant((0.5, 0.5, 0.5) if output.type == 'RGBA' else 0.5)
    graph.warn(node, "%s is not supported yet; 0.5 is used for every object" % output.name)
    return instead
