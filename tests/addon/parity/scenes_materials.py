"""Parity scenes of materials: one closure or node each, under a large lamp and a dim world.
Colours are either in the material or in the lamp, and muted: the product of two spectra is not that of their RGBs."""

import pictures
from stage import diffuse, light, material, scene, still_life, world

GLOSSY = ("ShaderNodeBsdfGlossy", "ShaderNodeBsdfAnisotropic")
PALE = (0.8, 0.72, 0.62, 1.0)


def show(build, floor=None):
    still_life(material("Shown", build), floor)
    light('AREA', 120, (2.0, -2.0, 3.5), shape='SQUARE', size=2.5)
    world(0.35)


def principled(tree, **inputs):
    """Without what later versions add by default. Single scattering: the same microfacets everywhere."""
    return tree.node("ShaderNodeBsdfPrincipled", {"distribution": 'GGX'}, **inputs)


def textured(tree, picture, vector=None, **settings):
    node = tree.node("ShaderNodeTexImage", {"image": picture, **settings})
    if vector is not None:
        tree.put(node.inputs["Vector"], vector)
    return node


# Principled ------------------------------------------------------------------------------------------------------

@scene(samples=(64, 384), run="always")
def principled_textured():
    show(lambda tree: principled(tree, Base_Color=textured(tree, pictures.chart()), Roughness=0.5))


@scene()
def principled_rough():
    show(lambda tree: principled(tree, Base_Color=PALE, Roughness=0.9))


@scene()
def principled_smooth():
    show(lambda tree: principled(tree, Base_Color=PALE, Roughness=0.15))


@scene()
def principled_no_specular():
    show(lambda tree: principled(tree, Base_Color=PALE, Specular=0.0))


@scene(samples=(64, 320), run="every")
def principled_metal():
    show(lambda tree: principled(tree, Base_Color=PALE, Metallic=1.0, Roughness=0.3))


@scene()
def principled_half_metal():
    show(lambda tree: principled(tree, Base_Color=PALE, Metallic=0.5, Roughness=0.4))


@scene(samples=(128, 512))
def principled_glass():
    show(lambda tree: principled(tree, Base_Color=PALE, Transmission=1.0, Roughness=0.0, IOR=1.45), diffuse(0.5))


@scene(samples=(128, 384))
def principled_rough_glass():
    show(lambda tree: principled(tree, Base_Color=PALE, Transmission=1.0, Roughness=0.3, IOR=1.45), diffuse(0.5))


@scene(samples=(128, 384), run="long")
def principled_half_glass():
    show(lambda tree: principled(tree, Base_Color=PALE, Transmission=0.5, Roughness=0.2, IOR=1.45), diffuse(0.5))


@scene(run="long")
def principled_masked_metal():
    show(lambda tree: principled(tree, Base_Color=PALE, Metallic=textured(tree, pictures.mask()), Roughness=0.4))


@scene(run="long")
def principled_masked_roughness():
    show(lambda tree: principled(tree, Base_Color=PALE, Metallic=0.8, Roughness=textured(tree, pictures.mask())))


# Plain closures --------------------------------------------------------------------------------------------------

@scene()
def diffuse_coloured():
    show(lambda tree: tree.node("ShaderNodeBsdfDiffuse", Color=PALE))


@scene()
def diffuse_oren_nayar():
    show(lambda tree: tree.node("ShaderNodeBsdfDiffuse", Color=PALE, Roughness=1.0))


@scene(run="every")
def glossy_rough():
    show(lambda tree: tree.node(GLOSSY, {"distribution": 'GGX'}, Color=PALE, Roughness=0.4))


@scene()
def glossy_mirror():
    show(lambda tree: tree.node(GLOSSY, {"distribution": 'GGX'}, Color=PALE, Roughness=0.0), diffuse(0.5))


@scene(samples=(128, 1600), run="every")
def glass_smooth():
    show(lambda tree: tree.node("ShaderNodeBsdfGlass", {"distribution": 'GGX'}, Roughness=0.0, IOR=1.5), diffuse(0.5))


@scene(samples=(128, 384))
def glass_rough():
    show(lambda tree: tree.node("ShaderNodeBsdfGlass", {"distribution": 'GGX'}, Color=PALE, Roughness=0.35, IOR=1.5),
         diffuse(0.5))


@scene(samples=(128, 384), run="long")
def refraction():
    show(lambda tree: tree.node("ShaderNodeBsdfRefraction", {"distribution": 'BECKMANN'}, Roughness=0.0, IOR=1.2),
         diffuse(0.5))


@scene()
def transparent():
    show(lambda tree: tree.node("ShaderNodeBsdfTransparent", Color=PALE), diffuse(0.5))


@scene(run="long")
def translucent():
    show(lambda tree: tree.node("ShaderNodeBsdfTranslucent", Color=PALE), diffuse(0.5))


@scene(run="every")
def mixed():
    """A third of a sharp gloss over diffuse."""
    show(lambda tree: tree.node("ShaderNodeMixShader", None, Fac=0.35,
                                Shader=tree.node("ShaderNodeBsdfDiffuse", Color=PALE),
                                Shader_001=tree.node(GLOSSY, {"distribution": 'GGX'}, Roughness=0.2)))


@scene()
def mixed_by_fresnel():
    show(lambda tree: tree.node("ShaderNodeMixShader", None, Fac=tree.node("ShaderNodeFresnel", IOR=1.6),
                                Shader=tree.node("ShaderNodeBsdfDiffuse", Color=PALE),
                                Shader_001=tree.node(GLOSSY, {"distribution": 'GGX'}, Roughness=0.1)))


@scene(run="long")
def mixed_by_facing():
    def build(tree):
        weight = tree.node("ShaderNodeLayerWeight", Blend=0.4).outputs["Facing"]
        return tree.node("ShaderNodeMixShader", None, Fac=weight,
                         Shader=tree.node("ShaderNodeBsdfDiffuse", Color=PALE),
                         Shader_001=tree.node("ShaderNodeBsdfDiffuse", Color=(0.1, 0.1, 0.1, 1)))
    show(build)


@scene()
def cut_out():
    """Holes where the picture says so: transparent shadows."""
    show(lambda tree: tree.node("ShaderNodeMixShader", None, Fac=textured(tree, pictures.chart(alpha=0.3)).outputs["Alpha"],
                                Shader=tree.node("ShaderNodeBsdfTransparent"),
                                Shader_001=tree.node("ShaderNodeBsdfDiffuse", Color=PALE)), diffuse(0.5))


@scene()
def emission_textured():
    show(lambda tree: tree.node("ShaderNodeEmission", Color=textured(tree, pictures.chart()), Strength=1.5),
         diffuse(0.5))


@scene(run="long")
def added():
    show(lambda tree: tree.node("ShaderNodeAddShader", None,
                                Shader=tree.node("ShaderNodeBsdfDiffuse", Color=(0.3, 0.25, 0.2, 1)),
                                Shader_001=tree.node("ShaderNodeEmission", Strength=0.3)))


# Texture look-up -------------------------------------------------------------------------------------------------

def placed(tree, kind="UV", **mapping):
    place = tree.node("ShaderNodeTexCoord").outputs[kind]
    return tree.node("ShaderNodeMapping", None, Vector=place, **mapping)


@scene(samples=(64, 320))
def texture_mapped():
    show(lambda tree: tree.node("ShaderNodeBsdfDiffuse", Color=textured(
        tree, pictures.chart(), placed(tree, Location=(0.1, 0.3, 0), Rotation=(0, 0, 0.5), Scale=(1.7, 0.8, 1)))))


@scene(run="long")
def texture_closest_clipped():
    show(lambda tree: tree.node("ShaderNodeBsdfDiffuse", Color=textured(
        tree, pictures.chart(), placed(tree, Location=(-0.2, -0.2, 0), Scale=(1.4, 1.4, 1)),
        interpolation='Closest', extension='CLIP')))


@scene(run="long")
def texture_generated():
    show(lambda tree: tree.node("ShaderNodeBsdfDiffuse", Color=textured(
        tree, pictures.chart(), placed(tree, "Generated"), extension='EXTEND')))


@scene(samples=(64, 320))
def texture_with_alpha():
    """Alpha that no node uses multiplies the colours, before they are decoded."""
    show(lambda tree: tree.node("ShaderNodeBsdfDiffuse", Color=textured(tree, pictures.chart(alpha=0.5))))


@scene()
def normal_map():
    def build(tree):
        bumpy = tree.node("ShaderNodeNormalMap", None, Color=textured(tree, pictures.bumps()), Strength=0.8)
        return tree.node("ShaderNodeBsdfDiffuse", Color=PALE, Normal=bumpy)
    show(build)
