"""What is not rendered as in Cycles, listed by its owner: of the last look or the last export."""

import bpy

SHOWN = 40

_warnings = None  # [(owner, property, text)] of the last check or export; None: there was none yet


def keep(warnings):
    """The engine's last export tells here what it had to replace. Entries are (owner, property,
    text)."""
    global _warnings
    _warnings = [tuple(entry) for entry in warnings]


class Nowhere:
    """Stands in for a stream where only warnings count."""

    def send(self, message, /, **members):
        pass


def check(context):
    """Warnings of an export of what the window shows, and of the nodes that it hides and a render
    does not."""
    from ..export import ExportContext, camera, images, nodes, send_scene

    class Look(ExportContext):
        def image(self, image, times_alpha=False):
            return image.name_full if images.is_there(image, self) else None

    scene, depsgraph = context.scene, context.evaluated_depsgraph_get()
    look = Look(Nowhere(), depsgraph)
    if scene.camera:
        size = camera.resolution(scene)
        shown_camera = scene.camera.evaluated_get(depsgraph)
        send_scene(look, shown_camera, size, camera.border(scene, size))
    else:
        look.warn(scene, "camera", "there is none")
    for thing in scene.objects:
        if thing.type == 'LIGHT' and not thing.hide_render:
            nodes.light_emission(thing.data, look)
        for slot in () if thing.hide_render else thing.material_slots:
            if slot.material:
                nodes.surface(slot.material, look)
                nodes.volume(slot.material, look)
    return look.warnings


class STOKES_OT_check_scene(bpy.types.Operator):
    """Look through the whole scene for what Stokes cannot render as Cycles does"""

    bl_idname = "stokes.check_scene"
    bl_label = "Check Scene"

    def execute(self, context):
        keep(check(context))
        count = len(_warnings)
        self.report(
            {'INFO'},
            "Everything is supported"
            if not count
            else "%d thing%s not rendered as in Cycles" % (count, "s are" if count > 1 else " is"),
        )
        return {'FINISHED'}


def draw(layout, context):
    if _warnings is None:
        return
    if not _warnings:
        layout.label(text="Everything is supported", icon='CHECKMARK')
        return
    width = _letters(context)
    owner = None
    box = None
    for name, prop, text in _warnings[:SHOWN]:
        if name != owner:
            owner = name
            box = layout.box().column(align=True)
            box.label(text=name, icon='ERROR')
        _wrapped(box, "%s %s" % (prop, text), width)
    if len(_warnings) > SHOWN:
        layout.label(text="… and %d more" % (len(_warnings) - SHOWN))


def _letters(context):
    """About how many letters fit beside each other in the panel."""
    points = context.region.width / context.preferences.system.ui_scale
    return max(16, int((points - 50.0) / 5.6))


def _wrapped(layout, text, width):
    """Labels do not wrap by themselves."""
    line = ""
    for word in text.split():
        if line and len(line) + 1 + len(word) > width:
            layout.label(text=line)
            line = "   "
        line += (" " if line.strip() else "") + word
    layout.label(text=line)


CLASSES = (STOKES_OT_check_scene,)
