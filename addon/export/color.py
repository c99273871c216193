"""The colours of the running Blender: which OpenColorIO config, which working space, which view."""

import os

import bpy
from mathutils import Color


def send_color(context):
    scene = context.scene
    view = scene.view_settings
    context.send(
        "color",
        config=config_path(),
        working_space=working_space(),
        rgb_to_xyz=rgb_to_xyz(),
        display=scene.display_settings.display_device,
        view=view.view_transform,
        look="" if view.look == 'None' else view.look,
        exposure=view.exposure,
        gamma=max(view.gamma, 1e-3),  # Blender allows 0
    )


def config_path():
    """The config that Blender itself reads: $OCIO, or the one of its data files."""
    chosen = os.environ.get("OCIO", "")
    if chosen and os.path.isfile(chosen):
        return chosen
    folder = bpy.utils.system_resource('DATAFILES', path="colormanagement")
    path = os.path.join(folder, "config.ocio") if folder else ""
    return path if os.path.isfile(path) else ""


def working_space():
    """From 5.0 on each file chooses its own; before, the config's role decides."""
    chosen = getattr(bpy.data, "colorspace", None)
    return chosen.working_space if chosen else "scene_linear"


def rgb_to_xyz():
    """Row-major; its columns are the XYZ of the three primaries."""
    columns = [
        Color(primary).from_scene_linear_to_xyz_d65()
        for primary in ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    ]
    return [column[row] for row in range(3) for column in columns]
