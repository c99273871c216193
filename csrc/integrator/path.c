/* Sub-path tracing: grows a path from the camera or a light, one vertex a call, and fills throughput, both densities and
   the geometry term of each step, for a bundle of wavelengths. Transparent surfaces are no vertices: a ray passes them with the probability of their
   transmittance, and no density that enters a weight holds that factor, on either side. */
#include "integrator/path.h"

#include <string.h>

#include "integrator/gather.h"
#include "integrator/tally.h"

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
    bool passed;        /* a transparent surface */
};

/* Passes a transparent surface or stops there, with a chance that all lanes share; each owes the difference. */
static bool passes(const struct worker *w, const struct flight *f, int pass, const struct material *material,
                   struct vertex *next)
{
    struct arrival *at = &next->arrival;
    double tau[LANES_MAX];
    for (int i = 0; i < at->lanes; i++)
        tau[i] = material_transmittance(material, &next->hit, negate(f->ray.direction), at->lambda[i]);
    float chance = (float)(lanes_sum(tau, at->lanes) / at->lanes);
    bool passed = random_at(w->random, f->dimension + (uint32_t)pass * DIMS_PER_STEP + STEP_PASS) < chance;
    float owed = 1 / (passed ? chance : 1 - chance);
    next->passage *= owed;
    for (int i = 0; i < at->lanes; i++)
        at->throughput[i] *= passed ? tau[i] * owed : owed;
    return passed;
}

/* How much of what a camera's own ray meets is a hole in the picture: all of an object, or the share of a material. */
static float hole_at(const struct integrator *it, const struct material *material, const struct vertex *next,
                     const struct flight *f)
{
    if (next[-1].kind != VERTEX_CAMERA)
        return 0;
    return scene_hit_is_holdout(it->scene, &next->hit)
               ? 1
               : material_holdout(material, &next->hit, negate(f->ray.direction));
}

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
            gather_lamps(it, w, &seen, f->passed, !met);
        }
        if (!met)
            return false;
        float hole = hole_at(it, material, next, f), before = next->passage;
        if (side == SIDE_CAMERA && hole < 1 && next->hit.light >= 0)
            gather_surface(it, w, &next->hit, f->ray.direction, f->passed);
        if (!material_may_be_transparent(material) || !passes(w, f, pass, material, next)) {
            /* Where it might have passed, what stops counts for all. */
            w->hole = hole > 0 ? fminf(1, hole * next->passage / before) : w->hole;
            if (hole >= 1)
                return false;
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
                   struct vec3 direction, bool passed)
{
    next->kind = VERTEX_SURFACE;
    next->kinds = scene_hit_kinds(it->scene, &next->hit);
    next->label = LABEL_ELASTIC;
    next->disperses = false;
    next->memo[MEMO_ARRIVING].lanes = next->memo[MEMO_OTHERS].lanes = 0;
    next->unbounded = false;
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
    return true;
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
    *chance = choose_copy(w, copying, dimension + STEP_COPY);
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

/* Everything that the lanes owe after a drawn step: densities, who might have led, gains. False if nothing lives on. */
static bool follow(const struct integrator *it, struct worker *w, enum side side, const struct subpath *path,
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

/* The next vertex's arrival, but for the edge to it. */
static void depart(const struct integrator *it, const struct worker *w, enum side side,
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
    tally_pass(it, w, side, v, here, v->from, steps, there);
    arrival_fill(there, next->lambda_film, it->lanes);
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
        !(drawn.pdf > 0) || !follow(it, w, side, path, dimension, &drawn, v, next, &steps, gain))
        return false;
    /* Seen from the camera, this vertex's scattering sends a ray to the one that a light sub-path came from. */
    if (side == SIDE_LIGHT && !(v[-1].kinds & path_ray_kind((enum scatter_class)drawn.depth_class)))
        return false;
    v->label = drawn.label;
    v->lobe = drawn.lobe;
    v->to_next = drawn.direction;
    v->disperses = drawn.disperses;
    if (path->count - 1 >= it->settings.roulette_start) {
        float survival = clampf((float)(lanes_sum(gain, v->lanes_out) / v->lanes_out), roulette_floor, 1);
        if (random_at(w->random, dimension + STEP_ROULETTE) >= survival)
            return false;
        v->drawn *= survival;
        for (int i = 0; i < v->lanes_out; i++)
            gain[i] /= survival;
    }
    for (int i = 0; i < SCATTER_CLASSES; i++)
        next->bounces[i] = (uint8_t)(v->bounces[i] + (i == drawn.depth_class));
    depart(it, w, side, v, path->count - 1, &steps, gain, next);
    f->ray =
        (struct ray){scene_offset(&v->hit, drawn.direction), drawn.direction, 0, INFINITY,
                     side == SIDE_LIGHT ? any_kind : path_ray_kind((enum scatter_class)drawn.depth_class)};
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
        if (!fly(it, w, side, f, next) || !arrive(it, prev, next, f->ray.direction, f->passed))
            return;
        path->count++;
    }
}

/* What arrives at vertex 1 from an end whose lanes are set. */
static void depart_end(const struct integrator *it, const struct worker *w, enum side side,
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
    tally_pass(it, w, side, end, &end->arrival, end->from, &steps, there);
    arrival_fill(there, next->lambda_film, it->lanes);
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
    depart_end(it, w, SIDE_CAMERA, v, throughput, pdf_lambda, 0, &v[1]);
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
    double chance = copying ? choose_copy(w, copying, block + DIM_LAMBDA) : 1;
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
    v->drawn = pdf_direction;
    for (int i = 0; i < v->lanes_out; i++) {
        float emitted = scene_light_emission(it->scene, &v->light, f->ray.direction, v->lambda_out[i]);
        v->own[i] = pdf[i] * pdf_direction;
        v->other[i] = 0;
        throughput[i] = v->arrival.throughput[i] * emitted / (drawn[i] * pdf_direction);
    }
    /* Lanes of the two sides are paired by number: what leads on one must have no certain partner on the other. */
    int leader = (int)(random_at(w->random, block + DIM_LIGHT_LEADER) * (float)v->lanes_out);
    depart_end(it, w, SIDE_LIGHT, v, throughput, pdf, leader, &v[1]);
    double sum = lanes_sum(throughput, v->lanes_out);
    return isfinite(sum) && (sum > 0 || (it->exact && !w->copying));
}

void path_trace_light(const struct integrator *it, struct worker *w)
{
    struct flight f = {.ray = {.far = INFINITY, .kind = any_kind}};
    if (start_light(it, w, &w->light, 0, &f))
        extend(it, w, SIDE_LIGHT, &w->light, &f, it->light_edges);
}

void path_trace_copy(const struct integrator *it, struct worker *w, struct copying *copying)
{
    struct flight f = {.ray = {.far = INFINITY, .kind = any_kind}};
    copying->taken = -1;
    copying->start = 0;
    w->copying = copying;
    if (start_light(it, w, &w->copy, DIM_COPY, &f))
        extend(it, w, SIDE_LIGHT, &w->copy, &f, it->light_edges);
    w->copying = NULL;
}
