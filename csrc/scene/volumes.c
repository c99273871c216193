/* The list of a scene's volumes, and whether its camera may be inside of one. */
#include <stdlib.h>

#include "base/error.h"
#include "scene/state.h"

#define VOLUMES_MAX INT16_MAX

static void list_one(struct volumes *volumes, const struct volume *volume, struct material *material)
{
    if (!volume || volume_is_empty(volume))
        return;
    if (material)
        material_set_volume(material, volumes->count);
    volumes->list[volumes->count++] = volume;
}

static bool has_volume(const struct instances *instances)
{
    for (size_t slot = 0; slot < instances->slot_count; slot++)
        if (material_volume(instances->materials[slot]) >= 0)
            return true;
    return false;
}

bool scene_list_volumes(struct scene *scene, stokes_error *err)
{
    struct volumes *volumes = &scene->volumes;
    free((void *)volumes->list);
    *volumes = (struct volumes){.list = calloc(scene->materials.count + 1, sizeof *volumes->list)};
    if (!volumes->list || scene->materials.count >= VOLUMES_MAX)
        return fail(err, "scene", "volume", "no place for %zu volumes", scene->materials.count);
    if (scene->world)
        list_one(volumes, scene->world->input.volume, NULL);
    volumes->world = volumes->count > 0;
    for (size_t i = 0; i < scene->materials.count; i++) {
        const struct material_slot *slot = scene->materials.entry[i].item;
        material_set_volume(slot->compiled, -1);
        list_one(volumes, slot->volume, slot->compiled);
    }
    for (size_t i = 0; i < scene->instances.count; i++)
        volumes->bounded = volumes->bounded || has_volume(scene->instances.entry[i].item);
    return true;
}

/* --- The camera ------------------------------------------------------------------------------------------ */

/* A sphere about the camera that holds all beginnings of its rays. */
static float camera_reach(const struct camera_input *in)
{
    const float *frame = in->frame;
    float wide = fabsf(frame[0]) + fabsf(frame[1]) + fabsf(frame[2]) + fabsf(frame[3]);
    float lens = in->lens_radius * (1 + 1 / in->aspect);
    if (in->orthographic)
        return in->clip[0] + 2 * wide + lens * (1 + in->clip[0] / in->focus_distance);
    return 2 * in->clip[0] * (1 + wide) + lens;
}

static float beyond(float x, float low, float high)
{
    return fmaxf(0, fmaxf(low - x, x - high));
}

static bool is_near(const struct object *object, struct vec3 p, float reach)
{
    struct vec3 low = vec3(INFINITY, INFINITY, INFINITY), high = negate(low);
    for (int corner = 0; corner < 8; corner++) {
        const struct mesh *mesh = object->mesh;
        struct vec3 at = transform_point(&object->to_world, vec3(corner & 1 ? mesh->low.x : mesh->high.x,
                                                                 corner & 2 ? mesh->low.y : mesh->high.y,
                                                                 corner & 4 ? mesh->low.z : mesh->high.z));
        low = vec3(fminf(low.x, at.x), fminf(low.y, at.y), fminf(low.z, at.z));
        high = vec3(fmaxf(high.x, at.x), fmaxf(high.y, at.y), fmaxf(high.z, at.z));
    }
    struct vec3 gap =
        vec3(beyond(p.x, low.x, high.x), beyond(p.y, low.y, high.y), beyond(p.z, low.z, high.z));
    return length_squared(gap) <= reach * reach;
}

void scene_place_camera(struct scene *scene)
{
    scene->volumes.camera_inside = false;
    if (!scene->camera || !scene->volumes.bounded)
        return;
    float reach = camera_reach(&scene->camera->input);
    for (size_t i = 0; i < scene->object_count && !scene->volumes.camera_inside; i++)
        scene->volumes.camera_inside = has_volume(scene->objects[i].instances) &&
                                       is_near(&scene->objects[i], scene->camera->position, reach);
}
