/* A surface at a hit: values, densities and draws in both directions of transport (material.h states the measures).
   Every density is label × lobe × direction; all of them come from the one function `surface_chances`. */
#include "material/surface.h"

/* Share of a lobe's chance that does not depend on its colour at this wavelength: what another wavelength of the run can do must
   have a positive chance at this one's (algorithm.md §9). */
#define CHANCE_FLOOR 0.02f
/* The same for mix factors of the angle of view, which light sub-paths do not know. */
#define VIEW_FLOOR 0.1f

/* --- Geometry -------------------------------------------------------------------------------------------- */

/* The direction in a lobe's frame. False on the horizon, or where geometric and shading sides disagree. */
bool surface_in_frame(const struct surface *s, const struct frame *frame, struct vec3 w, struct vec3 *local)
{
    *local = to_local(frame, w);
    return s->in_volume || local->z * dot(w, s->ng) > 0;
}

static bool is_diffuse(const struct lobe *lobe)
{
    return lobe->kind->reflects_as == SCATTER_DIFFUSE && lobe->kind->nature != LOBE_DELTA;
}

/* A lobe whose frame bends: rough reflection under a normal map. */
bool lobe_is_bent(const struct lobe *lobe)
{
    return lobe->mapped && lobe->kind->nature == LOBE_FINITE && lobe->kind->reflectance;
}

/* The cosine with ng that a mirrored direction keeps, unless the camera's own is lower still. */
#define BENT_COSINE 0.01f
#define BENT_SHARE 0.9f

/* Where a map turns the normal so far that the camera's mirror direction sinks below the surface, Cycles turns the normal back
   until it just rises. In the plane of ng and n, at φ from ng, its cosine is r cos(2φ − ψ) with (cx, cz) = r (sin ψ, cos ψ), which
   falls where n was turned too far. The frame depends on the camera's direction alone, so that all techniques agree. */
static struct frame frame_toward(const struct surface *s, const struct lobe *lobe, struct vec3 to_camera)
{
    float side = copysignf(1, dot(to_camera, s->ng)), cz = fabsf(dot(to_camera, s->ng));
    struct vec3 ng = scale(s->ng, side), n = scale(lobe->frame.n, side);
    float least = fminf(BENT_SHARE * cz, BENT_COSINE), nc = dot(n, to_camera);
    if (2 * nc * dot(n, ng) - cz >= least)
        return lobe->frame;
    struct vec3 x = normalize(along(n, ng, -dot(n, ng)));
    float cx = dot(to_camera, x), r = sqrtf(cx * cx + cz * cz);
    float phi = 0.5f * (atan2f(cx, cz) + acosf(fminf(1, least / r)));
    return frame_about(scale(add(scale(x, sinf(phi)), scale(ng, cosf(phi))), side));
}

/* Below this cosine a camera is taken to see a diffuse lobe at this cosine. */
#define CAMERA_MIN_COSINE 1e-3f

/* The lobe's frame for a camera, and the camera's direction in it. What a diffuse lobe sends out hardly depends on that direction,
   so its side is that of ng alone: or else bumps and silhouettes that turn away from the camera would be black. */
static bool camera_frame(const struct surface *s, const struct lobe *lobe, struct vec3 to_camera,
                         struct frame *frame, struct vec3 *local)
{
    *frame = lobe_is_bent(lobe) ? frame_toward(s, lobe, to_camera) : lobe->frame;
    if (surface_in_frame(s, frame, to_camera, local))
        return true;
    local->z = copysignf(CAMERA_MIN_COSINE, dot(to_camera, s->ng));
    return is_diffuse(lobe) && dot(to_camera, s->ng) != 0;
}

float surface_view_weight(const struct surface *s, const struct lobe *lobe, struct vec3 direction)
{
    float weight = 1;
    for (uint32_t i = 0; i < lobe->view_count; i++)
        weight *= view_factor_eval(&lobe->view[i], direction, s->ng, s->ns);
    return weight;
}

/* Chiang et al. 2019, "Taming the shadow terminator": a normal map alone may not cut light off sharply where the surface under it
   still faces the light. As in Cycles; a function of the light's direction, so that all techniques agree. */
static float terminator(const struct surface *s, const struct lobe *lobe, struct vec3 to_light)
{
    float g = dot(s->ns, to_light) / (dot(lobe->frame.n, to_light) * dot(s->ns, lobe->frame.n));
    return g >= 1 ? 1 : g > 0 ? g * (1 + g - g * g) : 0;
}

/* --- Chances (algorithm.md §4) ----------------------------------------------------------------------------- */

/* Splits 1 among fluorescent and other lobes: P_F is clamped where there are others, and 0/0 means E. Without others and with
   nothing to go by, fluorescent lobes share evenly. */
static void split(const struct surface *s, float chance[], float fluorescent, float elastic, float soft)
{
    float p_f = fluorescent > 0 ? fluorescent / (fluorescent + elastic) : 0;
    p_f = soft > 0 ? fminf(p_f, FLUORESCENT_CHANCE_MAX) : 1;
    for (int i = 0; i < s->lobe_count; i++) {
        if (s->lobe[i].kind->nature != LOBE_FLUORESCENT)
            chance[i] *= (1 - p_f) / soft;
        else
            chance[i] = fluorescent > 0 ? p_f * chance[i] / fluorescent : p_f / s->fluorescent_count;
    }
}

/* The chance of each lobe for a sub-path from `side` that came in from `arriving`. They sum to 1, if there are lobes. */
void surface_chances(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                     float chance[])
{
    float fluorescent = 0, elastic = 0, soft = 0;
    if (s->lobe_count == 1) {
        chance[0] = 1;
        return;
    }
    for (int i = 0; i < s->lobe_count; i++) {
        const struct lobe *lobe = &s->lobe[i];
        float view = surface_view_weight(s, lobe, arriving), floored = lobe->weight * fmaxf(view, VIEW_FLOOR);
        if (lobe->kind->nature == LOBE_FLUORESCENT) {
            chance[i] = floored * fluorophore_strength(lobe_fluorophore(lobe), side, lambda);
            fluorescent += chance[i];
            continue;
        }
        float z = fmaxf(fabsf(dot(arriving, lobe->frame.n)), 1e-4f);
        float albedo = lobe->kind->albedo(lobe, copysignf(z, dot(arriving, s->ng)), lambda);
        elastic += lobe->weight * view * albedo;
        chance[i] = floored * (CHANCE_FLOOR + (1 - CHANCE_FLOOR) * fminf(albedo, 1));
        soft += chance[i];
    }
    split(s, chance, fluorescent, elastic, soft);
}

/* --- Values ---------------------------------------------------------------------------------------------- */

bool surface_lobe_at(const struct surface *s, const struct lobe *lobe, struct vec3 to_light,
                     struct vec3 to_camera, struct vec3 *light, struct vec3 *camera, float *weight)
{
    struct frame frame;
    if (lobe->kind->nature != LOBE_FINITE || !camera_frame(s, lobe, to_camera, &frame, camera) ||
        !surface_in_frame(s, &frame, to_light, light))
        return false;
    *weight = lobe->weight * surface_view_weight(s, lobe, to_camera);
    if (lobe->mapped && is_diffuse(lobe))
        *weight *= terminator(s, lobe, to_light);
    return *weight > 0;
}

float surface_elastic(const struct surface *s, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    float sum = 0, weight, cosine = surface_cosine(s, to_light);
    struct vec3 l, c;
    if (!s->has_elastic || cosine == 0)
        return 0;
    for (int i = 0; i < s->lobe_count; i++)
        if (surface_lobe_at(s, &s->lobe[i], to_light, to_camera, &l, &c, &weight))
            sum += weight * s->lobe[i].kind->evaluate(&s->lobe[i], l, c, lambda);
    return sum / cosine;
}

float surface_fluorescent(const struct surface *s, int f, struct vec3 to_light, struct vec3 to_camera,
                          float lambda_in, float lambda_out)
{
    const struct lobe *lobe = &s->lobe[s->fluorescent[f]];
    const struct fluorophore *dye = lobe_fluorophore(lobe);
    struct vec3 l, c;
    struct frame frame;
    if (!camera_frame(s, lobe, to_camera, &frame, &c) || !surface_in_frame(s, &frame, to_light, &l) ||
        l.z * c.z < 0)
        return 0;
    float weight = lobe->weight * surface_view_weight(s, lobe, to_camera) *
                   fluorophore_value(dye, lambda_in, lambda_out);
    if (lobe->mapped)
        weight *= terminator(s, lobe, to_light);
    return weight * fabsf(l.z) / (PI_F * fabsf(dot(to_light, s->ng)));
}

/* --- Densities ------------------------------------------------------------------------------------------- */

/* The frame in which a sub-path draws, and how it sees `arriving`. A diffuse lobe's value is even over the camera's directions about
   ng, so that is how light sub-paths draw them. */
bool surface_drawing_frame(const struct surface *s, const struct lobe *lobe, enum side side,
                           struct vec3 arriving, struct frame *frame, struct vec3 *local)
{
    if (side == SIDE_CAMERA)
        return camera_frame(s, lobe, arriving, frame, local);
    *frame = lobe->frame;
    bool possible = surface_in_frame(s, frame, arriving, local);
    if (is_diffuse(lobe)) {
        *frame = frame_about(s->ng);
        *local = to_local(frame, arriving);
    }
    return possible;
}

static float drawn_pdf(const struct surface *s, const struct lobe *lobe, enum side side, struct vec3 arriving,
                       struct vec3 leaving, float lambda)
{
    struct vec3 a, b;
    struct frame frame;
    if (!surface_drawing_frame(s, lobe, side, arriving, &frame, &a) ||
        !surface_in_frame(s, &frame, leaving, &b))
        return 0;
    return lobe->kind->pdf(lobe, side, a, b, lambda) / surface_cosine(s, leaving);
}

/* Per projected solid angle, of one lobe of finite density, without its chance. */
static float direction_pdf(const struct surface *s, const struct lobe *lobe, enum side side,
                           struct vec3 arriving, struct vec3 leaving, float lambda)
{
    float pdf = drawn_pdf(s, lobe, side, arriving, leaving, lambda);
    if (side == SIDE_CAMERA || !lobe_is_bent(lobe))
        return pdf;
    bool reflects = dot(arriving, s->ng) * dot(leaving, s->ng) > 0;
    return (1 - BENT_ANYWHERE) * pdf + (reflects ? BENT_ANYWHERE / PI_F : 0);
}

float surface_pdf_elastic(const struct surface *s, enum side side, struct vec3 arriving, struct vec3 leaving,
                          float lambda)
{
    float chance[SURFACE_LOBES], sum = 0;
    if (!s->has_elastic)
        return 0;
    surface_chances(s, side, arriving, lambda, chance);
    for (int i = 0; i < s->lobe_count; i++)
        if (s->lobe[i].kind->nature == LOBE_FINITE)
            sum += chance[i] * direction_pdf(s, &s->lobe[i], side, arriving, leaving, lambda);
    return sum;
}

float surface_pdf_fluorescent(const struct surface *s, enum side side, int f, struct vec3 arriving,
                              struct vec3 leaving, float lambda_arriving, float lambda_leaving)
{
    float chance[SURFACE_LOBES];
    int index = s->fluorescent[f];
    const struct lobe *lobe = &s->lobe[index];
    surface_chances(s, side, arriving, lambda_arriving, chance);
    float pdf =
        chance[index] * fluorophore_pdf(lobe_fluorophore(lobe), side, lambda_arriving, lambda_leaving);
    return pdf > 0 ? pdf * direction_pdf(s, lobe, side, arriving, leaving, lambda_arriving) : 0;
}

/* ∫ albedo by Gauss–Legendre of 4 points on pieces of at most 50 nm. What has no cumulative table is smooth: colours upsampled from
   RGB, and Fresnel's formulae over tabulated indices. */
static double albedo_quadrature(const struct lobe *lobe, float z, float a, float b)
{
    static const double node[] = {0.06943184420297371, 0.33000947820757187, 0.6699905217924281,
                                  0.9305681557970263};
    static const double weight[] = {0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
                                    0.17392742256872693};
    int pieces = 1 + (int)((b - a) / 50);
    double width = (b - a) / (double)pieces, sum = 0;
    for (int i = 0; i < pieces; i++)
        for (int k = 0; k < 4; k++)
            sum += weight[k] * lobe->kind->albedo(lobe, z, (float)(a + width * (i + node[k])));
    return sum * width;
}

/* g(λl)·2d/∫g of eq. 26, as g over its mean; at an end of Λ the mean is over the part inside. */
static float mollified_ratio(const struct surface *s, struct vec3 arriving, float center, float lambda,
                             float half_width)
{
    struct range range = s->material->context.range;
    float a = fmaxf(center - half_width, range.min), b = fminf(center + half_width, range.max);
    double value = 0, integral = 0, part;
    if (!(b > a))
        return 1; /* d → 0 */
    for (int i = 0; i < s->lobe_count; i++) {
        const struct lobe *lobe = &s->lobe[i];
        if (lobe->kind->nature != LOBE_FINITE)
            continue;
        float weight = lobe->weight * surface_view_weight(s, lobe, arriving),
              z = dot(arriving, lobe->frame.n);
        if (!lobe->kind->albedo_integral || !lobe->kind->albedo_integral(lobe, z, a, b, &part))
            part = albedo_quadrature(lobe, z, a, b);
        integral += weight * part;
        value += weight * lobe->kind->albedo(lobe, z, lambda);
    }
    return integral > 0 ? (float)(value * (b - a) / integral) : 0;
}

float surface_pdf_mollified(const struct surface *s, enum side side, struct vec3 arriving,
                            struct vec3 leaving, float lambda_arriving, float lambda_leaving,
                            float half_width_nm)
{
    if (fabsf(lambda_arriving - lambda_leaving) > half_width_nm)
        return 0; /* the indicator that eq. 25 lacks */
    float pdf = surface_pdf_elastic(s, side, arriving, leaving, lambda_arriving);
    if (side == SIDE_LIGHT || pdf == 0)
        return pdf;
    return pdf * mollified_ratio(s, arriving, lambda_arriving, lambda_leaving, half_width_nm);
}

/* --- What a crossing or a reflection is ---------------------------------------------------------------------- */

bool surface_elastic_disperses(const struct surface *s, struct vec3 a, struct vec3 b)
{
    if (!surface_crosses(s, a, b))
        return false;
    for (int i = 0; i < s->lobe_count; i++)
        if (s->lobe[i].kind->nature == LOBE_FINITE && s->lobe[i].kind->disperses &&
            s->lobe[i].kind->disperses(&s->lobe[i]))
            return true;
    return false;
}

enum scatter_class surface_elastic_class(const struct surface *s, struct vec3 a, struct vec3 b)
{
    if (s->in_volume)
        return SCATTER_VOLUME;
    if (surface_crosses(s, a, b))
        return SCATTER_TRANSMISSION;
    for (int i = 0; i < s->lobe_count; i++)
        if (s->lobe[i].kind->nature == LOBE_FINITE && s->lobe[i].kind->reflects_as == SCATTER_DIFFUSE)
            return SCATTER_DIFFUSE;
    return SCATTER_GLOSSY;
}

/* --- Fluorophores ---------------------------------------------------------------------------------------- */

float surface_pdf_emitted(const struct surface *s, int f, float lambda_in, float lambda_out)
{
    return surface_pdf_lambda(s, SIDE_LIGHT, f, lambda_in, lambda_out);
}

float surface_pdf_absorbed(const struct surface *s, int f, float lambda_in, float lambda_out)
{
    return surface_pdf_lambda(s, SIDE_CAMERA, f, lambda_out, lambda_in);
}

const struct spectrum *surface_fluorescent_emission(const struct surface *s, int f)
{
    return lobe_fluorophore(&s->lobe[s->fluorescent[f]])->emission;
}

const struct spectrum *surface_fluorescent_absorption(const struct surface *s, int f)
{
    return lobe_fluorophore(&s->lobe[s->fluorescent[f]])->reradiation;
}

int surface_fluorophore(const struct surface *s, int f)
{
    return lobe_fluorophore(&s->lobe[s->fluorescent[f]])->index;
}
