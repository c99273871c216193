/* Principled as in Blender 4.x: metal (F82-tint), glass, and a dielectric layer over a Lambertian base that gets what the layer's
   albedo leaves. Layering and energy compensation look toward the camera, as Cycles' do, so they are not reciprocal. */
#include <stdlib.h>

#include "material/dielectric.h"
#include "material/microfacet.h"
#include "material/principled.h"

#define SHARE_TABLES 8

/* Tables of one closure. Its two upper lobes and the base share them; the plan made first owns them. */
struct tables {
    struct albedo_table *white;               /* NULL: no energy compensation */
    struct albedo_table *share[SHARE_TABLES]; /* at F0^¼ from low to high; one where specular is constant */
    int share_count;
    float low, high;
};

static void tables_destroy(void *data)
{
    struct tables *t = data;
    if (!t)
        return;
    albedo_table_destroy(t->white);
    for (int i = 0; i < t->share_count; i++)
        albedo_table_destroy(t->share[i]);
    free(t);
}

static const struct tables *tables_of(const struct lobe *lobe)
{
    return lobe->data;
}

/* parameter[0] and [1] are those of microfacet.h. */
enum { ROUGHNESS = 2, F0, ETA };

/* --- Metal ----------------------------------------------------------------------------------------------- */

/* F82-tint (Kutz et al. 2021): Schlick less b·cos·(1 − cos)⁶, b such that a tint multiplies Schlick at cos = 1/7. */
static float f82_dip(float f0, float tint)
{
    float m = 6.0f / 7, m5 = square(square(m)) * m;
    return lerpf(f0, 1, m5) * 7 / (m5 * m) * (1 - tint);
}

static float metal_reflectance(const struct lobe *lobe, float cosine, float lambda)
{
    float f0 = spectral_value_eval(&lobe->color[PRINCIPLED_BASE], lambda);
    float tint = spectral_value_eval(&lobe->color[PRINCIPLED_TINT], lambda), m5 = schlick_weight(cosine);
    return saturate(lerpf(f0, 1, m5) - f82_dip(f0, tint) * cosine * m5 * (1 - cosine));
}

static float metal_evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera,
                            float lambda)
{
    float value = microfacet_evaluate(lobe, to_light, to_camera, lambda);
    if (value == 0)
        return 0;
    float f0 = spectral_value_eval(&lobe->color[PRINCIPLED_BASE], lambda);
    float tint = spectral_value_eval(&lobe->color[PRINCIPLED_TINT], lambda);
    /* ∫ 2 cos F d cos of F82-tint. */
    float mean = saturate(lerpf(f0, 1, 1.0f / 21) - f82_dip(f0, tint) / 126);
    return value * albedo_compensation(tables_of(lobe)->white, lobe->parameter[ROUGHNESS], to_camera.z, mean);
}

static const struct lobe_kind lobe_metal = {
    .name = "principled 4, metal",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = metal_reflectance,
    .evaluate = metal_evaluate,
    .pdf = microfacet_pdf,
    .sample = microfacet_sample,
};

static const struct lobe_kind lobe_smooth_metal = {
    .name = "principled 4, smooth metal",
    .nature = LOBE_DELTA,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = metal_reflectance,
    .scatter = mirror_scatter,
};

static void shade_facets(const struct inputs *in, struct lobe *lobe)
{
    lobe->parameter[0] = alpha_of_roughness(saturate(in->value[PRINCIPLED_ROUGHNESS]));
    lobe->parameter[1] = 0;
    lobe->parameter[ROUGHNESS] = saturate(in->value[PRINCIPLED_ROUGHNESS]);
    lobe->color[PRINCIPLED_BASE] = in->color[PRINCIPLED_BASE];
    lobe->color[PRINCIPLED_TINT] = in->color[PRINCIPLED_TINT];
}

static bool shade_metal(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->weight *= saturate(in->value[PRINCIPLED_METALLIC]);
    shade_facets(in, lobe);
    lobe->kind = lobe->parameter[ROUGHNESS] < SMOOTH_ROUGHNESS ? &lobe_smooth_metal : &lobe_metal;
    return lobe->weight > 0;
}

/* --- The dielectric layer -------------------------------------------------------------------------------- */

/* F0 and index of the layer: `specular` scales F0, ½ leaves the index as it is. */
static void shade_layer(const struct closure *closure, const struct inputs *in, struct lobe *lobe)
{
    float ior = (float)closure->number[PRINCIPLED_IOR], level = fmaxf(in->value[PRINCIPLED_SPECULAR], 0);
    float f0 = fminf(fresnel_f0(ior) * 2 * level, 0.99f), root = sqrtf(f0), eta = (1 + root) / (1 - root);
    shade_facets(in, lobe);
    lobe->parameter[F0] = f0;
    lobe->parameter[ETA] = ior < 1 ? 1 / eta : eta;
}

static float layer_f0(const struct lobe *lobe, float lambda)
{
    return saturate(lobe->parameter[F0] * spectral_value_eval(&lobe->color[PRINCIPLED_TINT], lambda));
}

static float layer_reflectance(const struct lobe *lobe, float cosine, float lambda)
{
    float f0 = lobe->parameter[F0], f = fresnel_dielectric(cosine, lobe->parameter[ETA]);
    return lerpf(layer_f0(lobe, lambda), 1, saturate((f - f0) / (1 - f0)));
}

/* Mean reflectance of the layer's facets. */
static float layer_facets(const struct lobe *lobe, float lambda)
{
    float f0 = lobe->parameter[F0], mean = fresnel_mean(lobe->parameter[ETA]);
    return lerpf(layer_f0(lobe, lambda), 1, saturate((mean - f0) / (1 - f0)));
}

static float layer_evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera,
                            float lambda)
{
    float value = microfacet_evaluate(lobe, to_light, to_camera, lambda);
    return value == 0 ? 0
                      : value * albedo_compensation(tables_of(lobe)->white, lobe->parameter[ROUGHNESS],
                                                    to_camera.z, layer_facets(lobe, lambda));
}

static const struct lobe_kind lobe_layer = {
    .name = "principled 4, layer",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = layer_reflectance,
    .evaluate = layer_evaluate,
    .pdf = microfacet_pdf,
    .sample = microfacet_sample,
};

static const struct lobe_kind lobe_smooth_layer = {
    .name = "principled 4, smooth layer",
    .nature = LOBE_DELTA,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = layer_reflectance,
    .scatter = mirror_scatter,
};

static float opaque_weight(const struct inputs *in)
{
    return (1 - saturate(in->value[PRINCIPLED_METALLIC])) *
           (1 - saturate(in->value[PRINCIPLED_TRANSMISSION]));
}

static bool shade_specular(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    lobe->weight *= opaque_weight(in);
    shade_layer(plan->closure, in, lobe);
    lobe->kind = lobe->parameter[ROUGHNESS] < SMOOTH_ROUGHNESS ? &lobe_smooth_layer : &lobe_layer;
    return lobe->weight > 0 && lobe->parameter[ETA] != 1;
}

/* --- The base under it ------------------------------------------------------------------------------------ */

static float fresnel_share(const struct lobe *lobe, float cosine)
{
    const struct tables *t = tables_of(lobe);
    float roughness = lobe->parameter[ROUGHNESS];
    if (t->share_count == 1)
        return albedo_at(t->share[0], roughness, cosine);
    float x = (sqrtf(sqrtf(lobe->parameter[F0])) - t->low) / (t->high - t->low) * (float)(t->share_count - 1);
    x = clampf(x, 0, (float)(t->share_count - 1));
    int i = (int)fminf(x, (float)(t->share_count - 2));
    return lerpf(albedo_at(t->share[i], roughness, cosine), albedo_at(t->share[i + 1], roughness, cosine),
                 x - (float)i);
}

/* What the layer's albedo leaves, seen along a cosine. */
static float base_share(const struct lobe *lobe, float cosine, float lambda)
{
    const struct tables *t = tables_of(lobe);
    float roughness = lobe->parameter[ROUGHNESS];
    if (lobe->parameter[ETA] == 1)
        return 1;
    float albedo = lerpf(layer_f0(lobe, lambda), 1, fresnel_share(lobe, cosine));
    if (t->white) /* E·compensation: 1 for facets that absorb nothing */
        albedo *= albedo_at(t->white, roughness, cosine) *
                  albedo_compensation(t->white, roughness, cosine, layer_facets(lobe, lambda));
    return saturate(1 - albedo);
}

static float base_albedo(const struct lobe *lobe, float z, float lambda)
{
    return spectral_value_eval(&lobe->color[PRINCIPLED_BASE], lambda) * base_share(lobe, fabsf(z), lambda);
}

static float base_evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    return to_light.z * to_camera.z > 0 ? base_albedo(lobe, to_camera.z, lambda) * fabsf(to_light.z) / PI_F
                                        : 0;
}

static const struct lobe_kind lobe_base = {
    .name = "principled 4, base",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_DIFFUSE,
    .albedo = base_albedo,
    .evaluate = base_evaluate,
    .pdf = diffuse_pdf,
    .sample = diffuse_sample,
};

static bool shade_base(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    lobe->weight *= opaque_weight(in);
    shade_layer(plan->closure, in, lobe);
    lobe->kind = &lobe_base;
    return lobe->weight > 0;
}

/* --- Glass ----------------------------------------------------------------------------------------------- */

static bool shade_glass(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->weight *=
        saturate(in->value[PRINCIPLED_TRANSMISSION]) * (1 - saturate(in->value[PRINCIPLED_METALLIC]));
    lobe->color[0] = spectral_flat(1);
    lobe->color[1] = in->color[PRINCIPLED_BASE];
    lobe->color[2] = in->color[PRINCIPLED_TINT];
    dielectric_shade(lobe, in->value[PRINCIPLED_ROUGHNESS],
                     (struct dielectric_look){.tinted = 1, .halved = true});
    return lobe->weight > 0;
}

static bool compile_glass(struct compiler *compiler, const struct closure *closure)
{
    struct ior ior = {IOR_CONSTANT, {closure->number[PRINCIPLED_IOR]}};
    struct dielectric *d = dielectric_create(
        compiler, ior, closure, closure->option[PRINCIPLED_MULTI_SCATTER] ? PRINCIPLED_ROUGHNESS : -1);
    return d && compiler_add(compiler, closure, shade_glass, d, dielectric_destroy);
}

/* --- Compiling ------------------------------------------------------------------------------------------- */

static struct tables *tables_create(const struct closure *closure)
{
    float level, ior = (float)closure->number[PRINCIPLED_IOR];
    struct tables *t = calloc(1, sizeof *t);
    if (!t)
        return NULL;
    bool fixed = closure_value_is_constant(closure, PRINCIPLED_SPECULAR, &level), made = true;
    t->low = fixed ? powf(clampf(fresnel_f0(ior) * 2 * level, 1e-6f, 0.99f), 0.25f) : 0.05f;
    t->high = fixed ? t->low : 0.99f;
    t->share_count = fixed ? 1 : SHARE_TABLES;
    for (int i = 0; i < t->share_count; i++) {
        float z = fixed ? t->low : lerpf(t->low, t->high, (float)i / (SHARE_TABLES - 1)), root = z * z;
        float eta = (1 + root) / (1 - root);
        t->share[i] =
            albedo_table_create(ALBEDO_FRESNEL_SHARE, ior < 1 ? 1 / eta : eta, closure, PRINCIPLED_ROUGHNESS);
        made = made && t->share[i];
    }
    if (closure->option[PRINCIPLED_MULTI_SCATTER])
        made = (t->white = albedo_table_create(ALBEDO_WHITE, 1, closure, PRINCIPLED_ROUGHNESS)) && made;
    if (!made) {
        tables_destroy(t);
        return NULL;
    }
    return t;
}

bool principled4_compile(struct compiler *compiler, const struct closure *closure)
{
    bool metal = principled_can_exceed(closure, PRINCIPLED_METALLIC, 0);
    bool dielectric = principled_can_stay_below(closure, PRINCIPLED_METALLIC, 1);
    bool glass = dielectric && principled_can_exceed(closure, PRINCIPLED_TRANSMISSION, 0);
    bool opaque = dielectric && principled_can_stay_below(closure, PRINCIPLED_TRANSMISSION, 1);
    bool layer = opaque && principled_can_exceed(closure, PRINCIPLED_SPECULAR, 0) &&
                 closure->number[PRINCIPLED_IOR] != 1;
    bool base = opaque && closure_color_is_present(closure, PRINCIPLED_BASE);
    bool (*const shade[])(const struct lobe_plan *, const struct inputs *,
                          struct lobe *) = {shade_metal, shade_specular, shade_base};
    const bool wanted[] = {metal, layer, base};
    if (glass && !compile_glass(compiler, closure))
        return false;
    struct tables *tables = metal || layer || base ? tables_create(closure) : NULL;
    if (!tables)
        return !(metal || layer || base) || compiler_fail(compiler, "", "out of memory");
    for (int i = 0, first = 1; i < 3; i++)
        if (wanted[i]) {
            if (!compiler_add(compiler, closure, shade[i], tables, first ? tables_destroy : NULL))
                return false;
            first = 0;
        }
    return true;
}
