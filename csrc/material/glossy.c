/* Microfacet reflection without Fresnel: Cycles' Glossy BSDF with GGX. */
#include "material/microfacet.h"

static float reflectance(const struct lobe *lobe, float cosine, float lambda)
{
    (void)cosine;
    return spectral_value_eval(&lobe->color[0], lambda);
}

static bool reflectance_integral(const struct lobe *lobe, float z, float a, float b, double *integral)
{
    (void)z;
    return spectral_value_integral(&lobe->color[0], a, b, integral);
}

static const struct lobe_kind lobe_glossy = {
    .name = "glossy",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .albedo_integral = reflectance_integral,
    .reflectance = reflectance,
    .evaluate = microfacet_evaluate,
    .pdf = microfacet_pdf,
    .sample = microfacet_sample,
};

static const struct lobe_kind lobe_mirror = {
    .name = "glossy, smooth",
    .nature = LOBE_DELTA,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = reflectance,
    .scatter = mirror_scatter,
};

static bool shade(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->color[0] = in->color[0];
    lobe->parameter[0] = alpha_of_roughness(in->value[0]);
    lobe->parameter[1] = 0;
    lobe->kind = in->value[0] < SMOOTH_ROUGHNESS ? &lobe_mirror : &lobe_glossy;
    return true;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    return !closure_color_is_present(closure, 0) || compiler_add(compiler, closure, shade, NULL, NULL);
}

const struct bsdf_kind bsdf_glossy = {
    .signature = {.name = "glossy", .color_names = {"color"}, .value_names = {"roughness"}},
    .color_defaults = {0.8f},
    .value_defaults = {0.5f},
    .compile = compile,
};
