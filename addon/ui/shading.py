"""Material, light, world and camera tabs: what Blender's panels show for its own engines only."""

import bpy

from ..nodes import has_nodes
from .base import StokesPanel, column_of, is_ours


class ShadingPanel(StokesPanel):
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'


class STOKES_OT_use_nodes(bpy.types.Operator):
    """Give this material, light or world a node tree"""

    bl_idname = "stokes.use_nodes"
    bl_label = "Use Nodes"
    bl_options = {'REGISTER', 'UNDO'}

    def execute(self, context):
        owner = context.material or context.light or context.world
        if owner is None:
            self.report({'ERROR'}, "There is no material, light or world here")
            return {'CANCELLED'}
        owner.use_nodes = True
        return {'FINISHED'}


def draw_tree(layout, owner, socket_identifier="Surface"):
    """The nodes behind an output's input, as a list; False if there are none."""
    if not has_nodes(owner):
        layout.operator("stokes.use_nodes", icon='NODETREE')
        return False
    output = owner.node_tree.get_output_node('CYCLES')
    if output is None:
        layout.label(text="No output node", icon='ERROR')
        return True
    socket = next(
        (socket for socket in output.inputs if socket.identifier == socket_identifier), None
    )
    layout.template_node_view(owner.node_tree, output, socket)
    return True


class STOKES_PT_material_slots(ShadingPanel, bpy.types.Panel):
    bl_label = ""
    bl_context = "material"
    bl_options = {'HIDE_HEADER'}

    @classmethod
    def poll(cls, context):
        return is_ours(context) and (context.material or context.object)

    def draw(self, context):
        layout = self.layout
        shown, slot = context.object, context.material_slot
        if shown:
            row = layout.row()
            row.template_list(
                "MATERIAL_UL_matslots",
                "",
                shown,
                "material_slots",
                shown,
                "active_material_index",
                rows=5 if len(shown.material_slots) > 1 else 3,
            )
            column = row.column(align=True)
            column.operator("object.material_slot_add", icon='ADD', text="")
            column.operator("object.material_slot_remove", icon='REMOVE', text="")
            column.separator()
            column.menu("MATERIAL_MT_context_menu", icon='DOWNARROW_HLT', text="")
            if len(shown.material_slots) > 1:
                column.separator()
                column.operator(
                    "object.material_slot_move", icon='TRIA_UP', text=""
                ).direction = 'UP'
                column.operator(
                    "object.material_slot_move", icon='TRIA_DOWN', text=""
                ).direction = 'DOWN'
        row = layout.row()
        if shown:
            row.template_ID(shown, "active_material", new="material.new")
            if slot:
                row.prop(
                    slot,
                    "link",
                    icon='OBJECT_DATA' if slot.link == 'OBJECT' else 'MESH_DATA',
                    icon_only=True,
                )
            if shown.mode == 'EDIT':
                row = layout.row(align=True)
                row.operator("object.material_slot_assign", text="Assign")
                row.operator("object.material_slot_select", text="Select")
                row.operator("object.material_slot_deselect", text="Deselect")
        elif context.material:
            row.template_ID(context.space_data, "pin_id")


class MaterialPanel(ShadingPanel):
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return is_ours(context) and context.material and not context.material.grease_pencil


class STOKES_PT_material_preview(MaterialPanel, bpy.types.Panel):
    bl_label = "Preview"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        self.layout.template_preview(context.material)


class STOKES_PT_material_surface(MaterialPanel, bpy.types.Panel):
    bl_label = "Surface"

    def draw(self, context):
        self.layout.use_property_split = True
        if not draw_tree(self.layout, context.material):
            self.layout.prop(context.material, "diffuse_color")


class STOKES_PT_material_volume(MaterialPanel, bpy.types.Panel):
    bl_label = "Volume"
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and has_nodes(context.material)

    def draw(self, context):
        self.layout.use_property_split = True
        draw_tree(self.layout, context.material, "Volume")


class STOKES_PT_light(ShadingPanel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return is_ours(context) and context.light

    def draw(self, context):
        light = context.light
        self.layout.row().prop(light, "type", expand=True)
        column = column_of(self.layout)
        column.prop(light, "color")
        column.prop(light, "energy")
        for name in ("exposure", "normalize"):  # 4.5 and later
            if hasattr(light, name):
                column.prop(light, name)
        column.separator()
        if light.type in {'POINT', 'SPOT'}:
            column.prop(light, "shadow_soft_size", text="Radius")
        elif light.type == 'SUN':
            column.prop(light, "angle")
        else:
            _draw_area(column, light)
        if light.type == 'SPOT':
            column.separator()
            column.prop(light, "spot_size", text="Beam Size")
            column.prop(light, "spot_blend", text="Blend", slider=True)
            column.prop(light, "show_cone")


def _draw_area(column, light):
    column.prop(light, "shape")
    size = column.column(align=True)
    if light.shape in {'SQUARE', 'DISK'}:
        size.prop(light, "size")
    else:
        size.prop(light, "size", text="Size X")
        size.prop(light, "size_y", text="Y")


class STOKES_PT_light_nodes(ShadingPanel, bpy.types.Panel):
    bl_label = "Spectrum"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return is_ours(context) and context.light

    def draw(self, context):
        row = self.layout.row()
        row.operator_menu_enum(
            "stokes.light_spectrum", "spectrum", text="Set Spectrum", icon='LIGHT'
        )
        self.layout.use_property_split = True
        draw_tree(self.layout, context.light)


class WorldPanel(ShadingPanel):
    bl_context = "world"

    @classmethod
    def poll(cls, context):
        return is_ours(context) and context.world


class STOKES_PT_world(WorldPanel, bpy.types.Panel):
    bl_label = "Surface"

    def draw(self, context):
        self.layout.use_property_split = True
        if not draw_tree(self.layout, context.world):
            self.layout.prop(context.world, "color")


class STOKES_PT_world_volume(WorldPanel, bpy.types.Panel):
    bl_label = "Volume"
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and has_nodes(context.world)

    def draw(self, context):
        self.layout.use_property_split = True
        draw_tree(self.layout, context.world, "Volume")


class STOKES_PT_camera_dof(ShadingPanel, bpy.types.Panel):
    bl_label = "Depth of Field"
    bl_context = "data"
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return is_ours(context) and context.camera

    def draw_header(self, context):
        self.layout.prop(context.camera.dof, "use_dof", text="")

    def draw(self, context):
        dof = context.camera.dof
        column = column_of(self.layout)
        column.active = dof.use_dof
        column.prop(dof, "focus_object", text="Focus on Object")
        distance = column.column()
        distance.active = dof.focus_object is None
        distance.prop(dof, "focus_distance", text="Focus Distance")
        aperture = column.column()
        aperture.separator()
        aperture.prop(dof, "aperture_fstop")
        aperture.prop(dof, "aperture_blades")
        aperture.prop(dof, "aperture_rotation")
        aperture.prop(dof, "aperture_ratio")


class STOKES_PT_object_visibility(ShadingPanel, bpy.types.Panel):
    bl_label = "Visibility"
    bl_context = "object"
    bl_options = {'DEFAULT_CLOSED'}

    @classmethod
    def poll(cls, context):
        return (
            is_ours(context)
            and context.object
            and context.object.type
            in {
                'MESH',
                'CURVE',
                'SURFACE',
                'FONT',
                'META',
                'CURVES',
                'POINTCLOUD',
                'VOLUME',
                'LIGHT',
            }
        )

    def draw(self, context):
        shown = context.object
        column = column_of(self.layout)
        show = column.column(heading="Show In")
        show.prop(shown, "hide_viewport", text="Viewports", invert_checkbox=True, toggle=False)
        show.prop(shown, "hide_render", text="Renders", invert_checkbox=True, toggle=False)
        rays = column.column(heading="Rays")
        for name in ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow"):
            text = name.replace("_", " ").title()
            rays.prop(shown, "visible_" + name, text=text, toggle=False)
        column.column(heading="Mask").prop(shown, "is_holdout", text="Holdout")


CLASSES = (
    STOKES_OT_use_nodes,
    STOKES_PT_material_slots,
    STOKES_PT_material_preview,
    STOKES_PT_material_surface,
    STOKES_PT_material_volume,
    STOKES_PT_light,
    STOKES_PT_light_nodes,
    STOKES_PT_world,
    STOKES_PT_world_volume,
    STOKES_PT_camera_dof,
    STOKES_PT_object_visibility,
)
