/* Tangents of smooth meshes for normal maps. Faces that meet at a vertex with one normal, one texture
   coordinate and one orientation of the map share a tangent there: the mean of theirs in the vertex's tangent
   plane, by angle (as the MikkTSpace of Blender and Cycles has it), or every edge would show. */
#include <stdlib.h>
#include <string.h>

#include "scene/state.h"

/* One face's corner at a vertex. */
struct wedge {
    float key[6];        /* normal, texture coordinate, orientation */
    uint32_t corner;     /* 3 · triangle + i */
    struct vec3 tangent; /* weighted by the face's angle here */
};

static int by_key(const void *a, const void *b)
{
    const struct wedge *x = a, *y = b;
    for (int i = 0; i < 6; i++)
        if (x->key[i] != y->key[i])
            return x->key[i] < y->key[i] ? -1 : 1;
    return (x->corner > y->corner) - (x->corner < y->corner);
}

static struct vec3 read_vector(const float *values, uint32_t i)
{
    return vec3(values[3 * (size_t)i], values[3 * (size_t)i + 1], values[3 * (size_t)i + 2]);
}

static struct vec3 in_plane(struct vec3 v, struct vec3 normal)
{
    return normalize(along(v, normal, -dot(v, normal)));
}

static void fill_wedge(const struct mesh *mesh, uint32_t corner, struct wedge *wedge)
{
    uint32_t triangle = corner / 3, own = corner % 3, index[3];
    struct vec3 p[3];
    const float *uv[3];
    mesh_triangle(mesh, triangle, p);
    for (uint32_t i = 0; i < 3; i++) {
        index[i] = hit_corner(&mesh->hit, triangle, i);
        uv[i] = mesh->uv[0].data + 2 * (size_t)index[i];
    }
    float du1 = uv[1][0] - uv[0][0], dv1 = uv[1][1] - uv[0][1], du2 = uv[2][0] - uv[0][0],
          dv2 = uv[2][1] - uv[0][1];
    float determinant = du1 * dv2 - du2 * dv1, sign = copysignf(determinant != 0, determinant);
    struct vec3 tangent = scale(along(scale(sub(p[1], p[0]), dv2), sub(p[2], p[0]), -dv1), sign);
    struct vec3 normal = normalize(read_vector(mesh->normals, index[own]));
    struct vec3 a = in_plane(sub(p[(own + 1) % 3], p[own]), normal),
                b = in_plane(sub(p[(own + 2) % 3], p[own]), normal);
    *wedge = (struct wedge){{normal.x, normal.y, normal.z, uv[own][0], uv[own][1], sign},
                            corner,
                            scale(in_plane(normalize(tangent), normal), acosf(clampf(dot(a, b), -1, 1)))};
}

static bool same_key(const struct wedge *a, const struct wedge *b)
{
    return memcmp(a->key, b->key, sizeof a->key) == 0;
}

/* Gives the wedges of one vertex their groups' tangents. */
static void share(struct wedge *wedge, size_t count, float *tangents)
{
    qsort(wedge, count, sizeof *wedge, by_key);
    for (size_t first = 0, end; first < count; first = end) {
        struct vec3 sum = vec3(0, 0, 0);
        for (end = first; end < count && same_key(&wedge[first], &wedge[end]); end++)
            sum = add(sum, wedge[end].tangent);
        sum = normalize(sum);
        for (size_t i = first; i < end; i++)
            memcpy(tangents + 3 * (size_t)wedge[i].corner, &sum, 3 * sizeof(float));
    }
}

/* Lists the corners at each vertex: those of vertex v are list[start[v]] … list[start[v + 1] − 1]. Returns
   the most. */
static size_t list_corners(const struct mesh *mesh, size_t *start, uint32_t *list)
{
    size_t corners = 3 * mesh->triangle_count, most = 0;
    for (size_t c = 0; c < corners; c++)
        start[mesh->triangles[c] + 1]++;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        most = start[v + 1] > most ? start[v + 1] : most;
        start[v + 1] += start[v];
    }
    for (size_t c = corners; c > 0; c--)
        list[--start[mesh->triangles[c - 1] + 1]] = (uint32_t)(c - 1);
    memmove(start, start + 1, mesh->vertex_count * sizeof *start); /* each now holds its own start */
    start[mesh->vertex_count] = corners;
    return most;
}

bool mesh_build_tangents(struct mesh *mesh)
{
    if (mesh->tangents || !mesh->normals || !mesh->uv_count || !mesh->triangle_count)
        return true;
    size_t corners = 3 * mesh->triangle_count;
    size_t *start = calloc(mesh->vertex_count + 2, sizeof *start);
    uint32_t *list = malloc(corners * sizeof *list);
    float *tangents = malloc(3 * corners * sizeof *tangents);
    size_t most = start && list ? list_corners(mesh, start, list) : 0;
    struct wedge *wedge = malloc((most + 1) * sizeof *wedge);
    bool whole = start && list && tangents && wedge;
    for (size_t v = 0; whole && v < mesh->vertex_count; v++) {
        size_t count = start[v + 1] - start[v];
        for (size_t i = 0; i < count; i++)
            fill_wedge(mesh, list[start[v] + i], &wedge[i]);
        share(wedge, count, tangents);
    }
    free(start);
    free(list);
    free(wedge);
    if (whole)
        mesh->tangents = tangents;
    else
        free(tangents);
    return whole;
}
