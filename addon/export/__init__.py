"""The depsgraph as a Stokes stream: `send_scene` is the whole export, in the order of its
messages."""

import bpy

from .. import properties
from . import camera, color, nodes, objects
from .context import ExportContext, StrictError  # noqa: F401

PREVIEW_SECONDS = 1.0  # of rendering; with start, export and display a preview stays under two


def send_scene(context, shown_camera, size, rectangle, threads=None):
    """All messages of a scene but `render`. `shown_camera` is an evaluated object; `rectangle` the
    border."""
    scene = context.scene
    color.send_color(context)
    settings = properties.stream_settings(scene, preview=context.preview)
    if threads is not None:
        settings["threads"] = threads
    if context.preview:
        # Whatever finals leave out, a material is to be seen.
        settings.update(
            integrator="bdpt",
            lanes=4,
            time_limit=PREVIEW_SECONDS,
            max_path=min(settings["max_path"], 12),
        )
    context.send("settings", **settings)
    _warn_of_scene(context)
    objects.send_objects(context)
    send_world(context)
    camera.send_camera(shown_camera, size, rectangle, context)


# On in every new view layer, and of no use without others.
_PASSES_OF_NO_USE = {"use_pass_combined", "use_pass_cryptomatte_accurate"}


def _warn_of_passes(context):
    layer = context.view_layer
    wanted = [
        prop.name
        for prop in layer.bl_rna.properties
        if prop.identifier.startswith("use_pass_")
        and prop.identifier not in _PASSES_OF_NO_USE
        and getattr(layer, prop.identifier)
    ]
    if wanted:
        context.warn(layer, "passes", "not rendered: %s; only Combined is" % ", ".join(wanted))


def _warn_of_scene(context):
    scene = context.scene
    _warn_of_passes(context)
    if scene.render.use_motion_blur:
        context.warn(scene, "use_motion_blur", "is not rendered: everything stands still")
    if scene.render.use_multiview:
        context.warn(scene, "use_multiview", "is not rendered: both eyes see the same")
    if context.cycles(scene, "film_exposure", 1.0) != 1.0:
        context.warn(
            scene, "film_exposure", "of Cycles is not applied; use the exposure of Color Management"
        )


def send_world(context):
    world = context.scene.world if context.view_layer.use_sky else None
    members = nodes.world(world, context)
    visibility = getattr(world, "cycles_visibility", None)
    if visibility:
        members["visible"] = {
            ray: getattr(visibility, blender)
            for ray, blender in (
                ("camera", "camera"),
                ("diffuse", "diffuse"),
                ("glossy", "glossy"),
                ("transmission", "transmission"),
                ("volume", "scatter"),
            )
        }
    context.send("world", **members)


def record(path, depsgraph=None, samples=None):
    """Writes the scene as a file for `stokes render`, without a core; returns the warnings. For
    scripts and tests."""
    from ..core import stream

    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    scene = depsgraph.scene
    size = camera.resolution(scene)
    with stream.Recorder(path) as recorder:
        context = ExportContext(recorder, depsgraph)
        send_scene(context, scene.camera.evaluated_get(depsgraph), size, camera.border(scene, size))
        recorder.send(
            "render",
            samples=[0, samples or properties.sample_count(scene)],
            layer=depsgraph.view_layer.name,
        )
    return context.warnings
