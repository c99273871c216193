"""Runs inside Blender, before the code of a test: registers the add-on of the checkout and gives
that code its tools."""

import json
import math  # noqa: F401  the tests use what is imported here
import os
import sys
from array import array

import bpy
from mathutils import Matrix, Vector  # noqa: F401

sys.path.insert(0, os.environ["ROOT"])
TMP = os.environ["TMP_PATH"]

import addon  # noqa: E402

addon.register()

from addon.core import stream  # noqa: E402


def tell(value):
    """Hands a value to the test, as JSON."""
    print("\nTOLD " + json.dumps(value), flush=True)


def empty_scene(samples=2, size=(16, 8)):
    """Nothing but a camera at (0, 0, 5) that looks down."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = 'STOKES'
    scene.stokes.samples = samples
    scene.render.resolution_x, scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.camera = add("Camera", bpy.data.cameras.new("Camera"), (0, 0, 5))
    return scene


def add(name, data, location=(0, 0, 0)):
    shown = bpy.data.objects.new(name, data)
    shown.location = location
    bpy.context.scene.collection.objects.link(shown)
    return shown


def add_mesh(
    name="Quad", vertices=((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)), faces=((0, 1, 2, 3),)
):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    return add(name, mesh)


def add_material(name, mesh):
    material = bpy.data.materials.new(name)
    mesh.materials.append(material)
    return material


def render_frames(**kwargs):
    """Renders with the tests' core; the frames that it got, as [(message, members, blobs)]."""
    path = os.path.join(TMP, "frames.stokes")
    os.environ["STOKES_RECORD"] = path
    try:
        bpy.ops.render.render(**kwargs)
    finally:
        del os.environ["STOKES_RECORD"]
    return stream.read(path)


def messages(frames, name):
    return [members for message, members, _ in frames if message == name]


def blob(frames, message, object_name, member, kind):
    """One bulk array of the named object's message."""
    for name, members, area in frames:
        if name == message and members["name"] == object_name:
            at = members[member]["at"]
            return list(array(kind, bytes(area[at : at + members[member]["bytes"]])))
    raise KeyError(object_name)


def save_exr(name, **kwargs):
    """Renders into a file and returns its path."""
    scene = bpy.context.scene
    scene.render.image_settings.file_format = 'OPEN_EXR'
    scene.render.image_settings.color_depth = '32'
    scene.render.filepath = os.path.join(TMP, name)
    bpy.ops.render.render(write_still=True, **kwargs)
    return scene.render.filepath + ("" if name.endswith(".exr") else ".exr")


def pixels(path):
    """(width, height, flat RGBA) of an EXR."""
    image = bpy.data.images.load(path)
    image.colorspace_settings.is_data = True
    values = array("f", bytes(4 * 4 * image.size[0] * image.size[1]))
    image.pixels.foreach_get(values)
    return image.size[0], image.size[1], list(values)
