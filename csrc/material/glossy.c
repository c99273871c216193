/* Microfacet reflection without Fresnel: Cycles' Glossy BSDF with GGX, or Multiscatter GGX by compensation. */
#include "material/albedo.h"
#include "material/microfacet.h"

/* parameter[0] and [1] are those of microfacet.h. */
enum { ROUGHNESS = 2 };

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

static float evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    float value = microfacet_evaluate(lobe, to_light, to_camera, lambda);
    if (value == 0 || !lobe->data)
        return value;
    return value * albedo_compensation(lobe->data, lobe->parameter[ROUGHNESS], to_camera.z,
                                       reflectance(lobe, 1, lambda));
}

static const struct lobe_kind lobe_glossy = {
    .name = "glossy",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .albedo_integral = reflectance_integral,
    .reflectance = reflectance,
    .evaluate = evaluate,
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
    lobe->color[0] = in->color[0];
    lobe->parameter[0] = alpha_of_roughness(in->value[0]);
    lobe->parameter[1] = plan->closure->number[0] == 3 && !plan->data;
    lobe->parameter[ROUGHNESS] = clampf(in->value[0], 0, 1);
    lobe->kind = in->value[0] < SMOOTH_ROUGHNESS ? &lobe_mirror : &lobe_glossy;
    return true;
}

static void table_destroy(void *data)
{
    albedo_table_destroy(data);
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    struct albedo_table *table = NULL;
    if (!compiler_check_model(compiler, closure->number[0]))
        return false;
    if (!closure_color_is_present(closure, 0))
        return true;
    if (closure->option[0] && !(table = albedo_table_create(ALBEDO_WHITE, 1, closure, 0)))
        return compiler_fail(compiler, "", "out of memory");
    return compiler_add(compiler, closure, shade, table, table_destroy);
}

const struct bsdf_kind bsdf_glossy = {
    .signature =
        {
            .name = "glossy",
            .color_names = {"color"},
            .value_names = {"roughness"},
            .option_names = {"multi_scatter"},
            .option_choices = {{"false", "true"}},
            .number_names = {"model"},
            .number_defaults = {4},
        },
    .color_defaults = {0.8f},
    .value_defaults = {0.5f},
    .compile = compile,
};
