"""What every Stokes node is: a plain node group with a tag, settings, and an approximation inside.
So a file looks right in Cycles and EEVEE, and in a Blender that has never heard of Stokes."""

import bpy
from bpy.props import EnumProperty

UNITS = (
    (
        'total',
        "Power",
        "The spectrum is normalised, so that the strength of the lamp is all of its power",
    ),
    ('per_nm', "Per Nanometre", "The values are strength per nm, as they stand"),
)


class Socket:
    """One socket of a node, in words that 3.4 and 5.x have in common."""

    def __init__(self, name, kind, default=None, low=None, high=None, tooltip="", hidden=False):
        self.name = name
        self.kind = kind  # 'COLOR', 'FACTOR', 'FLOAT', 'VECTOR', 'SHADER'
        self.default = default
        self.low = low
        self.high = high
        self.tooltip = tooltip
        self.hidden = hidden  # no value beside it, only a link


class NodeKind:
    """Base of all kinds; one instance per file of this folder."""

    name = ""  # the tag; also the name of its settings
    label = ""
    tooltip = ""
    category = 'SHADER'  # or 'SPECTRUM'
    width = 180
    inputs = ()
    outputs = ()
    Settings = None  # a PropertyGroup class, or None

    def build(self, inside, settings):
        """Makes the approximation with the helpers of `Inside`."""
        raise NotImplementedError

    def title(self, settings):
        """What the node's header says."""
        return self.label

    def changed(self, node, settings):
        """After a setting of `node` changed: adjust sockets that the setting makes useless or
        sets."""

    def draw(self, layout, settings, node):
        """The settings in the sidebar."""
        for name in getattr(self.Settings, "__annotations__", ()):
            layout.prop(settings, name)


class Inside:
    """The inside of a group, while its approximation is built."""

    _SPACING = 220

    def __init__(self, tree):
        self.tree = tree
        self._column = 0
        tree.nodes.clear()
        self.input = self.node("NodeGroupInput")
        self.output = tree.nodes.new("NodeGroupOutput")

    def node(self, bl_idname, **properties):
        node = self.tree.nodes.new(bl_idname)
        node.location = (self._column * self._SPACING, 0)
        self._column += 1
        for name, value in properties.items():
            setattr(node, name, value)
        return node

    def link(self, source, target):
        self.tree.links.new(source, target)
        return target

    def given(self, name):
        """The group's input of that name, as a source of links."""
        return next(socket for socket in self.input.outputs if socket.name == name)

    def result(self, source):
        self.output.location = (self._column * self._SPACING, 0)
        self.link(source, self.output.inputs[0])

    def socket(self, node, identifier):
        """By identifier: names change between versions, and by language."""
        return next(socket for socket in node.inputs if socket.identifier == identifier)

    def math(self, operation, a, b=None, clamp=False):
        node = self.node("ShaderNodeMath", operation=operation, use_clamp=clamp)
        for socket, value in zip(node.inputs, (a, b)):
            self._give(socket, value)
        return node.outputs[0]

    def mix(self, blend, factor, a, b):
        """MixRGB exists on all versions from 3.4 to 5.x."""
        node = self.node("ShaderNodeMixRGB", blend_type=blend)
        for socket, value in zip(node.inputs, (factor, a, b)):
            self._give(socket, value)
        return node.outputs[0]

    def surface(self, bl_idname, **inputs):
        """The approximation's BSDF, with the group's normal; becomes the result."""
        node = self.node(bl_idname)
        for identifier, value in inputs.items():
            self._give(self.socket(node, identifier), value)
        self.link(self.given("Normal"), self.socket(node, "Normal"))
        self.result(node.outputs[0])

    def rgb(self, color):
        node = self.node("ShaderNodeRGB")
        node.outputs[0].default_value = (*color, 1.0)
        return node.outputs[0]

    def _give(self, socket, value):
        if value is None:
            return
        if isinstance(value, bpy.types.NodeSocket):
            self.link(value, socket)
        elif isinstance(value, tuple):
            socket.default_value = (*value, 1.0)
        else:
            socket.default_value = value


_SOCKET_TYPES = {
    'COLOR': "NodeSocketColor",
    'FACTOR': "NodeSocketFloat",
    'FLOAT': "NodeSocketFloat",
    'VECTOR': "NodeSocketVector",
    'SHADER': "NodeSocketShader",
}


def _add_socket(tree, socket, in_out):
    if hasattr(tree, "interface"):  # 4.0 and later
        item = tree.interface.new_socket(
            name=socket.name, in_out=in_out, socket_type=_SOCKET_TYPES[socket.kind]
        )
        if socket.kind == 'FACTOR':
            item.subtype = 'FACTOR'
    else:
        sockets = tree.inputs if in_out == 'INPUT' else tree.outputs
        kind = "NodeSocketFloatFactor" if socket.kind == 'FACTOR' else _SOCKET_TYPES[socket.kind]
        item = sockets.new(kind, socket.name)
    item.description = socket.tooltip
    if socket.hidden:
        item.hide_value = True
    if socket.low is not None:
        item.min_value = socket.low
        item.max_value = socket.high
    if socket.default is not None:
        item.default_value = (*socket.default, 1.0) if socket.kind == 'COLOR' else socket.default


def make_interface(tree, kind):
    for socket in kind.inputs:
        _add_socket(tree, socket, 'INPUT')
    for socket in kind.outputs:
        _add_socket(tree, socket, 'OUTPUT')


def find_node(settings):
    """The node that holds a settings group (or part of one), or None: the tree itself holds it."""
    address = settings.as_pointer()
    for node in getattr(settings.id_data, "nodes", ()):
        if node.bl_idname != "ShaderNodeGroup" or not node.stokes.kind:
            continue
        part = getattr(node.stokes, node.stokes.kind, None)
        if part is not None and part.as_pointer() == address:
            return node
    return None


def copy_settings(source, target):
    """Copies every member, nested groups too, without waking their update functions for nothing."""
    for name in source.__annotations__:
        value = getattr(source, name)
        if isinstance(value, bpy.types.PropertyGroup):
            copy_settings(value, getattr(target, name))
        elif getattr(target, name) != value:
            setattr(target, name, value)


def on_change(self, _context):
    """`update` of every setting: the node that it belongs to shows it at once."""
    node = find_node(self)
    if node is not None:
        from . import refresh

        refresh(node)


def unit_property():
    return EnumProperty(
        name="As a Light",
        description="How strong a light of this spectrum is",
        items=UNITS,
        default='total',
        update=on_change,
    )


NORMAL = Socket("Normal", 'VECTOR', tooltip="A Normal Map node, or nothing", hidden=True)
COLOR_OUT = Socket("Color", 'COLOR', tooltip="The spectrum; in Cycles and EEVEE its colour")
BSDF_OUT = Socket("BSDF", 'SHADER')
