/* Diffuse reflection, both faces: Lambert, and Oren–Nayar in the form that Cycles uses (Fujii's, after Oren & Nayar 1994), since
   Blender 4.3 with the light of several bounces. */
#include "material/lobe.h"

enum { ROUGHNESS, MULTI_SCATTER };

float diffuse_pdf(const struct lobe *lobe, enum side side, struct vec3 arriving, struct vec3 leaving,
                  float lambda)
{
    (void)lobe, (void)side, (void)lambda;
    return arriving.z * leaving.z > 0 ? fabsf(leaving.z) / PI_F : 0;
}

bool diffuse_sample(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda,
                    const float u[3], struct vec3 *leaving)
{
    (void)lobe, (void)side, (void)lambda;
    *leaving = cosine_hemisphere(u[0], u[1]);
    leaving->z = copysignf(leaving->z, arriving.z);
    return leaving->z != 0;
}

static float lambert(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    return to_light.z * to_camera.z > 0
               ? spectral_value_eval(&lobe->color[0], lambda) * fabsf(to_light.z) / PI_F
               : 0;
}

static float reflectance(const struct lobe *lobe, float z, float lambda)
{
    (void)z;
    return spectral_value_eval(&lobe->color[0], lambda);
}

static bool reflectance_integral(const struct lobe *lobe, float z, float a, float b, double *integral)
{
    (void)z;
    return spectral_value_integral(&lobe->color[0], a, b, integral);
}

static bool reflectance_terms(const struct lobe *lobe, enum part part, struct part_terms *terms)
{
    *terms = (struct part_terms){.constant = 1};
    return part == PART_KEPT || spectral_value_terms(&lobe->color[0], terms);
}

/* Fujii's A = 1/(π + (π/2 − 2/3) σ), B = σ A: f = A + B t. */
static float fujii_a(float sigma)
{
    return 1 / (PI_F + (0.5f * PI_F - 2.0f / 3) * sigma);
}

/* Directional albedo of A + B t by B's part: π A + B G(cos) (the integral over the other direction). */
static float fujii_albedo(float sigma, float cosine)
{
    float a = fujii_a(sigma), sine = sqrtf(fmaxf(0, 1 - cosine * cosine)), g;
    if (cosine < 1e-6f)
        g = 0.5f * PI_F - 2.0f / 3 - cosine;
    else
        g = sine * (acosf(fminf(1, cosine)) - 2.0f / 3 - sine * cosine) +
            2.0f / 3 * sine / cosine * (1 - sine * sine * sine);
    return a * (PI_F + sigma * g);
}

/* Further bounces leave as (1 − E_l)(1 − E_c), scaled by what they keep; as in Cycles, whose colour enters squared here. */
static float fujii_bounces(float sigma, float cl, float cc, float color)
{
    float a = fujii_a(sigma), mean = a * (PI_F + sigma * (2 * PI_F - 5.6f) / 3);
    float kept = color * color * mean / ((1 - mean) * (1 - color * (1 - mean)));
    return kept * (1 - fujii_albedo(sigma, cl)) * (1 - fujii_albedo(sigma, cc)) / PI_F;
}

static float oren_nayar(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    if (to_light.z * to_camera.z <= 0)
        return 0;
    float sigma = lobe->parameter[ROUGHNESS], cl = fabsf(to_light.z), cc = fabsf(to_camera.z);
    float color = spectral_value_eval(&lobe->color[0], lambda), t = dot(to_light, to_camera) - cl * cc;
    if (t > 0)
        t /= fmaxf(cl, cc);
    float f = fujii_a(sigma) * (1 + sigma * t);
    if (lobe->parameter[MULTI_SCATTER] != 0)
        f += fujii_bounces(sigma, cl, cc, color);
    return color * f * cl;
}

const struct lobe_kind lobe_diffuse = {
    .name = "diffuse",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_DIFFUSE,
    .is_lambert = true,
    .albedo = reflectance,
    .albedo_integral = reflectance_integral,
    .terms = reflectance_terms,
    .evaluate = lambert,
    .pdf = diffuse_pdf,
    .sample = diffuse_sample,
};

static const struct lobe_kind lobe_oren_nayar = {
    .name = "diffuse, rough",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_DIFFUSE,
    .albedo = reflectance,
    .albedo_integral = reflectance_integral,
    .terms = reflectance_terms,
    .evaluate = oren_nayar,
    .pdf = diffuse_pdf,
    .sample = diffuse_sample,
};

static bool shade(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    lobe->color[0] = in->color[0];
    lobe->parameter[MULTI_SCATTER] = (float)plan->closure->option[0];
    lobe->parameter[ROUGHNESS] = clampf(in->value[0], 0, 1);
    lobe->kind = in->value[0] > 0 ? &lobe_oren_nayar : &lobe_diffuse;
    return true;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    return !closure_color_is_present(closure, 0) || compiler_add(compiler, closure, shade, NULL, NULL);
}

const struct bsdf_kind bsdf_diffuse = {
    .signature = {.name = "diffuse",
                  .color_names = {"reflectance"},
                  .value_names = {"roughness"},
                  .option_names = {"multi_scatter"},
                  .option_choices = {{"false", "true"}}},
    .color_defaults = {0.8f},
    .compile = compile,
};
