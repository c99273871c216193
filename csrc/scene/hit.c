/* From a triangle and barycentric coordinates to what materials need to know: positions, normals, tangent,
   texture coordinates, and a bound of the rounding error, by which rays leave the surface. */
#include <float.h>

#include "scene/state.h"

/* Roundings (of relative size 2⁻²⁴) between exact coordinates and what is compared with them, all told: 5 in
   the barycentric sum, 4 in a transform, and some 8 in Embree's test of a triangle against a ray
   (differences, edge functions, quotient); doubled, because the next ray's test has its own. */
#define ROUNDINGS (2 * 17 * 0.5f * FLT_EPSILON)

static struct vec3 absolute(struct vec3 a)
{
    return vec3(fabsf(a.x), fabsf(a.y), fabsf(a.z));
}

static struct vec3 larger(struct vec3 a, struct vec3 b)
{
    return vec3(fmaxf(a.x, b.x), fmaxf(a.y, b.y), fmaxf(a.z, b.z));
}

/* |t| p, and |translation| with it: what the sizes of rounded terms add up to when t is applied. */
static struct vec3 magnitude(const struct transform *t, struct vec3 p)
{
    const float *m = t->m;
    return vec3(fabsf(m[0]) * p.x + fabsf(m[1]) * p.y + fabsf(m[2]) * p.z + fabsf(m[3]),
                fabsf(m[4]) * p.x + fabsf(m[5]) * p.y + fabsf(m[6]) * p.z + fabsf(m[7]),
                fabsf(m[8]) * p.x + fabsf(m[9]) * p.y + fabsf(m[10]) * p.z + fabsf(m[11]));
}

/* Displacement along ng that rounding may cause. Embree takes rays into an instance's space, where the sizes
   of the world's coordinates come back through the inverse; anisotropic scales make that much more than the
   point's own coordinates. */
static float error_bound(const struct object *object, const struct vec3 corner[3], const struct hit *hit)
{
    struct vec3 local = larger(larger(absolute(corner[0]), absolute(corner[1])), absolute(corner[2]));
    struct vec3 world = absolute(hit->position);
    if (!object->flattened)
        local = add(local, magnitude(&object->to_local, world));
    struct vec3 size = add(magnitude(&object->to_world, local), world);
    return ROUNDINGS * dot(absolute(hit->ng), size) + FLT_MIN;
}

/* Normals go by the cofactors, det M · M⁻ᵀ, which exist for flat transforms too; the determinant's sign is
   taken out again, so that a mirrored object keeps its outside. */
static struct vec3 transform_normal(const struct object *object, struct vec3 n)
{
    const float *m = object->to_world.m;
    struct vec3 a = vec3(m[0], m[4], m[8]), b = vec3(m[1], m[5], m[9]), c = vec3(m[2], m[6], m[10]);
    struct vec3 world = along(along(scale(cross(b, c), n.x), cross(c, a), n.y), cross(a, b), n.z);
    return object->mirrored ? negate(world) : world;
}

/* Unit vector; components are brought to size 1 first, since squares of tiny ones vanish. Zero stays zero. */
static struct vec3 unit(struct vec3 v)
{
    float size = fmaxf(fmaxf(fabsf(v.x), fabsf(v.y)), fabsf(v.z));
    return size > 0 ? normalize(scale(v, 1 / size)) : v;
}

static struct vec3 interpolate(const float *values, const uint32_t corner[3], float w, float u, float v)
{
    const float *a = values + 3 * (size_t)corner[0], *b = values + 3 * (size_t)corner[1],
                *c = values + 3 * (size_t)corner[2];
    return vec3(w * a[0] + u * b[0] + v * c[0], w * a[1] + u * b[1] + v * c[1],
                w * a[2] + u * b[2] + v * c[2]);
}

static void fill_normals(const struct object *object, const struct vec3 p[3], const uint32_t corner[3],
                         struct hit *hit)
{
    const struct mesh *mesh = object->mesh;
    struct vec3 flat = cross(unit(sub(p[1], p[0])), unit(sub(p[2], p[0])));
    hit->ng = unit(transform_normal(object, unit(flat)));
    hit->ns = hit->ng;
    if (!mesh->normals)
        return;
    struct vec3 smooth =
        interpolate(mesh->normals, corner, 1 - hit->bary_u - hit->bary_v, hit->bary_u, hit->bary_v);
    smooth = unit(transform_normal(object, unit(smooth)));
    if (length_squared(smooth) > 0)
        hit->ns = smooth;
}

/* ∂p/∂u of the default layer: the first column of (e1 e2)(du1 du2; dv1 dv2)⁻¹, up to a positive factor, or
   what the corners share. */
static void fill_tangent(const struct object *object, const struct vec3 p[3], const uint32_t corner[3],
                         struct hit *hit)
{
    hit->uv[0] = hit->uv[1] = 0;
    hit->tangent = vec3(0, 0, 0);
    hit->mirrored_uv = false;
    if (!object->mesh->uv_count)
        return;
    const float *uv = object->mesh->uv[0].data;
    const float *a = uv + 2 * (size_t)corner[0], *b = uv + 2 * (size_t)corner[1],
                *c = uv + 2 * (size_t)corner[2];
    float w = 1 - hit->bary_u - hit->bary_v;
    hit->uv[0] = w * a[0] + hit->bary_u * b[0] + hit->bary_v * c[0];
    hit->uv[1] = w * a[1] + hit->bary_u * b[1] + hit->bary_v * c[1];
    float du1 = b[0] - a[0], dv1 = b[1] - a[1], du2 = c[0] - a[0], dv2 = c[1] - a[1];
    float determinant = du1 * dv2 - du2 * dv1;
    if (determinant == 0)
        return;
    struct vec3 tangent = along(scale(sub(p[1], p[0]), dv2), sub(p[2], p[0]), -dv1);
    tangent = scale(tangent, copysignf(1, determinant));
    if (object->mesh->tangents) {
        const float *tangents = object->mesh->tangents + 9 * (size_t)hit->primitive;
        tangent = interpolate(tangents, (const uint32_t[3]){0, 1, 2}, w, hit->bary_u, hit->bary_v);
    }
    hit->tangent = unit(transform_vector(&object->to_world, tangent));
    hit->mirrored_uv = (determinant < 0) != object->mirrored;
}

/* Generated coordinates: 0 … 1 over the bounding box; 0.5 along an axis in which the mesh is flat. */
static float generated(float x, float low, float high)
{
    return high > low ? (x - low) / (high - low) : 0.5f;
}

void scene_fill_hit(const struct scene *scene, uint32_t index, uint32_t triangle, float u, float v,
                    struct hit *hit)
{
    const struct object *object = &scene->objects[index];
    const struct mesh *mesh = object->mesh;
    struct vec3 p[3];
    mesh_triangle(mesh, triangle, p);
    uint32_t corner[3];
    for (uint32_t i = 0; i < 3; i++)
        corner[i] = hit_corner(&mesh->hit, triangle, i);
    hit->instance = index;
    hit->primitive = triangle;
    hit->mesh = &mesh->hit;
    hit->bary_u = u;
    hit->bary_v = v;
    hit->object = along(along(scale(p[0], 1 - u - v), p[1], u), p[2], v);
    hit->position = transform_point(&object->to_world, hit->object);
    hit->generated = vec3(generated(hit->object.x, mesh->low.x, mesh->high.x),
                          generated(hit->object.y, mesh->low.y, mesh->high.y),
                          generated(hit->object.z, mesh->low.z, mesh->high.z));
    fill_normals(object, p, corner, hit);
    fill_tangent(object, p, corner, hit);
    hit->error = error_bound(object, p, hit);
    int emitter = object->first_light < 0 ? -1 : object->instances->emitter[object_slot(object, triangle)];
    hit->light = emitter < 0 ? -1 : object->first_light + emitter;
}

struct vec3 scene_offset(const struct hit *hit, struct vec3 direction)
{
    return along(hit->position, hit->ng, dot(direction, hit->ng) < 0 ? -hit->error : hit->error);
}

bool scene_intersect(const struct scene *scene, const struct ray *ray, struct hit *hit,
                     const struct material **material)
{
    struct accel_hit found;
    if (!accel_intersect(scene, ray, &found))
        return false;
    scene_fill_hit(scene, found.object, found.primitive, found.u, found.v, hit);
    if (length_squared(hit->ng) == 0) /* a sliver too thin for a normal faces the ray */
        hit->ng = hit->ns = negate(ray->direction);
    const struct object *object = &scene->objects[found.object];
    *material = object->instances->materials[object_slot(object, found.primitive)];
    return true;
}

const float scene_segment_end = 1 - 2 * ROUNDINGS;

float scene_visibility(const struct scene *scene, struct vec3 from, struct vec3 to, float lambda,
                       uint32_t kind)
{
    return accel_transmittance(scene, from, sub(to, from), scene_segment_end, lambda, kind, NULL);
}

float scene_visibility_distant(const struct scene *scene, struct vec3 from, struct vec3 direction,
                               float lambda, uint32_t kind)
{
    return accel_transmittance(scene, from, direction, INFINITY, lambda, kind, NULL);
}

bool scene_has_barriers(const struct scene *scene)
{
    return scene->mixed;
}

bool scene_is_barred(const struct scene *scene, struct vec3 from, struct vec3 to)
{
    return accel_meets(scene, from, sub(to, from), scene_segment_end, SEEN_BY_SOME);
}

bool scene_hit_is_holdout(const struct scene *scene, const struct hit *hit)
{
    return scene->objects[hit->instance].instances->holdout;
}

uint32_t scene_hit_kinds(const struct scene *scene, const struct hit *hit)
{
    return scene->objects[hit->instance].instances->mask;
}
