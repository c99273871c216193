/* Lamps: checking what the `light` message brings, and the geometry that their kinds share. */
#include <stdlib.h>

#include "base/error.h"
#include "scene/state.h"

/* A sun this small (rad) is a single direction: float directions could not tell its rim from its centre. */
#define SUN_HALF_ANGLE_MIN 5e-5f

void lamp_destroy(struct lamp *lamp)
{
    if (!lamp)
        return;
    emission_free(&lamp->emission);
    emission_node_destroy(lamp->input.emission);
    free(lamp->name);
    free(lamp);
}

static struct vec3 column(const struct transform *t, int i)
{
    return vec3(t->m[i], t->m[4 + i], t->m[8 + i]);
}

/* Edges may be sheared by the transform; the duals give coordinates along them. */
static bool derive_flat(struct lamp *lamp, stokes_error *err)
{
    const struct light_input *in = &lamp->input;
    lamp->axis_u = scale(column(&in->transform, 0), in->size[0]);
    lamp->axis_v = scale(column(&in->transform, 1), in->size[1]);
    struct vec3 across = cross(lamp->axis_u, lamp->axis_v);
    lamp->area = length(across);
    if (!(in->size[0] > 0 && in->size[1] > 0) || !(lamp->area > 0) || !isfinite(lamp->area))
        return fail(err, lamp->name, "size", "%g × %g m under its transform has no area", (double)in->size[0],
                    (double)in->size[1]);
    lamp->normal = scale(across, 1 / lamp->area);
    if (dot(lamp->normal, column(&in->transform, 2)) > 0) /* local −Z is lit */
        lamp->normal = negate(lamp->normal);
    struct vec3 u = cross(lamp->axis_v, across), v = cross(across, lamp->axis_u);
    lamp->dual_u = scale(u, 1 / dot(u, lamp->axis_u));
    lamp->dual_v = scale(v, 1 / dot(v, lamp->axis_v));
    if (in->shape == LIGHT_ELLIPSE)
        lamp->area *= PI_F / 4;
    return true;
}

static bool derive_round(struct lamp *lamp, stokes_error *err)
{
    float radius = lamp->input.radius;
    if (!(radius > 0) || !isfinite(radius))
        return fail(err, lamp->name, "radius", "is %g m", (double)radius);
    lamp->area = 4 * PI_F * radius * radius;
    return true;
}

static bool derive_spot(struct lamp *lamp, stokes_error *err)
{
    const struct light_input *in = &lamp->input;
    if (!(in->angle > 0 && in->angle <= 2 * PI_F + 1e-5f))
        return fail(err, lamp->name, "angle", "is %g rad, not in (0, 2π]", (double)in->angle);
    if (!(in->blend >= 0 && in->blend <= 1))
        return fail(err, lamp->name, "blend", "is %g, not in [0, 1]", (double)in->blend);
    if (!transform_inverse(&in->transform, &lamp->to_local))
        return fail(err, lamp->name, "transform", "has no inverse");
    lamp->determinant = (float)fabs(transform_determinant(&in->transform));
    lamp->cos_half = cosf(0.5f * in->angle);
    lamp->smooth = (1 - lamp->cos_half) * in->blend;
    return in->radius == 0 || derive_round(lamp, err);
}

static bool derive_sun(struct lamp *lamp, stokes_error *err)
{
    lamp->normal = normalize(column(&lamp->input.transform, 2));
    if (!(length_squared(lamp->normal) > 0))
        return fail(err, lamp->name, "transform", "has no Z axis");
    lamp->half_angle = 0.5f * lamp->input.angle;
    if (!(lamp->half_angle >= 0 && lamp->half_angle < 0.5f * PI_F))
        return fail(err, lamp->name, "angle", "is %g rad, not in [0, π)", (double)lamp->input.angle);
    if (lamp->half_angle < SUN_HALF_ANGLE_MIN)
        lamp->half_angle = 0;
    lamp->cos_half = cosf(lamp->half_angle);
    return true;
}

bool lamp_derive(struct lamp *lamp, stokes_error *err)
{
    lamp->center = column(&lamp->input.transform, 3);
    lamp->mask = visibility_mask(lamp->input.visible);
    if (!transform_is_finite(&lamp->input.transform))
        return fail(err, lamp->name, "transform", "is not finite");
    switch (lamp->input.shape) {
    case LIGHT_RECTANGLE:
    case LIGHT_ELLIPSE: return derive_flat(lamp, err);
    case LIGHT_SPHERE: return derive_round(lamp, err);
    case LIGHT_POINT: return true;
    case LIGHT_SPOT: return derive_spot(lamp, err);
    case LIGHT_SUN: return derive_sun(lamp, err);
    }
    return fail(err, lamp->name, "kind", "is unknown");
}

static bool check_emission(const struct lamp *lamp, stokes_error *err)
{
    const struct emission_node *node = lamp->input.emission;
    if (!node || (!node->spectrum && !node->texture))
        return fail(err, lamp->name, "emission", "missing");
    if (node->texture && lamp->input.shape != LIGHT_RECTANGLE && lamp->input.shape != LIGHT_ELLIPSE)
        return fail(err, lamp->name, "emission", "only rectangles and ellipses can be textured");
    return true;
}

bool scene_add_light(struct scene *scene, const struct light_input *in, stokes_error *err)
{
    struct lamp *lamp = calloc(1, sizeof *lamp);
    if (!lamp || !(lamp->name = copy_text(in->name))) {
        free(lamp);
        emission_node_destroy(in->emission);
        return fail(err, in->name, "light", "no memory");
    }
    lamp->input = *in;
    lamp->input.name = lamp->name;
    void *old;
    if (!check_emission(lamp, err) || !lamp_derive(lamp, err)) {
        lamp_destroy(lamp);
        return false;
    }
    if (!registry_put(&scene->lamps, lamp->name, lamp, &old)) {
        lamp_destroy(lamp);
        return fail(err, in->name, "light", "no memory");
    }
    lamp_destroy(old);
    scene->lights_dirty = true;
    scene->committed = false;
    return true;
}

void lamp_bounds(const struct lamp *lamp, struct vec3 *low, struct vec3 *high)
{
    struct vec3 reach;
    if (lamp->input.shape == LIGHT_RECTANGLE || lamp->input.shape == LIGHT_ELLIPSE)
        reach =
            vec3(fabsf(lamp->axis_u.x) + fabsf(lamp->axis_v.x), fabsf(lamp->axis_u.y) + fabsf(lamp->axis_v.y),
                 fabsf(lamp->axis_u.z) + fabsf(lamp->axis_v.z));
    else
        reach = vec3(2 * lamp->input.radius, 2 * lamp->input.radius, 2 * lamp->input.radius);
    reach = scale(reach, 0.5001f); /* half of it, and a margin for rounding */
    *low = sub(lamp->center, reach);
    *high = add(lamp->center, reach);
}
