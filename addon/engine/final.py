"""A final render or a material preview of one view layer: from the depsgraph to the Image Editor.
Whatever goes wrong ends here, as one line; an exception that left render() would write a black file."""

import struct
import time
import traceback

import bpy

from ..core.client import CoreError
from ..core.find import CoreNotFound
from ..core.stream import StreamError
from ..export import StrictError, camera
from ..ui import report
from .session import Session

SHOW_SECONDS = 0.25  # between two pictures shown
BATCH_SECONDS = 1.0
CANCEL_SECONDS = 5  # a core that is well needs a tenth of one
SHOW_SHARE = 0.1  # of the time may go into showing them


class Cancelled(Exception):
    """Esc before the core had begun."""


def render(engine, depsgraph):
    try:
        _render(engine, depsgraph)
    except Cancelled:
        pass
    except (CoreError, CoreNotFound, StreamError, StrictError) as error:
        _fail(engine, str(error))
    except Exception as error:
        traceback.print_exc()  # our own mistake: the console gets the place, the artist the line
        _fail(engine, "Stokes failed: %s: %s" % (type(error).__name__, error))


def _fail(engine, text):
    """report() gives exit status 1 and no file; error_set() puts the line over the picture in the
    window (in a batch it would only say it twice)."""
    engine.report({'ERROR'}, text)
    if not bpy.app.background:
        engine.error_set(text)


def _render(engine, depsgraph):
    scene = depsgraph.scene
    shown_camera = engine.camera_override or scene.camera
    if shown_camera is None:
        raise CoreError("%s: camera: the scene has none" % scene.name)
    size = camera.resolution(scene)
    if engine.is_preview:
        size = engine.resolution_x, engine.resolution_y
    rectangle = camera.border(scene, size)
    engine.update_stats("", "Exporting the scene")
    with Session(
        depsgraph, shown_camera.evaluated_get(depsgraph), size, rectangle, engine.is_preview
    ) as session:
        session.export(lambda: _check(engine))
        if not engine.is_preview:
            report.keep(session.replaced)
        _tell_warnings(engine, session)
        picture = Picture(engine, session, depsgraph.view_layer.name)
        try:
            finished = _follow(engine, session, picture)
        finally:
            picture.close()
        _tell_warnings(engine, session)
        _tell_report(engine, finished)


def _check(engine):
    if engine.test_break():
        raise Cancelled


def _follow(engine, session, picture):
    """Until the core has finished; returns what it said then."""
    give_up = None
    progress = Progress(engine)
    while True:
        if give_up is None and engine.test_break():
            session.client.cancel()
            give_up = time.monotonic() + CANCEL_SECONDS
        if give_up is not None and time.monotonic() > give_up:
            raise CoreError(
                "The core did not stop within %d seconds and was ended" % CANCEL_SECONDS
            )
        for event in session.events():
            if event.name == "progress":
                progress.show(event.members)
            elif event.name == "tile":
                picture.changed()
            elif event.name == "finished":
                picture.show()
                return event.members
        picture.show_now_and_then()


class Picture:
    """The render result that stays open for the whole render: what it holds is kept when the render
    ends early."""

    def __init__(self, engine, session, layer):
        self.engine = engine
        self.session = session
        width, height = session.width, session.height
        self.result = engine.begin_result(0, 0, width, height, layer=layer)
        self.combined = self.result.layers[0].passes["Combined"]
        if (self.result.resolution_x, self.result.resolution_y) != (width, height):
            found = self.result.resolution_x, self.result.resolution_y
            engine.end_result(self.result)
            raise CoreError(
                "border: the picture is %d × %d, Blender's %d × %d" % (width, height, *found)
            )
        self.is_fresh = False
        self.next_show = 0.0

    def changed(self):
        self.is_fresh = True

    def show_now_and_then(self):
        """Nobody looks at a batch render on its way; beside a window showing must not cost more
        than it is worth."""
        start = time.monotonic()
        if not self.is_fresh or bpy.app.background or start < self.next_show:
            return
        self.show()
        end = time.monotonic()
        self.next_show = end + max(SHOW_SECONDS, (end - start) / SHOW_SHARE)

    def show(self):
        set_pixels(self.combined, self.session.pixels(), self.session.width * self.session.height)
        self.engine.update_result(self.result)
        self.is_fresh = False

    def close(self):
        """Also after a failure: what the film holds then is shown, and kept."""
        if self.is_fresh:
            self.show()
        self.engine.end_result(self.result)


def set_pixels(target, data, count):
    """`count` RGBA pixels from the film's bytes into a render pass."""
    if bpy.app.version >= (4, 2, 0):
        with memoryview(data) as view, view.cast("f") as floats:
            target.rect.foreach_set(floats)
    else:  # 3.4 refuses a flat array for a pass of four channels
        target.rect = list(struct.iter_unpack("<4f", data[: 16 * count]))


class Progress:
    """What the status line says; a batch render prints each line, so there it speaks once a
    second."""

    def __init__(self, engine):
        self.engine = engine
        self.next_show = 0.0

    def show(self, members):
        now = time.monotonic()
        if now >= self.next_show:
            self.next_show = now + (BATCH_SECONDS if bpy.app.background else SHOW_SECONDS)
            _show_progress(self.engine, members)


def _show_progress(engine, members):
    sample, samples = members["sample"], max(1, members["samples"])
    engine.update_progress(min(sample / samples, 0.999))  # 100 % is said by the end alone
    parts = [members.get("text") or "Sample %d/%d" % (sample, samples)]
    if members.get("remaining", -1) >= 0:
        parts.insert(0, "Remaining " + duration(members["remaining"]))
    engine.update_stats("", " | ".join(parts))


def duration(seconds):
    minutes, seconds = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return "%d:%02d:%02d" % (hours, minutes, seconds) if hours else "%02d:%02d" % (minutes, seconds)


def _tell_warnings(engine, session):
    """One report for all of them: each names its object and property. A preview stays silent."""
    if session.warnings and not engine.is_preview:
        engine.report({'WARNING'}, "Stokes warns of:\n" + "\n".join(session.warnings))
    session.warnings = []


def _tell_report(engine, finished):
    if not engine.is_preview:
        for line in finished.get("report", []):
            print("Stokes:", line)
