/* Runs at other wavelengths: a walk back over one run, without a ray. */
#include "integrator/relight.h"

#include <string.h>

#include "integrator/tally.h"

/* The step that starts the run: what a light emits, a camera sees or a dye takes or gives at the new wavelengths. */
static void start_again(const struct integrator *it, enum side side, const struct vertex *v, int lanes,
                        const float lambda[LANES_MAX], float draw[LANES_MAX], struct surface_steps *steps)
{
    float direction = (float)v->drawn;
    switch (v->kind) {
    case VERTEX_CAMERA:
        for (int i = 0; i < lanes; i++) {
            draw[i] = spectrum_pdf(it->wavelengths.camera, lambda[i]);
            steps->value[i] =
                direction; /* importance over the density of directions is 1 (scene_camera_ray) */
            steps->pdf[i] = direction * draw[i];
            steps->pdf_other[i] = 0;
        }
        return;
    case VERTEX_LIGHT:
        for (int i = 0; i < lanes; i++) {
            draw[i] = scene_pdf_light_lambda(it->scene, &v->light, lambda[i]);
            steps->value[i] = scene_light_emission(it->scene, &v->light, v->to_next, lambda[i]);
            steps->pdf[i] = direction * draw[i];
            steps->pdf_other[i] = 0;
        }
        return;
    case VERTEX_SURFACE: break;
    }
    surface_steps(&v->surface, side, LABEL_FLUORESCENT, v->lobe, v->to_prev, v->to_next, lanes,
                  v->arrival.lambda, lambda, v->memo, steps);
    memcpy(draw, steps->draw, sizeof steps->draw);
}

double edge_transmittance(const struct integrator *it, enum side side, const struct vertex *from,
                          const struct vec3 *to, struct vec3 direction, float lambda)
{
    struct vec3 origin = vertex_offset(from, direction);
    uint32_t kind = path_step_kind(side, from);
    return to ? scene_visibility(it->scene, origin, *to, lambda, kind)
              : scene_visibility_distant(it->scene, origin, direction, lambda, kind);
}

static void pass_edge(const struct integrator *it, enum side side, const struct vertex *from,
                      const struct vertex *to, struct arrival *at)
{
    struct vec3 end = vertex_offset(to, to->to_prev);
    for (int i = 0; i < at->lanes; i++) {
        at->seam[i] /= (double)to->geometry;
        at->throughput[i] *= (double)to->passage;
        if (to->passed)
            at->throughput[i] *= edge_transmittance(it, side, from, from->unbounded ? NULL : &end,
                                                    from->to_next, at->lambda[i]);
        if (it->has_volumes)
            at->throughput[i] *=
                crossing_transmittance(it->scene, &to->inside.crossing, at->lambda[i]) / to->inside.flown;
    }
    if (it->has_volumes || to->inside.back == 0)
        tally_cross(at, to->inside.ahead, to->inside.back, at->lanes);
}

int relight(const struct integrator *it, const struct worker *w, enum side side, const struct subpath *path,
            int start, int end, int lanes, const float lambda[LANES_MAX], struct strand *strand)
{
    strand->start = start;
    for (int i = start; i < end; i++) {
        const struct vertex *v = &path->vertex[i];
        const struct arrival *here = i == start ? &v->arrival : &strand->at[i];
        struct arrival *there = &strand->at[i + 1];
        struct surface_steps steps;
        if (i == start)
            start_again(it, side, v, lanes, lambda, there->draw, &steps);
        else
            surface_steps(&v->surface, side, v->label, v->lobe, v->to_prev, v->to_next, lanes, lambda, lambda,
                          v->memo, &steps);
        double inverse = 1 / v->drawn;
        for (int k = 0; k < lanes; k++) {
            there->lambda[k] = lambda[k];
            there->throughput[k] = here->throughput[k] * steps.value[k] * inverse;
            strand->own[i][k] = steps.pdf[k];
            strand->other[i][k] = steps.pdf_other[k];
            if (i > start)
                there->draw[k] = here->draw[k];
        }
        const struct arrival *traced = &path->vertex[i + 1].arrival;
        there->lanes = lanes;
        there->start = start;
        there->first = i == start;
        there->origin = traced->origin;
        there->dyes = traced->dyes;
        there->disperses = traced->disperses;
        there->disperses_early = traced->disperses_early;
        tally_pass(it, w, side, v, here, 0, &steps, there);
        if (i + 1 < path->count)
            pass_edge(it, side, v, &path->vertex[i + 1], there);
        if (!(lanes_sum(there->throughput, lanes) > 0))
            return i;
        arrival_fill(there, NULL, it->lanes);
    }
    return end;
}
