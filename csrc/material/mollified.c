/* Kernels: their supports, levels, strengths, densities, and draws. */
#include "material/mollified.h"

#include "material/parts.h"
#include "material/surface.h"

const char *kernel_name(enum kernel kernel)
{
    static const char *const names[KERNEL_COUNT] = {"constant", "incident_reflectance", "incident", "box",
                                                    "asymmetric"};
    return names[kernel];
}

float kernel_density(enum kernel kernel, float lambda_in, float lambda_out, float d)
{
    float shift = lambda_out - lambda_in;
    switch (kernel) {
    case KERNEL_CONSTANT:
    case KERNEL_INCIDENT_REFLECTANCE:
    case KERNEL_INCIDENT: return fabsf(shift) < d ? 1 / (2 * d) : 0;
    case KERNEL_BOX: return fabsf(shift) < d ? (d - fabsf(shift)) / (d * d) : 0;
    case KERNEL_ASYMMETRIC: return shift >= 0 && shift < 2 * d ? 1 / (2 * d) : 0;
    case KERNEL_COUNT: break;
    }
    return 0;
}

/* Where the other wavelength may lie. */
static void support(enum kernel kernel, enum side side, double lambda, double d, double *low, double *high)
{
    bool asymmetric = kernel == KERNEL_ASYMMETRIC, camera = side == SIDE_CAMERA;
    *low = lambda - (asymmetric ? camera ? 2 * d : 0 : d);
    *high = lambda + (asymmetric ? camera ? 0 : 2 * d : d);
}

/* --- Values -------------------------------------------------------------------------------------------------- */

/* The level of one lobe's albedo. */
static double level(const struct lobe *lobe, struct range range, enum kernel kernel, float z, float in,
                    float out, float d)
{
    double low, high;
    switch (kernel) {
    case KERNEL_CONSTANT:
    case KERNEL_ASYMMETRIC: return part_at(lobe, PART_ALL, range, z, in);
    case KERNEL_INCIDENT: return part_at(lobe, PART_ALL, range, z, out);
    case KERNEL_INCIDENT_REFLECTANCE:
        return part_at(lobe, PART_KEPT, range, z, in) * part_at(lobe, PART_REFLECTED, range, z, out);
    case KERNEL_BOX:
        low = fmaxf(in, out) - 0.5 * d;
        high = fminf(in, out) + 0.5 * d;
        return high > low ? part_integral(lobe, PART_ALL, range, z, low, high) / (high - low) : 0;
    case KERNEL_COUNT: break;
    }
    return 0;
}

struct evaluation {
    const struct lobe *lobe;
    struct vec3 light, camera;
};

static double evaluate_at(const void *user, double lambda)
{
    const struct evaluation *e = user;
    return e->lobe->kind->evaluate(e->lobe, e->light, e->camera, (float)lambda);
}

/* The level of a lobe's value; it follows from the albedo's where that is all that depends on the wavelength. */
static double level_of_value(const struct evaluation *e, struct range range, enum kernel kernel, float in,
                             float out, float d)
{
    if (e->lobe->kind->is_lambert)
        return e->light.z * e->camera.z > 0
                   ? level(e->lobe, range, kernel, e->camera.z, in, out, d) * fabsf(e->light.z) / PI_F
                   : 0;
    if (kernel == KERNEL_CONSTANT || kernel == KERNEL_ASYMMETRIC)
        return evaluate_at(e, in);
    if (kernel != KERNEL_BOX)
        return evaluate_at(e, out);
    double low = fmaxf(in, out) - 0.5 * d, high = fminf(in, out) + 0.5 * d;
    double a = fmax(low, range.min), b = fmin(high, range.max);
    return b > a ? part_quadrature(evaluate_at, e, a, b) / (high - low) : 0;
}

float surface_mollified(const struct surface *s, enum kernel kernel, struct vec3 to_light,
                        struct vec3 to_camera, float lambda_in, float lambda_out, float d)
{
    float weight, cosine = surface_cosine(s, to_light);
    double sum = 0;
    if (!s->has_elastic || cosine == 0)
        return 0;
    for (int i = 0; i < s->lobe_count; i++) {
        struct evaluation e = {.lobe = &s->lobe[i]};
        if (surface_lobe_at(s, e.lobe, to_light, to_camera, &e.light, &e.camera, &weight))
            sum += weight * level_of_value(&e, s->material->context.range, kernel, lambda_in, lambda_out, d);
    }
    return (float)(sum / cosine);
}

/* --- Sums over lobes ------------------------------------------------------------------------------------------ */

/* What the sums ask of each lobe, of the albedo seen from the arriving direction. */
struct question {
    enum kernel kernel;
    enum side side;
    float lambda, d;
    double other; /* the other wavelength, or the end of an interval of it */
};

typedef double (*answer)(const struct lobe *, struct range, float z, const struct question *);

static double over_lobes(const struct surface *s, struct vec3 arriving, answer ask, const struct question *q)
{
    double sum = 0;
    for (int i = 0; i < s->lobe_count; i++) {
        const struct lobe *lobe = &s->lobe[i];
        if (lobe->kind->nature != LOBE_FINITE)
            continue;
        float z = copysignf(fmaxf(fabsf(dot(arriving, lobe->frame.n)), 1e-4f), dot(arriving, s->ng));
        sum += lobe->weight * surface_view_weight(s, lobe, arriving) *
               ask(lobe, s->material->context.range, z, q);
    }
    return sum;
}

static double level_at(const struct lobe *lobe, struct range range, float z, const struct question *q)
{
    bool light = q->side == SIDE_LIGHT;
    return level(lobe, range, q->kernel, z, light ? q->lambda : (float)q->other,
                 light ? (float)q->other : q->lambda, q->d);
}

/* ∫ of the elastic term over the other wavelength, from the support's low end to `other`. */
static double integral_to(const struct lobe *lobe, struct range range, float z, const struct question *q)
{
    double low, high, l = q->lambda, d = q->d, end;
    bool light = q->side == SIDE_LIGHT;
    support(q->kernel, q->side, l, d, &low, &high);
    end = fmin(q->other, high);
    if (!(end > low))
        return 0;
    switch (q->kernel) {
    case KERNEL_CONSTANT:
    case KERNEL_ASYMMETRIC:
        return (light ? (end - low) * part_at(lobe, PART_ALL, range, z, q->lambda)
                      : part_integral(lobe, PART_ALL, range, z, low, end)) /
               (2 * d);
    case KERNEL_INCIDENT:
        return (light ? part_integral(lobe, PART_ALL, range, z, low, end)
                      : (end - low) * part_at(lobe, PART_ALL, range, z, q->lambda)) /
               (2 * d);
    case KERNEL_INCIDENT_REFLECTANCE:
        return part_at(lobe, light ? PART_KEPT : PART_REFLECTED, range, z, q->lambda) *
               part_integral(lobe, light ? PART_REFLECTED : PART_KEPT, range, z, low, end) / (2 * d);
    case KERNEL_BOX: {
        /* ∫ G(x + d/2) − G(λ − d/2) up to λ, then ∫ G(λ + d/2) − G(x − d/2), G the cumulative table of g (algorithm.md §3). */
        double from = l - 0.5 * d, to = l + 0.5 * d;
        double sum = part_second(lobe, PART_ALL, range, z, from, fmin(end, l) + 0.5 * d);
        if (end > l)
            sum += (end - l) * part_integral(lobe, PART_ALL, range, z, from, to) -
                   part_second(lobe, PART_ALL, range, z, from, end - 0.5 * d);
        return sum / (d * d);
    }
    case KERNEL_COUNT: break;
    }
    return 0;
}

/* --- Densities ------------------------------------------------------------------------------------------------ */

double mollified_strength(const struct surface *s, enum kernel kernel, enum side side, struct vec3 arriving,
                          float lambda, float d)
{
    return over_lobes(s, arriving, integral_to, &(struct question){kernel, side, lambda, d, INFINITY});
}

/* p^moll/k. */
static double ratio(const struct surface *s, enum kernel kernel, enum side side, struct vec3 arriving,
                    float lambda_arriving, float lambda_leaving, float d)
{
    double strength = mollified_strength(s, kernel, side, arriving, lambda_arriving, d);
    const struct question q = {kernel, side, lambda_arriving, d, lambda_leaving};
    return strength > 0 ? over_lobes(s, arriving, level_at, &q) / strength : 0;
}

static float kernel_between(enum kernel kernel, enum side side, float arriving, float leaving, float d)
{
    return side == SIDE_LIGHT ? kernel_density(kernel, arriving, leaving, d)
                              : kernel_density(kernel, leaving, arriving, d);
}

float mollified_pdf(const struct surface *s, enum kernel kernel, enum side side, struct vec3 arriving,
                    float lambda_arriving, float lambda_leaving, float d)
{
    float k = kernel_between(kernel, side, lambda_arriving, lambda_leaving, d);
    return k > 0 ? (float)(k * ratio(s, kernel, side, arriving, lambda_arriving, lambda_leaving, d)) : 0;
}

double mollified_cdf(const struct surface *s, enum kernel kernel, enum side side, struct vec3 arriving,
                     float lambda_arriving, float lambda_leaving, float d)
{
    struct range range = s->material->context.range;
    struct question q = {kernel, side, lambda_arriving, d, INFINITY};
    double all = over_lobes(s, arriving, integral_to, &q);
    if (!(all > 0))
        return 0;
    q.other = fminf(fmaxf(lambda_leaving, range.min), range.max);
    double below = over_lobes(s, arriving, integral_to, &q);
    q.other = range.min;
    return (below - over_lobes(s, arriving, integral_to, &q)) / all;
}

float surface_pdf_mollified_by(const struct surface *s, enum kernel kernel, enum side side,
                               struct vec3 arriving, struct vec3 leaving, float lambda_arriving,
                               float lambda_leaving, float d)
{
    if (kernel == KERNEL_CONSTANT) /* in its own, faster form */
        return surface_pdf_mollified(s, side, arriving, leaving, lambda_arriving, lambda_leaving, d);
    if (!(kernel_between(kernel, side, lambda_arriving, lambda_leaving, d) > 0))
        return 0;
    float pdf = surface_pdf_elastic(s, side, arriving, leaving, lambda_arriving);
    return pdf > 0 ? pdf * (float)ratio(s, kernel, side, arriving, lambda_arriving, lambda_leaving, d) : 0;
}

/* P_x p^fl + (1 − P_x) p^moll with the chances of eqs. 21 and 22. */
float mollified_pdf_of_all(const struct surface *s, enum kernel kernel, enum side side, struct vec3 arriving,
                           float lambda_arriving, float lambda_leaving, float d)
{
    double elastic = mollified_strength(s, kernel, side, arriving, lambda_arriving, d);
    double all = elastic,
           sum = elastic * mollified_pdf(s, kernel, side, arriving, lambda_arriving, lambda_leaving, d);
    for (int f = 0; f < s->fluorescent_count; f++) {
        const struct lobe *lobe = &s->lobe[s->fluorescent[f]];
        double strength = lobe->weight * surface_view_weight(s, lobe, arriving) *
                          fluorophore_strength(lobe_fluorophore(lobe), side, lambda_arriving);
        all += strength;
        sum += strength * fluorophore_pdf(lobe_fluorophore(lobe), side, lambda_arriving, lambda_leaving);
    }
    return all > 0 ? (float)(sum / all) : 0;
}

/* --- Drawing -------------------------------------------------------------------------------------------------- */

/* The cdf has no closed inverse for a sum of lobes; forty halvings leave no more of an interval than a float can tell. */
static double invert(const struct surface *s, struct vec3 arriving, struct question q, double target)
{
    double low, high;
    support(q.kernel, q.side, q.lambda, q.d, &low, &high);
    for (int i = 0; i < 40; i++) {
        q.other = 0.5 * (low + high);
        if (over_lobes(s, arriving, integral_to, &q) < target)
            low = q.other;
        else
            high = q.other;
    }
    return 0.5 * (low + high);
}

bool mollified_sample(const struct surface *s, enum kernel kernel, enum side side, struct vec3 arriving,
                      float lambda_arriving, float d, float u, float *lambda, float *pdf)
{
    const struct question q = {kernel, side, lambda_arriving, d, INFINITY};
    struct range range = s->material->context.range;
    double all = over_lobes(s, arriving, integral_to, &q);
    if (!(all > 0))
        return false;
    *lambda = (float)invert(s, arriving, q, u * all);
    *pdf = mollified_pdf(s, kernel, side, arriving, lambda_arriving, *lambda, d);
    return *lambda >= range.min && *lambda <= range.max && *pdf > 0;
}
