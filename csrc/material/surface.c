/* A surface at a hit: values, densities and draws in both directions of transport (material.h states the measures).
   Every density is label × lobe × direction; all of them come from the one function `chances`. */
#include "material/lobe.h"

/* Share of a lobe's chance that does not depend on its colour at this wavelength: what another wavelength of the run can do must
   have a positive chance at this one's (exact.md §4.1). */
#define CHANCE_FLOOR 0.02f
/* The same for mix factors of the angle of view, which light sub-paths do not know. */
#define VIEW_FLOOR 0.1f

/* --- Geometry -------------------------------------------------------------------------------------------- */

/* The direction in a lobe's frame. False on the horizon, or where geometric and shading sides disagree. */
static bool in_frame(const struct surface *s, const struct frame *frame, struct vec3 w, struct vec3 *local)
{
    *local = to_local(frame, w);
    return local->z * dot(w, s->ng) > 0;
}

static bool is_diffuse(const struct lobe *lobe)
{
    return lobe->kind->reflects_as == SCATTER_DIFFUSE && lobe->kind->nature != LOBE_DELTA;
}

/* A lobe whose frame bends: rough reflection under a normal map. */
static bool is_bent(const struct lobe *lobe)
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
    *frame = is_bent(lobe) ? frame_toward(s, lobe, to_camera) : lobe->frame;
    if (in_frame(s, frame, to_camera, local))
        return true;
    local->z = copysignf(CAMERA_MIN_COSINE, dot(to_camera, s->ng));
    return is_diffuse(lobe) && dot(to_camera, s->ng) != 0;
}

static float view_weight(const struct surface *s, const struct lobe *lobe, struct vec3 direction)
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

static const struct fluorophore *fluorophore_of(const struct lobe *lobe)
{
    return lobe->data;
}

/* --- Chances (algorithm.md §4) ----------------------------------------------------------------------------- */

/* What a fluorescent lobe sends on, of what arrives with this wavelength: c e(λo) A from the camera, c ã(λi) from the light. */
static float fluorescent_strength(const struct lobe *lobe, enum side side, float lambda)
{
    const struct fluorophore *f = fluorophore_of(lobe);
    return side == SIDE_CAMERA ? spectrum_eval(f->emission, lambda) * (float)f->strength
                               : spectrum_eval(f->reradiation, lambda);
}

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
static void chances(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                    float chance[])
{
    float fluorescent = 0, elastic = 0, soft = 0;
    if (s->lobe_count == 1) {
        chance[0] = 1;
        return;
    }
    for (int i = 0; i < s->lobe_count; i++) {
        const struct lobe *lobe = &s->lobe[i];
        float view = view_weight(s, lobe, arriving), floored = lobe->weight * fmaxf(view, VIEW_FLOOR);
        if (lobe->kind->nature == LOBE_FLUORESCENT) {
            chance[i] = floored * fluorescent_strength(lobe, side, lambda);
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

float surface_elastic(const struct surface *s, struct vec3 to_light, struct vec3 to_camera, float lambda)
{
    float sum = 0, cosine = fabsf(dot(to_light, s->ng));
    if (!s->has_elastic || cosine == 0)
        return 0;
    for (int i = 0; i < s->lobe_count; i++) {
        const struct lobe *lobe = &s->lobe[i];
        struct vec3 l, c;
        struct frame frame;
        if (lobe->kind->nature != LOBE_FINITE || !camera_frame(s, lobe, to_camera, &frame, &c) ||
            !in_frame(s, &frame, to_light, &l))
            continue;
        float weight = lobe->weight * view_weight(s, lobe, to_camera);
        if (lobe->mapped && is_diffuse(lobe))
            weight *= terminator(s, lobe, to_light);
        if (weight > 0)
            sum += weight * lobe->kind->evaluate(lobe, l, c, lambda);
    }
    return sum / cosine;
}

float surface_fluorescent(const struct surface *s, int f, struct vec3 to_light, struct vec3 to_camera,
                          float lambda_in, float lambda_out)
{
    const struct lobe *lobe = &s->lobe[s->fluorescent[f]];
    const struct fluorophore *dye = fluorophore_of(lobe);
    struct vec3 l, c;
    struct frame frame;
    if (!camera_frame(s, lobe, to_camera, &frame, &c) || !in_frame(s, &frame, to_light, &l) || l.z * c.z < 0)
        return 0;
    float weight =
        lobe->weight * view_weight(s, lobe, to_camera) * spectrum_eval(dye->reradiation, lambda_in);
    if (lobe->mapped)
        weight *= terminator(s, lobe, to_light);
    return weight * spectrum_eval(dye->emission, lambda_out) * fabsf(l.z) /
           (PI_F * fabsf(dot(to_light, s->ng)));
}

/* --- Densities ------------------------------------------------------------------------------------------- */

/* The frame in which a sub-path draws, and how it sees `arriving`. A diffuse lobe's value is even over the camera's directions about
   ng, so that is how light sub-paths draw them. */
static bool drawing_frame(const struct surface *s, const struct lobe *lobe, enum side side,
                          struct vec3 arriving, struct frame *frame, struct vec3 *local)
{
    if (side == SIDE_CAMERA)
        return camera_frame(s, lobe, arriving, frame, local);
    *frame = lobe->frame;
    bool possible = in_frame(s, frame, arriving, local);
    if (is_diffuse(lobe)) {
        *frame = frame_about(s->ng);
        *local = to_local(frame, arriving);
    }
    return possible;
}

/* Light sub-paths do not know how a camera's direction will bend the frame: this share of theirs goes anywhere above ng. */
#define BENT_ANYWHERE 0.1f

static float drawn_pdf(const struct surface *s, const struct lobe *lobe, enum side side, struct vec3 arriving,
                       struct vec3 leaving, float lambda)
{
    struct vec3 a, b;
    struct frame frame;
    if (!drawing_frame(s, lobe, side, arriving, &frame, &a) || !in_frame(s, &frame, leaving, &b))
        return 0;
    return lobe->kind->pdf(lobe, side, a, b, lambda) / fabsf(dot(leaving, s->ng));
}

/* Per projected solid angle, of one lobe of finite density, without its chance. */
static float direction_pdf(const struct surface *s, const struct lobe *lobe, enum side side,
                           struct vec3 arriving, struct vec3 leaving, float lambda)
{
    float pdf = drawn_pdf(s, lobe, side, arriving, leaving, lambda);
    if (side == SIDE_CAMERA || !is_bent(lobe))
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
    chances(s, side, arriving, lambda, chance);
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
    const struct fluorophore *dye = fluorophore_of(lobe);
    chances(s, side, arriving, lambda_arriving, chance);
    float pdf =
        chance[index] * spectrum_pdf(side == SIDE_CAMERA ? dye->reradiation : dye->emission, lambda_leaving);
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
        float weight = lobe->weight * view_weight(s, lobe, arriving), z = dot(arriving, lobe->frame.n);
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

/* --- Draws ----------------------------------------------------------------------------------------------- */

/* What a draw knows: the sub-path's state, and the chances there. */
struct draw {
    const struct surface *surface;
    enum side side, other;
    struct vec3 arriving;
    float lambda;
    const float *u;
    float chance[SURFACE_LOBES];
};

/* The lobe that u falls on; −1 without lobes. */
static int choose(const struct draw *d)
{
    float u = d->u[0];
    int last = -1;
    for (int i = 0; i < d->surface->lobe_count; i++) {
        if (!(d->chance[i] > 0))
            continue;
        last = i;
        if (u < d->chance[i])
            return i;
        u -= d->chance[i];
    }
    return last; /* rounding left u a hair above the sum */
}

static bool draw_direction(const struct draw *d, const struct lobe *lobe, struct vec3 *leaving)
{
    const struct surface *s = d->surface;
    const float u[3] = {d->u[2], d->u[3], d->u[1]};
    struct vec3 a, b;
    struct frame frame;
    if (d->side == SIDE_LIGHT && is_bent(lobe) && d->u[1] < BENT_ANYWHERE) {
        frame = frame_about(s->ng);
        a = to_local(&frame, d->arriving);
        if (!diffuse_sample(lobe, d->side, a, d->lambda, u, &b))
            return false;
    } else if (!drawing_frame(s, lobe, d->side, d->arriving, &frame, &a) ||
               !lobe->kind->sample(lobe, d->side, a, d->lambda, u, &b))
        return false;
    *leaving = to_world(&frame, b);
    return b.z * dot(*leaving, s->ng) > 0;
}

static bool crosses(const struct surface *s, struct vec3 a, struct vec3 b)
{
    return dot(a, s->ng) * dot(b, s->ng) < 0;
}

bool surface_elastic_disperses(const struct surface *s, struct vec3 a, struct vec3 b)
{
    if (!crosses(s, a, b))
        return false;
    for (int i = 0; i < s->lobe_count; i++)
        if (s->lobe[i].kind->nature == LOBE_FINITE && s->lobe[i].kind->disperses &&
            s->lobe[i].kind->disperses(&s->lobe[i]))
            return true;
    return false;
}

enum scatter_class surface_elastic_class(const struct surface *s, struct vec3 a, struct vec3 b)
{
    if (crosses(s, a, b))
        return SCATTER_TRANSMISSION;
    for (int i = 0; i < s->lobe_count; i++)
        if (s->lobe[i].kind->nature == LOBE_FINITE && s->lobe[i].kind->reflects_as == SCATTER_DIFFUSE)
            return SCATTER_DIFFUSE;
    return SCATTER_GLOSSY;
}

static bool draw_elastic(const struct draw *d, const struct lobe *lobe, struct scatter *out)
{
    const struct surface *s = d->surface;
    struct vec3 leaving;
    if (!draw_direction(d, lobe, &leaving))
        return false;
    bool camera = d->side == SIDE_CAMERA;
    *out = (struct scatter){
        .label = LABEL_ELASTIC,
        .direction = leaving,
        .lambda = d->lambda,
        .value =
            surface_elastic(s, camera ? leaving : d->arriving, camera ? d->arriving : leaving, d->lambda),
        .pdf = surface_pdf_elastic(s, d->side, d->arriving, leaving, d->lambda),
        .pdf_other = surface_pdf_elastic(s, d->other, leaving, d->arriving, d->lambda),
        .refracts = crosses(s, d->arriving, leaving) && lobe->kind->disperses,
        .disperses = surface_elastic_disperses(s, d->arriving, leaving),
        .depth_class = surface_elastic_class(s, d->arriving, leaving),
    };
    return true;
}

static int index_among(const uint8_t list[], int lobe)
{
    int i = 0;
    while (list[i] != lobe)
        i++;
    return i;
}

static bool draw_fluorescent(const struct draw *d, int index, struct scatter *out)
{
    const struct surface *s = d->surface;
    const struct lobe *lobe = &s->lobe[index];
    const struct fluorophore *dye = fluorophore_of(lobe);
    bool camera = d->side == SIDE_CAMERA;
    int f = index_among(s->fluorescent, index);
    struct vec3 leaving;
    float pdf, lambda = spectrum_sample(camera ? dye->reradiation : dye->emission, d->u[1], &pdf);
    if (!draw_direction(d, lobe, &leaving))
        return false;
    *out = (struct scatter){
        .label = LABEL_FLUORESCENT,
        .lobe = f,
        .direction = leaving,
        .lambda = lambda,
        .value = camera ? surface_fluorescent(s, f, leaving, d->arriving, lambda, d->lambda)
                        : surface_fluorescent(s, f, d->arriving, leaving, d->lambda, lambda),
        .pdf = surface_pdf_fluorescent(s, d->side, f, d->arriving, leaving, d->lambda, lambda),
        .pdf_other = surface_pdf_fluorescent(s, d->other, f, leaving, d->arriving, lambda, d->lambda),
        .depth_class = SCATTER_DIFFUSE,
    };
    return true;
}

/* Value and both densities share the δ in projected solid angle of the *light's* direction. For that the light's density, which is
   drawn in the camera's, takes n² and the ratio of shading to geometric cosines (exact.md §1). */
static bool draw_delta(const struct draw *d, int index, struct scatter *out)
{
    const struct surface *s = d->surface;
    const struct lobe *lobe = &s->lobe[index];
    struct vec3 a;
    struct delta delta;
    if (!in_frame(s, &lobe->frame, d->arriving, &a) ||
        !lobe->kind->scatter(lobe, d->side, a, d->lambda, d->u[1], &delta))
        return false;
    struct vec3 leaving = to_world(&lobe->frame, delta.leaving);
    float leaving_g = dot(leaving, s->ng), arriving_g = dot(d->arriving, s->ng);
    if (!(delta.leaving.z * leaving_g > 0))
        return false;
    bool camera = d->side == SIDE_CAMERA;
    float factor = fabsf(leaving_g * a.z / (delta.leaving.z * arriving_g)); /* seen from the camera */
    float measure = delta.n_squared * (camera ? factor : 1 / factor);
    float back[SURFACE_LOBES];
    chances(s, d->other, leaving, d->lambda, back);
    float here = d->chance[index] * delta.probability, there = back[index] * delta.probability;
    *out = (struct scatter){
        .label = LABEL_SPECULAR,
        .lobe = index_among(s->specular, index),
        .direction = leaving,
        .lambda = d->lambda,
        .value = lobe->weight * view_weight(s, lobe, camera ? d->arriving : leaving) * delta.coefficient *
                 delta.n_squared,
        .pdf = camera ? here : here * measure,
        .pdf_other = camera ? there * measure : there,
        .refracts = delta.refracts,
        .disperses = delta.disperses,
        .depth_class = delta.depth_class,
    };
    return true;
}

bool surface_sample(const struct surface *s, enum side side, struct vec3 arriving, float lambda,
                    const float u[4], struct scatter *out)
{
    struct draw d = {.surface = s,
                     .side = side,
                     .other = side == SIDE_CAMERA ? SIDE_LIGHT : SIDE_CAMERA,
                     .arriving = arriving,
                     .lambda = lambda,
                     .u = u};
    chances(s, side, arriving, lambda, d.chance);
    int index = choose(&d);
    if (index < 0)
        return false;
    bool drawn = false;
    switch (s->lobe[index].kind->nature) {
    case LOBE_FINITE: drawn = draw_elastic(&d, &s->lobe[index], out); break;
    case LOBE_FLUORESCENT: drawn = draw_fluorescent(&d, index, out); break;
    case LOBE_DELTA: drawn = draw_delta(&d, index, out); break;
    }
    return drawn && out->pdf > 0;
}

/* --- The same step at another wavelength --------------------------------------------------------------------- */

/* The branch of a δ lobe that leaves to a known side: its scatter takes the first branch for u = 0 and the last for u → 1. */
static bool delta_again(const struct surface *s, enum side side, int index, struct vec3 arriving,
                        struct vec3 leaving, float lambda, struct scatter *out)
{
    static const float branch[2] = {0, 1 - 0x1p-24f};
    for (int i = 0; i < 2; i++) {
        const float u[4] = {0, branch[i], 0, 0};
        struct draw d = {.surface = s,
                         .side = side,
                         .other = side == SIDE_CAMERA ? SIDE_LIGHT : SIDE_CAMERA,
                         .arriving = arriving,
                         .lambda = lambda,
                         .u = u};
        chances(s, side, arriving, lambda, d.chance);
        if (draw_delta(&d, index, out) && dot(out->direction, s->ng) * dot(leaving, s->ng) > 0)
            return true;
    }
    return false;
}

bool surface_step_again(const struct surface *s, enum side side, enum label label, int which,
                        struct vec3 arriving, struct vec3 leaving, float lambda_arriving,
                        float lambda_leaving, struct surface_step *out)
{
    enum side other = side == SIDE_CAMERA ? SIDE_LIGHT : SIDE_CAMERA;
    bool camera = side == SIDE_CAMERA;
    struct vec3 to_light = camera ? leaving : arriving, to_camera = camera ? arriving : leaving;
    struct scatter delta;
    switch (label) {
    case LABEL_ELASTIC:
        out->value = surface_elastic(s, to_light, to_camera, lambda_arriving);
        out->pdf = surface_pdf_elastic(s, side, arriving, leaving, lambda_arriving);
        out->pdf_other = surface_pdf_elastic(s, other, leaving, arriving, lambda_arriving);
        return true;
    case LABEL_FLUORESCENT:
        out->value =
            surface_fluorescent(s, which, to_light, to_camera, camera ? lambda_leaving : lambda_arriving,
                                camera ? lambda_arriving : lambda_leaving);
        out->pdf =
            surface_pdf_fluorescent(s, side, which, arriving, leaving, lambda_arriving, lambda_leaving);
        out->pdf_other =
            surface_pdf_fluorescent(s, other, which, leaving, arriving, lambda_leaving, lambda_arriving);
        return true;
    case LABEL_SPECULAR:
        if (!delta_again(s, side, s->specular[which], arriving, leaving, lambda_arriving, &delta))
            return false;
        *out = (struct surface_step){delta.value, delta.pdf, delta.pdf_other};
        return true;
    }
    return false;
}

/* --- Fluorophores ---------------------------------------------------------------------------------------- */

const struct spectrum *surface_fluorescent_emission(const struct surface *s, int f)
{
    return fluorophore_of(&s->lobe[s->fluorescent[f]])->emission;
}

const struct spectrum *surface_fluorescent_absorption(const struct surface *s, int f)
{
    return fluorophore_of(&s->lobe[s->fluorescent[f]])->reradiation;
}

int surface_fluorophore(const struct surface *s, int f)
{
    return fluorophore_of(&s->lobe[s->fluorescent[f]])->index;
}
