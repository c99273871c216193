"""Walks a node tree from an output back: links, reroutes, muted nodes, groups in groups.
Sockets are found by identifier: names differ between versions and languages."""

import math
from contextlib import contextmanager

from ... import nodes
from .registry import CLOSURES, VALUES, key_of
from .spectra import on_grid
from .values import (
    Constant,
    Environment,
    Spectral,
    Textured,
    Varying,
    as_factor,
    as_number,
    as_rgb,
    as_spectrum,
    rgb_spectrum,
)

# What procedural textures are on average: the nearest constant.
_MEANS = {
    "ShaderNodeTexNoise": 0.5,
    "ShaderNodeTexMusgrave": 0.0,
    "ShaderNodeTexWave": 0.5,
    "ShaderNodeTexVoronoi": 0.5,
    "ShaderNodeTexMagic": 0.5,
    "ShaderNodeTexGradient": 0.5,
    "ShaderNodeTexWhiteNoise": 0.5,
    "ShaderNodeTexGabor": 0.5,
    "ShaderNodeTexIES": 1.0,
    "ShaderNodeAmbientOcclusion": 1.0,
    "ShaderNodeObjectInfo": 0.5,
    "ShaderNodeParticleInfo": 0.5,
    "ShaderNodeTexSky": (0.35, 0.5, 0.75),
}


SPLITS = 2  # colours of one BSDF that may mix by factors that vary: each doubles its lobes


class Split(Exception):
    """A colour mixes two by a factor that varies. BSDFs are linear in their colours, so the closure
    around it becomes the same mix of two closures."""

    def __init__(self, key, factor):
        super().__init__()
        self.key = key
        self.factor = factor


class Graph:
    """One walk: `owner` is the material, world or light that warnings name."""

    def __init__(self, owner, context):
        self.owner = owner
        self.context = context
        self.path = ()  # the groups that the walk is in, outermost first
        self.sides = {}  # of colours that split the closure that is being translated: 0 or 1
        self.camera_ray = 1.0  # what Light Path says of it
        self.splits = SPLITS
        self.in_closure = False  # somebody waits for a Split
        self.may_split = False
        self.means = _MEANS
        self.cannot_vary = "cannot vary over the surface"

    def warn(self, node, text):
        self.context.warn(self.owner, node.label or node.name, text)

    # --- sockets ---

    @staticmethod
    def socket(node, *identifiers):
        """The input with the first of these identifiers that this version has, or None."""
        for identifier in identifiers:
            for socket in node.inputs:
                if socket.identifier == identifier:
                    return socket
        return None

    def input(self, node, *identifiers):
        """An input that must be there; a Stokes node's by name, as groups number their
        identifiers."""
        socket = self.socket(node, *identifiers)
        return socket if socket is not None else nodes.input_of(node, identifiers[0])

    def follow(self, socket, path):
        """(node, output, path) that feeds an input; or (None, input, path): that input's own value
        counts. (None, None, path) is 0, as in Cycles: out of a muted node or a reroute that nothing
        is linked to, whatever their sockets say, and out of a group without an output."""
        passed = False
        while True:
            link = next(
                (link for link in socket.links if link.is_valid and not link.is_muted), None
            )
            if link is None:
                return None, None if passed else socket, path
            node, output = link.from_node, link.from_socket
            if node.mute:
                inner = next((it for it in node.internal_links if it.to_socket == output), None)
                if inner is None:
                    return None, None if passed else socket, path
                socket, passed = inner.from_socket, True
            elif node.bl_idname == "NodeReroute":
                socket, passed = node.inputs[0], True
            elif node.bl_idname == "NodeGroupInput" and path:
                socket, passed = _same_socket(path[-1].inputs, output), False
                path = path[:-1]
            elif node.bl_idname == "ShaderNodeGroup" and not nodes.kind_of(node):
                inner = _group_result(node, output)
                if inner is None:
                    return None, None, path
                socket, path, passed = inner, path + (node,), False
            else:
                return node, output, path

    @contextmanager
    def inside(self, path):
        outer, self.path = self.path, path
        try:
            yield
        finally:
            self.path = outer

    def is_linked(self, socket):
        return self.follow(socket, self.path)[0] is not None

    # --- closures ---

    def closure(self, socket):
        """The closure that feeds a shader input; None (absorbs all) where nothing does."""
        node, output, path = self.follow(socket, self.path)
        if node is None:
            return None
        with self.inside(path):
            if output.type != 'SHADER':  # Cycles turns a colour into light
                return {
                    "emission": self.light(self._evaluate(node, output, None), 1.0, node),
                    "two_sided": True,
                }
            translate = CLOSURES.get(key_of(node))
            if translate is None:
                self.warn(node, "is not known to Stokes; a grey diffuse surface is used")
                return {"bsdf": "diffuse", "reflectance": rgb_spectrum(0.8)}
            return self._translated(translate, node)

    def _translated(self, translate, node):
        """One closure, or the tree of closures into which its colours split it."""
        outer, self.in_closure = self.in_closure, True
        try:
            return translate(node, self)
        except Split as split:
            closures = []
            for side in (0, 1):
                self.sides[split.key] = side
                closures.append(self._translated(translate, node))
            del self.sides[split.key]
            return {"mix": closures, "factor": split.factor}
        finally:
            self.in_closure = outer

    @contextmanager
    def splitting(self, may_split):
        outer, self.may_split = self.may_split, may_split
        try:
            yield
        finally:
            self.may_split = outer

    def choose(self, node, factor, first, second):
        """first + factor · (second − first), where the factor varies: in each of two closures one
        of the two. None if there can be no two closures here."""
        key = (node.as_pointer(), tuple(group.as_pointer() for group in self.path))
        if key in self.sides:
            return second() if self.sides[key] else first()
        if not self.may_split or len(self.sides) >= self.splits or factor is None:
            return None
        raise Split(key, factor)

    @staticmethod
    def bsdf(name, normal=None, **members):
        closure = {"bsdf": name}
        closure.update((key, value) for key, value in members.items() if value is not None)
        if normal:
            closure["normal"] = normal
        return closure

    # --- values ---

    def value(self, socket):
        """What an input carries (values.py)."""
        node, output, path = self.follow(socket, self.path)
        if node is None:
            return own_value(output)
        with self.inside(path):
            return self._evaluate(node, output, socket)

    def _evaluate(self, node, output, socket):
        evaluate = VALUES.get(key_of(node))
        if evaluate is not None:
            try:
                return finite(evaluate(node, output, self))
            except ArithmeticError:
                return Constant(0.0)  # Cycles' answer where there is none
        mean = self.means.get(node.bl_idname)
        instead = None if mean is None else Constant(mean)
        if instead is None:
            instead = own_value(socket) if socket is not None else Constant(0.5)
        self.warn(node, "is not supported yet; %s is used" % describe(instead))
        return instead

    def linear_value(self, node, socket):
        """What an input carries in which the closure is linear: it may split the closure."""
        with self.splitting(self.in_closure):
            value = self.value(socket)
            if isinstance(value, Varying) and as_spectrum(value) is None:
                grey = self.choose(
                    socket, value.factor, lambda: Constant(0.0), lambda: Constant(1.0)
                )
                return value if grey is None else grey
            return value

    def plain_value(self, socket):
        """What an input carries that says how, not how much."""
        with self.splitting(False):
            return self.value(socket)

    def color(self, node, *identifiers):
        """S of a colour input that reflects, lets through or absorbs: within 0 and 1."""
        socket = self.input(node, *identifiers)
        value = self.linear_value(node, socket)
        spectrum = as_spectrum(value)
        if spectrum is None:
            return as_spectrum(self.instead(node, socket, "cannot vary like that"))
        if isinstance(value, Textured) and value.scale > 1.0:
            self.warn(
                node,
                "%s is an image times %.3g; the image itself is used" % (socket.name, value.scale),
            )
            return {"texture": value.texture}
        return self._within_one(node, socket, spectrum) if isinstance(value, Spectral) else spectrum

    def spectrum(self, node, *identifiers):
        """S of an input that takes no image."""
        socket = self.input(node, *identifiers)
        value = self.plain_value(socket)
        if isinstance(value, (Constant, Spectral)):
            return self._within_one(node, socket, as_spectrum(value))
        return as_spectrum(self.instead(node, socket, self.cannot_vary))

    def shape(self, node, *identifiers):
        """S of which only the shape counts, or None if there is nothing in it."""
        socket = self.input(node, *identifiers)
        value = self.plain_value(socket)
        if not isinstance(value, (Constant, Spectral)):
            value = self.instead(node, socket, self.cannot_vary)
        if isinstance(value, Constant) and max(as_rgb(value.value)) <= 0.0:
            self.warn(node, "%s is black: nothing glows" % socket.name)
            return None
        return as_spectrum(value)

    def _within_one(self, node, socket, spectrum):
        """A spectrum brighter than 1 is a light's; as a reflectance its shape is used."""
        values = on_grid(spectrum)
        top = max(values) if values else 0.0
        if top <= 1.0 + 1e-6:
            return spectrum
        self.warn(node, "%s reaches %.3g; it is scaled down to 1" % (socket.name, top))
        return {"scale": 1.0 / top, "of": spectrum}

    def instead(self, node, socket, why):
        instead = own_value(socket)
        self.warn(node, "%s %s; %s is used" % (socket.name, why, describe(instead)))
        return instead

    def factor(self, node, *identifiers):
        """V of a number input."""
        socket = self.input(node, *identifiers)
        factor = as_factor(self.plain_value(socket))
        if factor is None:
            factor = as_number(self.instead(node, socket, "is a number, not a spectrum").value)
        return factor

    def number(self, node, *identifiers, low=None, high=None):
        """A number input that must be the same all over the surface, and within what the core
        takes."""
        socket = self.input(node, *identifiers)
        value = self.plain_value(socket)
        if not isinstance(value, Constant):
            value = self.instead(node, socket, self.cannot_vary)
        number = as_number(value.value)
        kept = number if low is None else max(low, number)
        kept = kept if high is None else min(high, kept)
        if kept != number:
            self.warn(node, "%s is %.3g; %.3g is used" % (socket.name, number, kept))
        return kept

    def vector(self, node, *identifiers):
        """Three numbers that must be the same all over the surface."""
        socket = self.input(node, *identifiers)
        value = self.plain_value(socket)
        if not isinstance(value, Constant):
            value = self.instead(node, socket, self.cannot_vary)
        return as_rgb(value.value)

    def light(self, color, strength, node):
        """L of a colour value and a number."""
        if isinstance(color, Spectral) and isinstance(color.spectrum, dict):
            if "rgb" in color.spectrum:  # how a colour reflects says nothing of how it shines
                color = Constant(tuple(color.spectrum["rgb"]))
        if isinstance(color, Spectral):
            values = on_grid(color.spectrum)
            if values and max(values) < 1e-12:
                self.warn(node, "the spectrum holds no light; black is used")
                return {"rgb": [0.0, 0.0, 0.0], "scale": 1.0}
            return {"shape": color.spectrum, "scale": strength, "unit": color.unit}
        if isinstance(color, Textured):
            return {"texture": color.texture, "scale": strength * color.scale}
        if isinstance(color, Constant):
            rgb = as_rgb(color.value)
            if min(rgb) < 0.0:
                self.warn(node, "light cannot be negative; its negative channels are black")
            return {"rgb": [max(0.0, channel) for channel in rgb], "scale": strength}
        if (
            isinstance(color, Varying)
            and isinstance(color.factor, dict)
            and "texture" in color.factor
        ):
            return {"texture": color.factor["texture"], "scale": strength}
        self.warn(node, "the light's colour cannot vary like that; white is used")
        return {"rgb": [1.0, 1.0, 1.0], "scale": strength}


def own_value(socket):
    """What an input says when nothing is linked to it."""
    value = getattr(socket, "default_value", None)
    if value is None:  # shaders, virtual sockets, and no socket at all
        return Constant(0.0)
    if isinstance(value, (int, float)):  # bool too
        return Constant(decimal(value))
    return Constant(
        0.0 if isinstance(value, str) else tuple(decimal(channel) for channel in value[:3])
    )


def finite(value):
    """A constant without what is no number; whatever else is left as it is."""
    if isinstance(value, Constant):
        numbers = value.value if isinstance(value.value, tuple) else (value.value,)
        if not all(math.isfinite(number) for number in numbers):
            return Constant(0.0)
    return value


def decimal(number):
    """A single-precision number of Blender's as it was typed in: 0.8, not 0.800000011920929."""
    return float("%.7g" % number)


def describe(value):
    """For warnings: "grey 0.8", "(1, 0.5, 0)"."""
    if isinstance(value, Constant) and isinstance(value.value, tuple):
        if max(value.value) == min(value.value):
            return "grey %.3g" % value.value[0]
        return "(%.3g, %.3g, %.3g)" % value.value
    if isinstance(value, Constant):
        return "%.3g" % value.value
    if isinstance(value, Textured):
        return "the image '%s'" % value.texture["image"]
    if isinstance(value, Environment):
        return "the environment '%s'" % value.image
    return "a spectrum" if isinstance(value, Spectral) else "a varying factor"


def _same_socket(sockets, other):
    return next(socket for socket in sockets if socket.identifier == other.identifier)


def _group_result(group, output):
    """The input of the inner Group Output that an output of `group` shows, or None."""
    if group.node_tree is None:
        return None
    results = [node for node in group.node_tree.nodes if node.bl_idname == "NodeGroupOutput"]
    active = next(
        (node for node in results if node.is_active_output), results[0] if results else None
    )
    return _same_socket(active.inputs, output) if active else None
