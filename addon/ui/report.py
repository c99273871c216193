"""What is not rendered as in Cycles, listed by material, light and world: of the last look or the
last export."""

import bpy

SHOWN = 40

_warnings = None  # [(owner, property, text)] of the last check or export; None: there was none yet


def keep(warnings):
    """The engine's last export tells here what it had to replace. Entries are (owner, property,
    text)."""
    global _warnings
    _warnings = [tuple(entry) for entry in warnings]


class NodeCheck:
    """Stands in for an ExportContext where nothing is sent: only warnings count."""

    def __init__(self, scene):
        self.scene = scene
        self.blender_version = tuple(bpy.app.version)
        self.warnings = []

    def warn(self, owner, prop, text):
        entry = (getattr(owner, "name_full", None) or str(owner), prop, text)
        if entry not in self.warnings:
            self.warnings.append(entry)

    def image(self, image):
        if image.source not in {'FILE', 'GENERATED', 'VIEWER'}:
            self.warn(image, "source", "%s is not supported yet" % image.source.lower())
        return image.name_full

    def cycles(self, owner, name, default):
        return getattr(getattr(owner, "cycles", None), name, default)


def check(scene):
    """Warnings of all materials, lights and the world of a scene."""
    from ..export import nodes

    context = NodeCheck(scene)
    materials, lights = set(), set()
    for thing in scene.objects:
        if thing.type == 'LIGHT':
            lights.add(thing.data)
        else:
            materials.update(slot.material for slot in thing.material_slots if slot.material)
    for material in sorted(materials, key=lambda material: material.name_full):
        nodes.surface(material, context)
    for light in sorted(lights, key=lambda light: light.name_full):
        nodes.light_emission(light, context)
    nodes.world(scene.world, context)
    return context.warnings


class STOKES_OT_check_scene(bpy.types.Operator):
    """Look through all materials, lights and the world for what Stokes cannot render as Cycles
    does"""

    bl_idname = "stokes.check_scene"
    bl_label = "Check Scene"

    def execute(self, context):
        keep(check(context.scene))
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
