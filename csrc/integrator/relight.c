/* Runs at another wavelength: a walk back over one run, without a ray. */
#include "integrator/relight.h"

int run_start(const struct subpath *path, int at)
{
    int start = at - 1;
    while (start > 0 && path->vertex[start].label != LABEL_FLUORESCENT)
        start--;
    return start;
}

/* Density with which vertex `start` drew the wavelength that its run was traced with. */
static double drawn_density(const struct integrator *it, enum side side, const struct vertex *v)
{
    switch (v->kind) {
    case VERTEX_CAMERA: return spectrum_pdf(it->wavelengths.camera, v->lambda_out);
    case VERTEX_LIGHT: return scene_pdf_light_lambda(it->scene, &v->light, v->lambda_out);
    case VERTEX_SURFACE: break;
    }
    return spectrum_pdf(side == SIDE_CAMERA ? surface_fluorescent_absorption(&v->surface, v->lobe)
                                            : surface_fluorescent_emission(&v->surface, v->lobe),
                        v->lambda_out);
}

/* The step that starts the run: what a light emits, a camera sees or a dye takes or gives at the new wavelength. */
static bool start_again(const struct integrator *it, enum side side, const struct vertex *v, float lambda,
                        struct surface_step *step)
{
    double direction = v->pdf_own / drawn_density(it, side, v);
    switch (v->kind) {
    case VERTEX_CAMERA:
        /* Importance over the density of directions is 1 (scene_camera_ray). */
        *step = (struct surface_step){(float)direction,
                                      (float)(direction * spectrum_pdf(it->wavelengths.camera, lambda)), 0};
        return true;
    case VERTEX_LIGHT:
        *step = (struct surface_step){
            scene_light_emission(it->scene, &v->light, v->to_next, lambda),
            (float)(direction * scene_pdf_light_lambda(it->scene, &v->light, lambda)), 0};
        return step->value > 0;
    case VERTEX_SURFACE: break;
    }
    return surface_step_again(&v->surface, side, LABEL_FLUORESCENT, v->lobe, v->to_prev, v->to_next,
                              v->lambda_in, lambda, step) &&
           step->value > 0;
}

double edge_transmittance_ratio(const struct integrator *it, const struct vertex *from, const struct vec3 *to,
                                struct vec3 direction, float lambda, float lambda_drawn)
{
    struct vec3 origin = vertex_offset(from, direction);
    float drawn = to ? scene_visibility(it->scene, origin, *to, lambda_drawn)
                     : scene_visibility_distant(it->scene, origin, direction, lambda_drawn);
    float now = to ? scene_visibility(it->scene, origin, *to, lambda)
                   : scene_visibility_distant(it->scene, origin, direction, lambda);
    return drawn > 0 ? now / drawn : 0;
}

static double passage(const struct integrator *it, const struct vertex *from, const struct vertex *to,
                      float lambda)
{
    if (!to->passed)
        return to->passage;
    struct vec3 end = vertex_offset(to, to->to_prev);
    return to->passage * edge_transmittance_ratio(it, from, from->unbounded ? NULL : &end, from->to_next,
                                                  lambda, to->lambda_in);
}

bool relight(const struct integrator *it, enum side side, const struct subpath *path, int start, int end,
             float lambda, struct relit *relit)
{
    struct surface_step step;
    *relit = (struct relit){.start = start, .end = end, .lambda = lambda};
    for (int i = start; i < end; i++) {
        const struct vertex *v = &path->vertex[i];
        double actual = v->pdf_own * v->survival;
        double before = i == start ? (v->kind == VERTEX_CAMERA ? 1 : v->throughput) : relit->throughput[i];
        if (i == start) {
            if (!start_again(it, side, v, lambda, &step))
                return false;
            actual /= drawn_density(it, side, v);
        } else if (!surface_step_again(&v->surface, side, v->label, v->lobe, v->to_prev, v->to_next, lambda,
                                       lambda, &step) ||
                   !(step.value > 0)) {
            return false;
        }
        relit->throughput[i + 1] = before * step.value / actual;
        if (i + 1 < path->count)
            relit->throughput[i + 1] *= passage(it, v, &path->vertex[i + 1], lambda);
        relit->own[i] = step.pdf;
        relit->other[i] = step.pdf_other;
    }
    return true;
}

void relit_put(const struct relit *relit, enum side side, int upto, struct full_path *path)
{
    for (int i = relit->start; i < relit->end && i < upto; i++) {
        int at = side == SIDE_LIGHT ? i : path->edges - i;
        struct full_step *step = &path->step[at];
        step->fwd = side == SIDE_LIGHT ? relit->own[i] : relit->other[i];
        step->rev = side == SIDE_LIGHT ? relit->other[i] : relit->own[i];
        path->step[side == SIDE_LIGHT ? at + 1 : at].lambda = relit->lambda;
    }
}
