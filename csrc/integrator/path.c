/* Sub-path tracing: grows a path from the camera or a light, one vertex a call, and fills throughput, both densities and
   the geometry term of each step. Transparent surfaces are no vertices: a ray passes them with the probability of their
   transmittance, and no density that enters a weight holds that factor, on either side. */
#include "integrator/path.h"

#include <string.h>

#include "integrator/gather.h"

/* Roulette never kills with more than this probability; it divides the contribution and stays out of the weights. */
static const float roulette_floor = 0.05f;
/* A grazing edge whose cosine is below this has no density that floats can hold. */
static const float cosine_min = 1e-6f;

struct vec3 vertex_offset(const struct vertex *v, struct vec3 direction)
{
    if (v->kind == VERTEX_SURFACE)
        return scene_offset(&v->hit, direction);
    if (v->kind == VERTEX_LIGHT && v->light.on_mesh)
        return scene_offset(&v->light.hit, direction);
    return v->position;
}

/* What one step of a sub-path needs while it looks for the next surface. */
struct flight {
    struct ray ray;
    uint32_t dimension; /* of the next pass */
    double throughput;
    bool passed; /* a transparent surface */
};

/* Follows the ray to the next surface that scatters it; every emitter on the way is offered to `gather` (camera side).
   Returns false when the path ends: it left the scene, or met only glass-clear surfaces for too long. */
static bool fly(const struct integrator *it, struct worker *w, enum side side, struct flight *f,
                struct vertex *next)
{
    const struct material *material;
    f->passed = false;
    next->passage = 1;
    for (int pass = 0; pass < PASSES_MAX; pass++) {
        bool met = scene_intersect(it->scene, &f->ray, &next->hit, &material);
        if (side == SIDE_CAMERA) {
            struct ray seen = f->ray;
            if (met)
                seen.far = length(sub(next->hit.position, f->ray.origin));
            gather_lamps(it, w, &seen, f->throughput, f->passed, !met);
        }
        if (!met)
            return false;
        if (side == SIDE_CAMERA && next->hit.light >= 0)
            gather_surface(it, w, &next->hit, f->ray.direction, f->throughput, f->passed);
        if (!material_may_be_transparent(material))
            break;
        float passed =
            material_transmittance(material, &next->hit, negate(f->ray.direction), next->lambda_in);
        if (random_at(w->random, f->dimension + (uint32_t)pass * DIMS_PER_STEP + 5) >= passed) {
            next->passage = 1 / (1 - passed);
            f->throughput *= next->passage;
            break;
        }
        f->passed = true;
        if (pass + 1 == PASSES_MAX)
            return false;
        /* The camera's clipping distances are from the camera. */
        f->ray.near = 0;
        f->ray.far -= length(sub(next->hit.position, f->ray.origin));
        f->ray.origin = scene_offset(&next->hit, f->ray.direction);
    }
    material_shade(material, &next->hit, negate(f->ray.direction), &next->surface);
    return true;
}

/* Fills what a new surface vertex knows of the edge to its predecessor. */
static bool arrive(const struct integrator *it, struct vertex *prev, struct vertex *next,
                   struct vec3 direction, double throughput, bool passed)
{
    next->kind = VERTEX_SURFACE;
    next->kinds = scene_hit_kinds(it->scene, &next->hit);
    next->label = LABEL_ELASTIC;
    next->disperses = false;
    next->unbounded = false;
    next->position = next->hit.position;
    next->to_prev = negate(direction);
    next->throughput = throughput;
    next->passed = passed;
    float cosines = vertex_cosine(prev, direction) * vertex_cosine(next, direction);
    next->geometry =
        prev->unbounded ? cosines : cosines / length_squared(sub(next->position, prev->position));
    return cosines > cosine_min * cosine_min && isfinite(next->geometry);
}

bool path_keeps_bounces(const struct integrator_settings *s, const uint8_t bounces[SCATTER_CLASSES])
{
    return bounces[SCATTER_DIFFUSE] <= s->max_diffuse && bounces[SCATTER_GLOSSY] <= s->max_glossy &&
           bounces[SCATTER_TRANSMISSION] <= s->max_transmission;
}

/* What a light sub-path meets may be seen by any kind of ray; which one, its scattering there decides. */
static const uint32_t any_kind = RAY_CAMERA | RAY_DIFFUSE | RAY_GLOSSY | RAY_TRANSMISSION;

uint32_t path_ray_kind(enum scatter_class depth_class)
{
    return depth_class == SCATTER_DIFFUSE  ? RAY_DIFFUSE
           : depth_class == SCATTER_GLOSSY ? RAY_GLOSSY
                                           : RAY_TRANSMISSION;
}

/* The wavelength of a run that begins: its own with chance q_own, or one of the camera's. Returns the chance of what was chosen. */
static double choose_copy(const struct worker *w, struct copying *copying, uint32_t dimension)
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

/* A copying light sub-path begins a run at a dye: with its own wavelength, or with one of the camera's. What was copied before the dye
   and again after it would be singular, so such a path ends. */
static bool copy_at_dye(struct worker *w, const struct subpath *path, uint32_t dimension,
                        const struct vertex *v, struct scatter *drawn, double *gain)
{
    struct copying *copying = w->copying;
    struct surface_step step;
    if (copying->taken >= 0)
        return false;
    double chance = choose_copy(w, copying, dimension);
    if (copying->taken < 0) {
        *gain /= chance;
        return true;
    }
    float lambda = copying->lambda[copying->taken];
    double direction =
        drawn->pdf / spectrum_pdf(surface_fluorescent_emission(&v->surface, drawn->lobe), drawn->lambda);
    copying->start = path->count - 1;
    if (!surface_step_again(&v->surface, SIDE_LIGHT, LABEL_FLUORESCENT, drawn->lobe, v->to_prev,
                            drawn->direction, v->lambda_in, lambda, &step) ||
        !(step.value > 0))
        return false;
    drawn->lambda = lambda;
    drawn->value = step.value;
    drawn->pdf = step.pdf;
    drawn->pdf_other = step.pdf_other;
    *gain = step.value / (direction * chance);
    return true;
}

/* Scatters at the last vertex and sets up the flight to the next one. False: absorbed, or lost at roulette. */
static bool scatter(const struct integrator *it, struct worker *w, enum side side, struct subpath *path,
                    uint32_t dimension, struct flight *f)
{
    struct vertex *v = &path->vertex[path->count - 1], *next = v + 1;
    struct scatter drawn;
    float u[4];
    for (int i = 0; i < 4; i++)
        u[i] = random_at(w->random, dimension + (uint32_t)i);
    if (!surface_sample(&v->surface, side, v->to_prev, v->lambda_in, u, &drawn) || !(drawn.pdf > 0))
        return false;
    double gain = (double)drawn.value / drawn.pdf;
    if (w->copying && drawn.label == LABEL_FLUORESCENT &&
        !copy_at_dye(w, path, dimension + 6, v, &drawn, &gain))
        return false;
    /* Seen from the camera, this vertex's scattering sends a ray to the one that a light sub-path came from. */
    if (side == SIDE_LIGHT && !(v[-1].kinds & path_ray_kind((enum scatter_class)drawn.depth_class)))
        return false;
    v->label = drawn.label;
    v->lobe = drawn.lobe;
    v->to_next = drawn.direction;
    v->lambda_out = drawn.lambda;
    v->pdf_own = drawn.pdf;
    v->pdf_other = drawn.pdf_other;
    v->disperses = drawn.disperses;
    v->survival = 1;
    if (path->count - 1 >= it->settings.roulette_start) {
        v->survival = clampf((float)gain, roulette_floor, 1);
        if (random_at(w->random, dimension + 4) >= v->survival)
            return false;
    }
    next->lambda_in = drawn.lambda;
    next->run_disperses = drawn.label != LABEL_FLUORESCENT && (v->run_disperses || drawn.disperses);
    for (int i = 0; i < SCATTER_CLASSES; i++)
        next->bounces[i] = (uint8_t)(v->bounces[i] + (i == drawn.depth_class));
    f->throughput = v->throughput * gain / v->survival;
    f->ray =
        (struct ray){scene_offset(&v->hit, drawn.direction), drawn.direction, 0, INFINITY,
                     side == SIDE_LIGHT ? any_kind : path_ray_kind((enum scatter_class)drawn.depth_class)};
    /* In exact.c what is dark at this wavelength may be bright at another. */
    return (f->throughput > 0 || it->exact) && isfinite(f->throughput) &&
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
        if (!fly(it, w, side, f, next) || !arrive(it, prev, next, f->ray.direction, f->throughput, f->passed))
            return;
        path->count++;
    }
}

void path_trace_camera(const struct integrator *it, struct worker *w, float x, float y)
{
    struct subpath *path = &w->camera;
    struct vertex *v = path->vertex;
    float lens[2] = {random_at(w->random, DIM_LENS), random_at(w->random, DIM_LENS + 1)}, pdf_lambda,
          pdf_direction;
    float lambda = spectrum_sample(it->wavelengths.camera, random_at(w->random, DIM_LAMBDA), &pdf_lambda);
    vertex_begin(v, VERTEX_CAMERA);
    v->lambda_out = lambda;
    v->unbounded = scene_camera_is_orthographic(it->scene);
    struct flight f = {.ray = scene_camera_ray(it->scene, x, y, lens, &v->lens, &pdf_direction),
                       .throughput = 1 / (double)pdf_lambda};
    v->position = v->lens.position;
    v->to_next = f.ray.direction;
    v->pdf_own = pdf_lambda * pdf_direction;
    path->count = 1;
    v[1].lambda_in = lambda;
    v[1].run_disperses = false;
    memset(v[1].bounces, 0, sizeof v[1].bounces);
    extend(it, w, SIDE_CAMERA, path, &f, it->camera_edges);
}

/* --- Light sub-paths, and the copying kind (algorithm.md §9) ------------------------------------------------------- */

static bool start_light(const struct integrator *it, struct worker *w, struct subpath *path, uint32_t block,
                        struct copying *copying, struct flight *f)
{
    struct vertex *v = path->vertex;
    float u[3], turn[2], pdf_lambda, pdf_direction;
    for (uint32_t i = 0; i < 3; i++)
        u[i] = random_at(w->random, block + DIM_LIGHT + i);
    for (uint32_t i = 0; i < 2; i++)
        turn[i] = random_at(w->random, block + DIM_LIGHT_DIRECTION + i);
    path->count = 0;
    vertex_begin(v, VERTEX_LIGHT);
    if (!scene_sample_light(it->scene, u, &v->light, &v->pdf_point))
        return false;
    v->position = v->light.position;
    v->unbounded = v->light.distant;
    v->kinds = scene_light_kinds(it->scene, v->light.light);
    v->throughput = 1 / (double)v->pdf_point;
    path->count = 1;
    v->lambda_out = scene_sample_light_lambda(it->scene, &v->light,
                                              random_at(w->random, block + DIM_LIGHT_LAMBDA), &pdf_lambda);
    if (!(pdf_lambda > 0) || !scene_sample_light_direction(it->scene, &v->light, turn, &f->ray.origin,
                                                           &f->ray.direction, &pdf_direction))
        return false;
    double actual = (double)pdf_lambda * pdf_direction;
    if (copying) {
        double chance = choose_copy(w, copying, block + DIM_LAMBDA);
        if (copying->taken >= 0) {
            v->lambda_out = copying->lambda[copying->taken];
            pdf_lambda = scene_pdf_light_lambda(it->scene, &v->light, v->lambda_out);
            actual = pdf_direction;
        }
        actual *= chance;
    }
    v->to_next = f->ray.direction;
    v->pdf_own = pdf_lambda * pdf_direction;
    f->throughput =
        v->throughput * scene_light_emission(it->scene, &v->light, f->ray.direction, v->lambda_out) / actual;
    v[1].lambda_in = v->lambda_out;
    v[1].run_disperses = false;
    memset(v[1].bounces, 0, sizeof v[1].bounces);
    return isfinite(f->throughput) && (f->throughput > 0 || (it->exact && !copying));
}

void path_trace_light(const struct integrator *it, struct worker *w)
{
    struct flight f = {.ray = {.far = INFINITY, .kind = any_kind}};
    if (start_light(it, w, &w->light, 0, NULL, &f))
        extend(it, w, SIDE_LIGHT, &w->light, &f, it->light_edges);
}

void path_trace_copy(const struct integrator *it, struct worker *w, struct copying *copying)
{
    struct flight f = {.ray = {.far = INFINITY, .kind = any_kind}};
    copying->taken = -1;
    copying->start = 0;
    w->copying = copying;
    if (start_light(it, w, &w->copy, DIM_COPY, copying, &f))
        extend(it, w, SIDE_LIGHT, &w->copy, &f, it->light_edges);
    w->copying = NULL;
}
