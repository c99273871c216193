/* One run as exact.c connects it: which ends share it, at which wavelengths, what of it has to be evaluated again at those, and a single
   connection of two such runs. */
#include "integrator/runs.h"

#include <string.h>

#include "integrator/tally.h"

/* --- Ends that share a run ------------------------------------------------------------------------------------ */

struct group runs_elastic(const struct subpath *path, int start)
{
    struct group g = {.start = start, .first = start + 1, .end = start + 1, .as = {LABEL_ELASTIC, 0}};
    while (g.end < path->count && (g.end == start + 1 || path->vertex[g.end - 1].label != LABEL_FLUORESCENT))
        g.end++;
    g.dispersive = g.first;
    while (g.dispersive < g.end && !path->vertex[g.dispersive].arrival.disperses)
        g.dispersive++;
    return g;
}

int runs_list(const struct subpath *path, struct group out[GROUPS_MAX])
{
    int count = 0;
    for (int i = 0; i < path->count; i++) {
        const struct vertex *v = &path->vertex[i];
        if (i + 1 < path->count && v->label == LABEL_FLUORESCENT)
            out[count++] = runs_elastic(path, i);
        for (int f = 0; i > 0 && f < v->surface.fluorescent_count; f++)
            out[count++] = (struct group){i, i, i + 1, i + 1, {LABEL_FLUORESCENT, f}};
    }
    return count;
}

int runs_origin(const struct integrator *it, enum side side, const struct subpath *path,
                const struct group *g)
{
    const struct vertex *v = &path->vertex[g->start];
    if (g->as.label == LABEL_FLUORESCENT && v->kind == VERTEX_SURFACE)
        return wavelengths_dye(&it->wavelengths, side, surface_fluorophore(&v->surface, g->as.lobe));
    return g->as.label == LABEL_FLUORESCENT ? v->arrival.origin : path->vertex[g->first].arrival.origin;
}

/* --- At which wavelengths --------------------------------------------------------------------------------------- */

bool runs_draw(const struct integrator *it, const struct worker *w, int source, int sink, uint32_t dimension,
               struct bundle *mu)
{
    mu->lanes = it->lanes;
    mu->density = mu->drawn;
    mu->owed = 1;
    return draw_product(it, w, source, sink, dimension, it->lanes, mu->lambda, mu->drawn);
}

void runs_as_traced(const struct integrator *it, const struct subpath *path, const struct group *g,
                    struct bundle *mu)
{
    mu->lanes = 1;
    mu->density = NULL;
    mu->owed = 1;
    for (int i = 0; i < it->lanes; i++)
        mu->lambda[i] = path->vertex[g->dispersive].arrival.lambda[0];
}

bool runs_plain(const struct integrator *it, struct worker *w, enum side side, const struct subpath *path,
                const struct group *g, const struct bundle *mu, struct taps *taps)
{
    *taps = (struct taps){path, g, g->first, g->dispersive, NULL};
    if (g->first == g->dispersive)
        return false;
    if (g->as.label == LABEL_FLUORESCENT)
        return true;
    taps->strand = w->strand[side];
    int before = path->vertex[g->start].arrival.lanes, lanes = mu->lanes > before ? mu->lanes : before;
    taps->end =
        relight(it, w, side, path, g->start, g->dispersive - 1, lanes, mu->lambda, w->strand[side]) + 1;
    return taps->end > taps->first;
}

struct taps runs_dispersive(const struct subpath *path, const struct group *g)
{
    return (struct taps){path, g, g->dispersive, g->end, NULL};
}

/* --- One connection ------------------------------------------------------------------------------------------ */

bool runs_can_end(const struct vertex *v, struct choice as)
{
    return v->kind != VERTEX_SURFACE || as.label == LABEL_FLUORESCENT || v->surface.has_elastic;
}

/* Wavelengths on the film of paths whose connecting run has the bundle. */
static const float *film_lambda(const struct taps *camera, int x, const struct bundle *mu)
{
    if (camera->group->start == 0)
        return mu->lambda;
    return camera->path->vertex[camera->strand ? camera->strand->start : x].lambda_film;
}

void runs_join(const struct integrator *it, struct worker *w, struct joint *joint, const struct taps *light,
               int y, const struct taps *camera, int x, const struct bundle *mu, struct sight *sight,
               const int *splat)
{
    if (!joint_open(joint, &light->path->vertex[y], &camera->path->vertex[x], w->stamp, sight))
        return;
    joint_set_end(joint, SIDE_LIGHT, light->path, y, light->strand, light->group->as);
    joint_set_end(joint, SIDE_CAMERA, camera->path, x, camera->strand, camera->group->as);
    if (!joint_is_allowed(it, joint))
        return;
    int lanes_y = joint->end[SIDE_LIGHT].at->lanes, lanes_x = joint->end[SIDE_CAMERA].at->lanes;
    joint->lanes = lanes_y > lanes_x ? lanes_y : lanes_x;
    if (mu->lanes > joint->lanes)
        joint->lanes = mu->lanes;
    memcpy(joint->lambda, mu->lambda, sizeof joint->lambda);
    joint->owed = mu->owed;
    const float *film = film_lambda(camera, x, mu);
    if (joint_evaluate(it, w, joint, mu->density, film))
        joint_contribute(it, w, joint, mu->density, film, splat);
}
