/* Adds emission that a camera sub-path runs into, weighted against the techniques that connect to it. */
#include "integrator/gather.h"

#include "integrator/relight.h"

enum { LAMPS_MAX = 16 };

/* What a camera sub-path ran into, and how its last run is to be read: as traced, or at a wavelength drawn after the fact. */
struct sighting {
    const struct light_point *light;
    struct vec3 direction; /* of the ray */
    double throughput;     /* on arrival */
    float lambda, lambda_film;
    bool passed; /* transparent surfaces on the last edge */
};

static bool last_run_disperses(const struct vertex *last)
{
    return last->label != LABEL_FLUORESCENT && (last->run_disperses || last->disperses);
}

/* Where nothing dispersed, the last run's wavelength is drawn after the hit, from what the light emits and the run's start takes
   (algorithm.md §9): so a path tracer, too, sees a line spectrum. */
static bool relight_sighting(const struct integrator *it, const struct worker *w, uint32_t dimension,
                             struct sighting *seen, struct relit *relit)
{
    const struct subpath *camera = &w->camera;
    const struct vertex *last = &camera->vertex[camera->count - 1];
    int start = run_start(camera, camera->count);
    const struct vertex *taker = &camera->vertex[start];
    int sink = taker->kind == VERTEX_CAMERA ? wavelengths_sink_camera(&it->wavelengths)
                                            : surface_fluorophore(&taker->surface, taker->lobe);
    const struct spectral_histogram *product =
        wavelengths_product(&it->wavelengths, scene_light_shape(it->scene, seen->light->light), sink);
    float pdf;
    if (!product)
        return false;
    float lambda = spectral_histogram_sample(product, random_at(w->random, dimension), &pdf);
    if (!(pdf > 0) || !relight(it, SIDE_CAMERA, camera, start, camera->count, lambda, relit))
        return false;
    seen->throughput = relit->throughput[camera->count] / pdf;
    if (seen->passed) {
        bool distant = seen->light->distant;
        seen->throughput *= edge_transmittance_ratio(it, last, distant ? NULL : &seen->light->position,
                                                     seen->direction, lambda, last->lambda_out);
    }
    seen->lambda = lambda;
    seen->lambda_film = start == 0 ? lambda : seen->lambda_film;
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

static void gather_point(const struct integrator *it, struct worker *w, struct sighting seen)
{
    const struct light_point *light = seen.light;
    int edges = w->camera.count;
    const struct vertex *last = &w->camera.vertex[edges - 1];
    struct vec3 back = negate(seen.direction);
    struct relit relit;
    bool again = it->exact && !last_run_disperses(last);
    if (!it->settings.technique[0][edges + 1] ||
        (light->distant && edges == 1 && it->settings.film_transparent))
        return;
    uint32_t dimension = DIM_GATHER + w->sightings++;
    seen.lambda = last->lambda_out;
    seen.lambda_film = w->camera.vertex[0].lambda_out;
    if (again && !relight_sighting(it, w, dimension, &seen, &relit))
        return;
    float radiance = scene_light_emission(it->scene, light, back, seen.lambda);
    if (!(radiance > 0))
        return;
    struct full_path path;
    struct full_step *end = path.step;
    full_path_copy(&path, &w->light, 0, &w->camera, edges, edges);
    if (again)
        relit_put(&relit, SIDE_CAMERA, edges, &path);
    path.light = light;
    path.pdf_point = scene_pdf_light(it->scene, light);
    path.half_width_nm = w->half_width_nm;
    end[1].lambda = seen.lambda;
    end[1].geometry = edge_geometry(last, &seen);
    end[0] = (struct full_step){.fwd = scene_pdf_light_lambda(it->scene, light, seen.lambda) *
                                       (double)scene_pdf_light_direction(it->scene, light, back),
                                .label = LABEL_FLUORESCENT,
                                .dye = -1};
    if (!(end[1].geometry > 0))
        return;
    double value = seen.throughput * radiance * mis_weight(it, &path);
    film_sample_add(it->film, &w->gathered, value, seen.lambda_film, it->kappa);
    if (it->observe)
        it->observe(it->observer, &path, value);
}

void gather_lamps(const struct integrator *it, struct worker *w, const struct ray *ray, double throughput,
                  bool passed, bool to_infinity)
{
    struct light_point seen[LAMPS_MAX];
    int count = scene_lamps_along(it->scene, ray, seen, LAMPS_MAX);
    for (int i = 0; i < count; i++)
        gather_point(
            it, w,
            (struct sighting){
                .light = &seen[i], .direction = ray->direction, .throughput = throughput, .passed = passed});
    if (!to_infinity)
        return;
    count = scene_distant_along(it->scene, ray, seen, LAMPS_MAX);
    for (int i = 0; i < count; i++)
        gather_point(
            it, w,
            (struct sighting){
                .light = &seen[i], .direction = ray->direction, .throughput = throughput, .passed = passed});
}

void gather_surface(const struct integrator *it, struct worker *w, const struct hit *hit,
                    struct vec3 direction, double throughput, bool passed)
{
    struct light_point light;
    scene_light_point_at(it->scene, hit, &light);
    gather_point(it, w,
                 (struct sighting){
                     .light = &light, .direction = direction, .throughput = throughput, .passed = passed});
}
