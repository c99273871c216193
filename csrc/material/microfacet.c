/* What all reflecting microfacet lobes share: evaluation, density and sampling, and their smooth limit. */
#include "material/microfacet.h"

float fresnel_conductor(float cosine, float eta, float k)
{
    float c2 = cosine * cosine, s2 = 1 - c2;
    float d = eta * eta - k * k - s2, ab = sqrtf(d * d + 4 * square(eta * k));
    float a = sqrtf(fmaxf(0, 0.5f * (ab + d)));
    float s = (ab + c2 - 2 * cosine * a) / (ab + c2 + 2 * cosine * a);
    float p = s * (c2 * ab + s2 * s2 - 2 * cosine * a * s2) / (c2 * ab + s2 * s2 + 2 * cosine * a * s2);
    return 0.5f * (s + p);
}

float reflectance_albedo(const struct lobe *lobe, float z, float lambda)
{
    return lobe->kind->reflectance(lobe, fabsf(z), lambda);
}

float microfacet_evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    if (to_light.z * to_camera.z <= 0)
        return 0;
    if (to_light.z < 0) {
        to_light = mirrored(to_light);
        to_camera = mirrored(to_camera);
    }
    float alpha = lobe->parameter[0];
    struct vec3 h = normalize(add(to_light, to_camera));
    float g = ggx_g2(ggx_lambda(to_light, alpha), ggx_lambda(to_camera, alpha), lobe->parameter[1] != 0);
    float reflectance = lobe->kind->reflectance(lobe, fminf(1, dot(to_light, h)), lambda);
    return reflectance * ggx_d(h, alpha) * g / (4 * to_camera.z);
}

float microfacet_pdf(const struct lobe *lobe, enum side side, struct vec3 arriving, struct vec3 leaving,
                     float lambda)
{
    (void)side, (void)lambda;
    if (arriving.z * leaving.z <= 0)
        return 0;
    float alpha = lobe->parameter[0];
    struct vec3 h = normalize(add(arriving, leaving)); /* D is even in z */
    return ggx_d(h, alpha) / (4 * fabsf(arriving.z) * (1 + ggx_lambda(arriving, alpha)));
}

bool microfacet_sample(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda,
                       const float u[3], struct vec3 *leaving)
{
    (void)side, (void)lambda;
    bool back = arriving.z < 0;
    struct vec3 a = back ? mirrored(arriving) : arriving;
    struct vec3 b = reflect(a, ggx_sample(a, lobe->parameter[0], u[0], u[1]));
    *leaving = back ? mirrored(b) : b;
    return b.z > 0;
}

bool mirror_scatter(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda, float u,
                    struct delta *out)
{
    (void)side, (void)u;
    *out = (struct delta){
        .leaving = vec3(-arriving.x, -arriving.y, arriving.z),
        .coefficient = lobe->kind->reflectance(lobe, fabsf(arriving.z), lambda),
        .probability = 1,
        .n_squared = 1,
        .depth_class = SCATTER_GLOSSY,
    };
    return true;
}
