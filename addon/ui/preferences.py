"""The add-on's preferences: where the core is, and which one is in use."""

import bpy
from bpy.props import StringProperty

from ..core import find

_ADDON = __package__.rpartition(".")[0]
_found = ""  # what the panel says; looked for when the path changes, never while drawing


def _look(self, _context):
    global _found
    try:
        _found = "In use: " + find.find_core(bpy.path.abspath(self.core_path))
    except find.CoreNotFound as error:
        _found = str(error)


class StokesPreferences(bpy.types.AddonPreferences):
    bl_idname = _ADDON

    core_path: StringProperty(
        name="Core",
        subtype='FILE_PATH',
        update=_look,
        description="The executable that renders. Empty: the one beside the add-on, or in PATH",
    )

    def draw(self, _context):
        self.layout.prop(self, "core_path")
        row = self.layout.row()
        row.label(text=_found or "Not looked for yet", icon='INFO')
        row.operator("stokes.find_core")


class STOKES_OT_find_core(bpy.types.Operator):
    """Look for the executable that renders"""

    bl_idname = "stokes.find_core"
    bl_label = "Find"

    def execute(self, context):
        addon = context.preferences.addons.get(_ADDON)
        if addon is None:
            self.report({'WARNING'}, "The add-on is not enabled in the preferences")
            return {'CANCELLED'}
        _look(addon.preferences, context)
        self.report({'INFO'}, _found)
        return {'FINISHED'}


CLASSES = (STOKES_OT_find_core, StokesPreferences)
