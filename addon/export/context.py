"""What every exporter needs at hand: the stream, warnings, and data that is sent once.
Exporters take an ExportContext and return plain dicts in the words of csrc/stream/STREAM.md.

The entry points of `export.nodes`, which this context serves:
    surface(material, context)      -> a closure dict (or None: absorbs all)
    volume(owner, context)          -> what fills a material or world (or None)
    world(world, context)           -> the members of a `world` message; `world` may be None (black)
    light_emission(light, context)  -> an L of the light's node tree and colour, without its power
"""

import bpy

from . import images


class StrictError(Exception):
    """In strict mode a warning is an error."""


class ExportContext:
    """State of one export: one depsgraph into one stream."""

    def __init__(self, stream, depsgraph, strict=False, preview=False, check=None):
        self.stream = stream
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene
        self.view_layer = depsgraph.view_layer
        self.strict = strict
        self.preview = preview  # a material preview: small, quick, silent
        self.check = check or (
            lambda: None
        )  # called between objects; raises if the user wants to stop
        self.blender_version = tuple(bpy.app.version)
        self.warnings = []  # (object, property, text), each once, in order of appearance
        self._sent_images = {}  # name in the stream -> True

    def send(self, message, /, **members):
        """One frame of the stream; bytes-like members wrapped in core.stream.Blob travel as
        blobs."""
        return self.stream.send(message, **members)

    def warn(self, owner, prop, text):
        """Names what is not rendered as Cycles would: `owner` is a bpy ID or a text."""
        name = getattr(owner, "name_full", None) or getattr(owner, "name", None) or str(owner)
        entry = (name, prop, text)
        if entry in self.warnings:
            return
        self.warnings.append(entry)
        if self.strict:
            raise StrictError("%s: %s: %s" % entry)

    def image(self, image, times_alpha=False):
        """Sends a bpy image once, or once more with its colours multiplied by alpha; returns its
        name in the stream, or None (after a warning) if it has no pixels."""
        name = image.name_full + (" × alpha" if times_alpha else "")
        if name not in self._sent_images:
            self._sent_images[name] = images.send(image, name, self, times_alpha)
        return name if self._sent_images[name] else None

    def cycles(self, owner, name, default):
        """A setting that the Cycles add-on keeps on `owner`; it may be off, or the setting gone."""
        return getattr(getattr(owner, "cycles", None), name, default)
