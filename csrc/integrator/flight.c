/* Flights: transparent surfaces are no vertices, so a ray passes them with the probability of their transmittance, and no density that enters a weight holds
   that factor, on either side. In volumes a distance is drawn, by a density that all wavelengths and both sides share (algorithm.md §13). */
#include "integrator/flight.h"

#include "integrator/gather.h"
#include "integrator/tally.h"

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

/* --- Volumes ------------------------------------------------------------------------------------------------- */

/* A run keeps its rate: after each edge, the odds are what that says of it. So a run's weight is bounded as one edge's is. A new run
   begins anew, for its wavelengths know nothing of the old one's. */
static bool starts_run(const struct vertex *v)
{
    return v->label == LABEL_FLUORESCENT;
}

static int choose_rate(const struct vertex *from, float u)
{
    int k = 0;
    if (starts_run(from))
        return (int)(u * VOLUME_RATES);
    while (k + 1 < VOLUME_RATES && u >= from->inside.odds[k])
        u -= from->inside.odds[k++];
    return k;
}

struct length_density flight_density(const struct integrator *it, const struct vertex *from,
                                     const struct crossing *crossing, const struct media *end,
                                     float odds[VOLUME_RATES])
{
    struct length_density sum = {0};
    double density[VOLUME_RATES];
    bool fresh = starts_run(from);
    crossing_densities(it->scene, crossing, end, density);
    for (int k = 0; k < VOLUME_RATES; k++) {
        sum.nominal += density[k] / VOLUME_RATES;
        sum.drawn += density[k] *= fresh ? 1.0 / VOLUME_RATES : (double)from->inside.odds[k];
    }
    for (int k = 0; odds && sum.drawn > 0 && k < VOLUME_RATES; k++)
        odds[k] = (float)(density[k] / sum.drawn);
    return sum;
}

double flight_nominal(const struct integrator *it, const struct crossing *crossing, const struct vertex *to)
{
    double density[VOLUME_RATES], sum = 0;
    crossing_densities(it->scene, crossing, to->in_volume ? &to->inside.media : NULL, density);
    for (int k = 0; k < VOLUME_RATES; k++)
        sum += density[k];
    return sum / VOLUME_RATES;
}

/* Draws the optical depth at which volumes end the flight, and which of their rates counts it. */
static void draw_depth(const struct integrator *it, const struct worker *w, struct flight *f,
                       struct vertex *next)
{
    uint32_t dimension = f->dimension + (PASSES_MAX - 1) * DIMS_PER_STEP;
    const struct vertex *prev = next - 1;
    next->inside.crossing.count = 0;
    if (prev->kind == VERTEX_LIGHT && prev->unbounded) { /* from infinity to where the ray starts */
        struct media open = scene_open_media(it->scene);
        crossing_add(&next->inside.crossing, &open, INFINITY);
    }
    f->rate = choose_rate(prev, random_at(w->random, dimension + STEP_RATE));
    f->depth = -log1p(-(double)random_at(w->random, dimension + STEP_DEPTH));
}

/* How far along the ray volumes let it fly. */
static float reach(const struct integrator *it, const struct flight *f, const struct vertex *next)
{
    double rate = media_rate(it->scene, &f->media, f->rate);
    if (!(rate > 0))
        return INFINITY;
    double left = f->depth - crossing_depth(it->scene, &next->inside.crossing, f->rate);
    return left > 0 ? f->ray.near + (float)(left / rate) : -INFINITY;
}

/* Scatters inside of volumes, at this distance. */
static bool stop_inside(const struct integrator *it, const struct flight *f, float t, struct vertex *next)
{
    crossing_add(&next->inside.crossing, &f->media, t - f->ray.near);
    next->in_volume = true;
    next->inside.media = f->media;
    next->position = along(f->ray.origin, f->ray.direction, t);
    next->hit.ng = vec3(0, 0, 0);
    next->hit.light = -1;
    return t > f->ray.near && scene_shade_media(it->scene, &f->media, &next->surface);
}

struct media flight_media(const struct vertex *v, struct vec3 direction)
{
    struct media media = v->inside.media;
    float to_next = dot(direction, v->hit.ng);
    if (v->kind == VERTEX_SURFACE && !v->in_volume && v->inside.boundary >= 0 &&
        to_next * dot(v->to_prev, v->hit.ng) < 0)
        media_pass(&media, v->inside.boundary, to_next < 0);
    return media;
}

bool flight_settle(const struct integrator *it, const struct vertex *prev, struct vertex *next)
{
    struct arrival *at = &next->arrival;
    const struct crossing *c = &next->inside.crossing;
    double before = lanes_sum(at->throughput, it->lanes), mean = 0;
    struct length_density density =
        flight_density(it, prev, c, next->in_volume ? &next->inside.media : NULL, next->inside.odds);
    next->inside.flown = density.drawn;
    next->inside.ahead = density.nominal;
    next->inside.back *= flight_nominal(it, c, prev);
    if (!(next->inside.flown > 0) || !(next->inside.ahead > 0))
        return false;
    for (int i = 0; i < it->lanes; i++) {
        double left = crossing_transmittance(it->scene, c, at->lambda[i]) / next->inside.flown;
        at->throughput[i] *= left;
        mean += left / it->lanes;
    }
    next->inside.toll = (float)(before > 0 ? lanes_sum(at->throughput, it->lanes) / before : mean);
    tally_cross(at, next->inside.ahead, next->inside.back, it->lanes);
    double sum = lanes_sum(at->throughput, at->lanes);
    return isfinite(sum) && (sum > 0 || it->exact);
}

/* --- The flight ---------------------------------------------------------------------------------------------- */

/* The picture's alpha where a camera's ray leaves the scene: what volumes let through of the void behind. */
static void leave(const struct integrator *it, struct worker *w, const struct flight *f, struct vertex *next)
{
    struct crossing crossing = next->inside.crossing;
    double left = 0;
    if (next[-1].kind != VERTEX_CAMERA)
        return;
    crossing_add(&crossing, &f->media, INFINITY);
    double density = flight_density(it, next - 1, &crossing, NULL, NULL).drawn;
    for (int i = 0; i < it->lanes; i++)
        left += crossing_transmittance(it->scene, &crossing, next->arrival.lambda[i]) / it->lanes;
    w->veil = density > 0 ? (float)(1 - left / density) : 1;
}

/* What the camera's ray sees up to `far`. */
static void look_along(const struct integrator *it, struct worker *w, const struct flight *f, float far,
                       bool to_infinity)
{
    struct ray seen = f->ray;
    seen.far = far;
    gather_lamps(it, w, &seen, f->passed, to_infinity, &f->media);
}

/* Behind a surface that lets the ray through. */
static void go_on(const struct integrator *it, struct flight *f, const struct material *material,
                  const struct vertex *next)
{
    int volume = it->has_volumes ? material_volume(material) : -1;
    if (volume >= 0)
        media_pass(&f->media, volume, dot(f->ray.direction, next->hit.ng) < 0);
    f->passed |= !material_is_clear(material);
    /* The camera's clipping distances are from the camera. */
    f->ray.near = 0;
    f->ray.far -= length(sub(next->hit.position, f->ray.origin));
    f->ray.origin = scene_offset(&next->hit, f->ray.direction);
}

bool fly(const struct integrator *it, struct worker *w, enum side side, struct flight *f, struct vertex *next)
{
    const struct material *material;
    bool volumes = it->has_volumes, camera = side == SIDE_CAMERA;
    f->passed = next->in_volume = false;
    next->passage = 1;
    if (volumes)
        draw_depth(it, w, f, next);
    for (int pass = 0; pass < PASSES_MAX; pass++) {
        bool met = scene_intersect(it->scene, &f->ray, &next->hit, &material);
        float far = met ? length(sub(next->hit.position, f->ray.origin)) : f->ray.far,
              stop = volumes ? reach(it, f, next) : INFINITY;
        bool stops = stop < (met ? far : INFINITY);
        if (camera)
            look_along(it, w, f, stops ? stop : far, !met && !stops);
        if (stops)
            return stop_inside(it, f, stop, next);
        if (!met) {
            if (volumes && camera)
                leave(it, w, f, next);
            return false;
        }
        if (volumes)
            crossing_add(&next->inside.crossing, &f->media, far - f->ray.near);
        float hole = hole_at(it, material, next, f), before = next->passage;
        if (camera && hole < 1 && next->hit.light >= 0)
            gather_surface(it, w, &next->hit, f->ray.direction, f->passed);
        bool clear = material_is_clear(material);
        if (!clear && (!material_may_be_transparent(material) || !passes(w, f, pass, material, next))) {
            /* Where it might have passed, what stops counts for all. */
            w->hole = hole > 0 ? fminf(1, hole * next->passage / before) : w->hole;
            if (hole >= 1)
                return false;
            break;
        }
        bool barred = f->ray.kind != RAY_SHADOW && (scene_hit_kinds(it->scene, &next->hit) & SEEN_BY_SOME);
        if (pass + 1 == PASSES_MAX || (!camera && barred))
            return false;
        go_on(it, f, material, next);
    }
    if (volumes) {
        next->inside.media = f->media;
        next->inside.boundary = material_volume(material);
    }
    material_shade(material, &next->hit, negate(f->ray.direction), &next->surface);
    return true;
}
