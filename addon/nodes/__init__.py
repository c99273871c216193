"""Stokes' own nodes. `new(tree, "fluorescent", dye="...")` makes one from a script; the Add menu
and `bpy.ops.stokes.add_node` make one by hand. To add a node: a file here, its line in KINDS."""

import bpy
from bpy.props import PointerProperty, StringProperty

from . import base
from . import conductor, dispersive_glass, fluorescent, reradiation_matrix
from . import spectrum_blackbody, spectrum_constant, spectrum_file, spectrum_gaussian
from . import spectrum_illuminant, spectrum_library, spectrum_line, spectrum_rgb

KINDS = {
    kind.name: kind
    for kind in (
        fluorescent.KIND,
        reradiation_matrix.KIND,
        dispersive_glass.KIND,
        conductor.KIND,
        spectrum_library.KIND,
        spectrum_file.KIND,
        spectrum_illuminant.KIND,
        spectrum_blackbody.KIND,
        spectrum_gaussian.KIND,
        spectrum_line.KIND,
        spectrum_constant.KIND,
        spectrum_rgb.KIND,
    )
}


def _settings_class():
    """The settings of all kinds under one roof, so that one pointer on a node holds any of them."""
    members = {"kind": StringProperty(name="Kind", description="Which Stokes node this is, if any")}
    members.update(
        (kind.name, PointerProperty(type=kind.Settings)) for kind in KINDS.values() if kind.Settings
    )
    return type("StokesNodeSettings", (bpy.types.PropertyGroup,), {"__annotations__": members})


StokesNodeSettings = None


def has_nodes(owner):
    """From 5.0 on everything has; asking `use_nodes` there warns of its end."""
    if owner.node_tree is None:
        return False
    return bpy.app.version >= (5, 0, 0) or owner.use_nodes


def kind_of(node):
    """The NodeKind of a node, or None. A node that was added as a plain group is known by its
    tree."""
    settings = _tagged(node)
    return KINDS.get(settings.kind) if settings else None


def settings_of(node):
    """The settings of a Stokes node: its own, or else those of its tree."""
    settings = _tagged(node)
    return getattr(settings, settings.kind, None) if settings else None


def _tagged(node):
    if node.bl_idname != "ShaderNodeGroup" or node.node_tree is None:
        return None
    for owner in (node, node.node_tree):
        if owner.stokes.kind in KINDS:
            return owner.stokes
    return None


def new(tree, kind_name, location=None, sockets=None, **settings):
    """Adds a Stokes node to a shader node tree. `settings` are those of the sidebar, `sockets`
    values of its inputs by name. Raises KeyError for an unknown kind, TypeError or AttributeError
    for a wrong setting."""
    kind = KINDS[kind_name]
    group = bpy.data.node_groups.new(".Stokes " + kind.label, "ShaderNodeTree")
    base.make_interface(group, kind)
    node = tree.nodes.new("ShaderNodeGroup")
    try:
        node.node_tree = group
        node.name = kind.label
        node.width = kind.width
        if location is not None:
            node.location = location
        for name, value in settings.items():
            if not hasattr(getattr(node.stokes, kind.name, None), name):
                raise AttributeError("%s has no setting %r" % (kind.label, name))
            setattr(getattr(node.stokes, kind.name), name, value)
        node.stokes.kind = kind.name
        refresh(node)
        for name, value in (sockets or {}).items():
            set_input(node, name, value)
    except Exception:
        tree.nodes.remove(node)
        bpy.data.node_groups.remove(group)
        raise
    return node


def set_input(node, name, value):
    socket = input_of(node, name)
    if socket.type == 'RGBA' and len(value) == 3:
        value = (*value, 1.0)
    socket.default_value = value


def input_of(node, name):
    """A Stokes node's input by the name in its kind's table."""
    for socket in node.inputs:
        if socket.name == name:
            return socket
    raise KeyError("%s has no input %r" % (node.name, name))


def refresh(node):
    """Makes the inside, the header and the tree's copy of the settings fit the node's settings."""
    kind = KINDS[node.stokes.kind]
    tree = node.node_tree
    if tree.users > 1:  # a duplicated node shares its tree until one of the two is edited
        tree = tree.copy()
        node.node_tree = tree
    base.copy_settings(node.stokes, tree.stokes)
    settings = getattr(node.stokes, kind.name, None)
    kind.build(base.Inside(tree), settings)
    node.label = kind.title(settings)
    tree.name = ".Stokes " + node.label
    kind.changed(node, settings)


def register():
    global StokesNodeSettings
    for kind in KINDS.values():
        if kind.Settings:
            bpy.utils.register_class(kind.Settings)
    StokesNodeSettings = _settings_class()
    bpy.utils.register_class(StokesNodeSettings)
    bpy.types.ShaderNodeGroup.stokes = PointerProperty(type=StokesNodeSettings)
    bpy.types.ShaderNodeTree.stokes = PointerProperty(type=StokesNodeSettings)


def unregister():
    global StokesNodeSettings
    del bpy.types.ShaderNodeTree.stokes
    del bpy.types.ShaderNodeGroup.stokes
    bpy.utils.unregister_class(StokesNodeSettings)
    StokesNodeSettings = None
    for kind in reversed(list(KINDS.values())):
        if kind.Settings:
            bpy.utils.unregister_class(kind.Settings)
