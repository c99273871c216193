/* Principled as in Blender 3.x: Burley's diffuse (2012), one GGX lobe for dielectric and metal whose Fresnel runs from a specular
   colour to white, and glass. Layers are not weighted by albedo, so energy may exceed what arrives by some per cent, as there. */
#include "material/dielectric.h"
#include "material/microfacet.h"
#include "material/principled.h"

/* What of the roughness up to Cycles renders with single scattering even if asked for more. */
#define SINGLE_SCATTER_ROUGHNESS 0.075f

/* --- Diffuse --------------------------------------------------------------------------------------------- */

enum { DIFFUSE_ROUGHNESS };

static float diffuse_albedo(const struct lobe *lobe, float z, float lambda)
{
    (void)z;
    return spectral_value_eval(&lobe->color[0], lambda);
}

static bool diffuse_integral(const struct lobe *lobe, float z, float a, float b, double *integral)
{
    (void)z;
    return spectral_value_integral(&lobe->color[0], a, b, integral);
}

/* Burley 2012 with the retro-reflection of Burley 2015, §2.3. */
static float burley(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    if (to_light.z * to_camera.z <= 0)
        return 0;
    float fl = schlick_weight(fabsf(to_light.z)), fc = schlick_weight(fabsf(to_camera.z));
    float rr = lobe->parameter[DIFFUSE_ROUGHNESS] * (dot(to_light, to_camera) + 1);
    float f = (1 - 0.5f * fl) * (1 - 0.5f * fc) + rr * (fl + fc + fl * fc * (rr - 1));
    return spectral_value_eval(&lobe->color[0], lambda) * f * fabsf(to_light.z) / PI_F;
}

static const struct lobe_kind lobe_burley = {
    .name = "principled 3, diffuse",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_DIFFUSE,
    .albedo = diffuse_albedo,
    .albedo_integral = diffuse_integral,
    .evaluate = burley,
    .pdf = diffuse_pdf,
    .sample = diffuse_sample,
};

static bool shade_diffuse(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->weight *=
        (1 - saturate(in->value[PRINCIPLED_METALLIC])) * (1 - saturate(in->value[PRINCIPLED_TRANSMISSION]));
    lobe->color[0] = in->color[PRINCIPLED_BASE];
    lobe->parameter[DIFFUSE_ROUGHNESS] = saturate(in->value[PRINCIPLED_ROUGHNESS]);
    lobe->kind = &lobe_burley;
    return lobe->weight > 0;
}

/* --- Specular -------------------------------------------------------------------------------------------- */

/* parameter[0] and [1] are those of microfacet.h. */
enum { METALLIC = 2, F0, INVERSE_LUMINANCE, SPECULAR_ROUGHNESS };

/* At a share of the way from the colour at normal incidence to white. */
static float specular_color(const struct lobe *lobe, float toward_white, float lambda)
{
    float base = spectral_value_eval(&lobe->color[PRINCIPLED_BASE], lambda);
    float tint = spectral_value_eval(&lobe->color[PRINCIPLED_TINT], lambda);
    float dielectric = lobe->parameter[F0] * (1 - tint + tint * base * lobe->parameter[INVERSE_LUMINANCE]);
    float color = saturate(lerpf(dielectric, base, lobe->parameter[METALLIC]));
    return lerpf(color, 1, saturate(toward_white));
}

static float specular_index(const struct lobe *lobe)
{
    float root = sqrtf(lobe->parameter[F0]);
    return (1 + root) / (1 - root);
}

static float specular_reflectance(const struct lobe *lobe, float cosine, float lambda)
{
    float f0 = lobe->parameter[F0];
    return specular_color(lobe, (fresnel_dielectric(cosine, specular_index(lobe)) - f0) / (1 - f0), lambda);
}

/* Over all facets. */
static float specular_mean(const struct lobe *lobe, float lambda)
{
    float f0 = lobe->parameter[F0];
    return specular_color(lobe, (fresnel_mean(specular_index(lobe)) - f0) / (1 - f0), lambda);
}

static float specular_evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera,
                               float lambda)
{
    float value = microfacet_evaluate(lobe, to_light, to_camera, lambda),
          roughness = lobe->parameter[SPECULAR_ROUGHNESS];
    if (value == 0 || !lobe->data || roughness <= SINGLE_SCATTER_ROUGHNESS)
        return value;
    return value * albedo_compensation(lobe->data, roughness, to_camera.z, specular_mean(lobe, lambda));
}

static const struct lobe_kind lobe_specular = {
    .name = "principled 3, specular",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = specular_reflectance,
    .evaluate = specular_evaluate,
    .pdf = microfacet_pdf,
    .sample = microfacet_sample,
};

static const struct lobe_kind lobe_smooth_specular = {
    .name = "principled 3, smooth specular",
    .nature = LOBE_DELTA,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = reflectance_albedo,
    .reflectance = specular_reflectance,
    .scatter = mirror_scatter,
};

static bool shade_specular(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    float metallic = saturate(in->value[PRINCIPLED_METALLIC]),
          roughness = saturate(in->value[PRINCIPLED_ROUGHNESS]);
    float transmission = saturate(in->value[PRINCIPLED_TRANSMISSION]) * (1 - metallic);
    float specular = clampf(in->value[PRINCIPLED_SPECULAR], 0, 12),
          luminance = in->luminance[PRINCIPLED_BASE];
    if (closure_spectrum(plan->closure, PRINCIPLED_BASE))
        luminance = plan->luminance;
    bool compensated = plan->data && roughness > SINGLE_SCATTER_ROUGHNESS;
    lobe->weight *= 1 - transmission;
    lobe->color[PRINCIPLED_BASE] = in->color[PRINCIPLED_BASE];
    lobe->color[PRINCIPLED_TINT] =
        plan->closure->color[PRINCIPLED_TINT] ? in->color[PRINCIPLED_TINT] : spectral_flat(0);
    lobe->parameter[0] = alpha_of_roughness(roughness);
    lobe->parameter[1] = compensated ? 0 : 1;
    lobe->parameter[METALLIC] = metallic;
    lobe->parameter[F0] = 0.08f * specular;
    lobe->parameter[INVERSE_LUMINANCE] = luminance > 0 ? 1 / luminance : 1;
    lobe->parameter[SPECULAR_ROUGHNESS] = roughness;
    lobe->kind = roughness < SMOOTH_ROUGHNESS ? &lobe_smooth_specular : &lobe_specular;
    return lobe->weight > 0 && (specular > 1e-5f || metallic > 1e-5f);
}

/* Y under D65, relative to white: what a tint is normalised by. */
static float luminance_of(const struct spectrum *s)
{
    double sum = 0, white = 0;
    for (float l = CMF_MIN_NM; l <= CMF_MAX_NM; l += 1) {
        float xyz[3];
        cmf_eval(l, xyz);
        sum += (double)spectrum_eval(s, l) * xyz[1] * illuminant_d65(l);
        white += (double)xyz[1] * illuminant_d65(l);
    }
    return (float)(sum / white);
}

static void table_destroy(void *data)
{
    albedo_table_destroy(data);
}

static bool compile_specular(struct compiler *compiler, const struct closure *closure)
{
    struct albedo_table *table = NULL;
    if (closure->option[PRINCIPLED_MULTI_SCATTER]) {
        table = albedo_table_create(ALBEDO_WHITE, 1, closure, PRINCIPLED_ROUGHNESS);
        if (!table)
            return compiler_fail(compiler, "", "out of memory");
    }
    struct lobe_plan *plan = compiler_add(compiler, closure, shade_specular, table, table_destroy);
    if (plan && closure_spectrum(closure, PRINCIPLED_BASE))
        plan->luminance = luminance_of(closure_spectrum(closure, PRINCIPLED_BASE));
    return plan;
}

/* --- Glass ----------------------------------------------------------------------------------------------- */

static bool shade_glass(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    bool tinted = plan->closure->color[PRINCIPLED_TINT];
    lobe->weight *=
        saturate(in->value[PRINCIPLED_TRANSMISSION]) * (1 - saturate(in->value[PRINCIPLED_METALLIC]));
    lobe->color[0] = spectral_flat(1);
    lobe->color[1] = in->color[PRINCIPLED_BASE];
    lobe->color[2] = in->color[PRINCIPLED_BASE];
    /* The tint of 3.x is a number; its spectrum is flat. */
    float tint = tinted ? saturate(spectral_value_eval(&in->color[PRINCIPLED_TINT], 550)) : 0;
    dielectric_shade(lobe, in->value[PRINCIPLED_ROUGHNESS],
                     (struct dielectric_look){.tinted = tint,
                                              .model_3 = !plan->closure->option[PRINCIPLED_MULTI_SCATTER]});
    return lobe->weight > 0;
}

static bool compile_glass(struct compiler *compiler, const struct closure *closure)
{
    struct ior ior = {IOR_CONSTANT, {closure->number[PRINCIPLED_IOR]}};
    struct dielectric *d = dielectric_create(
        compiler, ior, closure, closure->option[PRINCIPLED_MULTI_SCATTER] ? PRINCIPLED_ROUGHNESS : -1);
    return d && compiler_add(compiler, closure, shade_glass, d, dielectric_destroy);
}

bool principled3_compile(struct compiler *compiler, const struct closure *closure)
{
    bool dielectric = principled_can_stay_below(closure, PRINCIPLED_METALLIC, 1);
    bool glass = dielectric && principled_can_exceed(closure, PRINCIPLED_TRANSMISSION, 0);
    bool opaque = principled_can_stay_below(closure, PRINCIPLED_TRANSMISSION, 1);
    bool specular = principled_can_exceed(closure, PRINCIPLED_SPECULAR, 1e-5f) ||
                    principled_can_exceed(closure, PRINCIPLED_METALLIC, 1e-5f);
    bool diffuse = dielectric && opaque && closure_color_is_present(closure, PRINCIPLED_BASE);
    if (specular && (opaque || !dielectric || principled_can_exceed(closure, PRINCIPLED_METALLIC, 0)) &&
        !compile_specular(compiler, closure))
        return false;
    if (glass && !compile_glass(compiler, closure))
        return false;
    return !diffuse || compiler_add(compiler, closure, shade_diffuse, NULL, NULL);
}
