"""The shader editor: our Add menu, the operator behind it, and the sidebar with a node's settings
and its curve."""

import bpy

from .. import nodes
from . import plot
from .base import StokesPanel, is_ours

# What the operator sets on a fresh node of the Add menu, so that it shows something at once.
_FIRST_LOOK = {"fluorescent": {"dye": "fluorescein_basic-ethanol"}}

# 3.4's own Add menu hides these from engines it does not know.
_HIDDEN_SHADERS = (
    "ShaderNodeBsdfPrincipled",
    "ShaderNodeBsdfDiffuse",
    "ShaderNodeBsdfGlossy",
    "ShaderNodeBsdfGlass",
    "ShaderNodeBsdfRefraction",
    "ShaderNodeBsdfTransparent",
    "ShaderNodeBsdfTranslucent",
    "ShaderNodeBsdfAnisotropic",
    "ShaderNodeSubsurfaceScattering",
    "ShaderNodeBsdfVelvet",
    "ShaderNodeBsdfToon",
    "ShaderNodeEmission",
    "ShaderNodeBackground",
    "ShaderNodeHoldout",
    "ShaderNodeVolumeAbsorption",
    "ShaderNodeVolumeScatter",
    "ShaderNodeMixShader",
    "ShaderNodeAddShader",
    "ShaderNodeOutputMaterial",
    "ShaderNodeOutputLight",
)


def shader_tree(context):
    space = context.space_data
    if space is None or space.type != 'NODE_EDITOR' or space.tree_type != 'ShaderNodeTree':
        return None
    return space.edit_tree


class STOKES_OT_add_node(bpy.types.Operator):
    """Add a Stokes node"""

    bl_idname = "stokes.add_node"
    bl_label = "Add Stokes Node"
    bl_options = {'REGISTER', 'UNDO'}

    kind: bpy.props.EnumProperty(
        name="Node", items=[(kind.name, kind.label, kind.tooltip) for kind in nodes.KINDS.values()]
    )

    @classmethod
    def description(cls, _context, operator):
        return nodes.KINDS[operator.kind].tooltip

    @classmethod
    def poll(cls, context):
        return shader_tree(context) is not None or getattr(context, "material", None) is not None

    def _make(self, context):
        tree = shader_tree(context)
        if tree is None:
            context.material.use_nodes = True
            tree = context.material.node_tree
        for node in tree.nodes:
            node.select = False
        node = nodes.new(tree, self.kind, **_FIRST_LOOK.get(self.kind, {}))
        node.select = True
        tree.nodes.active = node
        return node

    def execute(self, context):
        self._make(context)
        return {'FINISHED'}

    def invoke(self, context, _event):
        node = self._make(context)
        if shader_tree(context) is None:
            return {'FINISHED'}
        node.location = context.space_data.cursor_location
        return bpy.ops.node.translate_attach_remove_on_cancel('INVOKE_DEFAULT')


class STOKES_MT_add(bpy.types.Menu):
    bl_label = "Stokes"

    def draw(self, _context):
        layout = self.layout
        layout.operator_context = 'INVOKE_REGION_WIN'
        last = None
        for kind in nodes.KINDS.values():
            if last not in (None, kind.category):
                layout.separator()
            last = kind.category
            layout.operator("stokes.add_node", text=kind.label).kind = kind.name


class STOKES_MT_add_shader(bpy.types.Menu):
    bl_label = "Shader (Cycles)"

    def draw(self, _context):
        layout = self.layout
        layout.operator_context = 'INVOKE_REGION_WIN'
        for name in _HIDDEN_SHADERS:
            kind = getattr(bpy.types, name, None)
            if kind is not None:
                operator = layout.operator("node.add_node", text=kind.bl_rna.name)
                operator.type = name
                operator.use_transform = True


def draw_add_menu(self, context):
    if shader_tree(context) is None:
        return
    self.layout.separator()
    self.layout.menu("STOKES_MT_add", icon='OUTLINER_OB_LIGHT')
    if is_ours(context) and bpy.app.version < (4, 0, 0):
        self.layout.menu("STOKES_MT_add_shader")


class STOKES_PT_node(bpy.types.Panel):
    bl_label = "Stokes"
    bl_space_type = 'NODE_EDITOR'
    bl_region_type = 'UI'
    bl_category = "Node"

    @classmethod
    def poll(cls, context):
        node = context.active_node
        return (
            shader_tree(context) is not None
            and node is not None
            and nodes.kind_of(node) is not None
        )

    def draw(self, context):
        draw_settings(self.layout, context.active_node)


def draw_settings(layout, node):
    """A Stokes node's settings, and its curve."""
    kind, settings = nodes.kind_of(node), nodes.settings_of(node)
    column = layout.column()
    column.label(text=kind.label, icon='NODE')
    column.use_property_split = True
    column.use_property_decorate = False
    if settings is not None:
        kind.draw(column, settings, node)
    plot.draw(layout, node)


class NodesPanel(StokesPanel):
    """The same settings in the tab of what the nodes belong to, for whoever works without the node
    editor. `owner` is its name in the context."""

    bl_label = "Stokes Nodes"
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'

    @classmethod
    def poll(cls, context):
        owner = getattr(context, cls.owner, None)
        return is_ours(context) and owner is not None and any(_stokes_nodes(owner))

    def draw(self, context):
        for node in _stokes_nodes(getattr(context, self.owner)):
            draw_settings(self.layout.box(), node)


class STOKES_PT_material_node(NodesPanel, bpy.types.Panel):
    bl_context = owner = "material"


class STOKES_PT_light_node(NodesPanel, bpy.types.Panel):
    bl_context, owner = "data", "light"


class STOKES_PT_world_node(NodesPanel, bpy.types.Panel):
    bl_context = owner = "world"


def _stokes_nodes(owner):
    """Those with settings of their own; the others have all they need in their sockets."""
    if owner.node_tree is None:
        return
    for node in owner.node_tree.nodes:
        if nodes.settings_of(node) is not None:
            yield node


CLASSES = (
    STOKES_OT_add_node,
    STOKES_MT_add,
    STOKES_MT_add_shader,
    STOKES_PT_node,
    STOKES_PT_material_node,
    STOKES_PT_light_node,
    STOKES_PT_world_node,
)


def register():
    bpy.types.NODE_MT_add.append(draw_add_menu)


def unregister():
    bpy.types.NODE_MT_add.remove(draw_add_menu)
