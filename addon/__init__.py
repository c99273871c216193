"""Stokes: a fluorescent, spectral, bidirectional render engine for Blender 3.4 to 5.x.
Nothing is imported from bpy until Blender registers the add-on, so that `core` also serves scripts without Blender."""

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

    for room in _rooms():
        room.register()
    atexit.register(unregister)  # a registered engine crashes or hangs bpy 4.2 and 4.5 at exit


def unregister():
    import atexit

    atexit.unregister(unregister)
    for room in reversed(_rooms()):
        room.unregister()
