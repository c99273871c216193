"""Blender's own panels that also make sense for us: all that a plain renderer has, but those we
replace. COMPAT_ENGINES must not be guessed from EEVEE's name, which changes."""

import bpy

from .base import ENGINE

_OURS_INSTEAD = {
    'DATA_PT_area',
    'DATA_PT_camera_dof',
    'DATA_PT_falloff_curve',
    'DATA_PT_light',
    'DATA_PT_spot',
    'MATERIAL_PT_context_material',
    'MATERIAL_PT_preview',
    'NODE_DATA_PT_light',
    'NODE_DATA_PT_spot',
    'OBJECT_PT_visibility',
    'VIEWLAYER_PT_filter',
    'VIEWLAYER_PT_layer_passes',
    'RENDER_PT_post_processing',
    'RENDER_PT_simplify',
    'RENDER_PT_freestyle',
    'VIEWLAYER_PT_freestyle',
    'EEVEE_MATERIAL_PT_context_material',
}
_touched = []


def _panels():
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        if 'BLENDER_RENDER' in engines and panel.__name__ not in _OURS_INSTEAD:
            yield panel


def register():
    for panel in _panels():
        if ENGINE not in panel.COMPAT_ENGINES:
            panel.COMPAT_ENGINES.add(ENGINE)
            _touched.append(panel)


def unregister():
    while _touched:
        _touched.pop().COMPAT_ENGINES.discard(ENGINE)
