/* What a bundle of wavelengths owes for one drawn step: who might have led it, which lanes go on and at what price (algorithm.md §11). */
#include "integrator/bundle.h"

#include <string.h>

#include "integrator/tally.h"

double bundle_choose_copy(const struct worker *w, struct copying *copying, uint32_t dimension)
{
    float u = random_at(w->random, dimension);
    if (u < copying->own)
        return copying->own;
    u -= copying->own;
    int run = 0;
    while (run + 1 < copying->runs && u >= copying->chance[run])
        u -= copying->chance[run++];
    copying->taken = run;
    return copying->chance[run];
}

/* The lanes of a run that begins at a dye. A copying light sub-path has one, its own or one of the camera's; what was copied before the dye and
   again after it would be singular, so such a path ends: false. `chance` and `copies` are of that choice. */
static bool draw_lambdas(const struct integrator *it, struct worker *w, enum side side,
                         const struct subpath *path, uint32_t dimension, const struct scatter *drawn,
                         struct vertex *v, double *chance, bool *copies)
{
    struct copying *copying = w->copying;
    float u[LANES_MAX], pdf;
    *chance = 1;
    *copies = false;
    v->lanes_out = copying ? 1 : it->lanes;
    lanes_stratify(random_at(w->random, dimension + 1), v->lanes_out, u);
    for (int i = 0; i < v->lanes_out; i++) {
        int strata = (i + v->lanes_out - v->leader) % v->lanes_out;
        v->lambda_out[i] = i == v->leader ? drawn->lambda
                                          : surface_sample_lambda(&v->surface, side, drawn->lobe,
                                                                  v->arrival.lambda[i], u[strata], &pdf);
    }
    if (!copying)
        return true;
    if (copying->taken >= 0)
        return false;
    *chance = bundle_choose_copy(w, copying, dimension + STEP_COPY);
    *copies = copying->taken >= 0;
    if (*copies) {
        copying->start = path->count - 1;
        v->lambda_out[0] = copying->lambda[copying->taken];
    }
    return true;
}

/* After a dye, the leader is drawn anew among the lanes that live: what a dye gave nothing can lead nowhere. False if none does. */
static bool choose_leader(const struct worker *w, uint32_t dimension, const struct vertex *v,
                          const double gain[LANES_MAX], struct vertex *next)
{
    int alive[LANES_MAX];
    next->leaders = 0;
    for (int i = 0; i < v->lanes_out; i++) {
        next->lead[i] = gain[i] * v->arrival.throughput[i] > 0;
        if (next->lead[i] > 0)
            alive[next->leaders++] = i;
    }
    if (next->leaders == 0)
        return false;
    next->leader = alive[(int)(random_at(w->random, dimension + STEP_LEADER) * (float)next->leaders)];
    return true;
}

/* Density of a step over all lanes that might have led it: the balance heuristic of one sample (Wilkie et al. 2014). `chance` are the
   lanes' own densities, without wavelengths. */
static double led_by_any(const struct vertex *v, const double chance[LANES_MAX])
{
    double sum = 0;
    for (int i = 0; i < v->arrival.lanes; i++)
        sum += (double)v->lead[i] * chance[i];
    return sum / v->leaders;
}

/* Values and densities of the drawn step for the lanes that go on. A dispersive refraction is the leader's alone. */
static bool step_lanes(const struct integrator *it, struct worker *w, enum side side,
                       const struct subpath *path, uint32_t dimension, const struct scatter *drawn,
                       struct vertex *v, double density[LANES_MAX], struct surface_steps *steps)
{
    bool fluoresces = drawn->label == LABEL_FLUORESCENT, copies = false;
    double chance = 1;
    v->lanes_out = drawn->disperses ? 1 : v->arrival.lanes;
    int first = v->lanes_out < v->arrival.lanes ? v->leader : 0;
    for (int i = 0; i < v->lanes_out; i++)
        v->lambda_out[i] = v->arrival.lambda[first + i];
    if (fluoresces && !draw_lambdas(it, w, side, path, dimension, drawn, v, &chance, &copies))
        return false;
    if (v->lanes_out == 1 && v->lambda_out[0] == drawn->lambda)
        *steps = (struct surface_steps){
            {drawn->value}, {drawn->pdf}, {drawn->pdf_other}, {drawn->draw}, {drawn->draw_other}};
    else
        surface_steps(&v->surface, side, drawn->label, drawn->lobe, v->to_prev, drawn->direction,
                      v->lanes_out, v->arrival.lambda + first, v->lambda_out, v->memo, steps);
    for (int i = 0; i < v->lanes_out; i++) {
        v->from[i] = (uint8_t)(first + i);
        density[i] = fluoresces && !copies ? chance * (double)steps->draw[i] : chance;
    }
    return true;
}

bool bundle_follow(const struct integrator *it, struct worker *w, enum side side, const struct subpath *path,
                   uint32_t dimension, const struct scatter *drawn, struct vertex *v, struct vertex *next,
                   struct surface_steps *steps, double gain[LANES_MAX])
{
    double density[LANES_MAX], chance[LANES_MAX];
    bool fluoresces = drawn->label == LABEL_FLUORESCENT;
    if (!step_lanes(it, w, side, path, dimension, drawn, v, density, steps))
        return false;
    bool alone = v->lanes_out < v->arrival.lanes;
    for (int i = 0; i < v->lanes_out; i++) {
        v->own[i] = steps->pdf[i];
        v->other[i] = steps->pdf_other[i];
        chance[i] = !fluoresces          ? steps->pdf[i]
                    : steps->draw[i] > 0 ? steps->pdf[i] / (double)steps->draw[i]
                                         : 0;
    }
    /* Where the leader goes on alone, it stands for all that might have led. */
    v->drawn = alone ? chance[0] * (double)v->lead[v->leader] * v->arrival.lanes / v->leaders
                     : led_by_any(v, chance);
    if (!(v->drawn > 0))
        return false;
    for (int i = 0; i < v->lanes_out; i++) {
        gain[i] = density[i] > 0 ? steps->value[i] / (v->drawn * density[i]) : 0;
        next->lead[i] = alone ? 1 : (float)(v->lead[i] * chance[i] / v->drawn);
    }
    next->leaders = alone ? 1 : v->leaders;
    next->leader = alone ? 0 : v->leader;
    return !fluoresces || choose_leader(w, dimension, v, gain, next);
}

void bundle_depart(const struct integrator *it, const struct worker *w, enum side side,
                   const struct vertex *v, int at, const struct surface_steps *steps,
                   const double gain[LANES_MAX], struct vertex *next)
{
    const struct arrival *here = &v->arrival;
    struct arrival *there = &next->arrival;
    there->lanes = v->lanes_out;
    bool begins = v->label == LABEL_FLUORESCENT;
    for (int i = 0; i < v->lanes_out; i++) {
        int from = v->from[i];
        there->lambda[i] = v->lambda_out[i];
        there->throughput[i] = here->throughput[from] * gain[i];
        there->draw[i] = begins ? steps->draw[i] : here->draw[from];
        next->lambda_film[i] = v->lambda_film[from];
    }
    there->start = begins ? at : here->start;
    there->first = begins;
    there->origin = begins
                        ? wavelengths_dye(&it->wavelengths, side, surface_fluorophore(&v->surface, v->lobe))
                        : here->origin;
    there->dyes = here->dyes + begins;
    there->disperses = !begins && (here->disperses || v->disperses);
    there->disperses_early = !begins && here->disperses;
    there->behind_specular = v->label == LABEL_SPECULAR;
    there->connectable = here->connectable || !(here->behind_specular || there->behind_specular);
    tally_pass(it, w, side, v, here, v->from[0], steps, there);
    arrival_fill(there, next->lambda_film, it->lanes);
}

void bundle_depart_end(const struct integrator *it, const struct worker *w, enum side side,
                       struct vertex *end, const double throughput[LANES_MAX], const float draw[LANES_MAX],
                       int leader, struct vertex *next)
{
    struct arrival *there = &next->arrival;
    there->lanes = end->lanes_out;
    for (int i = 0; i < end->lanes_out; i++) {
        end->from[i] = (uint8_t)i;
        there->lambda[i] = end->lambda_out[i];
        there->draw[i] = draw[i];
        there->throughput[i] = throughput[i];
        next->lambda_film[i] = end->lambda_out[i];
        next->lead[i] = 1;
    }
    next->leaders = end->lanes_out;
    next->leader = leader;
    there->start = 0;
    there->first = true;
    there->origin = end->arrival.origin;
    there->dyes = 0;
    there->disperses = there->disperses_early = there->behind_specular = there->connectable = false;
    memset(next->bounces, 0, sizeof next->bounces);
    struct surface_steps steps;
    memcpy(steps.pdf, end->own, sizeof steps.pdf);
    tally_pass(it, w, side, end, &end->arrival, 0, &steps, there);
    arrival_fill(there, next->lambda_film, it->lanes);
}
