/* Instances as the messages bring them, and the list of placed meshes that scene_commit makes of them. A mesh
   that is placed once and is small is laid out in the top structure itself, which saves its rays a transform. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/state.h"

/* Laid out once, rays are up to three times faster where objects overlap, but an edit of anything lays out
   all again. So the first commit lays out much, and those after an edit little. */
#define FLATTEN_TRIANGLES_FIRST 16000000u
#define FLATTEN_TRIANGLES_LATER 500000u

void instances_forget(struct instances *instances)
{
    for (size_t i = 0; instances->cdf && i < instances->slot_count; i++)
        triangle_cdf_free(&instances->cdf[i]);
    free(instances->cdf);
    free((void *)instances->materials);
    free(instances->emitter);
    instances->cdf = NULL;
    instances->materials = NULL;
    instances->emitter = NULL;
    instances->slot_count = instances->emitter_count = 0;
}

void instances_destroy(struct instances *instances)
{
    if (!instances)
        return;
    instances_forget(instances);
    for (size_t i = 0; instances->material_names && i < instances->material_count; i++)
        free(instances->material_names[i]);
    free(instances->material_names);
    free(instances->transforms);
    free(instances->mesh_name);
    free(instances->name);
    free(instances);
}

static struct instances *instances_create(const struct instances_input *in)
{
    struct instances *instances = calloc(1, sizeof *instances);
    if (!instances)
        return NULL;
    instances->name = copy_text(in->name);
    instances->mesh_name = copy_text(in->mesh);
    instances->material_names = calloc(in->material_count + 1, sizeof *instances->material_names);
    instances->transforms = malloc(in->transform_count * sizeof *instances->transforms + 1);
    instances->mask = visibility_mask(in->visible);
    instances->holdout = in->holdout;
    instances->transform_count = in->transform_count;
    bool whole =
        instances->name && instances->mesh_name && instances->material_names && instances->transforms;
    for (size_t i = 0; whole && i < in->material_count; i++) {
        instances->material_names[i] = copy_text(in->materials[i]);
        instances->material_count = i + 1;
        whole = instances->material_names[i];
    }
    if (!whole) {
        instances_destroy(instances);
        return NULL;
    }
    if (in->transform_count)
        memcpy(instances->transforms, in->transforms, in->transform_count * sizeof *instances->transforms);
    return instances;
}

bool scene_add_instances(struct scene *scene, const struct instances_input *in, stokes_error *err)
{
    for (size_t i = 0; i < 12 * in->transform_count; i++)
        if (!(fabsf(in->transforms[i]) <= 1e12f))
            return fail(err, in->name, "transforms",
                        "number %zu of transform %zu is %g, which is not within ±1e12", i % 12, i / 12,
                        (double)in->transforms[i]);
    struct instances *instances = instances_create(in);
    void *old;
    if (!instances || !registry_put(&scene->instances, instances->name, instances, &old)) {
        instances_destroy(instances);
        return fail(err, in->name, "transforms", "no memory for %zu instances", in->transform_count);
    }
    instances_destroy(old);
    scene->geometry_dirty = true;
    scene->committed = false;
    return true;
}

static bool resolve_mesh(const struct scene *scene, struct instances *instances, stokes_error *err)
{
    instances->mesh = registry_find(&scene->meshes, instances->mesh_name);
    return instances->mesh ||
           fail(err, instances->name, "mesh", "there is no mesh named \"%.200s\"", instances->mesh_name);
}

/* Nothing is left of an object that is scaled to a line or a point, as is done to hide some: all areas are
   zero. */
static bool has_area(const struct transform *transform)
{
    const float *m = transform->m;
    double size = 0, area = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            size = fmax(size, fabs(m[4 * i + j]));
            for (int k = 0; k < j; k++)
                for (int l = 0; l < i; l++)
                    area = fmax(area, fabs((double)m[4 * i + j] * m[4 * l + k] -
                                           (double)m[4 * i + k] * m[4 * l + j]));
        }
    return area > 1e-12 * size * size;
}

/* `budget`: triangles that may still be laid out. A transform that flattens its object has no inverse, which
   an instance would need. */
static void place(const struct instances *instances, const struct transform *transform, size_t *budget,
                  struct object *object)
{
    *object = (struct object){
        .to_world = *transform, .mesh = instances->mesh, .instances = instances, .first_light = -1};
    size_t triangles = instances->mesh->triangle_count;
    bool single = instances->transform_count == 1 && triangles <= *budget;
    object->mirrored = transform_determinant(transform) < 0;
    object->vanished = !has_area(transform);
    object->flattened = !transform_inverse(transform, &object->to_local) || single;
    if (single)
        *budget -= triangles;
}

bool scene_build_objects(struct scene *scene, stokes_error *err)
{
    size_t count = 0;
    registry_sort(&scene->instances);
    for (size_t i = 0; i < scene->instances.count; i++) {
        struct instances *instances = scene->instances.entry[i].item;
        if (!resolve_mesh(scene, instances, err))
            return false;
        count += instances->mesh->triangle_count ? instances->transform_count : 0;
    }
    if (count >= UINT32_MAX)
        return fail(err, "scene", "instances", "%zu are more than 32 bits can name", count);
    struct object *objects = malloc((count + 1) * sizeof *objects);
    if (!objects)
        return fail(err, "scene", "instances", "no memory for %zu", count);
    free(scene->objects);
    scene->objects = objects;
    scene->object_count = count;
    size_t budget = scene->laid_out ? FLATTEN_TRIANGLES_LATER : FLATTEN_TRIANGLES_FIRST;
    scene->laid_out = true;
    for (size_t i = 0; i < scene->instances.count; i++) {
        const struct instances *instances = scene->instances.entry[i].item;
        for (size_t t = 0; instances->mesh->triangle_count && t < instances->transform_count; t++)
            place(instances, &instances->transforms[t], &budget, objects++);
    }
    return true;
}

double transform_determinant(const struct transform *t)
{
    const float *m = t->m;
    return (double)m[0] * ((double)m[5] * m[10] - (double)m[6] * m[9]) -
           (double)m[1] * ((double)m[4] * m[10] - (double)m[6] * m[8]) +
           (double)m[2] * ((double)m[4] * m[9] - (double)m[5] * m[8]);
}

bool transform_inverse(const struct transform *t, struct transform *inverse)
{
    const float *m = t->m;
    double determinant = transform_determinant(t), size = 1;
    for (int row = 0; row < 3; row++)
        size *= fabs(m[4 * row]) + fabs(m[4 * row + 1]) + fabs(m[4 * row + 2]);
    *inverse = (struct transform){{0}};
    if (!(fabs(determinant) > 1e-12 * size))
        return false;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) {
            int r1 = (column + 1) % 3, r2 = (column + 2) % 3, c1 = (row + 1) % 3, c2 = (row + 2) % 3;
            inverse->m[4 * row + column] =
                (float)(((double)m[4 * r1 + c1] * m[4 * r2 + c2] - (double)m[4 * r1 + c2] * m[4 * r2 + c1]) /
                        determinant);
        }
    for (int row = 0; row < 3; row++) {
        const float *r = inverse->m + 4 * row;
        inverse->m[4 * row + 3] = (float)-((double)r[0] * m[3] + (double)r[1] * m[7] + (double)r[2] * m[11]);
    }
    return transform_is_finite(inverse);
}

bool transform_is_finite(const struct transform *t)
{
    for (int i = 0; i < 12; i++)
        if (!isfinite(t->m[i]))
            return false;
    return true;
}
