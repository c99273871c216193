/* Adds emission that a camera sub-path runs into, weighted against the techniques that connect to it. */
#include "integrator/gather.h"

#include "integrator/flight.h"
#include "integrator/mis.h"
#include "integrator/relight.h"
#include "integrator/roulette.h"
#include "integrator/tally.h"
#include "integrator/trial.h"

enum { LAMPS_MAX = 16 };

/* What the last edge crosses of volumes, and the densities of its length: nominal ones for the camera's step over it and for the light's, and with which it
   was really drawn. */
struct veil {
    struct crossing crossing;
    double ahead, back, flown;
};

/* What a camera sub-path ran into. */
struct sighting {
    const struct light_point *light;
    struct vec3 direction;   /* of the ray */
    bool passed;             /* transparent surfaces on the last edge */
    const struct veil *veil; /* of volumes; NULL in a scene without */
};

/* Where nothing dispersed, the last run's wavelengths are drawn after the hit, from what the light emits and the run's start takes
   (algorithm.md §9): so a path tracer, too, sees a line spectrum. Fills `strand` and the lanes' densities. */
static bool relight_sighting(const struct integrator *it, struct worker *w, uint32_t dimension,
                             const struct sighting *seen, struct strand *strand, double density[LANES_MAX])
{
    const struct subpath *camera = &w->camera;
    const struct vertex *last = &camera->vertex[camera->count - 1], *next = last + 1;
    float lambda[LANES_MAX];
    if (!draw_product(it, w, scene_light_shape(it->scene, seen->light->light), next->arrival.origin,
                      dimension, it->lanes, lambda, density) ||
        relight(it, w, SIDE_CAMERA, camera, next->arrival.start, camera->count, it->lanes, lambda, strand) <
            camera->count)
        return false;
    struct arrival *at = &strand->at[camera->count];
    bool distant = seen->light->distant;
    for (int i = 0; i < it->lanes; i++) {
        at->throughput[i] *= (double)next->passage;
        if (seen->passed)
            at->throughput[i] *= edge_transmittance(
                it, SIDE_CAMERA, last, distant ? NULL : &seen->light->position, seen->direction, lambda[i]);
    }
    return true;
}

static double edge_geometry(const struct vertex *last, const struct sighting *seen)
{
    const struct light_point *light = seen->light;
    float cosines = vertex_cosine(last, seen->direction);
    if (light->distant || last->unbounded)
        return light->distant ? cosines : cosines * fabsf(dot(light->normal, seen->direction));
    if (light->has_normal)
        cosines *= fabsf(dot(light->normal, seen->direction));
    return cosines / length_squared(sub(light->position, last->position));
}

/* For observers and chosen subsets of techniques: one lane as a whole path. */
static void whole_path(const struct worker *w, const struct sighting *seen, const struct strand *strand,
                       double pdf_point, double geometry, float fwd, int lane, struct full_path *path)
{
    int edges = w->camera.count;
    full_path_of_camera(w, &w->camera, edges, strand, lane, path);
    path->light = seen->light;
    path->pdf_point = pdf_point;
    path->step[1].geometry = geometry;
    path->step[1].along = seen->veil ? seen->veil->back : 1;
    path->step[1].against = seen->veil ? seen->veil->ahead : 1;
    path->step[0] = (struct full_step){.fwd = fwd, .label = LABEL_FLUORESCENT, .dye = -1};
}

/* By no more than mirrors and clear glass. */
static bool camera_sees_light(const struct subpath *camera)
{
    for (int i = 1; i < camera->count; i++)
        if (camera->vertex[i].label != LABEL_SPECULAR)
            return false;
    return true;
}

static void gather_point(const struct integrator *it, struct worker *w, const struct sighting *seen)
{
    const struct light_point *light = seen->light;
    int edges = w->camera.count;
    const struct vertex *last = &w->camera.vertex[edges - 1], *next = last + 1;
    struct vec3 back = negate(seen->direction);
    struct strand *strand = it->exact && !next->arrival.disperses ? w->strand[SIDE_CAMERA] : NULL;
    double density[LANES_MAX], value[LANES_MAX], weight[LANES_MAX], geometry = edge_geometry(last, seen);
    if (!it->settings.technique[0][edges + 1] || !(geometry > 0) ||
        (light->distant && edges == 1 && it->settings.film_transparent))
        return;
    bool connectable = next->arrival.connectable || !next->arrival.behind_specular;
    if (it->settings.connectable_only && !connectable)
        return;
    uint32_t dimension = DIM_GATHER + w->sightings++;
    if (strand && !relight_sighting(it, w, dimension, seen, strand, density))
        return;
    const struct arrival *at = strand ? &strand->at[edges] : &next->arrival;
    const float *lambda_film = at->start == 0 ? at->lambda
                               : strand       ? w->camera.vertex[at->start].lambda_film
                                              : next->lambda_film;
    float draw[LANES_MAX], fwd[LANES_MAX], direction = scene_pdf_light_direction(it->scene, light, back);
    double pdf_point = scene_pdf_light(it->scene, light);
    for (int i = 0; i < it->lanes; i++) {
        draw[i] = path_light_draw(it, light, at->lambda[i]);
        fwd[i] = draw[i] * direction;
    }
    if (it->cuts != CUTS_CHOSEN)
        tally_weigh_sighting(it, w, at, light, pdf_point, edges, geometry, seen->veil ? seen->veil->ahead : 1,
                             seen->veil ? seen->veil->back : 1, fwd, draw, weight);
    for (int i = 0; i < at->lanes; i++) {
        struct full_path path;
        value[i] = at->throughput[i] * scene_light_emission(it->scene, light, back, at->lambda[i]) /
                   (strand ? density[i] * at->lanes : at->lanes);
        if (seen->veil)
            value[i] *=
                crossing_transmittance(it->scene, &seen->veil->crossing, at->lambda[i]) / seen->veil->flown;
        if (!(value[i] > 0))
            continue;
        if (it->observe || it->cuts == CUTS_CHOSEN)
            whole_path(w, seen, strand, pdf_point, geometry, fwd[i], i, &path);
        if (it->cuts == CUTS_CHOSEN)
            weight[i] = mis_weight(it, &path);
        value[i] *= weight[i];
        film_sample_add(it->film, &w->gathered, value[i], lambda_film[i], it->kappa);
        w->taken += value[i];
        w->unconnected += connectable ? 0 : value[i] * gather_cmf_sum(lambda_film[i]);
        path.weight = weight[i];
        if (it->observe)
            it->observe(it->observer, &path, value[i]);
    }
    double brightness;
    int brightest = w->trial ? trial_brightest(it, at->lanes, value, lambda_film, &brightness) : -1;
    if (brightest >= 0 && !camera_sees_light(&w->camera)) {
        struct full_path path;
        whole_path(w, seen, strand, pdf_point, geometry, fwd[brightest], brightest, &path);
        trial_add(w->trial, it, &path, trial_see(w->trial, brightness, NULL));
    }
}

/* The light behind volumes: `media` (may be NULL) are those of the last `length` metres before it. */
static void gather_through(const struct integrator *it, struct worker *w, const struct sighting *seen,
                           const struct media *media, float length)
{
    const struct vertex *last = &w->camera.vertex[w->camera.count - 1], *next = last + 1;
    struct veil veil;
    if (!it->has_volumes) {
        gather_point(it, w, seen);
        return;
    }
    veil.crossing = next->inside.crossing;
    if (media)
        crossing_add(&veil.crossing, media, length);
    struct length_density density = flight_density(it, last, &veil.crossing, NULL, NULL);
    veil.flown = density.drawn;
    veil.ahead = density.nominal;
    veil.back = flight_nominal(it, &veil.crossing, last);
    struct sighting through = {seen->light, seen->direction, seen->passed, &veil};
    if (veil.flown > 0 && veil.ahead > 0)
        gather_point(it, w, &through);
}

void gather_lamps(const struct integrator *it, struct worker *w, const struct ray *ray, bool passed,
                  bool to_infinity, const struct media *media)
{
    struct light_point seen[LAMPS_MAX];
    int count = scene_lamps_along(it->scene, ray, seen, LAMPS_MAX);
    for (int i = 0; i < count; i++)
        gather_through(it, w, &(struct sighting){&seen[i], ray->direction, passed, NULL}, media,
                       length(sub(seen[i].position, ray->origin)) - ray->near);
    if (!to_infinity)
        return;
    count = scene_distant_along(it->scene, ray, seen, LAMPS_MAX);
    for (int i = 0; i < count; i++)
        gather_through(it, w, &(struct sighting){&seen[i], ray->direction, passed, NULL}, media, INFINITY);
}

void gather_surface(const struct integrator *it, struct worker *w, const struct hit *hit,
                    struct vec3 direction, bool passed)
{
    struct light_point light;
    scene_light_point_at(it->scene, hit, &light);
    gather_through(it, w, &(struct sighting){&light, direction, passed, NULL}, NULL, 0);
}
