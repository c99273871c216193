"""Panels, menus and operators. To add a panel: a class in the file of its tab, its name in that
file's CLASSES."""

import bpy

from . import engines, light_spectrum, node_editor, plot, preferences, render, report, shading

_FILES = (preferences, light_spectrum, shading, node_editor, report, render)


def register():
    for file in _FILES:
        for item in file.CLASSES:
            bpy.utils.register_class(item)
    for part in (plot, node_editor, engines):
        part.register()


def unregister():
    for part in (engines, node_editor, plot):
        part.unregister()
    for file in reversed(_FILES):
        for item in reversed(file.CLASSES):
            bpy.utils.unregister_class(item)
