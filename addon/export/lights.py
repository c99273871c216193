"""Blender's lights in physical units, as the Cycles of the *running* Blender means them.

Measured with Cycles in Blender 3.4.1 and bpy 4.2.23, 4.5.15, 5.0.1 (the change came with 4.0), for
a light of power P:
    point, spot    intensity P/4π; with a radius r radiance P/(4π²r²), whatever the object's scale
    area           radiance P/(πA), before 4.0 P/(4A); A is the area of the scaled shape
    sun            irradiance P; before 4.0 a disk of constant *projected* radiance, which loses
                   2cosα/(1+cosα) of it for half-angle α
Without `normalize` (4.5) the radiance is P/π, the intensity P/π, the sun's radiance P.
A spot of 3.4 is dimmed by the cosine too.

Points and spots with a radius r are spheres here, as in the Cycles of 4.0 and where *Soft Falloff*
(4.1 and later, on by default) is off. Before 4.0, and with it, Cycles draws a disk about the
light's centre that turns to face each point that it lights. At a distance d it gives d²/(d² + r²)
of the sphere's light, and its penumbra is narrower by half that share: 0.3 % in the parity scene
spot_soft. Only closer than a few radii it shows, and within r, where a sphere gives nothing. As
that radiance changes along a ray there is no such light for light sub-paths to start from."""

import math

from . import camera, nodes


def send_light(shown, matrix, visible, name, context):
    """One `light` message. `shown` is the evaluated object, `matrix` its place (of this
    instance)."""
    light = shown.data
    if context.cycles(light, "is_portal", False):
        return  # a portal emits nothing: it only guides Cycles' sampling
    if light.energy < 0:
        context.warn(light, "energy", "is negative: the light is left out")
        return
    _warn(light, matrix, context)
    kind, factor, members = _KINDS[light.type](light, matrix, context)
    if 0 in members.get("size", ()):
        context.warn(light, "size", "is 0: a lamp without area gives no light")
        return
    emission = scaled(
        nodes.light_emission(light, context),
        light.energy * factor * 2 ** getattr(light, "exposure", 0),
    )
    context.send(
        "light",
        name=name,
        kind=kind,
        transform=camera.flat(camera.rigid(matrix)),
        emission=emission,
        visible=visible,
        **members,
    )


def scaled(emission, factor):
    """`factor` times the emission L."""
    if "sum" in emission:
        return {"sum": [scaled(term, factor) for term in emission["sum"]]}
    return dict(emission, scale=emission.get("scale", 1.0) * factor)


def _is_normalized(light):
    return getattr(light, "normalize", True)


def _point(light, _matrix, _context):
    radius = light.shadow_soft_size
    kind, members = ("sphere", {"radius": radius}) if radius > 0 else ("point", {})
    return kind, _radial_factor(light, radius), members


def _spot(light, _matrix, context):
    radius = light.shadow_soft_size
    members = {"radius": radius, "angle": light.spot_size, "blend": light.spot_blend}
    if context.blender_version < (3, 5, 0):
        members["dimmed"] = True
    return "spot", _radial_factor(light, radius), members


def _radial_factor(light, radius):
    """Radiance of a sphere, or intensity of a point, per power."""
    if not _is_normalized(light):
        return 1 / math.pi
    return 1 / (4 * math.pi**2 * radius**2) if radius > 0 else 1 / (4 * math.pi)


def _sun(light, _matrix, context):
    half = light.angle / 2
    factor = 1.0
    if not _is_normalized(light) and half > 0:
        factor = math.pi * math.sin(half) ** 2
    elif context.blender_version < (4, 0, 0):
        factor = 2 * math.cos(half) / (1 + math.cos(half))
    return "sun", factor, {"angle": light.angle}


def _area(light, matrix, context):
    scale = matrix.to_scale()
    height = light.size_y if light.shape in {'RECTANGLE', 'ELLIPSE'} else light.size
    size = [light.size * abs(scale.x), height * abs(scale.y)]
    is_round = light.shape in {'DISK', 'ELLIPSE'}
    area = size[0] * size[1] * (math.pi / 4 if is_round else 1)
    factor = 1 / 4 if context.blender_version < (4, 0, 0) else 1 / math.pi
    if _is_normalized(light) and area > 0:
        factor /= area
    return "ellipse" if is_round else "rectangle", factor, {"size": size}


_KINDS = {'POINT': _point, 'SPOT': _spot, 'SUN': _sun, 'AREA': _area}


def _warn(light, matrix, context):
    if light.type == 'AREA' and light.spread < math.pi - 1e-4:
        context.warn(light, "spread", "is not rendered: the light shines over its whole half-space")
    if light.type == 'SPOT':
        scale = matrix.to_scale()
        if max(scale) - min(scale) > 1e-3 * max(scale) and context.blender_version >= (3, 5, 0):
            context.warn(light, "scale", "of a spot is not rendered: its cone is round")
    casts = (
        light.use_shadow
        if context.blender_version >= (4, 2, 0)
        else context.cycles(light, "cast_shadow", True)
    )
    if not casts:
        context.warn(light, "use_shadow", "is off, but the light casts shadows all the same")
