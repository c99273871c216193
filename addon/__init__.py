"""Stokes: a fluorescent, spectral, bidirectional render engine for Blender 3.4 to 5.x.
Nothing is imported from bpy until Blender registers the add-on, so that `core` also serves scripts
without Blender."""

bl_info = {
    "name": "Stokes",
    "author": "The Stokes authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Render properties > Render Engine",
    "description": "Fluorescent, spectral, bidirectional rendering",
    "category": "Render",
}


def _rooms():
    from . import engine, nodes, properties, ui

    return properties, nodes, ui, engine


def register():
    import atexit

    import bpy

    for room in _rooms():
        room.register()
    if not bpy.app.binary_path:  # bpy is a Python module
        atexit.register(_leave_module)


def unregister():
    import atexit

    atexit.unregister(_leave_module)
    for room in reversed(_rooms()):
        room.unregister()


def _leave_module():
    """A registered engine makes bpy 4.2 crash and 4.5 hang at exit. And 4.2 crashes where bpy
    outlives the interpreter: it keeps the callbacks of properties for ever, and these keep their
    modules' bpy."""
    import sys

    unregister()
    for name, module in list(sys.modules.items()):
        if name == __package__ or name.startswith(__package__ + "."):
            vars(module).pop("bpy", None)
