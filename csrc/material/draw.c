/* Drawing what a sub-path does next at a surface: label, lobe, wavelength, direction. Values and densities are those of surface.c. */
#include "material/surface.h"

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
    if (d->side == SIDE_LIGHT && lobe_is_bent(lobe) && d->u[1] < BENT_ANYWHERE) {
        frame = frame_about(s->ng);
        a = to_local(&frame, d->arriving);
        if (!diffuse_sample(lobe, d->side, a, d->lambda, u, &b))
            return false;
    } else if (!surface_drawing_frame(s, lobe, d->side, d->arriving, &frame, &a) ||
               !lobe->kind->sample(lobe, d->side, a, d->lambda, u, &b))
        return false;
    *leaving = to_world(&frame, b);
    return s->in_volume || b.z * dot(*leaving, s->ng) > 0;
}

static bool draw_elastic(const struct draw *d, const struct lobe *lobe, struct scatter *out)
{
    const struct surface *s = d->surface;
    struct vec3 leaving;
    if (!draw_direction(d, lobe, &leaving))
        return false;
    struct surface_steps step;
    surface_steps(s, d->side, LABEL_ELASTIC, 0, d->arriving, leaving, 1, &d->lambda, &d->lambda, NULL, &step);
    *out = (struct scatter){
        .label = LABEL_ELASTIC,
        .direction = leaving,
        .lambda = d->lambda,
        .value = step.value[0],
        .pdf = step.pdf[0],
        .pdf_other = step.pdf_other[0],
        .refracts = surface_crosses(s, d->arriving, leaving) && lobe->kind->disperses,
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
    const struct fluorophore *dye = lobe_fluorophore(lobe);
    int f = index_among(s->fluorescent, index);
    struct vec3 leaving;
    float pdf, lambda = fluorophore_sample(dye, d->side, d->lambda, d->u[1], &pdf);
    if (!(pdf > 0) || !draw_direction(d, lobe, &leaving))
        return false;
    struct surface_steps step;
    surface_steps(s, d->side, LABEL_FLUORESCENT, f, d->arriving, leaving, 1, &d->lambda, &lambda, NULL,
                  &step);
    *out = (struct scatter){
        .label = LABEL_FLUORESCENT,
        .draw = step.draw[0],
        .draw_other = step.draw_other[0],
        .lobe = f,
        .direction = leaving,
        .lambda = lambda,
        .value = step.value[0],
        .pdf = step.pdf[0],
        .pdf_other = step.pdf_other[0],
        .depth_class = SCATTER_DIFFUSE,
    };
    return true;
}

/* Value and both densities share the δ in projected solid angle of the *light's* direction. For that the light's density, which is
   drawn in the camera's, takes n² and the ratio of shading to geometric cosines (algorithm.md §7). */
static bool draw_delta(const struct draw *d, int index, struct scatter *out)
{
    const struct surface *s = d->surface;
    const struct lobe *lobe = &s->lobe[index];
    struct vec3 a;
    struct delta delta;
    if (!surface_in_frame(s, &lobe->frame, d->arriving, &a) ||
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
    surface_chances(s, d->other, leaving, d->lambda, back);
    float here = d->chance[index] * delta.probability, there = back[index] * delta.probability;
    *out = (struct scatter){
        .label = LABEL_SPECULAR,
        .lobe = index_among(s->specular, index),
        .direction = leaving,
        .lambda = d->lambda,
        .value = lobe->weight * surface_view_weight(s, lobe, camera ? d->arriving : leaving) *
                 delta.coefficient * delta.n_squared,
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
    surface_chances(s, side, arriving, lambda, d.chance);
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
        surface_chances(s, side, arriving, lambda, d.chance);
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

void surface_steps(const struct surface *s, enum side side, enum label label, int which, struct vec3 arriving,
                   struct vec3 leaving, int lanes, const float lambda_arriving[],
                   const float lambda_leaving[], struct surface_memo memo[MEMOS], struct surface_steps *out)
{
    if (s->is_matte) {
        surface_matte_steps(s, side, label, which, arriving, leaving, lanes, lambda_arriving, lambda_leaving,
                            memo, out);
        return;
    }
    if (s->in_volume && s->lobe_count == 1) {
        surface_phase_steps(s, arriving, leaving, lanes, lambda_arriving, out);
        return;
    }
    for (int i = 0; i < lanes; i++) {
        struct surface_step step = {0};
        surface_step_again(s, side, label, which, arriving, leaving, lambda_arriving[i], lambda_leaving[i],
                           &step);
        if (label == LABEL_FLUORESCENT) {
            out->draw[i] = surface_pdf_lambda(s, side, which, lambda_arriving[i], lambda_leaving[i]);
            out->draw_other[i] = surface_pdf_lambda(s, side == SIDE_CAMERA ? SIDE_LIGHT : SIDE_CAMERA, which,
                                                    lambda_leaving[i], lambda_arriving[i]);
        }
        out->value[i] = step.value;
        out->pdf[i] = step.pdf;
        out->pdf_other[i] = step.pdf_other;
    }
}

float surface_sample_lambda(const struct surface *s, enum side side, int f, float lambda_arriving, float u,
                            float *pdf)
{
    return fluorophore_sample(lobe_fluorophore(&s->lobe[s->fluorescent[f]]), side, lambda_arriving, u, pdf);
}

float surface_pdf_lambda(const struct surface *s, enum side side, int f, float lambda_arriving,
                         float lambda_leaving)
{
    return fluorophore_pdf(lobe_fluorophore(&s->lobe[s->fluorescent[f]]), side, lambda_arriving,
                           lambda_leaving);
}
