/* Meshes: checked copies of what the `mesh` message brings. Zero-area triangles stay, so that primitive
   numbers are the sender's: no ray finds them and no light is drawn on them. */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/state.h"

/* Beyond this, squares and products of coordinates leave the range of floats. */
#define COORDINATE_MAX 1e12f

void mesh_destroy(struct mesh *mesh)
{
    if (!mesh)
        return;
    accel_release(mesh->structure);
    for (size_t i = 0; mesh->uv && i < mesh->uv_count; i++)
        free((void *)(uintptr_t)mesh->uv[i].data);
    free(mesh->uv);
    free((void *)mesh->uv_table);
    free(mesh->positions);
    free(mesh->triangles);
    free(mesh->corners);
    free(mesh->normals);
    free(mesh->tangents);
    free(mesh->material_index);
    free(mesh->name);
    free(mesh);
}

static bool check_positions(const struct mesh_input *in, stokes_error *err)
{
    for (size_t i = 0; i < 3 * in->vertex_count; i++)
        if (!(fabsf(in->positions[i]) <= COORDINATE_MAX))
            return fail(err, in->name, "positions", "vertex %zu is at %g, which is not within ±%g m", i / 3,
                        (double)in->positions[i], (double)COORDINATE_MAX);
    return true;
}

static bool check_indices(const struct mesh_input *in, const uint32_t *index, size_t limit,
                          const char *property, stokes_error *err)
{
    for (size_t i = 0; index && i < 3 * in->triangle_count; i++)
        if (index[i] >= limit)
            return fail(err, in->name, property, "triangle %zu names entry %u of %zu", i / 3, index[i],
                        limit);
    return true;
}

static bool check_finite(const struct mesh_input *in, const float *values, size_t count, const char *property,
                         stokes_error *err)
{
    for (size_t i = 0; values && i < count; i++)
        if (!isfinite(values[i]))
            return fail(err, in->name, property, "number %zu is not finite", i);
    return true;
}

static bool check_counts(const struct mesh_input *in, size_t corner_count, stokes_error *err)
{
    if (in->vertex_count > UINT32_MAX || in->triangle_count > UINT32_MAX / 3)
        return fail(err, in->name, "triangles",
                    "%zu triangles of %zu vertices are more than 32 bits can name", in->triangle_count,
                    in->vertex_count);
    if (in->triangle_count && !in->triangles)
        return fail(err, in->name, "triangles", "missing");
    if (!in->corners && corner_count < 3 * in->triangle_count && (in->corner_normals || in->uv_count))
        return fail(err, in->name, "corners", "%zu corners for %zu triangles", corner_count,
                    in->triangle_count);
    return true;
}

static bool check(const struct mesh_input *in, stokes_error *err)
{
    if (!check_counts(in, in->corner_count, err) || !check_positions(in, err) ||
        !check_indices(in, in->triangles, in->vertex_count, "triangles", err) ||
        !check_indices(in, in->corners, in->corner_count, "corners", err) ||
        !check_finite(in, in->corner_normals, 3 * in->corner_count, "corner_normals", err))
        return false;
    for (size_t i = 0; i < in->uv_count; i++)
        if (!check_finite(in, in->uv[i].data, 2 * in->corner_count, in->uv[i].name, err))
            return false;
    return true;
}

/* A copy with `padding` zero bytes behind it; NULL for nothing or without memory. */
static void *copy_array(const void *source, size_t bytes, size_t padding)
{
    if (!source)
        return NULL;
    unsigned char *copy = malloc(bytes + padding + 1);
    if (!copy)
        return NULL;
    memcpy(copy, source, bytes);
    memset(copy + bytes, 0, padding + 1);
    return copy;
}

static bool copy_uv(struct mesh *mesh, const struct mesh_input *in)
{
    if (!in->uv_count)
        return true;
    mesh->uv = calloc(in->uv_count, sizeof *mesh->uv);
    if (!mesh->uv)
        return false;
    mesh->uv_count = in->uv_count;
    for (size_t i = 0; i < in->uv_count; i++) {
        memcpy(mesh->uv[i].name, in->uv[i].name, sizeof mesh->uv[i].name);
        mesh->uv[i].data = copy_array(in->uv[i].data, 2 * in->corner_count * sizeof(float), 0);
        if (!mesh->uv[i].data)
            return false;
    }
    return true;
}

static void measure(struct mesh *mesh)
{
    struct vec3 low = vec3(FLT_MAX, FLT_MAX, FLT_MAX), high = negate(low);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        const float *p = mesh->positions + 3 * i;
        low = vec3(fminf(low.x, p[0]), fminf(low.y, p[1]), fminf(low.z, p[2]));
        high = vec3(fmaxf(high.x, p[0]), fmaxf(high.y, p[1]), fmaxf(high.z, p[2]));
    }
    mesh->low = mesh->vertex_count ? low : vec3(0, 0, 0);
    mesh->high = mesh->vertex_count ? high : vec3(0, 0, 0);
}

static struct mesh *mesh_create(const struct mesh_input *in)
{
    struct mesh *mesh = calloc(1, sizeof *mesh);
    if (!mesh)
        return NULL;
    size_t index_bytes = 3 * in->triangle_count * sizeof(uint32_t);
    mesh->vertex_count = in->vertex_count;
    mesh->triangle_count = in->triangle_count;
    mesh->corner_count = in->corner_count;
    mesh->name = copy_text(in->name);
    mesh->positions = copy_array(in->positions ? (const void *)in->positions : "",
                                 3 * in->vertex_count * sizeof(float), 4 * sizeof(float));
    mesh->triangles = copy_array(in->triangles ? (const void *)in->triangles : "", index_bytes, 0);
    mesh->corners = copy_array(in->corners, index_bytes, 0);
    mesh->normals = copy_array(in->corner_normals, 3 * in->corner_count * sizeof(float), 0);
    mesh->material_index = copy_array(in->material_index, in->triangle_count * sizeof(uint32_t), 0);
    bool whole = mesh->name && mesh->positions && mesh->triangles && (mesh->corners || !in->corners) &&
                 (mesh->normals || !in->corner_normals) && (mesh->material_index || !in->material_index);
    if (!whole || !copy_uv(mesh, in)) {
        mesh_destroy(mesh);
        return NULL;
    }
    mesh->hit.corners = mesh->corners;
    measure(mesh);
    return mesh;
}

bool scene_add_mesh(struct scene *scene, const struct mesh_input *in, stokes_error *err)
{
    struct mesh_input input = *in;
    if (!input.corners && !input.corner_count)
        input.corner_count = 3 * input.triangle_count;
    if (!check(&input, err))
        return false;
    struct mesh *mesh = mesh_create(&input);
    void *old;
    if (!mesh || !registry_put(&scene->meshes, mesh->name, mesh, &old)) {
        mesh_destroy(mesh);
        return fail(err, in->name, "mesh", "no memory for %zu triangles", in->triangle_count);
    }
    mesh_destroy(old);
    scene->geometry_dirty = true;
    scene->committed = false;
    return true;
}

static const float *find_layer(const struct mesh *mesh, const char *name)
{
    for (size_t i = 0; i < mesh->uv_count; i++)
        if (strncmp(mesh->uv[i].name, name, sizeof mesh->uv[i].name) == 0)
            return mesh->uv[i].data;
    return NULL;
}

bool mesh_resolve_uv(struct mesh *mesh, char *const *names, uint32_t count)
{
    const float **table = malloc((count + 1) * sizeof *table);
    if (!table)
        return false;
    table[0] = mesh->uv_count ? mesh->uv[0].data : NULL;
    for (uint32_t i = 0; i < count; i++)
        table[i + 1] = find_layer(mesh, names[i]);
    free((void *)mesh->uv_table);
    mesh->uv_table = table;
    mesh->hit.uv = table;
    mesh->hit.uv_count = count + 1;
    return true;
}

void mesh_triangle(const struct mesh *mesh, uint32_t triangle, struct vec3 corner[3])
{
    const uint32_t *index = mesh->triangles + 3 * (size_t)triangle;
    for (int i = 0; i < 3; i++) {
        const float *p = mesh->positions + 3 * (size_t)index[i];
        corner[i] = vec3(p[0], p[1], p[2]);
    }
}

double triangle_area(const struct mesh *mesh, const struct transform *transform, uint32_t triangle)
{
    struct vec3 p[3];
    mesh_triangle(mesh, triangle, p);
    struct vec3 a = sub(p[1], p[0]), b = sub(p[2], p[0]);
    if (transform) {
        a = transform_vector(transform, a);
        b = transform_vector(transform, b);
    }
    double x = (double)a.y * b.z - (double)a.z * b.y, y = (double)a.z * b.x - (double)a.x * b.z,
           z = (double)a.x * b.y - (double)a.y * b.x;
    return 0.5 * sqrt(x * x + y * y + z * z);
}
