/* Lights as integrators see them: drawn by power, asked for their densities and emission, met by rays. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/random.h"
#include "scene/state.h"

/* --- Choosing by power ------------------------------------------------------------------------------- */

/* Sum of a span of scaled spectra, halves first: unions of knots stay small. */
static struct spectrum *sum_spectra(const struct spectrum *const *spectra, const double *weight, size_t count)
{
    if (count == 1)
        return spectrum_scaled(spectra[0], (float)weight[0]);
    size_t half = count / 2;
    struct spectrum *a = sum_spectra(spectra, weight, half);
    struct spectrum *b = sum_spectra(spectra + half, weight + half, count - half);
    struct spectrum *sum = a && b ? spectrum_sum(a, b) : NULL;
    spectrum_destroy(a);
    spectrum_destroy(b);
    return sum;
}

/* Σ probability × normalised spectrum. */
static struct spectrum *mean_spectrum(const struct scene *scene)
{
    double *weight = calloc(scene->spectrum_count, sizeof *weight);
    if (!weight)
        return NULL;
    for (size_t i = 0; i < scene->light_count; i++)
        weight[scene->lights[i].shape] += scene->lights[i].probability;
    for (size_t i = 0; i < scene->spectrum_count; i++)
        weight[i] /= spectrum_integral(scene->spectra[i]);
    struct spectrum *sum = sum_spectra(scene->spectra, weight, scene->spectrum_count);
    free(weight);
    return sum;
}

bool scene_weigh_lights(struct scene *scene, stokes_error *err)
{
    double *sum = scene->light_sum;
    spectrum_destroy(scene->lamp_spectrum);
    scene->lamp_spectrum = NULL;
    for (size_t i = 0; i < scene->light_count; i++) {
        struct light *light = &scene->lights[i];
        light->power = light->kind->power(scene, light);
        if (!(light->power >= 0 && isfinite(light->power)))
            return fail(err, light->name, "emission", "has a power of %g W", light->power);
        sum[i + 1] = sum[i] + light->power;
    }
    double whole = sum[scene->light_count];
    if (!(whole > 0))
        return true;
    for (size_t i = 0; i < scene->light_count; i++)
        scene->lights[i].probability = (sum[i + 1] - sum[i]) / whole;
    scene->lamp_spectrum = mean_spectrum(scene);
    return scene->lamp_spectrum || fail(err, "scene", "lights", "no memory for their spectrum");
}

size_t search_sum(const double *sum, size_t count, double x, double *rest)
{
    double target = x * sum[count];
    size_t low = 0, high = count; /* sum[low] <= target < sum[high], up to rounding at the end */
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (sum[middle] <= target)
            low = middle;
        else
            high = middle;
    }
    while (low > 0 && !(sum[low + 1] > sum[low])) /* x = 1 may land behind the last entry of any size */
        low--;
    double span = sum[low + 1] - sum[low];
    *rest = span > 0 ? fmin((target - sum[low]) / span, 0x1.fffffep-1) : 0;
    return low;
}

/* 24 bits are few for a choice among all triangles of all lights: the rest of a double's bits come from a
   hash of all three numbers, so that the choice within one light is not a function of the point on its
   triangle. */
static double refine(const float u[3])
{
    uint32_t bits[3];
    memcpy(bits, u, sizeof bits);
    uint64_t hash = random_mix(random_mix((uint64_t)bits[0] << 32 | bits[1]) ^ bits[2]);
    return u[0] + (double)(hash >> 40) * 0x1p-48;
}

/* --- What integrators ask ---------------------------------------------------------------------------- */

int scene_light_count(const struct scene *scene)
{
    return (int)scene->light_count;
}

const char *scene_light_name(const struct scene *scene, int light)
{
    return scene->lights[light].name;
}

bool scene_light_is_delta(const struct scene *scene, int light)
{
    return scene->lights[light].kind->delta;
}

const struct spectrum *scene_light_spectrum(const struct scene *scene, int light)
{
    return scene->lights[light].spectrum;
}

const struct spectrum *scene_lamp_spectrum(const struct scene *scene)
{
    return scene->lamp_spectrum;
}

static void start_point(const struct scene *scene, int light, struct light_point *point)
{
    const struct light_kind *kind = scene->lights[light].kind;
    *point = (struct light_point){.light = light,
                                  .distant = kind->distant,
                                  .delta = kind->delta,
                                  .has_normal = kind->has_normal,
                                  .on_mesh = kind == &light_mesh,
                                  .hit = {.light = light}};
}

bool scene_sample_light(const struct scene *scene, const float u[3], struct light_point *point, float *pdf)
{
    *pdf = 0;
    if (!scene->lamp_spectrum)
        return false;
    double choice;
    size_t index = search_sum(scene->light_sum, scene->light_count, refine(u), &choice);
    const struct light *light = &scene->lights[index];
    start_point(scene, (int)index, point);
    *pdf = (float)(light->probability * light->kind->sample_point(scene, light, choice, u + 1, point));
    return *pdf > 0;
}

float scene_pdf_light(const struct scene *scene, const struct light_point *point)
{
    const struct light *light = &scene->lights[point->light];
    return (float)(light->probability * light->kind->pdf_point(scene, light, point));
}

float scene_sample_light_lambda(const struct scene *scene, const struct light_point *point, float u,
                                float *pdf)
{
    return spectrum_sample(scene->lights[point->light].spectrum, u, pdf);
}

float scene_pdf_light_lambda(const struct scene *scene, const struct light_point *point, float lambda)
{
    return spectrum_pdf(scene->lights[point->light].spectrum, lambda);
}

/* A distant light's rays start on a disk that covers the scene's bounding sphere. */
static float sample_disk(const struct scene *scene, struct vec3 toward_light, const float u[2],
                         struct vec3 *origin)
{
    struct frame frame = frame_about(toward_light);
    float radius = scene->radius * sqrtf(u[0]), phi = 2 * PI_F * u[1];
    *origin = along(scene->center, toward_light, scene->radius);
    *origin = along(along(*origin, frame.s, radius * cosf(phi)), frame.t, radius * sinf(phi));
    return 1 / (PI_F * scene->radius * scene->radius);
}

bool scene_sample_light_direction(const struct scene *scene, const struct light_point *point,
                                  const float u[2], struct vec3 *origin, struct vec3 *direction, float *pdf)
{
    const struct light *light = &scene->lights[point->light];
    if (light->kind->distant) {
        *direction = negate(point->normal);
        *pdf = sample_disk(scene, point->normal, u, origin);
        return true;
    }
    *pdf = light->kind->sample_direction(scene, light, point, u, direction);
    *origin = point->on_mesh ? scene_offset(&point->hit, *direction) : point->position;
    return *pdf > 0;
}

float scene_pdf_light_direction(const struct scene *scene, const struct light_point *point,
                                struct vec3 direction)
{
    const struct light *light = &scene->lights[point->light];
    if (light->kind->distant)
        return 1 / (PI_F * scene->radius * scene->radius);
    return light->kind->pdf_direction(scene, light, point, direction);
}

float scene_light_emission(const struct scene *scene, const struct light_point *point, struct vec3 direction,
                           float lambda)
{
    const struct light *light = &scene->lights[point->light];
    return light->kind->emission(scene, light, point, direction, lambda);
}

void scene_light_point_at(const struct scene *scene, const struct hit *hit, struct light_point *point)
{
    start_point(scene, hit->light, point);
    point->hit = *hit;
    point->position = hit->position;
    point->normal = hit->ng;
    point->uv[0] = hit->uv[0];
    point->uv[1] = hit->uv[1];
}

bool scene_light_seen_by_camera(const struct scene *scene, const struct light_point *point)
{
    const struct light *light = &scene->lights[point->light];
    return (light->mask & RAY_CAMERA) && (point->on_mesh || light->kind->hit);
}

/* --- Lamps along a ray ------------------------------------------------------------------------------- */

/* Up to this many lamps are tried one by one. */
#define LAMPS_LOOPED 4

static bool try_light(const struct scene *scene, int light, const struct ray *ray, struct light_point *point,
                      float *t)
{
    if (!(scene->lights[light].mask & ray->kind))
        return false;
    start_point(scene, light, point);
    return scene->lights[light].kind->hit(scene, &scene->lights[light], ray, point, t);
}

void lamp_hits_try(struct lamp_hits *hits, int light)
{
    struct light_point point;
    float t;
    if (!try_light(hits->scene, light, hits->ray, &point, &t) || !(t > hits->ray->near && t < hits->ray->far))
        return;
    int at = hits->count < hits->most ? hits->count++ : hits->most;
    for (; at > 0 && t < hits->t[at - 1]; at--)
        if (at < hits->most) {
            hits->t[at] = hits->t[at - 1];
            hits->point[at] = hits->point[at - 1];
        }
    if (at < hits->most) {
        hits->t[at] = t;
        hits->point[at] = point;
    }
}

int scene_lamps_along(const struct scene *scene, const struct ray *ray, struct light_point *points, int most)
{
    struct lamp_hits hits = {.scene = scene, .ray = ray, .point = points};
    hits.most = most < (int)(sizeof hits.t / sizeof *hits.t) ? most : (int)(sizeof hits.t / sizeof *hits.t);
    if (scene->hittable_count > LAMPS_LOOPED)
        accel_lamps(scene, &hits);
    else
        for (size_t i = 0; i < scene->hittable_count; i++)
            lamp_hits_try(&hits, scene->hittable[i]);
    return hits.count;
}

int scene_distant_along(const struct scene *scene, const struct ray *ray, struct light_point *points,
                        int most)
{
    int count = 0;
    float t;
    for (size_t i = 0; i < scene->distant_count && count < most; i++)
        count += try_light(scene, scene->distant[i], ray, &points[count], &t);
    return count;
}

uint32_t scene_light_kinds(const struct scene *scene, int light)
{
    return scene->lights[light].mask;
}
