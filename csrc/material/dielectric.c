/* An interface between vacuum (the side of ng) and a medium of index n(λ): smooth, or rough after Walter et al. 2007 with visible
   normals. Values carry (n_c/n_l)², because radiance scales by n² across an interface (algorithm.md §7; Veach 1997, §5.2). */
#include "material/dielectric.h"

#include <stdlib.h>
#include <string.h>

#include "material/microfacet.h"

enum { REFLECTED, TRANSMITTED, F0_TINT };
enum { ALPHA, BRANCHES, ROUGHNESS, TINTED, HALVED, MODEL_3 };

/* Below this |n − 1| a rough interface bends less than a float can say about its half vectors. */
#define INDEX_MATCHED 1e-4

static float inside_index(const struct lobe *lobe, float lambda)
{
    const struct dielectric *d = lobe->data;
    return d->disperses ? ior_eval(&d->ior, lambda) : (float)d->ior.term[0];
}

/* --- Coefficients ---------------------------------------------------------------------------------------- */

static enum dielectric_branches branches(const struct lobe *lobe)
{
    return (enum dielectric_branches)lobe->parameter[BRANCHES];
}

/* Chance of reflection where Fresnel says f. Colours stay out of it: what any wavelength of a run can do must have a positive
   chance at the leader's (algorithm.md §9). */
static float reflection_chance(const struct lobe *lobe, float f)
{
    switch (branches(lobe)) {
    case BRANCHES_BOTH: return f;
    case BRANCHES_REFLECT: return 1;
    case BRANCHES_REFRACT: return 0;
    }
    return f;
}

/* Fresnel's reflectance with F0 multiplied by a tint t, and 1 at grazing as ever: F + F0 (t − 1) (1 − F)/(1 − F0). */
static float tinted_fresnel(const struct lobe *lobe, float f, float n, float lambda)
{
    float f0 = fresnel_f0(n), tinted = lobe->parameter[TINTED];
    if (tinted == 0)
        return f;
    return f + f0 * tinted * (spectral_value_eval(&lobe->color[F0_TINT], lambda) - 1) * (1 - f) / (1 - f0);
}

static float reflected(const struct lobe *lobe, float f, float n, float lambda)
{
    if (branches(lobe) == BRANCHES_REFRACT)
        return 0;
    return spectral_value_eval(&lobe->color[REFLECTED], lambda) * tinted_fresnel(lobe, f, n, lambda);
}

static float transmit_color(const struct lobe *lobe, float lambda)
{
    float color = spectral_value_eval(&lobe->color[TRANSMITTED], lambda);
    return lobe->parameter[HALVED] != 0 ? sqrtf(color) : color;
}

/* `refract` alone lets all light through that total reflection does not stop, as Cycles' Refraction BSDF. */
static float transmitted(const struct lobe *lobe, float f, float n, float lambda)
{
    if (branches(lobe) == BRANCHES_REFLECT || f >= 1)
        return 0;
    float share = branches(lobe) == BRANCHES_REFRACT ? 1 : 1 - tinted_fresnel(lobe, f, n, lambda);
    return transmit_color(lobe, lambda) * share;
}

static float albedo(const struct lobe *lobe, float z, float lambda)
{
    float n = inside_index(lobe, lambda), f = fresnel_dielectric(fabsf(z), z > 0 ? n : 1 / n);
    return reflected(lobe, f, n, lambda) + transmitted(lobe, f, n, lambda);
}

/* --- Smooth ---------------------------------------------------------------------------------------------- */

static bool smooth_scatter(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda,
                           float u, struct delta *out)
{
    float n = inside_index(lobe, lambda), eta = arriving.z > 0 ? n : 1 / n;
    float f = fresnel_dielectric(fabsf(arriving.z), eta), chance = reflection_chance(lobe, f);
    *out = (struct delta){.probability = chance, .n_squared = 1, .depth_class = SCATTER_GLOSSY};
    if (u < chance) {
        out->leaving = vec3(-arriving.x, -arriving.y, arriving.z);
        out->coefficient = reflected(lobe, f, n, lambda);
        return true;
    }
    if (!refract(arriving, vec3(0, 0, copysignf(1, arriving.z)), eta, &out->leaving))
        return false;
    out->coefficient = transmitted(lobe, f, n, lambda);
    out->probability = 1 - chance;
    out->n_squared = side == SIDE_CAMERA ? 1 / square(eta) : square(eta);
    out->refracts = n != 1;
    out->disperses = ((const struct dielectric *)lobe->data)->disperses;
    out->depth_class = SCATTER_TRANSMISSION;
    return true;
}

/* --- Rough ----------------------------------------------------------------------------------------------- */

/* Cycles before 4.0 refracts at least this little beyond the critical angle of the shading normal. */
#define MODEL_3_FRESNEL_MAX 0.9999f

/* A pair of directions and the microfacet between them. */
struct facet {
    bool reflects;
    struct vec3 normal;
    float n_a, n_b;     /* indices on the sides of a and b */
    float cos_a, cos_b; /* with the normal, absolute */
    float fresnel;
};

static bool facet_between(struct vec3 a, struct vec3 b, float n, struct facet *f)
{
    f->n_a = a.z > 0 ? 1 : n;
    f->n_b = b.z > 0 ? 1 : n;
    f->reflects = a.z * b.z > 0;
    struct vec3 h = f->reflects ? add(a, b) : negate(along(scale(a, f->n_a), b, f->n_b));
    h = normalize(h.z < 0 ? negate(h) : h);
    float cos_a = dot(a, h), cos_b = dot(b, h);
    /* Both directions must see the facet's face that they lie on. */
    if (!(cos_a * a.z > 0 && cos_b * b.z > 0))
        return false;
    f->normal = h;
    f->cos_a = fminf(1, fabsf(cos_a));
    f->cos_b = fminf(1, fabsf(cos_b));
    f->fresnel = fresnel_dielectric(f->cos_a, (a.z > 0 ? n : 1) / f->n_a);
    return true;
}

static float model_3_fresnel(float z, float n)
{
    return fminf(fresnel_dielectric(fabsf(z), z > 0 ? n : 1 / n), MODEL_3_FRESNEL_MAX);
}

/* Chance of reflection for a sub-path. Model 3 weighs by the camera's direction: known from there, it decides; a light sub-path keeps
   to the facet's Fresnel, which leaves a chance to whatever some camera may see. */
static float rough_chance(const struct lobe *lobe, enum side side, struct vec3 arriving, float n, float facet)
{
    bool known = lobe->parameter[MODEL_3] != 0 && side == SIDE_CAMERA;
    return reflection_chance(lobe, known ? model_3_fresnel(arriving.z, n) : facet);
}

/* Toward the camera, as Cycles has it. */
static float compensation(const struct lobe *lobe, float cosine, float lambda)
{
    const struct dielectric *d = lobe->data;
    return d->entering ? albedo_compensation(cosine > 0 ? d->entering : d->leaving,
                                             lobe->parameter[ROUGHNESS], cosine, transmit_color(lobe, lambda))
                       : 1;
}

/* Walter et al. 2007, eqs. 20 and 21; the n² of the camera's side is theirs. */
static float rough_evaluate(const struct lobe *lobe, struct vec3 to_light, struct vec3 to_camera,
                            float lambda)
{
    struct facet f;
    float n = inside_index(lobe, lambda), alpha = lobe->parameter[ALPHA];
    if (!facet_between(to_light, to_camera, n, &f) || (!f.reflects && f.fresnel >= 1))
        return 0;
    bool model_3 = lobe->parameter[MODEL_3] != 0;
    float g = ggx_g2(ggx_lambda(to_light, alpha), ggx_lambda(to_camera, alpha), model_3);
    if (model_3)
        f.fresnel = model_3_fresnel(to_camera.z, n);
    float common = ggx_d(f.normal, alpha) * g * compensation(lobe, to_camera.z, lambda) / fabsf(to_camera.z);
    if (f.reflects)
        return reflected(lobe, f.fresnel, n, lambda) * common / 4;
    float length = f.n_a * f.cos_a - f.n_b * f.cos_b;
    return transmitted(lobe, f.fresnel, n, lambda) * common * f.cos_a * f.cos_b * square(f.n_b / length);
}

/* Density by visible normals. */
static float facet_pdf(const struct lobe *lobe, enum side side, struct vec3 arriving, struct vec3 leaving,
                       float lambda)
{
    struct facet f;
    float n = inside_index(lobe, lambda), alpha = lobe->parameter[ALPHA];
    if (!facet_between(arriving, leaving, n, &f))
        return 0;
    float chance = rough_chance(lobe, side, arriving, n, f.fresnel);
    float visible = ggx_d(f.normal, alpha) / ((1 + ggx_lambda(arriving, alpha)) * fabsf(arriving.z));
    if (f.reflects)
        return visible * chance / 4;
    if (f.fresnel >= 1)
        return 0;
    float length = f.n_a * f.cos_a - f.n_b * f.cos_b;
    return visible * (1 - chance) * f.cos_a * f.cos_b * square(f.n_b / length);
}

static bool facet_sample(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda,
                         const float u[3], struct vec3 *leaving)
{
    bool back = arriving.z < 0;
    float n = inside_index(lobe, lambda), eta = back ? 1 / n : n;
    struct vec3 a = back ? mirrored(arriving) : arriving, b;
    struct vec3 h = ggx_sample(a, lobe->parameter[ALPHA], u[0], u[1]);
    float f = fresnel_dielectric(fminf(1, dot(a, h)), eta);
    bool reflects = u[2] < rough_chance(lobe, side, arriving, n, f);
    if (reflects)
        b = reflect(a, h);
    else if (!refract(a, h, eta, &b))
        return false;
    *leaving = back ? mirrored(b) : b;
    return reflects ? b.z > 0 : b.z < 0;
}

/* --- Broad ----------------------------------------------------------------------------------------------- */

/* From this roughness on a refraction's directions depend so little on the wavelength that a run through it is evaluated again at others
   (algorithm.md §9). With the most dispersive of glasses that pays at 0.2; at 0.1 single wavelengths become noisier. */
#define BROAD_ROUGHNESS 0.25f

/* Where one wavelength's refraction cannot go, another's may. So this share goes anywhere across the surface. */
#define ANYWHERE 0.1f

static bool is_broad(const struct lobe *lobe)
{
    return ((const struct dielectric *)lobe->data)->disperses && branches(lobe) != BRANCHES_REFLECT &&
           lobe->parameter[ROUGHNESS] >= BROAD_ROUGHNESS;
}

static float rough_pdf(const struct lobe *lobe, enum side side, struct vec3 arriving, struct vec3 leaving,
                       float lambda)
{
    float pdf = facet_pdf(lobe, side, arriving, leaving, lambda);
    if (!is_broad(lobe))
        return pdf;
    return (1 - ANYWHERE) * pdf + (arriving.z * leaving.z < 0 ? ANYWHERE * fabsf(leaving.z) / PI_F : 0);
}

static bool rough_sample(const struct lobe *lobe, enum side side, struct vec3 arriving, float lambda,
                         const float u[3], struct vec3 *leaving)
{
    if (!is_broad(lobe))
        return facet_sample(lobe, side, arriving, lambda, u, leaving);
    if (u[2] < ANYWHERE)
        return diffuse_sample(lobe, side, negate(arriving), lambda, u, leaving);
    const float rest[3] = {u[0], u[1], (u[2] - ANYWHERE) / (1 - ANYWHERE)};
    return facet_sample(lobe, side, arriving, lambda, rest, leaving);
}

static bool rough_disperses(const struct lobe *lobe)
{
    return ((const struct dielectric *)lobe->data)->disperses && !is_broad(lobe);
}

/* --- Kinds ----------------------------------------------------------------------------------------------- */

const struct lobe_kind lobe_dielectric = {
    .name = "dielectric",
    .nature = LOBE_FINITE,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = albedo,
    .evaluate = rough_evaluate,
    .pdf = rough_pdf,
    .sample = rough_sample,
    .disperses = rough_disperses,
};

const struct lobe_kind lobe_smooth_dielectric = {
    .name = "dielectric, smooth",
    .nature = LOBE_DELTA,
    .reflects_as = SCATTER_GLOSSY,
    .albedo = albedo,
    .scatter = smooth_scatter,
};

void dielectric_shade(struct lobe *lobe, float roughness, struct dielectric_look look)
{
    const struct dielectric *d = lobe->data;
    bool matched = !d->disperses && fabs(d->ior.term[0] - 1) < INDEX_MATCHED;
    lobe->parameter[ALPHA] = alpha_of_roughness(roughness);
    lobe->parameter[BRANCHES] = (float)look.branches;
    lobe->parameter[ROUGHNESS] = clampf(roughness, 0, 1);
    lobe->parameter[TINTED] = look.tinted;
    lobe->parameter[HALVED] = look.halved;
    lobe->parameter[MODEL_3] = look.model_3;
    lobe->kind = roughness < SMOOTH_ROUGHNESS || matched ? &lobe_smooth_dielectric : &lobe_dielectric;
}

struct dielectric *dielectric_create(struct compiler *compiler, struct ior ior, const struct closure *closure,
                                     int roughness)
{
    struct dielectric *d = calloc(1, sizeof *d);
    if (!d) {
        compiler_fail(compiler, "ior", "out of memory");
        return NULL;
    }
    d->ior = ior.kind == IOR_ABBE ? ior_to_cauchy(&ior) : ior; /* cheaper at each hit */
    d->disperses = !ior_is_constant(&ior);
    if (roughness >= 0) {
        float middle = ior_eval(&ior, 550);
        d->entering = albedo_table_create(ALBEDO_GLASS, middle, closure, roughness);
        d->leaving = albedo_table_create(ALBEDO_GLASS, 1 / middle, closure, roughness);
        if (!d->entering || !d->leaving) {
            dielectric_destroy(d);
            compiler_fail(compiler, "ior", "out of memory");
            return NULL;
        }
    }
    return d;
}

void dielectric_destroy(void *data)
{
    struct dielectric *d = data;
    if (!d)
        return;
    albedo_table_destroy(d->entering);
    albedo_table_destroy(d->leaving);
    free(d);
}

static bool shade(const struct lobe_plan *plan, const struct inputs *in, struct lobe *lobe)
{
    const struct closure *c = plan->closure;
    lobe->color[REFLECTED] = in->color[0];
    lobe->color[TRANSMITTED] = in->color[1];
    dielectric_shade(lobe, in->value[0],
                     (struct dielectric_look){.branches = (enum dielectric_branches)c->option[0],
                                              .model_3 = c->number[0] == 3 && !c->option[1]});
    return true;
}

static bool compile(struct compiler *compiler, const struct closure *closure)
{
    struct ior ior = closure->ior;
    if (ior.kind == IOR_CONSTANT && ior.term[0] == 0)
        ior.term[0] = 1.5; /* left out */
    if (!compiler_check_ior(compiler, &ior) || !compiler_check_model(compiler, closure->number[0]))
        return false;
    /* What one branch alone loses between facets is not what both do; Cycles has no such compensation either. */
    bool compensated = closure->option[1] && closure->option[0] == BRANCHES_BOTH;
    struct dielectric *d = dielectric_create(compiler, ior, closure, compensated ? 0 : -1);
    return d && compiler_add(compiler, closure, shade, d, dielectric_destroy);
}

const struct bsdf_kind bsdf_dielectric = {
    .signature =
        {
            .name = "dielectric",
            .color_names = {"reflect_color", "transmit_color"},
            .value_names = {"roughness"},
            .option_names = {"lobes", "multi_scatter"},
            .option_choices = {{"both", "reflect", "refract"}, {"false", "true"}},
            .number_names = {"model"},
            .number_defaults = {4},
            .takes_ior = true,
        },
    .color_defaults = {1, 1},
    .compile = compile,
};
