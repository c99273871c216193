/* The scene's life, what is kept by name in it, and what is told of it. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/state.h"

char *copy_text(const char *text)
{
    size_t bytes = strlen(text) + 1;
    char *copy = malloc(bytes);
    return copy ? memcpy(copy, text, bytes) : NULL;
}

struct scene *scene_create(void)
{
    struct scene *scene = calloc(1, sizeof *scene);
    if (scene)
        scene->geometry_dirty = scene->materials_dirty = scene->lights_dirty = scene->camera_dirty = true;
    return scene;
}

static void destroy_all(struct registry *registry, void (*destroy)(void *))
{
    for (size_t i = 0; i < registry->count; i++)
        destroy(registry->entry[i].item);
    registry_free(registry);
}

static void destroy_mesh(void *item)
{
    mesh_destroy(item);
}
static void destroy_material(void *item)
{
    material_slot_destroy(item);
}
static void destroy_image(void *item)
{
    image_destroy(item);
}
static void destroy_instances(void *item)
{
    instances_destroy(item);
}
static void destroy_lamp(void *item)
{
    lamp_destroy(item);
}

void material_slot_destroy(struct material_slot *slot)
{
    if (!slot)
        return;
    closure_destroy(slot->closure);
    volume_destroy(slot->volume);
    material_destroy(slot->compiled);
    free(slot->name);
    free(slot);
}

void scene_destroy(struct scene *scene)
{
    if (!scene)
        return;
    scene_free_lights(scene);
    destroy_all(&scene->instances, destroy_instances);
    destroy_all(&scene->meshes, destroy_mesh);
    destroy_all(&scene->lamps, destroy_lamp);
    destroy_all(&scene->materials, destroy_material);
    material_destroy(scene->default_material);
    world_destroy(scene->world);
    camera_destroy(scene->camera);
    accel_destroy(scene->accel);
    destroy_all(&scene->images, destroy_image);
    for (size_t i = 0; i < scene->retired_count; i++)
        image_destroy(scene->retired[i]);
    for (uint32_t i = 0; i < scene->uv_name_count; i++)
        free(scene->uv_names[i]);
    free(scene->uv_names);
    free(scene->retired);
    free(scene->objects);
    free((void *)scene->volumes.list);
    free(scene->fluorophore_material);
    free(scene->fluorophore_first);
    spectrum_destroy(scene->lamp_spectrum);
    spectrum_destroy(scene->illuminant);
    rgb_table_destroy(scene->rgb_table);
    free(scene);
}

/* --- Materials and images ---------------------------------------------------------------------------- */

static bool has_normal_map(const struct closure *closure)
{
    return closure &&
           (closure->normal_map || has_normal_map(closure->child[0]) || has_normal_map(closure->child[1]));
}

bool scene_add_material(struct scene *scene, const char *name, struct closure *closure, stokes_error *err)
{
    return scene_add_material_with(scene, name, closure, NULL, err);
}

bool scene_add_material_with(struct scene *scene, const char *name, struct closure *closure,
                             struct volume *volume, stokes_error *err)
{
    struct material_slot *slot = calloc(1, sizeof *slot);
    void *old;
    if (!slot || !(slot->name = copy_text(name)) ||
        !registry_put(&scene->materials, slot->name, slot, &old)) {
        closure_destroy(closure);
        volume_destroy(volume);
        material_slot_destroy(slot);
        return fail(err, name, "surface", "no memory");
    }
    slot->closure = closure;
    slot->volume = volume;
    slot->needs_table = material_needs_rgb_table(closure);
    slot->has_normal_map = has_normal_map(closure);
    material_slot_destroy(old);
    scene->materials_dirty = true;
    scene->committed = false;
    return true;
}

/* Materials, lamps and the world hold pointers to images: a new picture of an old name, even of a removed one
   that is still in use, moves into the old one's place. */
static void refill_image(struct image *old, struct image *image)
{
    struct image swap = *old;
    *old = *image;
    old->name = swap.name; /* the registry's key */
    swap.name = image->name;
    *image = swap;
    image_destroy(image);
}

static struct image *find_retired(const struct scene *scene, const char *name)
{
    for (size_t i = 0; i < scene->retired_count; i++)
        if (strcmp(scene->retired[i]->name, name) == 0)
            return scene->retired[i];
    return NULL;
}

static void forget_retired(struct scene *scene, const struct image *image)
{
    for (size_t i = 0; i < scene->retired_count; i++)
        if (scene->retired[i] == image) {
            scene->retired[i] = scene->retired[--scene->retired_count];
            return;
        }
}

bool scene_add_image(struct scene *scene, struct image *image, stokes_error *err)
{
    struct image *old = registry_find(&scene->images, image->name),
                 *retired = find_retired(scene, image->name);
    struct image *kept = retired ? retired : image;
    void *none;
    if (!old && !registry_put(&scene->images, kept->name, kept, &none)) {
        fail(err, image->name, "pixels", "no memory");
        image_destroy(image);
        return false;
    }
    scene->images_dirty = scene->lights_dirty = true; /* lights keep mean colours */
    scene->committed = false;
    if (old) {
        refill_image(old, image);
    } else if (retired) {
        forget_retired(scene, retired);
        refill_image(retired, image);
    }
    return true;
}

const struct material *scene_find_material(const struct scene *scene, const char *name)
{
    const struct material_slot *slot = registry_find(&scene->materials, name);
    return slot ? slot->compiled : NULL;
}

const struct image *scene_find_image(const struct scene *scene, const char *name)
{
    return registry_find(&scene->images, name);
}

/* --- Removal ----------------------------------------------------------------------------------------- */

static bool retire_image(struct scene *scene, const char *name)
{
    struct image **retired = realloc(scene->retired, (scene->retired_count + 1) * sizeof *retired);
    if (!retired)
        return false;
    scene->retired = retired;
    retired[scene->retired_count++] = registry_take(&scene->images, name);
    return true;
}

static struct registry *registry_of(struct scene *scene, const char *kind)
{
    return strcmp(kind, "mesh") == 0        ? &scene->meshes
           : strcmp(kind, "material") == 0  ? &scene->materials
           : strcmp(kind, "instances") == 0 ? &scene->instances
           : strcmp(kind, "light") == 0     ? &scene->lamps
           : strcmp(kind, "image") == 0     ? &scene->images
                                            : NULL;
}

bool scene_remove(struct scene *scene, const char *kind, const char *name, stokes_error *err)
{
    struct registry *registry = registry_of(scene, kind);
    if (!registry)
        return fail(err, name, "kind", "\"%.100s\" is not mesh, material, instances, light or image", kind);
    if (!registry_find(registry, name))
        return fail(err, name, "name", "there is no %s of this name", kind);
    scene->committed = false;
    if (registry == &scene->images) {
        scene->images_dirty = scene->lights_dirty = true;
        return retire_image(scene, name) || fail(err, name, "image", "no memory");
    }
    void *item = registry_take(registry, name);
    if (registry == &scene->materials) {
        material_slot_destroy(item);
        scene->materials_dirty = true;
    } else if (registry == &scene->lamps) {
        lamp_destroy(item);
        scene->lights_dirty = true;
    } else {
        scene->geometry_dirty = true;
        if (registry == &scene->meshes)
            mesh_destroy(item);
        else
            instances_destroy(item);
    }
    return true;
}

/* --- What is told of it ------------------------------------------------------------------------------ */

void scene_bounds(const struct scene *scene, struct vec3 *center, float *radius)
{
    *center = scene->center;
    *radius = scene->radius;
}

struct scene_statistics scene_statistics(const struct scene *scene)
{
    struct scene_statistics statistics = {.meshes = scene->meshes.count,
                                          .instances = scene->object_count,
                                          .lights = scene->light_count,
                                          .lights_lost = scene->lost_count,
                                          .materials = scene->materials.count,
                                          .images = scene->images.count};
    for (size_t i = 0; i < scene->meshes.count; i++)
        statistics.triangles += ((const struct mesh *)scene->meshes.entry[i].item)->triangle_count;
    for (size_t i = 0; i < scene->lamps.count; i++)
        statistics.colors_out_of_reach +=
            ((const struct lamp *)scene->lamps.entry[i].item)->emission.out_of_reach;
    statistics.colors_out_of_reach += scene->world && scene->world->emission.out_of_reach;
    return statistics;
}

int scene_fluorophore_count(const struct scene *scene)
{
    return scene->fluorophore_count;
}

const struct spectrum *scene_fluorophore_emission(const struct scene *scene, int index)
{
    return material_fluorophore_emission(scene->fluorophore_material[index],
                                         index - scene->fluorophore_first[index]);
}

const struct spectrum *scene_fluorophore_absorption(const struct scene *scene, int index)
{
    return material_fluorophore_absorption(scene->fluorophore_material[index],
                                           index - scene->fluorophore_first[index]);
}

float scene_fluorophore_pdf_emitted(const struct scene *scene, int index, float lambda_in, float lambda_out)
{
    return material_fluorophore_pdf(scene->fluorophore_material[index],
                                    index - scene->fluorophore_first[index], SIDE_LIGHT, lambda_in,
                                    lambda_out);
}

float scene_fluorophore_pdf_absorbed(const struct scene *scene, int index, float lambda_in, float lambda_out)
{
    return material_fluorophore_pdf(scene->fluorophore_material[index],
                                    index - scene->fluorophore_first[index], SIDE_CAMERA, lambda_in,
                                    lambda_out);
}
