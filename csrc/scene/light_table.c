/* The table of lights: made from emissive objects, lamps and the world, in an order that depends on the scene
   alone. */
#include <stdlib.h>

#include "base/error.h"
#include "scene/state.h"

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
    free((void *)scene->spectra);
    scene->spectra = NULL;
    scene->spectrum_count = 0;
    scene->lights = NULL;
    scene->light_sum = NULL;
    scene->hittable = scene->distant = NULL;
    scene->light_count = scene->hittable_count = scene->distant_count = scene->lost_count = 0;
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

/* Whether anything gets through the world's volume from infinity: only wavelengths that it leaves alone altogether (algorithm.md §13). */
static bool infinity_arrives(const struct scene *scene)
{
    const struct volume *volume = scene->world ? scene->world->input.volume : NULL;
    return !volume || !volume->extinction || !(spectrum_min(volume->extinction) > 0);
}

static void add_lamp(struct scene *scene, const struct light *light)
{
    if (light->kind->distant && !infinity_arrives(scene))
        scene->lost_count++;
    else
        scene->lights[scene->light_count++] = *light;
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
            add_lamp(scene, &(struct light){.kind = kind_of(lamp),
                                            .name = lamp->name,
                                            .spectrum = lamp->emission.shape,
                                            .mask = lamp->mask,
                                            .lamp = lamp});
    }
    if (!scene->world || !world_compile(scene, err))
        return !scene->world;
    if (scene->world->emission.total > 0)
        add_lamp(scene, &(struct light){.kind = &light_world,
                                        .name = "world",
                                        .spectrum = scene->world->emission.shape,
                                        .mask = scene->world->mask});
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
    for (size_t i = 0; i < scene->light_count; i++)
        scene->lights[i].total = spectrum_integral(scene->lights[i].spectrum);
    list_what_rays_meet(scene);
    return scene_share_spectra(scene) || fail(err, "scene", "lights", "no memory for their spectra");
}
