"""One core at work for one view layer: exports the scene, starts the render, and hands on what the
core says. Knows no RenderEngine: `final` decides what becomes of the picture and of the words."""

import os

import bpy

from .. import properties
from ..core import stream
from ..core.client import Client, CoreError, error_line
from ..export import ExportContext, send_scene

POLL_SECONDS = 0.05  # how long Esc may wait for an event


class Session:
    """Use as a context manager: leaving it ends the core."""

    def __init__(self, depsgraph, shown_camera, size, rectangle, preview=False):
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene
        self.shown_camera = shown_camera
        self.size = size
        self.rectangle = rectangle
        self.preview = preview
        self.warnings = []  # one line each, until they are told
        self.replaced = []  # (object, property, text) of what the export had to replace
        self.width, self.height = rectangle[2] - rectangle[0], rectangle[3] - rectangle[1]
        # Beside a window a render must not be felt; a preview is over in a second, and waited for.
        low_priority = not (bpy.app.background or preview)
        self.client = Client(core_preference(), 16 * self.width * self.height, low_priority)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.client.close()

    def export(self, check):
        """Sends the scene and asks for the picture; also writes the scene file, if one is wanted.
        `check` is called now and then, and may raise to stop."""
        self.client.on_wait = check
        try:
            self._export(check)
        finally:
            self.client.on_wait = None

    def _export(self, check):
        path = "" if self.preview else record_path(self.depsgraph)
        if not path:
            self._send(self.client, check)
            return
        try:
            with stream.Recorder(path) as recorder:
                self._send(stream.Tee(self.client, recorder), check)
        except OSError as error:  # the core's own are a CoreError
            raise CoreError("%s: the scene cannot be recorded: %s" % (path, error.strerror)) from error

    def _send(self, out, check):
        context = ExportContext(
            out, self.depsgraph, strict=is_strict(self.scene), preview=self.preview, check=check
        )
        try:
            send_scene(context, self.shown_camera, self.size, self.rectangle, threads(self.scene))
        finally:
            self.replaced = context.warnings
            self.warnings += [": ".join(part for part in entry if part) for entry in self.replaced]
        out.send(
            "render",
            samples=[0, properties.sample_count(self.scene, preview=self.preview)],
            film=self.client.film_member,
            layer=self.depsgraph.view_layer.name,
        )

    def events(self):
        """What the core has said, for the caller; warnings are kept here and an error is raised."""
        told = []
        for event in self.client.events(POLL_SECONDS):
            if event.name == "error":
                raise CoreError(error_line(event.members))
            if event.name == "warning":
                self.warnings.append(error_line(event.members))
            else:
                told.append(event)
        return told

    def pixels(self):
        """The picture as it is now: RGBA floats as bytes, bottom row first."""
        return self.client.film


def core_preference():
    """The path in the add-on's preferences, "" if there is none."""
    addon = bpy.context.preferences.addons.get(__package__.rpartition(".")[0])
    return bpy.path.abspath(getattr(getattr(addon, "preferences", None), "core_path", ""))


def is_strict(scene):
    return bool(os.environ.get("STOKES_STRICT")) or scene.stokes.strict


def threads(scene):
    """All of them for a batch render; beside a window one stays free for it."""
    if scene.render.threads_mode == 'FIXED':
        return scene.render.threads
    return 0 if bpy.app.background else max(1, (os.cpu_count() or 2) - 1)


def record_path(depsgraph):
    """$STOKES_RECORD, or what the scene asks for; one file for each view layer that is rendered."""
    scene = depsgraph.scene
    path = os.environ.get("STOKES_RECORD") or properties.record_path(scene)
    layers = [layer for layer in scene.view_layers if layer.use]
    if path and len(layers) > 1 and not scene.render.use_single_layer:
        base, ending = os.path.splitext(path)
        path = "%s.%s%s" % (base, bpy.path.clean_name(depsgraph.view_layer.name), ending)
    return path
