"""The render engine as Blender sees it. It forwards: `final`, `viewport` and `session` do the
work, and are imported when there is some: half of the time that registering takes would be theirs."""

import bpy


class StokesEngine(bpy.types.RenderEngine):
    bl_idname = 'STOKES'
    bl_label = "Stokes"
    bl_use_preview = True
    bl_use_eevee_viewport = True  # Material Preview is rasterised, as with Cycles
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_spherical_stereo = False
    bl_use_custom_freestyle = False

    # Blender may call this twice on one object (4.4+), and with arguments or without: nothing
    # starts here.
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)

    def render(self, depsgraph):
        from . import final

        final.render(self, depsgraph)

    def view_update(self, context, depsgraph):
        from . import viewport

        viewport.update(self, context, depsgraph)

    def view_draw(self, context, depsgraph):
        from . import viewport

        viewport.draw(self, context, depsgraph)


def register():
    bpy.utils.register_class(StokesEngine)


def unregister():
    bpy.utils.unregister_class(StokesEngine)
