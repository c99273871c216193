/* Meshes that emit: one light per object and emissive material slot. A triangle is drawn by area, a point on
   it uniformly. */
#include <stdlib.h>

#include "scene/state.h"

void triangle_cdf_free(struct triangle_cdf *cdf)
{
    free(cdf->triangle);
    free(cdf->sum);
    *cdf = (struct triangle_cdf){0};
}

static uint32_t slot_of(const struct instances *instances, const struct mesh *mesh, size_t triangle)
{
    return (uint32_t)object_slot(&(struct object){.mesh = mesh, .instances = instances}, (uint32_t)triangle);
}

bool triangle_cdf_build(struct triangle_cdf *cdf, const struct instances *instances, const struct mesh *mesh,
                        const struct transform *transform, size_t slot)
{
    size_t count = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        count += slot_of(instances, mesh, t) == slot;
    *cdf = (struct triangle_cdf){malloc((count + 1) * sizeof *cdf->triangle),
                                 calloc(count + 1, sizeof *cdf->sum), 0};
    if (!cdf->triangle || !cdf->sum) {
        triangle_cdf_free(cdf);
        return false;
    }
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        double area = slot_of(instances, mesh, t) == slot ? triangle_area(mesh, transform, (uint32_t)t) : 0;
        if (!(area > 0))
            continue;
        cdf->triangle[cdf->count] = (uint32_t)t;
        cdf->sum[cdf->count + 1] = cdf->sum[cdf->count] + area;
        cdf->count++;
    }
    return true;
}

static const struct material *material_of(const struct scene *scene, const struct light *light)
{
    return scene->objects[light->object].instances->materials[light->slot];
}

/* World over local area of a transform that keeps the ratios of areas: |det|^(2/3). */
static double area_factor(const struct scene *scene, const struct light *light)
{
    if (light->own_cdf)
        return 1;
    return pow(fabs(transform_determinant(&scene->objects[light->object].to_world)), 2.0 / 3.0);
}

static double power(const struct scene *scene, const struct light *light)
{
    int sides = material_emits_on_both_sides(material_of(scene, light)) ? 2 : 1;
    double area = light->cdf->sum[light->cdf->count] * area_factor(scene, light);
    return light->total * area * PI_F * sides;
}

/* Probability of the triangle over its area in the world: the same for all where the table holds world areas;
   else the quotient of local and world area makes up for what the transform does to this triangle. */
static float pdf_triangle(const struct scene *scene, const struct light *light, uint32_t triangle)
{
    const struct object *object = &scene->objects[light->object];
    double whole = light->cdf->sum[light->cdf->count];
    if (!(whole > 0))
        return 0;
    if (light->own_cdf)
        return (float)(1 / whole);
    double local = triangle_area(object->mesh, NULL, triangle);
    double world = triangle_area(object->mesh, &object->to_world, triangle);
    return world > 0 ? (float)(local / (whole * world)) : 0;
}

static float sample_point(const struct scene *scene, const struct light *light, double choice,
                          const float u[2], struct light_point *point)
{
    if (!light->cdf->count)
        return 0;
    double rest;
    uint32_t triangle = light->cdf->triangle[search_sum(light->cdf->sum, light->cdf->count, choice, &rest)];
    float root = sqrtf(u[0]);
    scene_fill_hit(scene, light->object, triangle, root * (1 - u[1]), root * u[1], &point->hit);
    point->position = point->hit.position;
    point->normal = point->hit.ng;
    point->uv[0] = point->hit.uv[0];
    point->uv[1] = point->hit.uv[1];
    return pdf_triangle(scene, light, triangle);
}

static float pdf_point(const struct scene *scene, const struct light *light, const struct light_point *point)
{
    return pdf_triangle(scene, light, point->hit.primitive);
}

static float pdf_direction(const struct scene *scene, const struct light *light,
                           const struct light_point *point, struct vec3 direction)
{
    if (material_emits_on_both_sides(material_of(scene, light)))
        return 1 / (2 * PI_F);
    return dot(direction, point->normal) > 0 ? 1 / PI_F : 0;
}

static float sample_direction(const struct scene *scene, const struct light *light,
                              const struct light_point *point, const float u[2], struct vec3 *direction)
{
    struct vec3 normal = point->normal;
    float x = u[0];
    if (material_emits_on_both_sides(material_of(scene, light))) {
        normal = x < 0.5f ? normal : negate(normal);
        x = x < 0.5f ? 2 * x : 2 * x - 1;
    }
    struct frame frame = frame_about(normal);
    *direction = normalize(to_world(&frame, cosine_hemisphere(x, u[1])));
    if (!(dot(*direction, normal) > 0))
        return 0;
    return pdf_direction(scene, light, point, *direction);
}

static float emission(const struct scene *scene, const struct light *light, const struct light_point *point,
                      struct vec3 direction, float lambda)
{
    return material_emission(material_of(scene, light), &point->hit, direction, lambda);
}

const struct light_kind light_mesh = {.has_normal = true,
                                      .power = power,
                                      .sample_point = sample_point,
                                      .pdf_point = pdf_point,
                                      .sample_direction = sample_direction,
                                      .pdf_direction = pdf_direction,
                                      .emission = emission};
