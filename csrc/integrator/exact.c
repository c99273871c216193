/* Exact connections, run by run: all vertices of one run on either side share one bundle of wavelengths μ, for which both runs are evaluated
   again; then every pair of them connects at the price of an ordinary connection. */
#include "integrator/exact.h"

#include "integrator/link.h"
#include "integrator/roulette.h"
#include "integrator/runs.h"

static void join_taps(const struct integrator *it, struct worker *w, const struct taps *light,
                      const struct taps *camera, const struct bundle *mu)
{
    struct joint joint;
    bool copied = light->path == &w->copy;
    for (int y = light->first; y < light->end; y++) {
        if (!runs_can_end(&light->path->vertex[y], light->group->as))
            continue;
        for (int x = camera->first; x < camera->end; x++) {
            struct haze haze;
            struct sight seen_once = {.haze = &haze};
            if (!it->settings.technique[y + 1][x + 1] ||
                !runs_can_end(&camera->path->vertex[x], camera->group->as))
                continue;
            runs_join(it, w, &joint, light, y, camera, x, mu,
                      copied ? &seen_once : &w->sight[y * PATH_VERTICES + x], NULL);
        }
    }
}

/* --- Runs against runs: the rows of the table ------------------------------------------------------------------ */

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
            if (!it->settings.technique[y + 1][x + 1] || !runs_can_end(v, m->light->as) ||
                !runs_can_end(u, m->camera->as) ||
                !joint_open(&joint, v, u, w->stamp, &w->sight[y * PATH_VERTICES + x]))
                continue;
            any = true;
            sum += w->power[SIDE_LIGHT][y] * w->power[SIDE_CAMERA][x] * joint.geometry;
        }
    return any ? roulette(it, w, (double)(sum * per_nm) / technique_rate(it, 2, 2) * roulette_white(it)) : 0;
}

static void join_groups(const struct integrator *it, struct worker *w, const struct group *light,
                        const struct group *camera, uint32_t dimension)
{
    int source = runs_origin(it, SIDE_LIGHT, &w->light, light),
        sink = runs_origin(it, SIDE_CAMERA, &w->camera, camera);
    struct taps y, x;
    struct bundle mu;
    double owed = meeting_survives(
        it, w,
        &(struct meeting){light, camera, light->first, light->dispersive, camera->first, camera->dispersive},
        wavelengths_overlap(&it->wavelengths, source, sink));
    if (owed > 0 && runs_draw(it, w, source, sink, dimension, &mu)) {
        mu.owed = owed;
        if (runs_plain(it, w, SIDE_LIGHT, &w->light, light, &mu, &y) &&
            runs_plain(it, w, SIDE_CAMERA, &w->camera, camera, &mu, &x))
            join_taps(it, w, &y, &x, &mu);
    }
    owed = meeting_survives(
        it, w,
        &(struct meeting){light, camera, light->first, light->dispersive, camera->dispersive, camera->end},
        w->light.vertex[light->first].arrival.draw[0]);
    if (owed > 0) { /* the camera's own wavelength */
        runs_as_traced(it, &w->camera, camera, &mu);
        mu.owed = owed;
        x = runs_dispersive(&w->camera, camera);
        if (runs_plain(it, w, SIDE_LIGHT, &w->light, light, &mu, &y))
            join_taps(it, w, &y, &x, &mu);
    }
    owed = meeting_survives(
        it, w,
        &(struct meeting){light, camera, light->dispersive, light->end, camera->first, camera->dispersive},
        w->camera.vertex[camera->first].arrival.draw[0]);
    if (owed > 0) { /* the light's own */
        runs_as_traced(it, &w->light, light, &mu);
        mu.owed = owed;
        y = runs_dispersive(&w->light, light);
        if (runs_plain(it, w, SIDE_CAMERA, &w->camera, camera, &mu, &x))
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
        runs_as_traced(it, &w->camera, g, &mu);
    } else {
        int source = light->vertex->arrival.origin, sink = runs_origin(it, SIDE_CAMERA, &w->camera, g);
        double owed = light_survives(it, w, light, x, source, sink, sight);
        if (!(owed > 0) || !runs_draw(it, w, source, sink, dimension, &mu))
            return;
        mu.owed = owed;
        if (g->as.label == LABEL_ELASTIC) {
            if (relight(it, w, SIDE_CAMERA, &w->camera, g->start, x, it->lanes, mu.lambda,
                        w->strand[SIDE_CAMERA]) < x)
                return;
            taps.strand = w->strand[SIDE_CAMERA];
        }
    }
    runs_join(it, w, &joint, &y, 0, &taps, x, &mu, sight, NULL);
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
    runs_join(it, w, &joint, light, y, &x, 0, mu, sight, pixel);
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
                 runs_draw(it, w, runs_origin(it, SIDE_LIGHT, &w->light, run),
                           wavelengths_sink_camera(&it->wavelengths), dimension, &lit->mu) &&
                 runs_plain(it, w, SIDE_LIGHT, &w->light, run, &lit->mu, &lit->taps);
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
            struct taps taps = runs_dispersive(&w->light, run);
            runs_as_traced(it, &w->light, run, &mu);
            join_lens(it, w, &taps, y, &lens, pdf_direction, &mu, &sight, pixel);
        }
    }
    int dyes = y > 0 ? v->surface.fluorescent_count : 1; /* the light itself counts as one */
    for (int f = 0; f < dyes; f++) {
        struct group dye = {y, y, y + 1, y + 1, {LABEL_FLUORESCENT, f}};
        struct taps taps = {&w->light, &dye, y, y + 1, NULL};
        if (runs_draw(it, w, runs_origin(it, SIDE_LIGHT, &w->light, &dye),
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
    struct group light = runs_elastic(&w->copy, copying.start);
    struct taps y = runs_dispersive(&w->copy, &light), x = runs_dispersive(&w->camera, camera);
    runs_as_traced(it, &w->camera, camera, &mu);
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
                           int count)
{
    const uint32_t dimension = DIM_CONNECT + (uint32_t)GROUPS_MAX * (GROUPS_MAX + 1);
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

void exact_see_lights(const struct integrator *it, struct worker *w)
{
    struct group groups[GROUPS_MAX];
    if (w->light.count > 0)
        connect_lenses(it, w, groups, runs_list(&w->light, groups));
}

void exact_connect_all(const struct integrator *it, struct worker *w)
{
    struct group of_light[GROUPS_MAX], of_camera[GROUPS_MAX];
    int lights = w->light.count > 0 ? runs_list(&w->light, of_light) : 0;
    int cameras = w->camera.count > 0 ? runs_list(&w->camera, of_camera) : 0;
    roulette_weigh(it, w);
    connect_lights(it, w, of_camera, cameras);
    for (int x = 0; it->meets && x < cameras; x++)
        for (int y = 0; y < lights; y++)
            join_groups(it, w, &of_light[y], &of_camera[x],
                        DIM_CONNECT + (uint32_t)x * (GROUPS_MAX + 1) + (uint32_t)y);
    if (w->light.count > 0)
        connect_lenses(it, w, of_light, lights);
    if (it->meets && w->light_paths > 0)
        connect_copies(it, w, of_camera, cameras);
}
