"""Principled BSDF: of Blender 3.x (model 3) and of 4.0 and later (model 4), by old and new socket
identifiers."""

from .closures import add, light_of
from .registry import translates
from .textures import normal
from .values import Constant, as_number

# What we do not render: the socket (old, new name) and the part of the surface that it brings in.
_NOT_YET = (
    (
        ("Subsurface Weight", "Subsurface"),
        "light does not go below the surface yet; diffuse reflection is used",
    ),
    (("Sheen Weight", "Sheen"), "sheen is not supported yet and left out"),
    (
        ("Anisotropic",),
        "anisotropy is not supported yet; the same roughness in all directions is used",
    ),
    (
        ("Transmission Roughness",),
        "a roughness of its own for transmission is not supported; Roughness is used",
    ),
    (("Thin Wall",), "a thin wall is not supported yet; a solid is used"),
    (("Thin Film Thickness",), "the thin film is not supported yet and left out"),
    (
        ("Diffuse Roughness",),
        "the diffuse roughness is not supported yet; a Lambertian surface is used",
    ),
)

COAT_IOR = 1.5  # of Blender 3.x, where it is fixed


@translates("ShaderNodeBsdfPrincipled")
def principled(node, graph):
    for names, text in _NOT_YET:
        if _may_be_positive(node, graph, *names):
            graph.warn(node, text)
    _check_distribution(node, graph)
    is_new = graph.context.blender_version >= (4, 0, 0)
    surface = graph.bsdf(
        "principled",
        model=4 if is_new else 3,
        base_color=graph.color(node, "Base Color"),
        metallic=graph.factor(node, "Metallic"),
        roughness=graph.factor(node, "Roughness"),
        ior=graph.number(node, "IOR", low=0.2, high=8.0),
        specular=graph.factor(node, "Specular IOR Level", "Specular"),
        specular_tint=graph.color(node, "Specular Tint") if is_new else _tint_amount(node, graph),
        transmission=graph.factor(node, "Transmission Weight", "Transmission"),
        multi_scatter=node.distribution == 'MULTI_GGX',
        normal=normal(node, graph),
    )
    return _with_alpha(node, graph, add(_with_coat(node, graph, surface), _glow(node, graph)))


def _tint_amount(node, graph):
    """In 3.x the tint is a number: how much of the base colour's hue reflections take."""
    return graph.number(node, "Specular Tint", low=0.0, high=1.0)


def _may_be_positive(node, graph, *names):
    socket = graph.socket(node, *names)
    if socket is None:
        return False
    value = graph.value(socket) if graph.is_linked(socket) else Constant(socket.default_value)
    return not isinstance(value, Constant) or as_number(value.value) > 0.0


def _check_distribution(node, graph):
    if node.distribution not in {'GGX', 'MULTI_GGX'}:
        graph.warn(node, "the distribution %s is not supported; GGX is used" % node.distribution)


def _glow(node, graph):
    """Emission is added to the surface; a strength of 0 leaves it out."""
    name = "Emission Color" if graph.socket(node, "Emission Color") else "Emission"
    if graph.number(node, "Emission Strength") <= 0.0:
        return None
    light = light_of(node, graph, name, "Emission Strength")
    is_black = max(light.get("rgb", (1.0,))) <= 0.0
    return None if is_black else {"emission": light, "two_sided": True}


def _with_coat(node, graph, surface):
    """A clear layer: its Fresnel reflection in front of what is below. Cycles also loses light
    between the two."""
    if not _may_be_positive(node, graph, "Coat Weight", "Clearcoat"):
        return surface
    weight = graph.factor(node, "Coat Weight", "Clearcoat")
    has_ior = graph.socket(node, "Coat IOR") is not None
    ior = graph.number(node, "Coat IOR", low=0.2, high=8.0) if has_ior else COAT_IOR
    if not has_ior:  # 3.x: a coat of 1 reflects a quarter of what a real layer would
        weight = {"scale": 0.25, "of": weight} if isinstance(weight, dict) else 0.25 * weight
    graph.warn(
        node, "the coat is rendered as a Fresnel reflection in front of the surface, untinted"
    )
    coat = graph.bsdf(
        "glossy", color=1.0, roughness=graph.factor(node, "Coat Roughness", "Clearcoat Roughness")
    )
    return {"mix": [surface, coat], "factor": {"product": [weight, {"fresnel": ior}]}}


def _with_alpha(node, graph, surface):
    alpha = graph.factor(node, "Alpha")
    if alpha == 1.0:
        return surface
    return {"mix": [{"bsdf": "transparent", "color": 1.0}, surface], "factor": alpha}
