/* Fresnel's formulae and the GGX microfacet distribution (Walter et al. 2007; Heitz 2014), in a frame about the shading normal.
   Slopes are computed from x and y, never from 1 − z², which a float cannot hold for smooth surfaces. */
#ifndef MATERIAL_MICROFACET_H
#define MATERIAL_MICROFACET_H

#include "material/lobe.h"

static inline float square(float x)
{
    return x * x;
}

/* Unpolarised reflectance at a cosine ≥ 0 on the side of index 1; eta is the index on the other side. 1 in total reflection. */
static inline float fresnel_dielectric(float cosine, float eta)
{
    float t2 = 1 - (1 - cosine * cosine) / (eta * eta);
    if (t2 <= 0)
        return 1;
    float t = sqrtf(t2);
    float s = (cosine - eta * t) / (cosine + eta * t), p = (eta * cosine - t) / (eta * cosine + t);
    return 0.5f * (s * s + p * p);
}

static inline float fresnel_f0(float eta)
{
    return square((eta - 1) / (eta + 1));
}

/* ∫ 2 cos F d cos of a dielectric: the fits of Kulla & Conty 2017. */
static inline float fresnel_mean(float eta)
{
    return eta < 1 ? 0.997118f + eta * (0.1014f - eta * (0.965241f + eta * 0.130607f))
                   : (eta - 1) / (4.08567f + 1.00071f * eta);
}

/* Unpolarised reflectance of a conductor η + ik in vacuum, without approximation (Born & Wolf §14.2). */
float fresnel_conductor(float cosine, float eta, float k);

static inline float schlick_weight(float cosine)
{
    float m = clampf(1 - cosine, 0, 1);
    return square(square(m)) * m;
}

/* On the side of index 1 along `a` (a·h > 0), into eta. False in total reflection. */
static inline bool refract(struct vec3 a, struct vec3 h, float eta, struct vec3 *b)
{
    float cosine = dot(a, h), t2 = 1 - (1 - cosine * cosine) / (eta * eta);
    if (t2 <= 0)
        return false;
    *b = normalize(along(scale(a, -1 / eta), h, cosine / eta - sqrtf(t2)));
    return true;
}

static inline struct vec3 reflect(struct vec3 a, struct vec3 h)
{
    return normalize(along(negate(a), h, 2 * dot(a, h)));
}

/* Density of microfacet normals, per solid angle: ∫ D cos = 1. */
static inline float ggx_d(struct vec3 h, float alpha)
{
    float a2 = alpha * alpha, q = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    return a2 / (PI_F * q * q);
}

/* Smith's Λ. */
static inline float ggx_lambda(struct vec3 w, float alpha)
{
    return 0.5f * (sqrtf(1 + alpha * alpha * (w.x * w.x + w.y * w.y) / (w.z * w.z)) - 1);
}

/* Masking and shadowing: correlated by height, or (as Cycles had it before 4.0) the product of both. */
static inline float ggx_g2(float lambda_a, float lambda_b, bool separable)
{
    return separable ? 1 / ((1 + lambda_a) * (1 + lambda_b)) : 1 / (1 + lambda_a + lambda_b);
}

/* A normal that is visible from w (w.z > 0), by a spherical cap (Dupuy & Benyoub 2023); its density is D·G1(w)·(w·h)/w.z. */
static inline struct vec3 ggx_sample(struct vec3 w, float alpha, float u, float v)
{
    struct vec3 stretched = normalize(vec3(alpha * w.x, alpha * w.y, w.z));
    float z = 1 - u * (1 + stretched.z), r = sqrtf(fmaxf(0, 1 - z * z)), phi = 2 * PI_F * v;
    struct vec3 h = add(vec3(r * cosf(phi), r * sinf(phi), z), stretched);
    return normalize(vec3(alpha * h.x, alpha * h.y, fmaxf(h.z, 1e-7f)));
}

static inline struct vec3 mirrored(struct vec3 w)
{
    return vec3(w.x, w.y, -w.z);
}

/* Functions of reflecting lobes: parameter[0] is α, parameter[1] ≠ 0 asks for separable masking; kind->reflectance colours. */
float microfacet_evaluate(const struct lobe *, struct vec3 to_light, struct vec3 to_camera, float lambda);
float microfacet_pdf(const struct lobe *, enum side, struct vec3 arriving, struct vec3 leaving, float lambda);
bool microfacet_sample(const struct lobe *, enum side, struct vec3 arriving, float lambda, const float u[3],
                       struct vec3 *leaving);
/* A smooth one, both faces. */
bool mirror_scatter(const struct lobe *, enum side, struct vec3 arriving, float lambda, float u,
                    struct delta *);
/* The kind's reflectance as seen along z. */
float reflectance_albedo(const struct lobe *, float z, float lambda);

#endif
