"""What the depsgraph shows: each mesh once, its places gathered into one array, lights one by one.
Keyed by evaluated data-block, so that a million particles cost a million transforms and one
mesh."""

from array import array

import bpy

from ..core.stream import Blob
from . import geometry, lights

DEFAULT_MATERIAL = ""  # the stream's name of the grey that Cycles shows where there is no material
# The stream's rays, and the part of Blender's name for each.
RAYS = {
    "camera": "camera",
    "diffuse": "diffuse",
    "glossy": "glossy",
    "transmission": "transmission",
    "volume": "volume_scatter",
    "shadow": "shadow",
}

# Objects that no renderer shows, or that come a second time as the mesh they evaluate to.
_INVISIBLE = {
    'EMPTY',
    'CAMERA',
    'ARMATURE',
    'LATTICE',
    'SPEAKER',
    'LIGHT_PROBE',
    'CURVE',
    'SURFACE',
    'FONT',
    'META',
    'MESH',
    'GPENCIL',
    'GREASEPENCIL',
}  # Blender draws these over the picture of any engine


def send_objects(context):
    """Meshes and lights as they come, then materials, then the instances that need both."""
    groups = Groups(context)
    for instance in context.depsgraph.object_instances:
        if instance.show_self:
            groups.add(instance)
        if instance.show_particles:
            _warn_of_hair(instance.object, context)
    groups.send_materials()
    groups.send_instances()


class Groups:
    """Instances that differ only in their place share one message."""

    def __init__(self, context):
        self.context = context
        # pointer of the evaluated data -> (name, highest material index), or None without faces
        self.meshes = {}
        self.names = set()  # (kind, name in the stream)
        self.places = {}  # what an instance is made of -> the group's transforms, for the quick way
        self.groups = {}  # (mesh, materials, visible, holdout) -> [name, transforms]
        self.materials = {}  # name in the stream -> bpy material

    def add(self, instance):
        shown = instance.object
        data = shown.data
        if isinstance(data, bpy.types.Light):
            name = self._unique("light", shown.name_full)
            _warn_of_linking(shown, self.context)
            lights.send_light(
                shown,
                instance.matrix_world,
                visibility(shown, instance.parent, self.context),
                name,
                self.context,
            )
        elif isinstance(data, bpy.types.Mesh):
            if not self.context.view_layer.use_solid:
                return
            transforms = self._transforms(instance, shown, data)
            if transforms is not None:
                matrix = instance.matrix_world
                transforms.extend(matrix[0])
                transforms.extend(matrix[1])
                transforms.extend(matrix[2])
        elif shown.type not in _INVISIBLE:
            self.context.warn(shown, "type", "%s is not rendered" % shown.type.lower())

    def _transforms(self, instance, shown, data):
        """The array that takes the place of this instance, or None if it has no faces."""
        if not instance.is_instance:
            return self._group(instance, shown, data)
        key = (
            instance.instance_object.as_pointer() if instance.instance_object else 0,
            data.as_pointer(),
            instance.parent.as_pointer(),
        )
        try:
            return self.places[key]
        except KeyError:
            self.places[key] = transforms = self._group(instance, shown, data)
            return transforms

    def _group(self, instance, shown, data):
        mesh = self._mesh(shown, data)
        if mesh is None:
            return None
        name, highest = mesh
        materials = self._slots(shown, highest)
        parent = instance.parent if instance.is_instance else None
        visible = mesh_visibility(shown, parent, self.context)
        key = (name, materials, tuple(visible.items()), _is_holdout(parent or shown, self.context))
        if key not in self.groups:
            self.groups[key] = (self._unique("instances", shown.name_full), array("f"))
        if getattr(shown, "is_shadow_catcher", False):
            self.context.warn(shown, "is_shadow_catcher", "is rendered as a plain object")
        _warn_of_linking(shown, self.context)
        _warn_of_smoke(shown, self.context)
        return self.groups[key][1]

    def _mesh(self, shown, data):
        pointer = data.as_pointer()
        if pointer not in self.meshes:
            self.context.check()
            name = self._unique("mesh", data.name_full or shown.name_full)
            highest = geometry.send_mesh(data, name, self.context)
            self.meshes[pointer] = None if highest is None else (name, highest)
        return self.meshes[pointer]

    def _slots(self, shown, highest):
        """Names of the slots' materials; a face whose index is too high gets the last one, as in
        Cycles."""
        override = self.context.view_layer.material_override
        slots = [override or slot.material for slot in shown.material_slots] or [override]
        slots += [slots[-1]] * (highest + 1 - len(slots))
        for material in slots:
            if material:
                self.materials[material.name_full] = material
        return tuple(material.name_full if material else DEFAULT_MATERIAL for material in slots)

    def _unique(self, kind, name):
        """`name`, or name#2, name#3 …: names are unique within their kind."""
        candidate, number = name, 1
        while (kind, candidate) in self.names:
            number += 1
            candidate = "%s#%d" % (name, number)
        self.names.add((kind, candidate))
        return candidate

    def send_materials(self):
        from . import nodes

        for name, material in self.materials.items():
            self.context.send(
                "material",
                name=name,
                surface=nodes.surface(material, self.context),
                volume=nodes.volume(material, self.context),
            )

    def send_instances(self):
        for (mesh, materials, visible, holdout), (name, transforms) in self.groups.items():
            self.context.send(
                "instances",
                name=name,
                mesh=mesh,
                materials=list(materials),
                transforms=Blob(transforms),
                visible=dict(visible),
                holdout=holdout,
            )


def visibility(shown, parent, context):
    """Ray visibility of an object and of the instancer that shows it, as in Cycles."""
    owners = [owner for owner in (shown, parent) if owner]
    visible = {
        ray: all(getattr(owner, "visible_" + name) for owner in owners)
        for ray, name in RAYS.items()
    }
    if any(
        owner.indirect_only_get(view_layer=context.depsgraph.view_layer_eval) for owner in owners
    ):
        visible["camera"] = False
    return visible


def mesh_visibility(shown, parent, context):
    """Of a mesh: to Cycles of 3.4.1 and 4.2.23 light that a volume scattered is diffuse light too, to
    that of 4.5.15 it is not. Lamps were told apart before (all measured)."""
    visible = visibility(shown, parent, context)
    if context.blender_version < (4, 5, 0):
        visible["volume"] = visible["volume"] or visible["diffuse"]
    return visible


def _is_holdout(owner, context):
    return owner.is_holdout or owner.holdout_get(view_layer=context.depsgraph.view_layer_eval)


def _warn_of_linking(shown, context):
    linking = getattr(shown, "light_linking", None)  # since 4.0
    if linking and (linking.receiver_collection or linking.blocker_collection):
        context.warn(shown, "light_linking", "is not rendered: its light reaches everything")


def _warn_of_smoke(shown, context):
    for modifier in shown.modifiers:
        domain = modifier.domain_settings if modifier.type == 'FLUID' else None
        if domain is not None and domain.domain_type == 'GAS':
            context.warn(
                shown, modifier.name, "its smoke is not rendered; a volume fills the domain evenly"
            )


def _warn_of_hair(shown, context):
    for modifier in shown.modifiers:
        if modifier.type == 'PARTICLE_SYSTEM':
            settings = modifier.particle_system.settings
            if settings.type == 'HAIR' and settings.render_type == 'PATH':
                context.warn(shown, "hair", "is not rendered")
