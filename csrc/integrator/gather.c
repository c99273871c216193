/* Adds emission that a camera sub-path runs into, weighted against the techniques that connect to it. */
#include "integrator/gather.h"

#include "integrator/mis.h"

enum { LAMPS_MAX = 16 };

static void gather_point(const struct integrator *it, struct worker *w, const struct light_point *light,
                         struct vec3 direction, double throughput)
{
    int edges = w->camera.count;
    const struct vertex *last = &w->camera.vertex[edges - 1];
    float lambda = last->lambda_out;
    struct vec3 back = negate(direction);
    float radiance = scene_light_emission(it->scene, light, back, lambda);
    if (!(radiance > 0) || !it->settings.technique[0][edges + 1] ||
        (light->distant && edges == 1 && it->settings.film_transparent))
        return;
    struct full_path path;
    struct full_step *end = path.step;
    full_path_copy(&path, &w->light, 0, &w->camera, edges, edges);
    float cosines = vertex_cosine(last, direction);
    if (light->has_normal && !light->distant)
        cosines *= fabsf(dot(light->normal, direction));
    path.light = light;
    path.pdf_point = scene_pdf_light(it->scene, light);
    path.half_width_nm = w->half_width_nm;
    end[1].lambda = lambda;
    end[1].geometry = light->distant || last->unbounded
                          ? cosines
                          : cosines / length_squared(sub(light->position, last->position));
    end[0].fwd = scene_pdf_light_lambda(it->scene, light, lambda) *
                 (double)scene_pdf_light_direction(it->scene, light, back);
    end[0].label = LABEL_FLUORESCENT;
    if (!(end[1].geometry > 0))
        return;
    double value = throughput * radiance * mis_weight(it, &path);
    film_sample_add(it->film, &w->gathered, value, w->camera.vertex[0].lambda_out, it->kappa);
    if (it->observe)
        it->observe(it->observer, &path, value);
}

void gather_lamps(const struct integrator *it, struct worker *w, const struct ray *ray, double throughput,
                  bool to_infinity)
{
    struct light_point seen[LAMPS_MAX];
    int count = scene_lamps_along(it->scene, ray, seen, LAMPS_MAX);
    for (int i = 0; i < count; i++)
        gather_point(it, w, &seen[i], ray->direction, throughput);
    if (!to_infinity)
        return;
    count = scene_distant_along(it->scene, ray, seen, LAMPS_MAX);
    for (int i = 0; i < count; i++)
        gather_point(it, w, &seen[i], ray->direction, throughput);
}

void gather_surface(const struct integrator *it, struct worker *w, const struct hit *hit,
                    struct vec3 direction, double throughput)
{
    struct light_point light;
    scene_light_point_at(it->scene, hit, &light);
    gather_point(it, w, &light, direction, throughput);
}
