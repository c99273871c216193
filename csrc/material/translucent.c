/* Diffuse transmission without a change of index: what arrives on one side leaves on the other, cosine-distributed. */
#include "material/lobe.h"

static float evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    return to_light.z * to_camera.z < 0
               ? spectral_value_eval(&lobe->color[0], lambda) * fabsf(to_light.z) / PI_F
               : 0;
}

static float pdf(const struct lobe *lobe, enum side side, struct vec3 arriving, struct vec3 leaving,
                 float lambda)
{
    (void)lobe, (void)side, (void)lambda;
    return arriving.z * leaving.z < 0 ? fabsf(leaving.z) / PI_F : 0;
}

static bool sample(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda,
                   const float u[3], struct vec3 *leaving)
{
    return diffuse_sample(lobe, side, vec3(0, 0, -arriving.z), lambda, u, leaving);
}

static float transmittance(const struct lobe *lobe, float z, float lambda)
{
    (void)z;
    return spectral_value_eval(&lobe->color[0], lambda);
}

static bool transmittance_integral(const struct lobe *lobe, float z, float a, float b, double *integral)
{
    (void)z;
    return spectral_value_integral(&lobe->color[0], a, b, integral);
}

static const struct lobe_kind lobe_translucent = {
    .name = "translucent",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_DIFFUSE,
    .albedo = transmittance,
    .albedo_integral = transmittance_integral,
    .evaluate = evaluate,
    .pdf = pdf,
    .sample = sample,
};

static bool shade(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    (void)plan;
    lobe->color[0] = in->color[0];
    lobe->kind = &lobe_translucent;
    return true;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    return !closure_color_is_present(closure, 0) || compiler_add(compiler, closure, shade, NULL, NULL);
}

const struct bsdf_kind bsdf_translucent = {
    .signature = {.name = "translucent", .color_names = {"reflectance"}},
    .color_defaults = {0.8f},
    .compile = compile,
};
