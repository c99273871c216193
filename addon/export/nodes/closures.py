"""Cycles' BSDF nodes, one function each. What a closure of ours cannot say is named in a
warning."""

from .graph import decimal
from .registry import translates
from .textures import normal
from .values import rgb_spectrum


def microfacets(node, graph):
    """Members of a BSDF of microfacets: ours are GGX, of before 4.0 (model 3) or since, with one
    bounce between them or the light of many."""
    distribution = getattr(node, "distribution", 'GGX')
    roughness = 0.0 if distribution == 'SHARP' else graph.factor(node, "Roughness")
    if distribution not in {'GGX', 'MULTI_GGX'} and roughness != 0.0:
        graph.warn(node, "the distribution %s is not supported yet; GGX is used" % distribution)
    members = {"roughness": roughness}
    if graph.context.blender_version < (4, 0, 0):
        members["model"] = 3
    if distribution == 'MULTI_GGX':
        members["multi_scatter"] = True
    return members


@translates("ShaderNodeBsdfDiffuse")
def diffuse(node, graph):
    return graph.bsdf(
        "diffuse",
        reflectance=graph.color(node, "Color"),
        roughness=graph.factor(node, "Roughness"),
        normal=normal(node, graph),
    )


@translates("ShaderNodeBsdfTranslucent")
def translucent(node, graph):
    return graph.bsdf(
        "translucent", reflectance=graph.color(node, "Color"), normal=normal(node, graph)
    )


@translates("ShaderNodeBsdfTransparent")
def transparent(node, graph):
    return graph.bsdf("transparent", color=graph.color(node, "Color"))


@translates("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic")
def glossy(node, graph):
    anisotropy = graph.socket(node, "Anisotropy")
    if anisotropy is not None and (graph.is_linked(anisotropy) or anisotropy.default_value != 0.0):
        graph.warn(
            node, "anisotropy is not supported yet; the same roughness in all directions is used"
        )
    return graph.bsdf(
        "glossy",
        color=graph.color(node, "Color"),
        normal=normal(node, graph),
        **microfacets(node, graph),
    )


@translates("ShaderNodeBsdfGlass")
def glass(node, graph):
    thin_film = graph.socket(node, "Thin Film Thickness")
    if thin_film is not None and (graph.is_linked(thin_film) or thin_film.default_value > 0.0):
        graph.warn(node, "the thin film is not supported yet; plain glass is used")
    color = graph.color(node, "Color")
    return graph.bsdf(
        "dielectric",
        ior=graph.number(node, "IOR", low=0.2, high=8.0),
        reflect_color=color,
        transmit_color=color,
        lobes="both",
        normal=normal(node, graph),
        **microfacets(node, graph),
    )


@translates("ShaderNodeBsdfRefraction")
def refraction(node, graph):
    return graph.bsdf(
        "dielectric",
        ior=graph.number(node, "IOR", low=0.2, high=8.0),
        transmit_color=graph.color(node, "Color"),
        lobes="refract",
        normal=normal(node, graph),
        **microfacets(node, graph),
    )


@translates("ShaderNodeBsdfMetallic")
def metallic(node, graph):
    if node.fresnel_type == 'PHYSICAL_CONDUCTOR':
        graph.warn(
            node, "the IOR by channel is not supported yet; a reflection of its base colour is used"
        )
    elif max(graph.vector(node, "Edge Tint")) != min(graph.vector(node, "Edge Tint")):
        graph.warn(
            node, "the edge tint is not supported yet; the base colour is used at every angle"
        )
    return graph.bsdf(
        "glossy",
        color=graph.color(node, "Base Color"),
        normal=normal(node, graph),
        **microfacets(node, graph),
    )


@translates("ShaderNodeSubsurfaceScattering")
def subsurface(node, graph):
    graph.warn(
        node, "light does not go below the surface yet; a diffuse surface of its colour is used"
    )
    return graph.bsdf("diffuse", reflectance=graph.color(node, "Color"), normal=normal(node, graph))


@translates(
    "ShaderNodeBsdfVelvet",
    "ShaderNodeBsdfSheen",
    "ShaderNodeBsdfToon",
    "ShaderNodeBsdfHair",
    "ShaderNodeBsdfHairPrincipled",
)
def cloth_and_hair(node, graph):
    graph.warn(node, "is not supported yet; a diffuse surface of its colour is used")
    return graph.bsdf("diffuse", reflectance=graph.color(node, "Color"), normal=normal(node, graph))


@translates("ShaderNodeEeveeSpecular")
def eevee_specular(node, graph):
    graph.warn(node, "is an EEVEE node; Cycles renders nothing for it, and so do we")
    return None


@translates(
    "ShaderNodeVolumeAbsorption",
    "ShaderNodeVolumeScatter",
    "ShaderNodeVolumePrincipled",
    "ShaderNodeVolumeCoefficients",
)
def volume(node, graph):
    graph.warn(node, "is a volume; as a surface it is black, as in Cycles")
    return None


@translates("ShaderNodeHoldout")
def holdout(node, graph):
    return graph.bsdf("holdout")


@translates("ShaderNodeEmission", "ShaderNodeBackground")
def emission(node, graph):
    return {"emission": light_of(node, graph, "Color", "Strength"), "two_sided": True}


def light_of(node, graph, color_name, strength_name):
    """L of a colour and a strength input."""
    color = graph.linear_value(node, graph.input(node, color_name))
    return graph.light(color, graph.number(node, strength_name, low=0.0), node)


@translates("ShaderNodeMixShader")
def mix_shader(node, graph):
    factor = graph.factor(node, "Fac")
    first, second = node.inputs[1], node.inputs[2]
    if not isinstance(factor, dict):
        factor = min(1.0, max(0.0, factor))
        if factor in (0.0, 1.0):
            return graph.closure(second if factor else first)
    return {"mix": [graph.closure(first), graph.closure(second)], "factor": factor}


@translates("ShaderNodeAddShader")
def add_shader(node, graph):
    return add(graph.closure(node.inputs[0]), graph.closure(node.inputs[1]))


def add(*closures):
    """The sum of closures, without those that are black."""
    total = None
    for closure in closures:
        if closure is not None:
            total = closure if total is None else {"add": [total, closure]}
    return total


def plain(material):
    """A material without nodes: Cycles renders its viewport colour as a diffuse surface."""
    color = tuple(decimal(channel) for channel in material.diffuse_color[:3])
    return {"bsdf": "diffuse", "reflectance": rgb_spectrum(color)}
