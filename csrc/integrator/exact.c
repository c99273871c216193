/* Exact connections, run by run: all vertices of one run on either side share one wavelength μ, for which both runs are evaluated again;
   then every pair of them connects at the price of an ordinary connection. */
#include "integrator/exact.h"

#include "integrator/joint.h"
#include "integrator/link.h"
#include "integrator/relight.h"

/* Ends that share a run: either one vertex as an F end (its run begins there, with nothing in between), or the E ends of a run in the order
   in which they were traced, from `first` on; those from `dispersive` on lie behind a dispersive refraction. */
struct group {
    int start;
    int first, dispersive, end; /* vertices [first, dispersive) and [dispersive, end) */
    struct choice as;
};
enum { GROUPS_MAX = PATH_VERTICES * CHOICES_MAX };

/* Part of a group with what it needs to connect at one wavelength. */
struct taps {
    const struct subpath *path;
    const struct group *group;
    int first, end;
    const struct relit *relit; /* NULL: as traced */
};

static struct group elastic_group(const struct subpath *path, int start)
{
    struct group g = {.start = start, .first = start + 1, .end = start + 1, .as = {LABEL_ELASTIC, 0}};
    while (g.end < path->count && (g.end == start + 1 || path->vertex[g.end - 1].label != LABEL_FLUORESCENT))
        g.end++;
    g.dispersive = g.first;
    while (g.dispersive < g.end && !path->vertex[g.dispersive].run_disperses)
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

static int source_of(const struct integrator *it, const struct subpath *light, const struct group *g)
{
    const struct vertex *v = &light->vertex[g->start];
    int lobe = g->as.label == LABEL_FLUORESCENT ? g->as.lobe : v->lobe;
    return v->kind == VERTEX_LIGHT
               ? scene_light_shape(it->scene, v->light.light)
               : wavelengths_source_dye(&it->wavelengths, surface_fluorophore(&v->surface, lobe));
}

static int sink_of(const struct integrator *it, const struct subpath *camera, const struct group *g)
{
    const struct vertex *v = &camera->vertex[g->start];
    int lobe = g->as.label == LABEL_FLUORESCENT ? g->as.lobe : v->lobe;
    return v->kind == VERTEX_CAMERA ? wavelengths_sink_camera(&it->wavelengths)
                                    : surface_fluorophore(&v->surface, lobe);
}

/* --- One connection ------------------------------------------------------------------------------------------ */

static bool can_end(const struct vertex *v, struct choice as)
{
    return v->kind != VERTEX_SURFACE || as.label == LABEL_FLUORESCENT || v->surface.has_elastic;
}

/* Wavelength on the film of a path whose connecting run has wavelength mu. */
static float film_lambda(const struct taps *camera, float mu)
{
    bool first_run = camera->group->start == 0;
    return first_run ? mu : camera->path->vertex[0].lambda_out;
}

/* Value × weight of y and x joined at mu, with a density 1/draw of that wavelength; waits for the shadow ray. */
static void join(const struct integrator *it, struct worker *w, struct joint *joint, const struct taps *light,
                 const struct taps *camera, float mu, double draw, struct pendings *out)
{
    struct choice as_y = light->group->as, as_x = camera->group->as;
    int y_at = joint->s - 1, x_at = joint->t - 1;
    out->count = 0;
    if (!joint_open(w, joint, light->path, camera->path) || !joint_is_allowed(it, joint, as_y, as_x))
        return;
    if (light->relit) {
        relit_put(light->relit, SIDE_LIGHT, y_at, &joint->path);
        joint->throughput_y = light->relit->throughput[y_at];
    }
    if (camera->relit) {
        relit_put(camera->relit, SIDE_CAMERA, x_at, &joint->path);
        joint->throughput_x = camera->relit->throughput[x_at];
    }
    struct end y = joint_end(it, joint, SIDE_LIGHT, as_y, mu);
    if (!(y.value > 0))
        return;
    struct end x = joint_end(it, joint, SIDE_CAMERA, as_x, mu);
    double value = draw * joint_value(it, joint, &y, as_y, &x, as_x, mu);
    if (value > 0)
        pendings_add(it, out, joint, value, mu, film_lambda(camera, mu));
    pendings_resolve(it, out, joint);
}

static void join_taps(const struct integrator *it, struct worker *w, const struct taps *light,
                      const struct taps *camera, float mu, double draw)
{
    struct pendings pendings;
    for (int y = light->first; y < light->end; y++) {
        if (!can_end(&light->path->vertex[y], light->group->as))
            continue;
        for (int x = camera->first; x < camera->end; x++) {
            struct joint joint;
            joint_set(&joint, &light->path->vertex[y], &camera->path->vertex[x], y + 1, x + 1);
            if (!it->settings.technique[y + 1][x + 1] || !can_end(joint.x, camera->group->as))
                continue;
            join(it, w, &joint, light, camera, mu, draw, &pendings);
            pendings_gather(it, w, &pendings);
        }
    }
}

/* --- Runs against runs: the rows of the table ------------------------------------------------------------------ */

/* The non-dispersive part of a group at mu. False if there is none, or nothing of that wavelength arrives. */
static bool plain_taps(const struct integrator *it, enum side side, const struct subpath *path,
                       const struct group *g, float mu, struct relit *relit, struct taps *taps)
{
    *taps = (struct taps){path, g, g->first, g->dispersive, NULL};
    if (g->first == g->dispersive)
        return false;
    if (g->as.label == LABEL_FLUORESCENT)
        return true;
    taps->relit = relit;
    return relight(it, side, path, g->start, g->dispersive - 1, mu, relit);
}

static struct taps dispersive_taps(const struct subpath *path, const struct group *g)
{
    return (struct taps){path, g, g->dispersive, g->end, NULL};
}

static bool draw_product(const struct integrator *it, const struct worker *w, int source, int sink,
                         uint32_t dimension, float *mu, double *draw)
{
    const struct spectral_histogram *product = wavelengths_product(&it->wavelengths, source, sink);
    float pdf;
    if (!product)
        return false;
    *mu = spectral_histogram_sample(product, random_at(w->random, dimension), &pdf);
    *draw = 1 / (double)pdf;
    return pdf > 0;
}

static void join_groups(const struct integrator *it, struct worker *w, const struct group *light,
                        const struct group *camera, uint32_t dimension)
{
    struct relit at_y, at_x;
    struct taps y, x;
    float mu;
    double draw;
    bool y_plain = light->first < light->dispersive, x_plain = camera->first < camera->dispersive;
    if (y_plain && x_plain &&
        draw_product(it, w, source_of(it, &w->light, light), sink_of(it, &w->camera, camera), dimension, &mu,
                     &draw) &&
        plain_taps(it, SIDE_LIGHT, &w->light, light, mu, &at_y, &y) &&
        plain_taps(it, SIDE_CAMERA, &w->camera, camera, mu, &at_x, &x))
        join_taps(it, w, &y, &x, mu, draw);
    if (camera->dispersive < camera->end) { /* the camera's own wavelength */
        mu = w->camera.vertex[camera->dispersive].lambda_in;
        x = dispersive_taps(&w->camera, camera);
        if (plain_taps(it, SIDE_LIGHT, &w->light, light, mu, &at_y, &y))
            join_taps(it, w, &y, &x, mu, 1);
    }
    if (light->dispersive < light->end) { /* the light's */
        mu = w->light.vertex[light->dispersive].lambda_in;
        y = dispersive_taps(&w->light, light);
        if (plain_taps(it, SIDE_CAMERA, &w->camera, camera, mu, &at_x, &x))
            join_taps(it, w, &y, &x, mu, 1);
    }
}

/* --- Next event estimation and light tracing ---------------------------------------------------------------------- */

static void draw_numbers(const struct worker *w, uint32_t dimension, int count, float u[])
{
    for (int i = 0; i < count; i++)
        u[i] = random_at(w->random, dimension + (uint32_t)i);
}

static const struct group light_group = {0, 0, 1, 1, {LABEL_FLUORESCENT, 0}};

/* s = 1: a light point drawn anew for each vertex of the part. */
static void join_lights(const struct integrator *it, struct worker *w, const struct taps *camera, float mu,
                        double draw)
{
    struct vertex y;
    struct subpath light = {1, &y};
    struct taps taps = {&light, &light_group, 0, 1, NULL};
    struct pendings pendings;
    float u[3];
    for (int x = camera->first; x < camera->end; x++) {
        struct joint joint;
        joint_set(&joint, &y, &w->camera.vertex[x], 1, x + 1);
        draw_numbers(w, DIM_NEE + (uint32_t)(x + 1) * DIMS_PER_NEE, 3, u);
        if (!it->settings.technique[1][x + 1] || !can_end(joint.x, camera->group->as) ||
            !joint_light_vertex(it, u, &y))
            continue;
        join(it, w, &joint, &taps, camera, mu, draw, &pendings);
        pendings_gather(it, w, &pendings);
    }
}

static void connect_lights(const struct integrator *it, struct worker *w, const struct group *g,
                           uint32_t dimension)
{
    struct relit relit;
    struct taps taps;
    float mu;
    double draw;
    if (g->first < g->dispersive &&
        draw_product(it, w, wavelengths_source_lamps(&it->wavelengths), sink_of(it, &w->camera, g), dimension,
                     &mu, &draw) &&
        plain_taps(it, SIDE_CAMERA, &w->camera, g, mu, &relit, &taps))
        join_lights(it, w, &taps, mu, draw);
    taps = dispersive_taps(&w->camera, g);
    if (taps.first < taps.end)
        join_lights(it, w, &taps, w->camera.vertex[taps.first].lambda_in, 1);
}

/* t = 1: a lens point drawn anew for each vertex of the part. */
static void join_lens(const struct integrator *it, struct worker *w, const struct taps *light, float mu,
                      double draw)
{
    static const struct group camera_group = {0, 0, 1, 1, {LABEL_FLUORESCENT, 0}};
    struct vertex x;
    struct subpath camera = {1, &x};
    struct taps taps = {&camera, &camera_group, 0, 1, NULL};
    struct pendings pendings;
    float u[4];
    int pixel[2];
    for (int y = light->first; y < light->end; y++) {
        struct joint joint;
        joint_set(&joint, &light->path->vertex[y], &x, y + 1, 1);
        draw_numbers(w, DIM_SPLAT + (uint32_t)(y + 1) * DIMS_PER_SPLAT, 4, u);
        if (!it->settings.technique[y + 1][1] || !can_end(joint.y, light->group->as) ||
            !joint_camera_vertex(it, &joint, &x, u, pixel))
            continue;
        join(it, w, &joint, light, &taps, mu, draw, &pendings);
        pendings_splat(it, &pendings, pixel);
    }
}

static void connect_lens(const struct integrator *it, struct worker *w, int source, const struct group *g,
                         uint32_t dimension)
{
    struct relit relit;
    struct taps taps;
    float mu;
    double draw;
    if (g->first < g->dispersive &&
        draw_product(it, w, source, wavelengths_sink_camera(&it->wavelengths), dimension, &mu, &draw) &&
        plain_taps(it, SIDE_LIGHT, &w->light, g, mu, &relit, &taps))
        join_lens(it, w, &taps, mu, draw);
    taps = dispersive_taps(&w->light, g);
    if (taps.first < taps.end)
        join_lens(it, w, &taps, w->light.vertex[taps.first].lambda_in, 1);
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
            copying->lambda[at] = w->camera.vertex[groups[i].dispersive].lambda_in;
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
    if (!list_copies(it, w, groups, count, &copying))
        return;
    path_trace_copy(it, w, &copying);
    if (copying.taken < 0 || w->copy.count < 2)
        return;
    struct group light = elastic_group(&w->copy, copying.start);
    struct taps y = dispersive_taps(&w->copy, &light);
    struct taps x = dispersive_taps(&w->camera, &groups[copying.first[copying.taken]]);
    join_taps(it, w, &y, &x, copying.lambda[copying.taken], 1);
}

void exact_connect_all(const struct integrator *it, struct worker *w)
{
    struct group of_light[GROUPS_MAX], of_camera[GROUPS_MAX];
    int lights = w->light.count > 0 ? list_groups(&w->light, of_light) : 0;
    int cameras = w->camera.count > 0 ? list_groups(&w->camera, of_camera) : 0;
    for (int x = 0; x < cameras; x++) {
        uint32_t dimension = DIM_CONNECT + (uint32_t)x * (GROUPS_MAX + 1);
        connect_lights(it, w, &of_camera[x], dimension);
        for (int y = 0; y < lights; y++)
            join_groups(it, w, &of_light[y], &of_camera[x], dimension + 1 + (uint32_t)y);
    }
    uint32_t dimension = DIM_CONNECT + (uint32_t)GROUPS_MAX * (GROUPS_MAX + 1);
    for (int y = 0; y < lights; y++)
        connect_lens(it, w, source_of(it, &w->light, &of_light[y]), &of_light[y], dimension + (uint32_t)y);
    if (w->light.count > 0) /* the light itself, seen by the camera */
        connect_lens(it, w, wavelengths_source_lamps(&it->wavelengths), &light_group, dimension + GROUPS_MAX);
    if (it->settings.technique[2][2])
        connect_copies(it, w, of_camera, cameras);
}
