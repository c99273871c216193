/* The table of lights: made from emissive objects, lamps and the world, and drawn from by power. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/random.h"
#include "scene/state.h"

/* --- Making the table -------------------------------------------------------------------------------- */

void scene_free_lights(struct scene *scene)
{
    for (size_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].own_cdf) {
            triangle_cdf_free(scene->lights[i].own_cdf);
            free(scene->lights[i].own_cdf);
        }
    free(scene->lights);
    free(scene->light_sum);
    free(scene->hittable);
    free(scene->distant);
    scene->lights = NULL;
    scene->light_sum = NULL;
    scene->hittable = scene->distant = NULL;
    scene->light_count = scene->hittable_count = scene->distant_count = 0;
}

/* True if the transform stretches all directions alike, within 1 %, so that a table of local areas serves. */
static bool keeps_area_ratios(const struct transform *t)
{
    const float *m = t->m;
    double low = INFINITY, high = 0, most = 0;
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++) {
            double product = (double)m[i] * m[j] + (double)m[4 + i] * m[4 + j] + (double)m[8 + i] * m[8 + j];
            if (i == j)
                low = fmin(low, product), high = fmax(high, product);
            else
                most = fmax(most, fabs(product));
        }
    return high > 0 && high - low < 0.01 * high && most < 0.01 * high;
}

static bool add_emitter(struct scene *scene, uint32_t index, size_t slot, stokes_error *err)
{
    const struct object *object = &scene->objects[index];
    struct light *light = &scene->lights[scene->light_count++];
    *light = (struct light){.kind = &light_mesh,
                            .name = object->instances->name,
                            .mask = object->instances->mask,
                            .object = index,
                            .slot = (uint32_t)slot,
                            .cdf = &object->instances->cdf[slot],
                            .spectrum = material_emission_shape(object->instances->materials[slot])};
    if (keeps_area_ratios(&object->to_world))
        return true;
    light->own_cdf = calloc(1, sizeof *light->own_cdf);
    light->cdf = light->own_cdf;
    return (light->own_cdf &&
            triangle_cdf_build(light->own_cdf, object->instances, object->mesh, &object->to_world, slot)) ||
           fail(err, light->name, "emission", "no memory for its table of triangles");
}

static bool add_emitters(struct scene *scene, stokes_error *err)
{
    for (size_t i = 0; i < scene->object_count; i++) {
        struct object *object = &scene->objects[i];
        const struct instances *instances = object->instances;
        object->first_light = instances->emitter_count ? (int)scene->light_count : -1;
        for (size_t slot = 0; slot < instances->slot_count; slot++)
            if (instances->emitter[slot] >= 0 && !add_emitter(scene, (uint32_t)i, slot, err))
                return false;
    }
    return true;
}

static const struct light_kind *kind_of(const struct lamp *lamp)
{
    switch (lamp->input.shape) {
    case LIGHT_RECTANGLE: return &light_rectangle;
    case LIGHT_ELLIPSE: return &light_ellipse;
    case LIGHT_SPHERE: return &light_sphere;
    case LIGHT_POINT: return &light_point_lamp;
    case LIGHT_SPOT: return lamp->input.radius > 0 ? &light_spot_sphere : &light_spot;
    case LIGHT_SUN: return lamp->half_angle > 0 ? &light_sun : &light_sun_delta;
    }
    return NULL;
}

static bool add_lamps(struct scene *scene, stokes_error *err)
{
    registry_sort(&scene->lamps);
    for (size_t i = 0; i < scene->lamps.count; i++) {
        struct lamp *lamp = scene->lamps.entry[i].item;
        const struct texture *texture = lamp->input.emission->texture;
        if (!emission_compile(&lamp->emission, scene, lamp->input.emission,
                              texture && texture->image ? texture->image->mean : NULL, lamp->name, err))
            return false;
        if (lamp->emission.total > 0)
            scene->lights[scene->light_count++] = (struct light){.kind = kind_of(lamp),
                                                                 .name = lamp->name,
                                                                 .spectrum = lamp->emission.shape,
                                                                 .mask = lamp->mask,
                                                                 .lamp = lamp};
    }
    if (!scene->world || !world_compile(scene, err))
        return !scene->world;
    if (scene->world->emission.total > 0)
        scene->lights[scene->light_count++] = (struct light){.kind = &light_world,
                                                             .name = "world",
                                                             .spectrum = scene->world->emission.shape,
                                                             .mask = scene->world->mask};
    return true;
}

static void list_what_rays_meet(struct scene *scene)
{
    for (size_t i = 0; i < scene->light_count; i++) {
        if (!scene->lights[i].kind->hit)
            continue;
        if (scene->lights[i].kind->distant)
            scene->distant[scene->distant_count++] = (int)i;
        else
            scene->hittable[scene->hittable_count++] = (int)i;
    }
}

bool scene_build_lights(struct scene *scene, stokes_error *err)
{
    size_t most = scene->lamps.count + 1;
    for (size_t i = 0; i < scene->object_count; i++)
        most += scene->objects[i].instances->emitter_count;
    scene_free_lights(scene);
    scene->lights = calloc(most, sizeof *scene->lights);
    scene->light_sum = calloc(most + 1, sizeof *scene->light_sum);
    scene->hittable = calloc(most, sizeof *scene->hittable);
    scene->distant = calloc(most, sizeof *scene->distant);
    if (!scene->lights || !scene->light_sum || !scene->hittable || !scene->distant || most > INT32_MAX)
        return fail(err, "scene", "lights", "no memory for %zu", most);
    if (!add_emitters(scene, err) || !add_lamps(scene, err))
        return false;
    list_what_rays_meet(scene);
    return true;
}

/* --- Choosing by power ------------------------------------------------------------------------------- */

struct weighted_spectrum {
    const struct spectrum *spectrum;
    double weight; /* power over ∫ of the spectrum */
};

static int by_spectrum(const void *a, const void *b)
{
    const struct weighted_spectrum *x = a, *y = b;
    return (x->spectrum > y->spectrum) - (x->spectrum < y->spectrum);
}

/* Sum of a span of scaled spectra, halves first: unions of knots stay small. */
static struct spectrum *sum_spectra(const struct weighted_spectrum *part, size_t count)
{
    if (count == 1)
        return spectrum_scaled(part->spectrum, (float)part->weight);
    struct spectrum *a = sum_spectra(part, count / 2), *b = sum_spectra(part + count / 2, count - count / 2);
    struct spectrum *sum = a && b ? spectrum_sum(a, b) : NULL;
    spectrum_destroy(a);
    spectrum_destroy(b);
    return sum;
}

/* Many lights share few spectra: weights of the same one are added first. */
static size_t gather_spectra(const struct scene *scene, double whole, struct weighted_spectrum *part)
{
    size_t count = 0, distinct = 0;
    for (size_t i = 0; i < scene->light_count; i++)
        if (scene->lights[i].power > 0)
            part[count++] = (struct weighted_spectrum){
                scene->lights[i].spectrum,
                scene->lights[i].power / (whole * spectrum_integral(scene->lights[i].spectrum))};
    qsort(part, count, sizeof *part, by_spectrum);
    for (size_t i = 0; i < count; i++)
        if (distinct && part[distinct - 1].spectrum == part[i].spectrum)
            part[distinct - 1].weight += part[i].weight;
        else
            part[distinct++] = part[i];
    return distinct;
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
    struct weighted_spectrum *part = malloc(scene->light_count * sizeof *part);
    size_t count = part ? gather_spectra(scene, whole, part) : 0;
    scene->lamp_spectrum = count ? sum_spectra(part, count) : NULL;
    free(part);
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
