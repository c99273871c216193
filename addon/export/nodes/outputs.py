"""From a material, world or light to what the stream says of it: finds the output node and walks
back from it."""

from ...nodes import has_nodes
from . import lobes
from .closures import light_of, plain
from .graph import Graph, decimal, describe
from .registry import key_of
from .values import Constant, Environment, as_rgb, scaled
from .volumes import NOTHING_INSIDE, volume_of

_BLACK = {"rgb": [0.0, 0.0, 0.0], "scale": 1.0}
_DARK = {"kind": "constant", "emission": _BLACK}


def surface(material, context):
    """The closure of a material; None absorbs all."""
    if not has_nodes(material):
        return plain(material)
    output = material.node_tree.get_output_node('CYCLES')
    if output is None:
        return None
    graph = Graph(material, context)
    displacement = graph.socket(output, "Displacement")
    if displacement is not None and graph.is_linked(displacement):
        graph.warn(output, "displacement is not supported yet and left out")
    shown = graph.input(output, "Surface")
    inside = graph.socket(output, "Volume")
    if not graph.is_linked(shown) and inside is not None and graph.is_linked(inside):
        return {"bsdf": "transparent", "color": 1.0}  # the skin of a volume is not seen
    closure = graph.closure(shown)
    if lobes.count(closure) > lobes.LOBES:
        graph.splits = 0  # fewer lobes, the colours' mixes cut to their middle
        closure = graph.closure(shown)
    if lobes.count(closure) > lobes.LOBES:
        graph.warn(output, "the surface has more than %d lobes; the weakest are cut" % lobes.LOBES)
    return lobes.fit(closure)


def volume(owner, context):
    """W of a material or world, or None."""
    if not has_nodes(owner):
        return None
    output = owner.node_tree.get_output_node('CYCLES')
    graph = Graph(owner, context)
    socket = graph.socket(output, "Volume") if output else None
    if socket is None:
        return None
    graph.cannot_vary = "cannot vary inside a volume"
    graph.means = dict(graph.means, **NOTHING_INSIDE)
    return volume_of(socket, graph)


def light_emission(light, context):
    """L of a light's node tree and colour, without its power."""
    tint = tuple(decimal(channel) for channel in light.color)
    if getattr(light, "use_temperature", False):
        tint = tuple(a * b for a, b in zip(tint, light.temperature_color))
    if not has_nodes(light):
        return {"rgb": list(tint), "scale": 1.0}
    output = light.node_tree.get_output_node('CYCLES')
    if output is None:
        return dict(_BLACK)
    graph = Graph(light, context)
    terms = Terms(graph)
    terms.collect(graph.input(output, "Surface"), 1.0)
    tinted = [_tinted(term, tint, graph, output) for term in terms.lights]
    if not tinted:
        return dict(_BLACK)
    return tinted[0] if len(tinted) == 1 else {"sum": tinted}


def _tinted(emission, tint, graph, output):
    """Cycles multiplies the light's own colour into its nodes."""
    if "rgb" in emission:
        return dict(emission, rgb=[a * b for a, b in zip(emission["rgb"], tint)])
    strongest = max(tint)
    if "texture" in emission:
        graph.warn(output, "an image cannot light through a lamp yet; the lamp's colour is used")
        return {"rgb": list(tint), "scale": emission["scale"]}
    if min(tint) == strongest:
        return dict(emission, scale=emission["scale"] * strongest)
    if strongest <= 0.0:
        return dict(_BLACK)
    graph.warn(output, "the lamp's colour only tints its spectrum; its power stays what it is")
    shade = {"rgb": [channel / strongest for channel in tint]}
    return dict(emission, shape={"product": [emission["shape"], shade]})


def world(world, context):
    """The members of a `world` message; `world` may be None, which is black and empty."""
    if world is None:
        return dict(_DARK)
    return dict(_sky(world, context), volume=volume(world, context))


def _sky(world, context):
    if not has_nodes(world):
        return {
            "kind": "constant",
            "emission": {"rgb": [decimal(channel) for channel in world.color], "scale": 1.0},
        }
    output = world.node_tree.get_output_node('CYCLES')
    if output is None:
        return dict(_DARK)
    graph = Graph(world, context)
    terms = Terms(graph)
    terms.collect(graph.input(output, "Surface"), 1.0)
    return _world_of(terms, graph, output)


def _world_of(terms, graph, output):
    if terms.maps:
        if len(terms.maps) > 1 or terms.lights:
            graph.warn(
                output,
                "an image and other light are not mixed yet; %s is used" % describe(terms.maps[0]),
            )
        shown = terms.maps[0]
        return {
            "kind": "image",
            "image": shown.image,
            "scale": shown.scale,
            "transform": shown.transform,
        }
    if not terms.lights:
        return dict(_DARK)
    lights = [_untextured(light, graph, output) for light in terms.lights]
    emission = lights[0] if len(lights) == 1 else {"sum": lights}
    return {"kind": "constant", "emission": emission}


def _untextured(light, graph, output):
    if "texture" not in light:
        return light
    graph.warn(output, "a plain image cannot light the world; grey 0.5 is used")
    return {"rgb": [0.5, 0.5, 0.5], "scale": light["scale"]}


class Terms:
    """The light in a closure tree of a world or lamp, where there is no surface: a weighted sum."""

    def __init__(self, graph):
        self.graph = graph
        graph.camera_ray = 0.0  # what lights the scene counts for more than what is seen behind it
        self.lights = []  # L
        self.maps = []  # Environment

    def collect(self, socket, weight):
        graph = self.graph
        node, output, path = graph.follow(socket, graph.path)
        if node is None or weight == 0.0:
            return
        with graph.inside(path):
            key = key_of(node)
            if output.type != 'SHADER':
                self._add_light(graph.value(socket), weight, node)
            elif key in {"ShaderNodeBackground", "ShaderNodeEmission"}:
                color = graph.value(graph.input(node, "Color"))
                if isinstance(color, Environment):
                    self.maps.append(scaled(color, weight * graph.number(node, "Strength")))
                else:
                    light = light_of(node, graph, "Color", "Strength")
                    self.lights.append(dict(light, scale=light["scale"] * weight))
            elif key == "ShaderNodeAddShader":
                for shader in node.inputs:
                    self.collect(shader, weight)
            elif key == "ShaderNodeMixShader":
                share = min(1.0, max(0.0, graph.number(node, "Fac")))
                self.collect(node.inputs[1], weight * (1.0 - share))
                self.collect(node.inputs[2], weight * share)
            else:
                graph.warn(node, "gives no light here and is left out")

    def _add_light(self, color, weight, node):
        if isinstance(color, Environment):
            self.maps.append(scaled(color, weight))
        elif isinstance(color, Constant):
            self.lights.append({"rgb": list(as_rgb(color.value)), "scale": weight})
        else:
            self.lights.append(self.graph.light(color, weight, node))
