/* What a hit says of its mesh: texture coordinates that a material may ask for, without knowing of scenes.
   `struct hit.mesh` points to a struct hit_mesh, which the scene fills in scene_commit and keeps alive. */
#ifndef MATERIAL_HIT_MESH_H
#define MATERIAL_HIT_MESH_H

#include <stddef.h>

#include "material/material.h"

/* Where the camera sees a point, for window coordinates (0 … 1 over the frame). */
struct hit_window {
    struct transform to_camera;
    float left, bottom, inverse_width, inverse_height; /* of the frame; perspective: on the plane z = −1 */
    bool orthographic;
};

struct hit_mesh {
    const uint32_t *corners; /* 3 per triangle; NULL: corner i of triangle t is 3t + i */
    /* 2 floats per corner, by texture.uv_layer: 0 is the default layer, others are named; NULL: no such layer */
    const float *const *uv;
    uint32_t uv_count;
    const struct hit_window *window; /* NULL without a camera */
};

static inline uint32_t hit_corner(const struct hit_mesh *mesh, uint32_t triangle, uint32_t i)
{
    return mesh->corners ? mesh->corners[3 * (size_t)triangle + i] : 3 * triangle + i;
}

/* A UV layer at the hit; (0, 0) where the mesh has no such layer, as in Cycles. */
static inline struct vec3 hit_uv(const struct hit *hit, uint32_t layer)
{
    const struct hit_mesh *mesh = hit->mesh;
    const float *uv = mesh && layer < mesh->uv_count ? mesh->uv[layer] : NULL;
    if (!uv)
        return vec3(0, 0, 0);
    const float *a = uv + 2 * (size_t)hit_corner(mesh, hit->primitive, 0);
    const float *b = uv + 2 * (size_t)hit_corner(mesh, hit->primitive, 1);
    const float *c = uv + 2 * (size_t)hit_corner(mesh, hit->primitive, 2);
    float w = 1 - hit->bary_u - hit->bary_v;
    return vec3(w * a[0] + hit->bary_u * b[0] + hit->bary_v * c[0],
                w * a[1] + hit->bary_u * b[1] + hit->bary_v * c[1], 0);
}

static inline struct vec3 hit_window_coordinates(const struct hit *hit)
{
    const struct hit_mesh *mesh = hit->mesh;
    if (!mesh || !mesh->window)
        return vec3(0, 0, 0);
    const struct hit_window *window = mesh->window;
    struct vec3 p = transform_point(&window->to_camera, hit->position);
    if (!window->orthographic)
        p = p.z != 0 ? scale(p, -1 / p.z) : vec3(0, 0, 0);
    return vec3((p.x - window->left) * window->inverse_width, (p.y - window->bottom) * window->inverse_height,
                0);
}

/* What a texture is looked up at, before its own transform (texture_lookup applies that). */
static inline struct vec3 hit_coordinates(const struct hit *hit, const struct texture *texture)
{
    switch (texture->projection) {
    case TEXTURE_UV:
        return texture->uv_layer == 0 ? vec3(hit->uv[0], hit->uv[1], 0)
                                      : hit_uv(hit, (uint32_t)texture->uv_layer);
    case TEXTURE_GENERATED:
        return hit->generated;
    case TEXTURE_OBJECT:
        return hit->object;
    case TEXTURE_WINDOW:
        return hit_window_coordinates(hit);
    }
    return vec3(0, 0, 0);
}

#endif
