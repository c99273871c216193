/* Diffuse reflection, both faces: Lambert, and Oren–Nayar in the form that Cycles uses (Fujii's, after Oren & Nayar 1994). */
#include "material/lobe.h"

enum { ROUGHNESS };

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

static float oren_nayar(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    if (to_light.z * to_camera.z <= 0)
        return 0;
    float sigma = lobe->parameter[ROUGHNESS], cl = fabsf(to_light.z), cc = fabsf(to_camera.z);
    float t = dot(to_light, to_camera) - cl * cc;
    if (t > 0)
        t /= fmaxf(cl, cc);
    float f = (1 + sigma * t) / (PI_F + (0.5f * PI_F - 2.0f / 3.0f) * sigma);
    return spectral_value_eval(&lobe->color[0], lambda) * f * cl;
}

const struct lobe_kind lobe_diffuse = {
    .name = "diffuse",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_DIFFUSE,
    .albedo = reflectance,
    .albedo_integral = reflectance_integral,
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
    .evaluate = oren_nayar,
    .pdf = diffuse_pdf,
    .sample = diffuse_sample,
};

static bool shade(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->color[0] = in->color[0];
    lobe->parameter[ROUGHNESS] = clampf(in->value[0], 0, 1);
    lobe->kind = in->value[0] > 0 ? &lobe_oren_nayar : &lobe_diffuse;
    return true;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    return !closure_color_is_present(closure, 0) || compiler_add(compiler, closure, shade, NULL, NULL);
}

const struct bsdf_kind bsdf_diffuse = {
    .signature = {.name = "diffuse", .color_names = {"reflectance"}, .value_names = {"roughness"}},
    .color_defaults = {0.8f},
    .compile = compile,
};
