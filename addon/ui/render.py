"""The Render tab: one panel for each heading of properties.py."""

import bpy

from .. import properties
from . import report
from .base import RenderPanel, StokesPanel, column_of


class STOKES_OT_preset(bpy.types.Operator):
    """Set several settings at once"""

    bl_idname = "stokes.preset"
    bl_label = "Stokes Preset"
    bl_options = {'REGISTER', 'UNDO'}

    name: bpy.props.EnumProperty(
        name="Preset",
        items=[(key, label, tooltip) for key, (label, tooltip, _) in properties.PRESETS.items()],
    )

    @classmethod
    def description(cls, _context, operator):
        return properties.PRESETS[operator.name][1]

    def execute(self, context):
        properties.apply_preset(context.scene.stokes, self.name)
        return {'FINISHED'}


class STOKES_MT_presets(bpy.types.Menu):
    bl_label = "Presets"

    def draw(self, _context):
        for key, (label, _tooltip, _values) in properties.PRESETS.items():
            self.layout.operator("stokes.preset", text=label).name = key


class STOKES_PT_sampling(RenderPanel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw_header_preset(self, _context):
        self.layout.menu("STOKES_MT_presets", text="", icon='PRESET')

    def draw(self, context):
        settings = context.scene.stokes
        column = column_of(self.layout)
        column.prop(settings, "integrator")
        column.prop(settings, "lanes")
        column.separator()
        group = column.column(align=True)
        group.prop(settings, "samples", text="Samples")
        group.prop(settings, "preview_samples", text="Preview")
        column.separator()
        column.prop(settings, "time_limit")


class STOKES_PT_sampling_advanced(RenderPanel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_parent_id = "STOKES_PT_sampling"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        settings = context.scene.stokes
        row = column_of(self.layout).row(align=True)
        row.prop(settings, "seed")
        row.prop(settings, "animate_seed", text="", icon='TIME')


class STOKES_PT_mollification(RenderPanel, bpy.types.Panel):
    bl_label = "Mollification"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        settings = context.scene.stokes
        column = column_of(self.layout)
        if settings.integrator != 'mbdpt':
            column.label(text="Used by the mollified integrator", icon='INFO')
        column.active = settings.integrator == 'mbdpt'
        column.prop(settings, "d0", text="Width (nm)")
        column.prop(settings, "shrink")
        column.prop(settings, "kernel")
        column.prop(settings, "mollify_side")


class STOKES_PT_light_paths(RenderPanel, bpy.types.Panel):
    bl_label = "Light Paths"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        settings = context.scene.stokes
        column = column_of(self.layout)
        row = column.row()
        row.active = settings.integrator in {'bdpt', 'mbdpt'}
        row.prop(settings, "light_paths")
        column.separator()
        for names in (
            ("max_path", "max_camera", "max_light"),
            ("max_diffuse", "max_glossy", "max_transmission", "max_volume", "max_transparent"),
        ):
            group = column.column(align=True)
            for name in names:
                group.prop(settings, name)
            column.separator()


class STOKES_PT_wavelengths(RenderPanel, bpy.types.Panel):
    bl_label = "Wavelengths"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        settings = context.scene.stokes
        column = column_of(self.layout)
        group = column.column(align=True)
        group.prop(settings, "lambda_min", text="From (nm)")
        group.prop(settings, "lambda_max", text="To (nm)")
        column.prop(settings, "uv_rule")


class STOKES_PT_film(RenderPanel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        render = context.scene.render
        column = column_of(self.layout)
        column.prop(render, "filter_size", text="Filter Width")
        column.prop(render, "film_transparent", text="Transparent")


class STOKES_PT_performance(RenderPanel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        render = context.scene.render
        column = column_of(self.layout)
        column.prop(render, "threads_mode")
        row = column.column()
        row.enabled = render.threads_mode == 'FIXED'
        row.prop(render, "threads")


class STOKES_PT_scene_file(RenderPanel, bpy.types.Panel):
    bl_label = "Scene File"
    bl_options = {'DEFAULT_CLOSED'}

    def draw_header(self, context):
        self.layout.prop(context.scene.stokes, "use_record", text="")

    def draw(self, context):
        settings = context.scene.stokes
        column = column_of(self.layout)
        column.active = settings.use_record
        column.prop(settings, "record_path")


class STOKES_PT_report(RenderPanel, bpy.types.Panel):
    bl_label = "Report"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        settings = context.scene.stokes
        self.layout.operator("stokes.check_scene", icon='VIEWZOOM')
        report.draw(self.layout, context)
        column_of(self.layout).prop(settings, "strict")


class STOKES_PT_view_layer_filter(StokesPanel, bpy.types.Panel):
    bl_label = "Filter"
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    bl_context = "view_layer"

    def draw(self, context):
        column = column_of(self.layout).column(heading="Include")
        column.prop(context.view_layer, "use_sky", text="Environment")
        column.prop(context.view_layer, "use_solid", text="Surfaces")


class STOKES_PT_view_layer(StokesPanel, bpy.types.Panel):
    bl_label = "Override"
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    bl_context = "view_layer"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        column_of(self.layout).prop(context.view_layer, "material_override")


CLASSES = (
    STOKES_OT_preset,
    STOKES_MT_presets,
    STOKES_PT_sampling,
    STOKES_PT_sampling_advanced,
    STOKES_PT_mollification,
    STOKES_PT_light_paths,
    STOKES_PT_wavelengths,
    STOKES_PT_film,
    STOKES_PT_performance,
    STOKES_PT_scene_file,
    STOKES_PT_report,
    STOKES_PT_view_layer_filter,
    STOKES_PT_view_layer,
)
