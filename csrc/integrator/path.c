/* Sub-path tracing: grows a path from the camera or a light, one vertex a call, and fills throughput, both densities and
   the geometry term of each step, for a bundle of wavelengths. */
#include "integrator/path.h"

#include "integrator/bundle.h"
#include "integrator/flight.h"
#include "integrator/tally.h"

/* Roulette never kills with more than this probability; it divides the contribution and stays out of the weights. */
static const float roulette_floor = 0.05f;
/* A run may be evaluated again where it is bright, though it was traced where it is dark (algorithm.md §9). */
static const float roulette_floor_exact = 0.5f;
/* A grazing edge whose cosine is below this has no density that floats can hold. */
static const float cosine_min = 1e-6f;

struct vec3 vertex_offset(const struct vertex *v, struct vec3 direction)
{
    if (v->in_volume)
        return v->position;
    if (v->kind == VERTEX_SURFACE)
        return scene_offset(&v->hit, direction);
    if (v->kind == VERTEX_LIGHT && v->light.on_mesh)
        return scene_offset(&v->light.hit, direction);
    return v->position;
}

/* What a light sub-path meets may be seen by any kind of ray; which one, its scattering there decides. Its first edge is one that looks for a
   light. What lies between two of its vertices must be seen by all or by none that might fly there (algorithm.md §7): what is not ends it. */
static const uint32_t any_kind = RAY_CAMERA | RAY_DIFFUSE | RAY_GLOSSY | RAY_TRANSMISSION | RAY_VOLUME;

/* Fills what a new vertex knows of the edge to its predecessor. */
static bool arrive(const struct integrator *it, enum side side, struct vertex *prev, struct vertex *next,
                   struct vec3 direction, bool passed)
{
    next->kind = VERTEX_SURFACE;
    next->kinds = next->in_volume ? any_kind | RAY_SHADOW : scene_hit_kinds(it->scene, &next->hit);
    next->label = LABEL_ELASTIC;
    next->disperses = false;
    next->memo[MEMO_ARRIVING].lanes = next->memo[MEMO_OTHERS].lanes = 0;
    next->unbounded = false;
    if (!next->in_volume)
        next->position = next->hit.position;
    next->to_prev = negate(direction);
    next->passed = passed;
    float cosines = vertex_cosine(prev, direction) * vertex_cosine(next, direction);
    next->geometry =
        prev->unbounded ? cosines : cosines / length_squared(sub(next->position, prev->position));
    if (!(cosines > cosine_min * cosine_min) || !isfinite(next->geometry))
        return false;
    double edge = 1 / (double)next->geometry;
    for (int i = 0; i < it->lanes; i++)
        next->arrival.seam[i] *= edge;
    bool barred =
        it->has_barriers && side == SIDE_CAMERA && prev->kind == VERTEX_SURFACE &&
        scene_is_barred(it->scene, vertex_offset(prev, direction), vertex_offset(next, next->to_prev));
    next->inside.back = barred ? 0 : 1;
    if (!it->has_volumes && barred)
        tally_cross(&next->arrival, 1, 0, it->lanes);
    return !it->has_volumes || flight_settle(it, prev, next);
}

bool path_keeps_bounces(const struct integrator_settings *s, const uint8_t bounces[SCATTER_CLASSES])
{
    return bounces[SCATTER_DIFFUSE] <= s->max_diffuse && bounces[SCATTER_GLOSSY] <= s->max_glossy &&
           bounces[SCATTER_TRANSMISSION] <= s->max_transmission && bounces[SCATTER_VOLUME] <= s->max_volume;
}

uint32_t path_ray_kind(enum scatter_class depth_class)
{
    return depth_class == SCATTER_DIFFUSE  ? RAY_DIFFUSE
           : depth_class == SCATTER_GLOSSY ? RAY_GLOSSY
           : depth_class == SCATTER_VOLUME ? RAY_VOLUME
                                           : RAY_TRANSMISSION;
}

uint32_t path_step_kind(enum side side, const struct vertex *v)
{
    if (v->kind != VERTEX_SURFACE)
        return v->kind == VERTEX_CAMERA ? RAY_CAMERA : RAY_SHADOW;
    if (side == SIDE_LIGHT)
        return any_kind;
    int depth_class = 0;
    while (depth_class + 1 < SCATTER_CLASSES && v[1].bounces[depth_class] == v->bounces[depth_class])
        depth_class++;
    return path_ray_kind((enum scatter_class)depth_class);
}

/* What of the lanes' sum is left after the edge to a vertex and scattering there. By the mean of the lanes' own shares, a lane that is bright
   among dark ones would outgrow its chance at every vertex. */
static float gained(const struct integrator *it, const struct vertex *v, const double gain[LANES_MAX])
{
    const struct arrival *at = &v->arrival;
    double before = lanes_sum(at->throughput, at->lanes), after = 0;
    for (int i = 0; i < v->lanes_out; i++)
        after += gain[i] * at->throughput[v->from[i]];
    return (it->has_volumes ? v->inside.toll : 1) *
           (float)(before > 0 ? after / before : lanes_sum(gain, v->lanes_out) / v->lanes_out);
}

/* Scatters at the last vertex and sets up the flight to the next one. False: absorbed, or lost at roulette. */
static bool scatter(const struct integrator *it, struct worker *w, enum side side, struct subpath *path,
                    uint32_t dimension, struct flight *f)
{
    struct vertex *v = &path->vertex[path->count - 1], *next = v + 1;
    struct scatter drawn;
    struct surface_steps steps;
    double gain[LANES_MAX];
    float u[4];
    for (int i = 0; i < 4; i++)
        u[i] = random_at(w->random, dimension + (uint32_t)i);
    if (!surface_sample(&v->surface, side, v->to_prev, v->arrival.lambda[v->leader], u, &drawn) ||
        !(drawn.pdf > 0) || !bundle_follow(it, w, side, path, dimension, &drawn, v, next, &steps, gain))
        return false;
    /* Seen from the camera, this vertex's scattering sends a ray to the one that a light sub-path came from. */
    if (side == SIDE_LIGHT && !(v[-1].kinds & path_ray_kind((enum scatter_class)drawn.depth_class)))
        return false;
    v->label = drawn.label;
    v->lobe = drawn.lobe;
    v->to_next = drawn.direction;
    v->disperses = drawn.disperses;
    if (path->count - 1 >= it->settings.roulette_start) {
        float survival = clampf(gained(it, v, gain), it->exact ? roulette_floor_exact : roulette_floor, 1);
        if (random_at(w->random, dimension + STEP_ROULETTE) >= survival)
            return false;
        v->drawn *= survival;
        for (int i = 0; i < v->lanes_out; i++)
            gain[i] /= survival;
    }
    for (int i = 0; i < SCATTER_CLASSES; i++)
        next->bounces[i] = (uint8_t)(v->bounces[i] + (i == drawn.depth_class));
    bundle_depart(it, w, side, v, path->count - 1, &steps, gain, next);
    f->ray =
        (struct ray){vertex_offset(v, drawn.direction), drawn.direction, 0, INFINITY,
                     side == SIDE_LIGHT ? any_kind : path_ray_kind((enum scatter_class)drawn.depth_class)};
    if (it->has_volumes)
        f->media = flight_media(v, drawn.direction);
    double throughput = lanes_sum(next->arrival.throughput, next->arrival.lanes);
    /* In exact.c what is dark at this wavelength may be bright at another. */
    return (throughput > 0 || it->exact) && isfinite(throughput) &&
           path_keeps_bounces(&it->settings, next->bounces);
}

/* Adds vertices until the path ends or has `edges` edges. */
static void extend(const struct integrator *it, struct worker *w, enum side side, struct subpath *path,
                   struct flight *f, int edges)
{
    uint32_t block = side == SIDE_CAMERA ? DIM_CAMERA_STEP : w->copying ? DIM_COPY_STEP : DIM_LIGHT_STEP;
    for (int step = 0; path->count <= edges; step++) {
        struct vertex *prev = &path->vertex[path->count - 1], *next = prev + 1;
        f->dimension = block + (uint32_t)step * DIMS_PER_STEP * PASSES_MAX;
        if (step > 0 && !scatter(it, w, side, path, f->dimension, f))
            return;
        if (!fly(it, w, side, f, next) || !arrive(it, side, prev, next, f->ray.direction, f->passed))
            return;
        path->count++;
        w->work[side == SIDE_CAMERA ? BY_CAMERA : w->copying ? BY_CONNECTIONS : BY_SPLATS]++;
    }
}

void path_trace_camera(const struct integrator *it, struct worker *w, float x, float y)
{
    struct subpath *path = &w->camera;
    struct vertex *v = path->vertex;
    float lens[2] = {random_at(w->random, DIM_LENS), random_at(w->random, DIM_LENS + 1)}, u[LANES_MAX],
          pdf_lambda[LANES_MAX], pdf_direction;
    double throughput[LANES_MAX];
    struct flight f;
    vertex_begin(v, VERTEX_CAMERA);
    arrival_begin(&v->arrival, it->lanes, 1, wavelengths_sink_camera(&it->wavelengths));
    v->unbounded = scene_camera_is_orthographic(it->scene);
    f.ray = scene_camera_ray(it->scene, x, y, lens, &v->lens, &pdf_direction);
    v->position = v->lens.position;
    v->to_next = f.ray.direction;
    if (it->has_volumes)
        f.media = v->inside.media =
            scene_camera_media(it->scene, along(f.ray.origin, f.ray.direction, f.ray.near), f.ray.direction);
    v->drawn = pdf_direction;
    v->lanes_out = it->lanes;
    lanes_stratify(random_at(w->random, DIM_LAMBDA), it->lanes, u);
    for (int i = 0; i < it->lanes; i++) {
        v->lambda_out[i] = spectrum_sample(it->wavelengths.camera, u[i], &pdf_lambda[i]);
        v->own[i] = pdf_lambda[i] * pdf_direction;
        v->other[i] = 0;
        throughput[i] = 1 / (double)pdf_lambda[i]; /* importance over the density of directions is 1 */
    }
    path->count = 1;
    bundle_depart_end(it, w, SIDE_CAMERA, v, throughput, pdf_lambda, 0, &v[1]);
    extend(it, w, SIDE_CAMERA, path, &f, it->camera_edges);
}

/* --- Light sub-paths, and the copying kind (algorithm.md §9) ------------------------------------------------------- */

bool path_light_vertex(const struct integrator *it, const float u[3], struct vertex *v)
{
    vertex_begin(v, VERTEX_LIGHT);
    if (!scene_sample_light(it->scene, u, &v->light, &v->pdf_point))
        return false;
    v->position = v->light.position;
    v->unbounded = v->light.distant;
    v->kinds = scene_light_kinds(it->scene, v->light.light);
    arrival_begin(&v->arrival, it->lanes, 1 / (double)v->pdf_point,
                  scene_light_shape(it->scene, v->light.light));
    return true;
}

/* The lanes of the first run: from the light's spectrum, or one of the camera's. `drawn` are their densities, a copy's chance included. */
static bool first_lambdas(const struct integrator *it, struct worker *w, struct vertex *v, uint32_t block,
                          float pdf[LANES_MAX], double drawn[LANES_MAX])
{
    struct copying *copying = w->copying;
    float u[LANES_MAX];
    if (it->settings.shared_wavelength) { /* the camera's: nothing is drawn here */
        v->lanes_out = 1;
        v->lambda_out[0] = spectrum_sample(it->wavelengths.camera, random_at(w->random, DIM_LAMBDA), pdf);
        pdf[0] = 1;
        drawn[0] = 1;
        return true;
    }
    double chance = copying ? bundle_choose_copy(w, copying, block + DIM_LAMBDA) : 1;
    bool copies = copying && copying->taken >= 0;
    v->lanes_out = copying ? 1 : it->lanes;
    lanes_stratify(random_at(w->random, block + DIM_LIGHT_LAMBDA), v->lanes_out, u);
    for (int i = 0; i < v->lanes_out; i++) {
        if (copies) {
            v->lambda_out[i] = copying->lambda[copying->taken];
            pdf[i] = scene_pdf_light_lambda(it->scene, &v->light, v->lambda_out[i]);
        } else {
            v->lambda_out[i] = scene_sample_light_lambda(it->scene, &v->light, u[i], &pdf[i]);
        }
        drawn[i] = copies ? chance : chance * pdf[i];
    }
    return pdf[0] > 0;
}

static bool start_light(const struct integrator *it, struct worker *w, struct subpath *path, uint32_t block,
                        struct flight *f)
{
    struct vertex *v = path->vertex;
    float u[3], turn[2], pdf_direction, pdf[LANES_MAX];
    double drawn[LANES_MAX], throughput[LANES_MAX];
    for (uint32_t i = 0; i < 3; i++)
        u[i] = random_at(w->random, block + DIM_LIGHT + i);
    for (uint32_t i = 0; i < 2; i++)
        turn[i] = random_at(w->random, block + DIM_LIGHT_DIRECTION + i);
    path->count = 0;
    if (!path_light_vertex(it, u, v))
        return false;
    path->count = 1;
    if (!first_lambdas(it, w, v, block, pdf, drawn) ||
        !scene_sample_light_direction(it->scene, &v->light, turn, &f->ray.origin, &f->ray.direction,
                                      &pdf_direction))
        return false;
    v->to_next = f->ray.direction;
    if (it->has_volumes)
        f->media = v->unbounded ? scene_open_media(it->scene)
                                : scene_media_at(it->scene, f->ray.origin, f->ray.direction);
    v->drawn = pdf_direction;
    for (int i = 0; i < v->lanes_out; i++) {
        float emitted = scene_light_emission(it->scene, &v->light, f->ray.direction, v->lambda_out[i]);
        v->own[i] = pdf[i] * pdf_direction;
        v->other[i] = 0;
        throughput[i] = v->arrival.throughput[i] * emitted / (drawn[i] * pdf_direction);
    }
    /* Lanes of the two sides are paired by number: what leads on one must have no certain partner on the other. */
    int leader = (int)(random_at(w->random, block + DIM_LIGHT_LEADER) * (float)v->lanes_out);
    bundle_depart_end(it, w, SIDE_LIGHT, v, throughput, pdf, leader, &v[1]);
    double sum = lanes_sum(throughput, v->lanes_out);
    return isfinite(sum) && (sum > 0 || (it->exact && !w->copying));
}

void path_trace_light(const struct integrator *it, struct worker *w)
{
    struct flight f = {.ray = {.far = INFINITY, .kind = RAY_SHADOW}};
    if (start_light(it, w, &w->light, 0, &f))
        extend(it, w, SIDE_LIGHT, &w->light, &f, it->light_edges);
}

void path_trace_copy(const struct integrator *it, struct worker *w, struct copying *copying)
{
    struct flight f = {.ray = {.far = INFINITY, .kind = RAY_SHADOW}};
    copying->taken = -1;
    copying->start = 0;
    w->copying = copying;
    if (start_light(it, w, &w->copy, DIM_COPY, &f))
        extend(it, w, SIDE_LIGHT, &w->copy, &f, it->light_edges);
    w->copying = NULL;
}
