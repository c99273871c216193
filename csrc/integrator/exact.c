/* Exact connections, run by run: all vertices of one run on either side share one bundle of wavelengths μ, for which both runs are evaluated
   again; then every pair of them connects at the price of an ordinary connection. */
#include "integrator/exact.h"

#include <string.h>

#include "integrator/joint.h"
#include "integrator/link.h"
#include "integrator/relight.h"
#include "integrator/roulette.h"
#include "integrator/tally.h"

/* Ends that share a run: either one vertex as an F end (its run begins there, with nothing in between), or the E ends of a run in the order
   in which they were traced, from `first` on; those from `dispersive` on lie behind a dispersive refraction. */
struct group {
    int start;
    int first, dispersive, end; /* vertices [first, dispersive) and [dispersive, end) */
    struct choice as;
};
enum { GROUPS_MAX = PATH_VERTICES * CHOICES_MAX };

/* Part of a group with what it needs to connect. */
struct taps {
    const struct subpath *path;
    const struct group *group;
    int first, end;
    const struct strand *strand; /* NULL: as traced */
};

static struct group elastic_group(const struct subpath *path, int start)
{
    struct group g = {.start = start, .first = start + 1, .end = start + 1, .as = {LABEL_ELASTIC, 0}};
    while (g.end < path->count && (g.end == start + 1 || path->vertex[g.end - 1].label != LABEL_FLUORESCENT))
        g.end++;
    g.dispersive = g.first;
    while (g.dispersive < g.end && !path->vertex[g.dispersive].arrival.disperses)
        g.dispersive++;
    return g;
}

static int list_groups(const struct subpath *path, struct group out[GROUPS_MAX])
{
    int count = 0;
    for (int i = 0; i < path->count; i++) {
        const struct vertex *v = &path->vertex[i];
        if (i + 1 < path->count && v->label == LABEL_FLUORESCENT)
            out[count++] = elastic_group(path, i);
        for (int f = 0; i > 0 && f < v->surface.fluorescent_count; f++)
            out[count++] = (struct group){i, i, i + 1, i + 1, {LABEL_FLUORESCENT, f}};
    }
    return count;
}

/* The source or sink of wavelengths.h that a group's run begins at. */
static int origin_of(const struct integrator *it, enum side side, const struct subpath *path,
                     const struct group *g)
{
    const struct vertex *v = &path->vertex[g->start];
    if (g->as.label == LABEL_FLUORESCENT && v->kind == VERTEX_SURFACE)
        return wavelengths_dye(&it->wavelengths, side, surface_fluorophore(&v->surface, g->as.lobe));
    return g->as.label == LABEL_FLUORESCENT ? v->arrival.origin : path->vertex[g->first].arrival.origin;
}

/* --- One connection ------------------------------------------------------------------------------------------ */

static bool can_end(const struct vertex *v, struct choice as)
{
    return v->kind != VERTEX_SURFACE || as.label == LABEL_FLUORESCENT || v->surface.has_elastic;
}

/* The bundle of wavelengths of a connecting run. */
struct bundle {
    int lanes;
    float lambda[LANES_MAX];
    double drawn[LANES_MAX];
    const double *density; /* drawn, or NULL for what a sub-path's own steps have paid already */
    double owed;           /* 1/(chance that roulette left the run) */
};

/* Wavelengths on the film of paths whose connecting run has the bundle. */
static const float *film_lambda(const struct taps *camera, int x, const struct bundle *mu)
{
    if (camera->group->start == 0)
        return mu->lambda;
    return camera->path->vertex[camera->strand ? camera->strand->start : x].lambda_film;
}

/* y and x joined at mu. Both may be looked at before: then `sight` knows. */
static void join(const struct integrator *it, struct worker *w, struct joint *joint, const struct taps *light,
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

static void join_taps(const struct integrator *it, struct worker *w, const struct taps *light,
                      const struct taps *camera, const struct bundle *mu)
{
    struct joint joint;
    bool copied = light->path == &w->copy;
    for (int y = light->first; y < light->end; y++) {
        if (!can_end(&light->path->vertex[y], light->group->as))
            continue;
        for (int x = camera->first; x < camera->end; x++) {
            struct haze haze;
            struct sight seen_once = {.haze = &haze};
            if (!it->settings.technique[y + 1][x + 1] ||
                !can_end(&camera->path->vertex[x], camera->group->as))
                continue;
            join(it, w, &joint, light, y, camera, x, mu,
                 copied ? &seen_once : &w->sight[y * PATH_VERTICES + x], NULL);
        }
    }
}

/* --- Runs against runs: the rows of the table ------------------------------------------------------------------ */

/* The non-dispersive part of a group at mu. False if there is none, or nothing of its wavelengths arrives. */
static bool plain_taps(const struct integrator *it, struct worker *w, enum side side,
                       const struct subpath *path, const struct group *g, const struct bundle *mu,
                       struct taps *taps)
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

static struct taps dispersive_taps(const struct subpath *path, const struct group *g)
{
    return (struct taps){path, g, g->dispersive, g->end, NULL};
}

static bool bundle_draw(const struct integrator *it, const struct worker *w, int source, int sink,
                        uint32_t dimension, struct bundle *mu)
{
    mu->lanes = it->lanes;
    mu->density = mu->drawn;
    mu->owed = 1;
    return draw_product(it, w, source, sink, dimension, it->lanes, mu->lambda, mu->drawn);
}

/* The one wavelength that is left behind a dispersive refraction. */
static void bundle_traced(const struct integrator *it, const struct subpath *path, const struct group *g,
                          struct bundle *mu)
{
    mu->lanes = 1;
    mu->density = NULL;
    mu->owed = 1;
    for (int i = 0; i < it->lanes; i++)
        mu->lambda[i] = path->vertex[g->dispersive].arrival.lambda[0];
}

/* Parts of two groups, vertices [y, y_end) and [x, x_end), that may be connected. */
struct meeting {
    const struct group *light, *camera;
    int y, y_end, x, x_end;
};

/* Roulette by what the edges of a meeting are likely to bring in all, before anything is evaluated again. `per_nm` is how likely the two sides are to agree on a
   wavelength. 1/(the chance that was), or 0: given up, or there is no edge. */
static double meeting_survives(const struct integrator *it, struct worker *w, const struct meeting *m,
                               float per_nm)
{
    float sum = 0;
    bool any = false;
    for (int y = m->y; y < m->y_end; y++)
        for (int x = m->x; x < m->x_end; x++) {
            const struct vertex *v = &w->light.vertex[y], *u = &w->camera.vertex[x];
            struct joint joint;
            if (!it->settings.technique[y + 1][x + 1] || !can_end(v, m->light->as) ||
                !can_end(u, m->camera->as) ||
                !joint_open(&joint, v, u, w->stamp, &w->sight[y * PATH_VERTICES + x]))
                continue;
            any = true;
            sum += w->power[SIDE_LIGHT][y] * w->power[SIDE_CAMERA][x] * joint.geometry;
        }
    return any ? roulette(it, w, (double)(sum * per_nm) * roulette_white(it)) : 0;
}

static void join_groups(const struct integrator *it, struct worker *w, const struct group *light,
                        const struct group *camera, uint32_t dimension)
{
    int source = origin_of(it, SIDE_LIGHT, &w->light, light),
        sink = origin_of(it, SIDE_CAMERA, &w->camera, camera);
    struct taps y, x;
    struct bundle mu;
    double owed = meeting_survives(
        it, w,
        &(struct meeting){light, camera, light->first, light->dispersive, camera->first, camera->dispersive},
        wavelengths_overlap(&it->wavelengths, source, sink));
    if (owed > 0 && bundle_draw(it, w, source, sink, dimension, &mu)) {
        mu.owed = owed;
        if (plain_taps(it, w, SIDE_LIGHT, &w->light, light, &mu, &y) &&
            plain_taps(it, w, SIDE_CAMERA, &w->camera, camera, &mu, &x))
            join_taps(it, w, &y, &x, &mu);
    }
    owed = meeting_survives(
        it, w,
        &(struct meeting){light, camera, light->first, light->dispersive, camera->dispersive, camera->end},
        w->light.vertex[light->first].arrival.draw[0]);
    if (owed > 0) { /* the camera's own wavelength */
        bundle_traced(it, &w->camera, camera, &mu);
        mu.owed = owed;
        x = dispersive_taps(&w->camera, camera);
        if (plain_taps(it, w, SIDE_LIGHT, &w->light, light, &mu, &y))
            join_taps(it, w, &y, &x, &mu);
    }
    owed = meeting_survives(
        it, w,
        &(struct meeting){light, camera, light->dispersive, light->end, camera->first, camera->dispersive},
        w->camera.vertex[camera->first].arrival.draw[0]);
    if (owed > 0) { /* the light's own */
        bundle_traced(it, &w->light, light, &mu);
        mu.owed = owed;
        y = dispersive_taps(&w->light, light);
        if (plain_taps(it, w, SIDE_CAMERA, &w->camera, camera, &mu, &x))
            join_taps(it, w, &y, &x, &mu);
    }
}

/* --- Next event estimation and light tracing ---------------------------------------------------------------------- */

static void draw_numbers(const struct worker *w, uint32_t dimension, int count, float u[])
{
    for (int i = 0; i < count; i++)
        u[i] = random_at(w->random, dimension + (uint32_t)i);
}

static const struct group end_group = {0, 0, 1, 1, {LABEL_FLUORESCENT, 0}};

/* Roulette on the same, before the camera's run is evaluated again. A light's emission over its density is that of all wavelengths
   together. 1/(the chance that was), or 0. */
static double light_survives(const struct integrator *it, struct worker *w, const struct subpath *light,
                             int x, int source, int sink, struct sight *sight)
{
    const struct light_point *from = &light->vertex->light;
    struct joint joint;
    if (!joint_open(&joint, light->vertex, &w->camera.vertex[x], w->stamp, sight))
        return 0;
    float lambda = wavelengths_middle(&it->wavelengths, source, sink),
          draw = path_light_draw(it, from, lambda);
    float emitted = draw > 0 ? scene_light_emission(it->scene, from, joint.y_to_x, lambda) / draw : 0;
    float per_nm = wavelengths_overlap(&it->wavelengths, source, sink);
    return roulette(it, w,
                    light->vertex->arrival.throughput[0] *
                        (double)(emitted * per_nm * joint.geometry * w->power[SIDE_CAMERA][x]) *
                        roulette_white(it));
}

/* One camera vertex with one label, from the light point `light`. */
static void join_light(const struct integrator *it, struct worker *w, const struct subpath *light,
                       const struct group *g, int x, uint32_t dimension, struct sight *sight)
{
    struct taps y = {light, &end_group, 0, 1, NULL}, taps = {&w->camera, g, x, x + 1, NULL};
    struct joint joint;
    struct bundle mu;
    if (g->dispersive <= x) {
        bundle_traced(it, &w->camera, g, &mu);
    } else {
        int source = light->vertex->arrival.origin, sink = origin_of(it, SIDE_CAMERA, &w->camera, g);
        double owed = light_survives(it, w, light, x, source, sink, sight);
        if (!(owed > 0) || !bundle_draw(it, w, source, sink, dimension, &mu))
            return;
        mu.owed = owed;
        if (g->as.label == LABEL_ELASTIC) {
            if (relight(it, w, SIDE_CAMERA, &w->camera, g->start, x, it->lanes, mu.lambda,
                        w->strand[SIDE_CAMERA]) < x)
                return;
            taps.strand = w->strand[SIDE_CAMERA];
        }
    }
    join(it, w, &joint, &y, 0, &taps, x, &mu, sight, NULL);
}

/* s = 1: a light point drawn anew for each camera vertex. */
static void connect_light(const struct integrator *it, struct worker *w, const struct group *run, int x)
{
    struct vertex y;
    struct subpath light = {1, &y, NULL};
    struct haze haze;
    struct sight sight = {.haze = &haze};
    const struct vertex *v = &w->camera.vertex[x];
    uint32_t dimension = DIM_NEE + (uint32_t)(x + 1) * DIMS_PER_NEE;
    float u[3];
    draw_numbers(w, dimension, 3, u);
    if (!it->settings.technique[1][x + 1] || !v->surface.connects || !path_light_vertex(it, u, &y))
        return;
    if (v->surface.has_elastic)
        join_light(it, w, &light, run, x, dimension + 4, &sight);
    for (int f = 0; f < v->surface.fluorescent_count; f++) {
        struct group dye = {x, x, x + 1, x + 1, {LABEL_FLUORESCENT, f}};
        join_light(it, w, &light, &dye, x, dimension + 5 + (uint32_t)f, &sight);
    }
}

/* t = 1: one light vertex with one label, seen from a lens point. */
static void join_lens(const struct integrator *it, struct worker *w, const struct taps *light, int y,
                      const struct subpath *lens, float pdf_direction, const struct bundle *mu,
                      struct sight *sight, const int pixel[2])
{
    struct taps x = {lens, &end_group, 0, 1, NULL};
    struct joint joint; /* a kilobyte that is not worth clearing: joint_open and joint_set_end fill it */
    joint.pdf_camera_direction = pdf_direction;
    join(it, w, &joint, light, y, &x, 0, mu, sight, pixel);
}

/* The plain part of a light run at wavelengths that the camera takes, made once for all of its vertices. */
struct lit_run {
    struct taps taps;
    struct bundle mu;
    bool plain;
};

static void light_run(const struct integrator *it, struct worker *w, const struct group *run,
                      uint32_t dimension, struct lit_run *lit)
{
    lit->plain = run->first < run->dispersive &&
                 bundle_draw(it, w, origin_of(it, SIDE_LIGHT, &w->light, run),
                             wavelengths_sink_camera(&it->wavelengths), dimension, &lit->mu) &&
                 plain_taps(it, w, SIDE_LIGHT, &w->light, run, &lit->mu, &lit->taps);
}

/* A lens point drawn anew for each light vertex. */
static void connect_lens(const struct integrator *it, struct worker *w, const struct group *run,
                         const struct lit_run *lit, int y)
{
    struct vertex x;
    struct subpath lens = {1, &x, NULL};
    struct haze haze;
    struct sight sight = {.haze = &haze};
    const struct vertex *v = &w->light.vertex[y];
    uint32_t dimension = DIM_SPLAT + (uint32_t)(y + 1) * DIMS_PER_SPLAT;
    float u[4], pdf_direction;
    int pixel[2];
    struct bundle mu;
    draw_numbers(w, dimension, 4, u);
    if (!it->settings.technique[y + 1][1] || (y > 0 && !v->surface.connects) ||
        !joint_camera_vertex(it, v, &x, u, pixel, &pdf_direction))
        return;
    if (y > 0 && v->surface.has_elastic) {
        if (lit->plain && y < lit->taps.end)
            join_lens(it, w, &lit->taps, y, &lens, pdf_direction, &lit->mu, &sight, pixel);
        if (y >= run->dispersive) {
            struct taps taps = dispersive_taps(&w->light, run);
            bundle_traced(it, &w->light, run, &mu);
            join_lens(it, w, &taps, y, &lens, pdf_direction, &mu, &sight, pixel);
        }
    }
    int dyes = y > 0 ? v->surface.fluorescent_count : 1; /* the light itself counts as one */
    for (int f = 0; f < dyes; f++) {
        struct group dye = {y, y, y + 1, y + 1, {LABEL_FLUORESCENT, f}};
        struct taps taps = {&w->light, &dye, y, y + 1, NULL};
        if (bundle_draw(it, w, origin_of(it, SIDE_LIGHT, &w->light, &dye),
                        wavelengths_sink_camera(&it->wavelengths), dimension + 4 + (uint32_t)f, &mu))
            join_lens(it, w, &taps, y, &lens, pdf_direction, &mu, &sight, pixel);
    }
}

/* --- Both sides dispersive: a second light sub-path copies the camera's wavelength ----------------------------------- */

static bool list_copies(const struct integrator *it, const struct worker *w, const struct group groups[],
                        int count, struct copying *copying)
{
    double total = 0;
    int run = 0;
    copying->runs = 0;
    copying->own = copy_own_chance(it);
    for (int i = 0; i < count; i++) {
        if (groups[i].as.label != LABEL_ELASTIC)
            continue;
        if (groups[i].dispersive < groups[i].end) {
            int at = copying->runs++;
            copying->run[at] = run;
            copying->first[at] = i;
            copying->lambda[at] = w->camera.vertex[groups[i].dispersive].arrival.lambda[0];
            total += copying->chance[at] = copy_run_chance(it, run);
        }
        run++;
    }
    for (int i = 0; i < copying->runs; i++)
        copying->chance[i] *= (1 - copying->own) / total;
    return total > 0;
}

static void connect_copies(const struct integrator *it, struct worker *w, const struct group groups[],
                           int count)
{
    struct copying copying;
    struct bundle mu;
    if (!list_copies(it, w, groups, count, &copying))
        return;
    path_trace_copy(it, w, &copying);
    if (copying.taken < 0 || w->copy.count < 2)
        return;
    const struct group *camera = &groups[copying.first[copying.taken]];
    struct group light = elastic_group(&w->copy, copying.start);
    struct taps y = dispersive_taps(&w->copy, &light), x = dispersive_taps(&w->camera, camera);
    bundle_traced(it, &w->camera, camera, &mu);
    join_taps(it, w, &y, &x, &mu);
}

/* --- All of them ------------------------------------------------------------------------------------------------ */

static void connect_lights(const struct integrator *it, struct worker *w, const struct group groups[],
                           int count)
{
    for (int i = 0; i < count; i++)
        for (int x = groups[i].first; groups[i].as.label == LABEL_ELASTIC && x < groups[i].end; x++)
            connect_light(it, w, &groups[i], x);
}

static void connect_lenses(const struct integrator *it, struct worker *w, const struct group groups[],
                           int count, uint32_t dimension)
{
    connect_lens(it, w, NULL, NULL, 0); /* the light itself, seen by the camera */
    for (int i = 0; i < count; i++) {
        struct lit_run lit;
        if (groups[i].as.label != LABEL_ELASTIC)
            continue;
        light_run(it, w, &groups[i], dimension + (uint32_t)i, &lit);
        for (int y = groups[i].first; y < groups[i].end; y++)
            connect_lens(it, w, &groups[i], &lit, y);
    }
}

void exact_connect_all(const struct integrator *it, struct worker *w)
{
    struct group of_light[GROUPS_MAX], of_camera[GROUPS_MAX];
    int lights = w->light.count > 0 ? list_groups(&w->light, of_light) : 0;
    int cameras = w->camera.count > 0 ? list_groups(&w->camera, of_camera) : 0;
    roulette_weigh(it, w);
    connect_lights(it, w, of_camera, cameras);
    for (int x = 0; it->meets && x < cameras; x++)
        for (int y = 0; y < lights; y++)
            join_groups(it, w, &of_light[y], &of_camera[x],
                        DIM_CONNECT + (uint32_t)x * (GROUPS_MAX + 1) + (uint32_t)y);
    if (w->light.count > 0)
        connect_lenses(it, w, of_light, lights, DIM_CONNECT + (uint32_t)GROUPS_MAX * (GROUPS_MAX + 1));
    if (it->meets)
        connect_copies(it, w, of_camera, cameras);
}
